# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Whether yarn has passed through yarn since it was generated (a pull-through).

The generated yarns are deformed continuously into their present positions (``deformation_path``). Every crossing of
yarn through yarn on that path is found (``crossings_along_path``), and crossings that cancel each other are removed
(``cancelling_crossings``). Yarn that slides, turns or curls leaves no crossings. A pull-through leaves a crossing on
every path. The shape of a fabric does not determine the path on which it was deformed. Several paths are therefore
tried, with more or less smooth rotations. A crossing that remains in the same place on all paths is a pull-through.
"""

from __future__ import annotations

import numpy as np

from stitchmesh.errors import YarnError
from stitchmesh.linking.cancelling_crossings import near_crossings, uncancelled
from stitchmesh.linking.crossings_along_path import SampledPath, YarnCrossing
from stitchmesh.linking.deformation_path import DeformationPath
from stitchmesh.linking.rings import LONGEST_RING
from stitchmesh.linking.yarn_polylines import SAMPLES_PER_POINT, YarnPolylines
from stitchmesh.yarn import YarnSet

PATH_SETTINGS = ((5, 64), (0, 32), (5, 32), (20, 32), (0, 16), (100, 64))
"""Deformation paths that are tried: the number of smoothing steps of the rotations, and the number of control points
from which each rotation is computed."""


def pulled_through(generated: YarnSet, yarns: YarnSet) -> list[YarnCrossing]:
    """Crossings of yarn through yarn that remain on every deformation path.

    Args:
        generated: the yarns as generated.
        yarns: the same yarns at their present positions.

    Returns:
        The remaining crossings on the last path, by sampled points of ``YarnPolylines``; empty if there are none.
    """
    # Yarns that moved less than this, over the yarn radius, count as unmoved.
    if np.abs(generated.points - yarns.points).max() < 1e-3 * yarns.radius.min():
        return []
    polylines, reach = YarnPolylines(generated), LONGEST_RING * float(yarns.radius.mean())
    remaining: list[YarnCrossing] | None = None
    for smoothing_steps, neighbour_count in PATH_SETTINGS:
        found = uncancelled(SampledPath.along(DeformationPath(generated, yarns, smoothing_steps, neighbour_count)))
        if remaining is not None:
            found = [remaining[k] for k in sorted({k for k, _ in near_crossings(polylines, remaining, found, reach)})]
        remaining = found
        if not remaining:
            break
    return remaining or []


def check_pulled_through(generated: YarnSet, yarns: YarnSet) -> None:
    """Check that no yarn has passed through yarn.

    Args:
        generated: the yarns as generated.
        yarns: the same yarns at their present positions.

    Raises:
        YarnError: a yarn has passed through another one; the message names the faces of both.
    """
    found = pulled_through(generated, yarns)
    if found:
        faces = [int(yarns.face[point // SAMPLES_PER_POINT]) for point in (found[0].first, found[0].second)]
        raise YarnError(
            f"face {faces[0]}: its yarn passed through that of face {faces[1]} since it was generated ({len(found)} "
            "such crossings); expected none, relax the generated yarns again"
        )
