# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Triangles chosen by hand: those of panels, or of faces of a stitch mesh.

All functions return numbers of triangles, ascending and without repeats, as a region takes them (``region_around``).
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from stitchmesh.errors import ParameterError
from stitchmesh.mesh import StitchMesh
from stitchmesh.mixed.cloth.cloth import Cloth
from stitchmesh.mixed.cloth.from_stitches import triangle_start

Integers = NDArray[np.int64]


def triangles_of_panels(cloth: Cloth, *panels: str) -> Integers:
    """The triangles of panels by name.

    Raises:
        ParameterError: there is no such panel.
    """
    return np.flatnonzero(np.isin(cloth.panel, [_panel_number(cloth, panel) for panel in panels]))


def triangles_of_faces(fabric: StitchMesh, faces: ArrayLike) -> Integers:
    """The triangles of faces of a stitch mesh, in the cloth of ``cloth_from_stitches``.

    Args:
        fabric: the stitch mesh.
        faces: numbers of faces, as ``sm.select`` returns them for a selection such as ``hem 6``.

    Raises:
        ParameterError: a number is not that of a face.
    """
    start = triangle_start(fabric)
    chosen = np.unique(np.asarray(faces, dtype=np.int64))
    if len(chosen) and (chosen[0] < 0 or chosen[-1] >= len(start) - 1):
        found = f"got face {chosen[0] if chosen[0] < 0 else chosen[-1]}"
        raise ParameterError(f"yarn placement: {found}; expected 0 to {len(start) - 2}")
    mask = np.zeros(len(start) - 1, dtype=bool)
    mask[chosen] = True
    return np.flatnonzero(np.repeat(mask, np.diff(start)))


def _panel_number(cloth: Cloth, panel: str) -> int:
    if panel not in cloth.panel_names:
        raise ParameterError(f"yarn placement: got panel {panel!r}; expected one of {', '.join(cloth.panel_names)}")
    return cloth.panel_names.index(panel)
