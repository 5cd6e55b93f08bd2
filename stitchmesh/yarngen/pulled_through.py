# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Did yarn pass through yarn since it was drawn?

The drawn yarns are led to where they are now (``way``), every pass of yarn through yarn on that way is found
(``crossing_yarn``), and passes that undo one another are taken out (``undone_passes``). Yarn slides, turns and curls
that way without a trace; what is left cannot be undone along that way. One way without a trace is enough: as the shape
of the fabric does not tell how it got there, several are tried, on which it turns more or less evenly.
"""

from __future__ import annotations

import numpy as np

from stitchmesh.errors import YarnError
from stitchmesh.yarn import YarnSet
from stitchmesh.yarngen.crossing_yarn import Journey, Pass
from stitchmesh.yarngen.strands import SAMPLES
from stitchmesh.yarngen.undone_passes import lasting_passes
from stitchmesh.yarngen.way import Way

EVENINGS = (5, 0, 20)
"""How much rotations are evened out on the ways that are tried."""
AT_HOME = 1e-3
"""Over the yarn radius: yarns that moved less have not moved."""


def pulled_through(drawn: YarnSet, yarns: YarnSet) -> list[Pass]:
    """Passes of yarn through yarn, sampled points of ``strands``, that nothing undoes; those of the best way.

    Args:
        drawn: the yarns as generated.
        yarns: the same yarns as they are now.
    """
    if np.abs(drawn.points - yarns.points).max() < AT_HOME * yarns.radius.min():
        return []
    best: list[Pass] | None = None
    for evening in EVENINGS:
        found = lasting_passes(Journey.along(Way(drawn, yarns, evening)))
        if best is None or len(found) < len(best):
            best = found
        if not best:
            break
    return best or []


def check_pulled_through(drawn: YarnSet, yarns: YarnSet) -> None:
    """Raise where yarn passed through yarn.

    Raises:
        YarnError: it did; names the faces of both.
    """
    found = pulled_through(drawn, yarns)
    if found:
        faces = [int(yarns.face[point // SAMPLES]) for point in (found[0].first, found[0].second)]
        raise YarnError(
            f"face {faces[0]}: its yarn passed through that of face {faces[1]} since it was drawn ({len(found)} such "
            "passes); expected none, relax the generated yarns again"
        )
