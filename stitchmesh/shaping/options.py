# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""How rows are found on a surface, apart from the size of the stitches."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Literal, get_args

from stitchmesh.errors import ParameterError
from stitchmesh.settings import check_settings, setting, setting_named
from stitchmesh.shaping.marks import TimeMark

UP = (0.0, 1.0, 0.0)
"""Direction in which garments are knitted where nothing else decides."""
PANEL_SIZE = 6
"""Stitches and courses of a panel of a labeled mesh. Panels are then 4 to 8 stitches wide: large enough that few faces
make a garment and that whole stitches divide an edge to an eighth, small enough for a sleeve of six panels."""

Placement = Literal["seams", "spread"]
"""Where increases and decreases stand: stacked at seams, or spread over the row."""
DEFAULT_PLACEMENT: Placement = "spread"
LEAST_SHAPING = 1e-9
"""Smallest part of the stitches of a row that may be shaped, so that it is above 0."""


@dataclass(frozen=True, kw_only=True)
class ShapingOptions:
    """Options of ``shape_fabric``, apart from the size of the stitches.

    Raises:
        ParameterError: the direction is zero or not finite, the multiple is not positive, the part of increases and
            decreases is not a part of 1, or there is no such placement.
    """

    up: tuple[float, float, float] = setting(
        UP, "direction in which the garment is knitted where no mark decides, after its mesh was turned upright",
        flag=None,
    )  # fmt: skip
    multiple: int = setting(
        1, "number that the stitches of each round are a multiple of, for a pattern that repeats",
        least=1, expected="1 or more stitches",
    )  # fmt: skip
    short_rows: bool = setting(
        True, "turn the yarn back within the fabric where rows are far too high, as at a heel"
    )
    marks: tuple[TimeMark, ...] = setting(
        (), "JSON list of places where knitting begins and ends, where a row runs, or where no shaping is "
        "(docs/recipes.md)", form="FILE", unset="automatic",
    )  # fmt: skip
    most_shaping: float | None = setting(
        None, "largest part of the stitches of a row that are increases or decreases, such as 0.25; rows that would "
        "need more are stretched", form="PART", unset="as the mesh asks", example=0.25, least=LEAST_SHAPING, most=1.0,
        expected="a part of the stitches of a row above 0 and at most 1, such as 0.25",
    )  # fmt: skip
    shaping: Placement = setting(
        DEFAULT_PLACEMENT, "increases and decreases: seams (stacked at sides, raglan lines and edges, in a rhythm) or "
        "spread over the row", form="WHERE", choices=get_args(Placement),
    )  # fmt: skip

    def __post_init__(self) -> None:
        if len(self.up) != 3 or not all(map(math.isfinite, self.up)) or not any(self.up):
            raise ParameterError(f"up: got {self.up}; expected three finite numbers that are not all zero")
        check_settings(self)


def check_most_shaping(part: float | None) -> None:
    """Check the largest part of the stitches of a row that are increases or decreases.

    Raises:
        ParameterError: the part is not above 0, or it is above 1.
    """
    setting_named(ShapingOptions, "most_shaping").check("most shaping", part)


def check_placement(shaping: str) -> None:
    """Check that there is a placement of increases and decreases of that name.

    Raises:
        ParameterError: there is no such placement.
    """
    setting_named(ShapingOptions, "shaping").check("shaping", shaping)


AUTOMATIC = ShapingOptions()
"""Rows that follow from the surface alone."""
