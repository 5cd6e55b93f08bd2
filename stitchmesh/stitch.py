# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The stitches that a face of a stitch mesh can hold (Yuksel et al. 2012, section 4.2 and table 1).

A stitch is named by what is done on the loops below: ``k`` knit, ``p`` purl, ``y`` yarn-over, ``d`` decrease
followed by the stacking order of the loops it is worked through.
"""

from __future__ import annotations

from enum import IntEnum


class Stitch(IntEnum):
    """Type code of a stitch face; ``PANEL`` marks a face of a coarse mesh that is not one stitch yet."""

    PANEL = 0
    KNIT = 1
    PURL = 2
    CAST_ON = 3
    """Twisted yarn-overs on no loop: the first row, and new loops at the end of a short row."""
    BIND_OFF = 4
    """A yarn drawn through the loops below: the last row."""
    DRAW_THROUGH = 5
    """No top side: the row ends here and its yarn runs through the loops below."""
    KNIT_YARNOVER = 6
    YARNOVER_KNIT = 7
    KNIT_YARNOVER_KNIT = 8
    DECREASE_LEFT = 9
    """d12 k: two loops together, the left one in front."""
    DECREASE_RIGHT = 10
    """d21 k: two loops together, the right one in front."""
    DECREASE_CENTRE = 11
    """d213 k: three loops together, the centre one in front."""


CODES: dict[str, Stitch] = {
    "k": Stitch.KNIT,
    "p": Stitch.PURL,
    "ky": Stitch.KNIT_YARNOVER,
    "yk": Stitch.YARNOVER_KNIT,
    "kyk": Stitch.KNIT_YARNOVER_KNIT,
    "d12k": Stitch.DECREASE_LEFT,
    "d21k": Stitch.DECREASE_RIGHT,
    "d213k": Stitch.DECREASE_CENTRE,
}
"""The stitch of each code that a knitter writes."""

SIDE_COUNTS: dict[Stitch, tuple[int, int]] = {
    Stitch.KNIT: (1, 1),
    Stitch.PURL: (1, 1),
    Stitch.BIND_OFF: (1, 1),
    Stitch.KNIT_YARNOVER: (1, 2),
    Stitch.YARNOVER_KNIT: (1, 2),
    Stitch.KNIT_YARNOVER_KNIT: (1, 3),
    Stitch.DECREASE_LEFT: (2, 1),
    Stitch.DECREASE_RIGHT: (2, 1),
    Stitch.DECREASE_CENTRE: (3, 1),
}
"""Bottom and top sides of each stitch; the stitches not listed here take any number."""
