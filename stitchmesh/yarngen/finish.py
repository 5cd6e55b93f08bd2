# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""How first and last rows are finished, and which floats are cut."""

from __future__ import annotations

from dataclasses import dataclass

from stitchmesh.errors import ParameterError

BIND_OFFS = ("drawn", "chain")
"""A yarn drawn through the last loops, or each loop knitted and the one before passed over it, but in small rings."""
CAST_ONS = ("backward", "open")
"""Backward loops, which do not open, or yarn-overs."""


@dataclass(frozen=True)
class YarnFinish:
    """First and last rows, and floats.

    Raises:
        ParameterError: there is no such bind-off or cast-on, or the longest float is negative.
    """

    bind_off: str = "drawn"
    """drawn, a yarn through the last loops, or chain: each loop is knitted and the one before passed over it"""
    cast_on: str = "backward"
    """backward, loops that do not open, or open yarn-overs"""
    longest_float: int = 12
    """stitches of other yarns that a yarn is carried behind; where there are more, the yarn is cut and tied"""

    def __post_init__(self) -> None:
        for name, known in (("bind_off", BIND_OFFS), ("cast_on", CAST_ONS)):
            if getattr(self, name) not in known:
                raise ParameterError(f"{name}: got {getattr(self, name)!r}; expected one of {', '.join(known)}")
        if self.longest_float < 0:
            raise ParameterError(f"longest_float: got {self.longest_float} stitches; expected 0 or more")


DEFAULT_FINISH = YarnFinish()
