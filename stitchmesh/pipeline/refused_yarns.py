# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Errors about the yarns of a garment in the words of its maker: the place in space, the panel, and a remedy.

Numbers of stitches say nothing to a user who gave a mesh. A thinner yarn is proposed only after a trial.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from stitchmesh.errors import StitchMeshError, YarnError
from stitchmesh.mesh import StitchMesh
from stitchmesh.yarn import YarnSet

THINNER = (0.8, 0.6, 0.45)
"""Factors of the radius of the yarn that are tried; a still thinner yarn would not look knitted."""


def with_place_and_remedy(
    error: YarnError, fabric: StitchMesh, panel: int | None, made: Callable[[float], YarnSet], radius: float
) -> YarnError:
    """Return an error about the yarns of a stitch with its place, and with a remedy for those who knit a garment.

    Args:
        error: the error; it is returned as it is if it names no stitch.
        fabric: the stitches.
        panel: the panel of the stitch, if it has one.
        made: function that generates and checks the yarns of a radius [cm].
        radius: the radius that failed [cm].
    """
    if error.face is None:
        return error
    corners = fabric.face_vertex[fabric.sides_of(np.array([error.face]))]
    place = ", ".join(f"{value:.1f}" for value in fabric.vertices[corners].mean(axis=0))
    named = "" if panel is None else f"panel {panel}: "
    thinner = _thinner(made, radius)
    if thinner is not None:
        remedy = f"a yarn radius of {thinner:g} cm works (--yarn-radius {thinner:g})"
    elif panel is not None:
        remedy = "choose another direction of this panel (--panel-direction), or leave its seams to be sewn (--sew)"
    else:
        remedy = (
            "thinner yarns fail there too: two parts of the mesh touch there or fold sharply; move them apart by a "
            "stitch, make the mesh smoother there, or choose another stitch width"
        )
    return YarnError(f"{named}near ({place}) cm: {error.found}", face=error.face, remedy=remedy)


def _thinner(made: Callable[[float], YarnSet], radius: float) -> float | None:
    """Return the largest tried radius whose yarns can be made, rounded as in the message; None if there is none."""
    for part in THINNER:
        thinner = float(f"{part * radius:.2g}")
        try:
            made(thinner)
        except StitchMeshError:
            continue
        return thinner
    return None
