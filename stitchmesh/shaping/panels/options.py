# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""How the panels of a sewing pattern are knitted, apart from the size of the stitches."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

from stitchmesh.errors import ParameterError
from stitchmesh.shaping.options import DEFAULT_PLACEMENT, Placement, check_placement

PanelName = int | str
"""A panel by its number, or all panels of a name."""


@dataclass(frozen=True, kw_only=True)
class PanelOptions:
    """Options of ``knit_panels``, apart from the size of the stitches.

    Raises:
        ParameterError: a direction is not two finite numbers that are not both zero, or there is no such placement.
    """

    directions: Sequence[tuple[PanelName, tuple[float, float]]] = ()
    """Directions of knitting in the texture (u, v); if a panel has two, the later one counts."""
    sewn: Sequence[tuple[PanelName, PanelName]] = ()
    """Pairs of panels whose seams are left to be sewn, also where their stitches fit."""
    shaping: Placement = DEFAULT_PLACEMENT
    """Where increases and decreases stand: at both ends of the rows (``seams``) or ``spread``."""

    def __post_init__(self) -> None:
        check_placement(self.shaping)
        for panel, direction in self.directions:
            if len(direction) != 2 or not all(map(math.isfinite, direction)):
                raise ParameterError(
                    f"directions: panel {panel}: got {direction}; expected two numbers (u, v) that are finite"
                )
            if not any(direction):
                raise ParameterError(
                    f"directions: panel {panel}: got (0, 0); expected two numbers that are not both zero"
                )
