# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""How rows are found on a surface, apart from the size of the stitches."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal, get_args

from stitchmesh.errors import ParameterError
from stitchmesh.shaping.marks import TimeMark

UP = (0.0, 1.0, 0.0)
"""Direction in which garments are knitted where nothing else decides."""
PANEL_SIZE = 6
"""Stitches and courses of a panel of a labeled mesh. Panels are then 4 to 8 stitches wide: large enough that few faces
make a garment and that whole stitches divide an edge to an eighth, small enough for a sleeve of six panels."""

Placement = Literal["seams", "spread"]
"""Where increases and decreases stand: stacked at seams, or spread over the row."""
DEFAULT_PLACEMENT: Placement = "spread"


@dataclass(frozen=True, kw_only=True)
class ShapingOptions:
    """Options of ``shape_fabric``, apart from the size of the stitches.

    Raises:
        ParameterError: the direction is zero or not finite, the multiple is not positive, the part of increases and
            decreases is not a part of 1, or there is no such placement.
    """

    up: tuple[float, float, float] = UP
    """Direction in which the garment is knitted where nothing else decides."""
    multiple: int = 1
    """Number that the stitches of each round are a multiple of, for a pattern that repeats."""
    short_rows: bool = True
    """Whether the yarn turns back and comes again where rows are far too high, as at a heel; without, stitches there
    are stretched more."""
    marks: Sequence[TimeMark] = ()
    """Where knitting begins and ends, lines along which rows run, and plain places; automatic without any."""
    most_shaping: float | None = None
    """Largest part of the stitches of a row that are increases or decreases, such as 0.25 for one in four; None for as
    many as the surface asks. One is always permitted; rows that would need more are stretched."""
    shaping: Placement = DEFAULT_PLACEMENT
    """Where increases and decreases stand: ``spread`` over the row, or ``seams``: stacked at the sides of a tube, at
    underarms and raglan lines and at both ends of flat rows, in a steady rhythm. Where the surface asks for more than
    seams can give, and in rounds of a multiple, they are spread all the same."""

    def __post_init__(self) -> None:
        if len(self.up) != 3 or not all(map(math.isfinite, self.up)) or not any(self.up):
            raise ParameterError(f"up: got {self.up}; expected three finite numbers that are not all zero")
        if self.multiple < 1:
            raise ParameterError(f"multiple: got {self.multiple}; expected 1 or more stitches")
        check_most_shaping(self.most_shaping)
        check_placement(self.shaping)


def check_most_shaping(part: float | None) -> None:
    """Check the largest part of the stitches of a row that are increases or decreases.

    Raises:
        ParameterError: it is not above 0, or above 1.
    """
    if part is not None and not 0.0 < part <= 1.0:
        raise ParameterError(
            f"most shaping: got {part:g}; expected a part of the stitches of a row above 0 and at most 1, such as 0.25"
        )


def check_placement(shaping: str) -> None:
    """Check that there is a placement of increases and decreases of that name.

    Raises:
        ParameterError: there is none.
    """
    if shaping not in get_args(Placement):
        raise ParameterError(f"shaping: got {shaping!r}; expected one of {', '.join(get_args(Placement))}")


AUTOMATIC = ShapingOptions()
"""Rows that follow from the surface alone."""
