# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""How rows are found on a surface, apart from the size of the stitches."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from stitchmesh.errors import ParameterError
from stitchmesh.shaping.marks import TimeMark

UP = (0.0, 1.0, 0.0)
"""Direction in which garments are knitted where nothing else decides."""
PANEL_SIZE = 6
"""Stitches and courses of a panel of a labeled mesh. Panels are then 4 to 8 stitches wide: large enough that few faces
make a garment and that whole stitches divide an edge to an eighth, small enough for a sleeve of six panels."""


@dataclass(frozen=True, kw_only=True)
class ShapingOptions:
    """Options of ``shape_fabric``, apart from the size of the stitches.

    Raises:
        ParameterError: the direction is zero or not finite, or the multiple is not positive.
    """

    up: tuple[float, float, float] = UP
    """Direction in which the garment is knitted where nothing else decides."""
    multiple: int = 1
    """Number that the stitches of each round are a multiple of, for a pattern that repeats."""
    short_rows: bool = False
    """Whether the yarn turns back and comes again where rows are far too high."""
    marks: Sequence[TimeMark] = ()
    """Where knitting begins and ends, and lines along which rows run; automatic without any."""

    def __post_init__(self) -> None:
        if len(self.up) != 3 or not all(map(math.isfinite, self.up)) or not any(self.up):
            raise ParameterError(f"up: got {self.up}; expected three finite numbers that are not all zero")
        if self.multiple < 1:
            raise ParameterError(f"multiple: got {self.multiple}; expected 1 or more stitches")

    @property
    def arguments(self) -> dict[str, Any]:
        """Arguments of ``shape_fabric`` besides the mesh and the size of the stitches."""
        return {"up": self.up, "multiple": self.multiple, "short_rows": self.short_rows, "marks": self.marks}
