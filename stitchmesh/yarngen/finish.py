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
class Finish:
    """What a knitter chooses beside the stitches.

    Raises:
        ParameterError: there is no such bind-off or cast-on, or the longest float is negative.
    """

    bind_off: str = "drawn"
    """One of ``BIND_OFFS``."""
    cast_on: str = "backward"
    """One of ``CAST_ONS``."""
    longest_float: int = 12
    """Stitches of other yarns that a yarn is carried behind; where there are more it is cut and tied."""

    def __post_init__(self) -> None:
        for name, known in (("bind_off", BIND_OFFS), ("cast_on", CAST_ONS)):
            if getattr(self, name) not in known:
                raise ParameterError(f"{name}: got {getattr(self, name)!r}; expected one of {', '.join(known)}")
        if self.longest_float < 0:
            raise ParameterError(f"longest_float: got {self.longest_float} stitches; expected 0 or more")


DEFAULT_FINISH = Finish()
