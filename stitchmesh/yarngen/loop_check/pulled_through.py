# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Did yarn pass through yarn since it was drawn?

The drawn yarns are led to where they are now (``way``), every pass of yarn through yarn on that way is found
(``crossing_yarn``), and passes that undo one another are taken out (``undone_passes``). Yarn slides, turns and curls
that way without a trace. Yarn that was pulled through leaves one, on whatever way: as the shape of a fabric does not
tell how it got there, several are tried, on which it turns more or less evenly, and what leaves a trace in the same
place on all of them has been pulled through.
"""

from __future__ import annotations

import numpy as np

from stitchmesh.errors import YarnError
from stitchmesh.yarn import YarnSet
from stitchmesh.yarngen.loop_check.cancelling_crossings import LONGEST_RING, near_crossings, uncancelled
from stitchmesh.yarngen.loop_check.crossings_along_path import SampledPath, YarnCrossing
from stitchmesh.yarngen.loop_check.deformation_path import DeformationPath
from stitchmesh.yarngen.loop_check.yarn_polylines import SAMPLES_PER_POINT, YarnPolylines

PATH_SETTINGS = ((5, 64), (0, 32), (5, 32), (20, 32), (0, 16), (100, 64))
"""How often rotations are evened out on the ways that are tried, and of how many control points each is."""
UNMOVED = 1e-3
"""Over the yarn radius: yarns that moved less have not moved."""


def pulled_through(generated: YarnSet, yarns: YarnSet) -> list[YarnCrossing]:
    """Passes of yarn through yarn, by sampled points of ``polylines``, which no way can do without.

    Args:
        drawn: the yarns as generated.
        yarns: the same yarns as they are now.
    """
    if np.abs(generated.points - yarns.points).max() < UNMOVED * yarns.radius.min():
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
    """Raise where yarn passed through yarn.

    Raises:
        YarnError: it did; names the faces of both.
    """
    found = pulled_through(generated, yarns)
    if found:
        faces = [int(yarns.face[point // SAMPLES_PER_POINT]) for point in (found[0].first, found[0].second)]
        raise YarnError(
            f"face {faces[0]}: its yarn passed through that of face {faces[1]} since it was drawn ({len(found)} such "
            "passes); expected none, relax the generated yarns again"
        )
