# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""How the panels of a sewing pattern are knitted, apart from the size of the stitches."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import get_args

from stitchmesh.errors import ParameterError
from stitchmesh.settings import check_settings, setting
from stitchmesh.shaping.options import DEFAULT_PLACEMENT, Placement

PanelName = int | str
"""A panel by its number, or all panels of a name: the name of an object, a group or a material."""


@dataclass(frozen=True, kw_only=True)
class PanelDirection:
    """The direction of knitting of a panel."""

    panel: PanelName
    """The panel."""
    direction: tuple[float, float]
    """Direction in the texture (u, v)."""


@dataclass(frozen=True, kw_only=True)
class PanelOptions:
    """Options of ``knit_panels``, apart from the size of the stitches.

    Raises:
        ParameterError: a direction is not two finite numbers that are not both zero, or there is no such placement.
    """

    directions: tuple[PanelDirection, ...] = setting(
        (), "direction of knitting of a panel in its texture; PANEL is a number, or the name of objects or groups",
        flag="panel-direction", form="PANEL=U,V", unset="0,1: up in the pattern",
    )  # fmt: skip
    sewn: tuple[tuple[PanelName, PanelName], ...] = setting(
        (), "two panels whose seams are left to be sewn, also where their stitches fit", flag="sew", form="PANEL,PANEL"
    )
    shaping: Placement = setting(
        DEFAULT_PLACEMENT, "increases and decreases: at both ends of the rows (seams) or spread", flag=None,
        choices=get_args(Placement),
    )  # fmt: skip

    def __post_init__(self) -> None:
        check_settings(self)
        for one in self.directions:  # if a panel has two, the later one counts
            if len(one.direction) != 2 or not all(map(math.isfinite, one.direction)):
                raise ParameterError(
                    f"directions: panel {one.panel}: got {one.direction}; expected two numbers (u, v) that are finite"
                )
            if not any(one.direction):
                raise ParameterError(
                    f"directions: panel {one.panel}: got (0, 0); expected two numbers that are not both zero"
                )
