# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Options for the finish of first and last rows, and for the longest float."""

from __future__ import annotations

from dataclasses import dataclass

from stitchmesh.errors import ParameterError

BIND_OFFS = ("drawn", "chain")
"""Bind-offs. ``drawn``: a yarn is drawn through the last loops. ``chain``: each loop is knitted and the loop before it
is passed over it, except in small rings."""
CAST_ONS = ("backward", "open")
"""Cast-ons. ``backward``: loops whose legs cross, so that they do not open. ``open``: yarn-overs."""


@dataclass(frozen=True)
class YarnFinish:
    """How first and last rows are finished, and how long floats may be.

    Raises:
        ParameterError: the bind-off or the cast-on is unknown, or the longest float is negative.
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
"""The finish that is used where none is given."""
