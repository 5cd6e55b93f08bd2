# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Options of the first rows, the last rows and the floats of generated yarns."""

from __future__ import annotations

from dataclasses import dataclass

from stitchmesh.settings import check_settings, setting

BIND_OFFS = ("drawn", "chain")
"""Kinds of bind-off. ``drawn``: a yarn is drawn through the last loops, which stay long.

``chain``, the default: each loop of the last row is knitted, and the loop before it is passed over it; small rings are
drawn in any case.
"""
CAST_ONS = ("backward", "open")
"""Kinds of cast-on. ``backward``: backward loops, which cannot unravel. ``open``: yarn-overs."""


@dataclass(frozen=True)
class YarnFinish:
    """How first and last rows are finished, and how long floats may be.

    Raises:
        ParameterError: the bind-off or the cast-on is unknown, or the longest float is negative.
    """

    bind_off: str = setting(
        "chain", "bind-off: chain (each loop is passed over the next one), or drawn (a yarn through the last loops)",
        choices=BIND_OFFS,
    )  # fmt: skip
    cast_on: str = setting(
        "backward", "cast-on: backward (backward loops, which cannot unravel), or open (yarn-overs)", choices=CAST_ONS
    )
    longest_float: int = setting(
        12, "largest number of stitches of other yarns behind which a yarn floats; longer floats are cut and tied",
        least=0, expected="0 or more stitches",
    )  # fmt: skip

    def __post_init__(self) -> None:
        check_settings(self)


DEFAULT_FINISH = YarnFinish()
"""The finish that is used where none is given."""
