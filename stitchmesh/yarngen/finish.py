# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""How first and last rows are finished, and which floats are cut."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from stitchmesh.errors import ParameterError
from stitchmesh.mesh import BORDER, IntArray, StitchMesh
from stitchmesh.mesh.courses import course_through
from stitchmesh.mesh.stitch import Stitch
from stitchmesh.yarngen.bind_off import small_rings
from stitchmesh.yarngen.bridges import Bridges, crossing_number
from stitchmesh.yarngen.templates.edge_templates import Edge

BIND_OFFS = ("drawn", "chain")
"""A yarn drawn through the last loops, or each loop knitted and the one before passed over it, but in small rings."""
CAST_ONS = ("backward", "open")
"""Backward loops, which do not open, or yarn-overs."""


@dataclass(frozen=True)
class YarnFinish:
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


DEFAULT_FINISH = YarnFinish()


def edges(whole: StitchMesh, bridges: Bridges, finish: YarnFinish) -> IntArray:
    """How each face is drawn (``Edge``), shape (F,).

    Args:
        whole: the stitch mesh with its bind-off row.
        bridges: its row ends: a row bound off is worked away from the end at which yarn reaches it.
        finish: what is chosen.
    """
    edge = np.full(whole.face_count, Edge.BY_STITCH)
    if finish.cast_on == "open":
        edge[whole.stitch == Stitch.CAST_ON] = Edge.YARN_OVERS
    if finish.bind_off == "chain":
        _draw_chains(whole, bridges, edge)
    return edge


def _draw_chains(whole: StitchMesh, bridges: Bridges, edge: IntArray) -> None:
    bound = whole.stitch == Stitch.BIND_OFF
    edge[bound] = Edge.CHAIN
    for ring in small_rings(whole):
        edge[whole.side_face[ring]] = Edge.BY_STITCH
    for face in np.flatnonzero(bound & (whole.twin[whole.left_wale] == BORDER)).tolist():
        row = list(course_through(whole, face, climbing=True).faces)
        if len(row) == 1:
            edge[face] = Edge.CHAIN_ALONE
        elif _starts_right(bridges, int(whole.left_wale[face]), int(whole.right_wale[row[-1]])):
            edge[row] = [Edge.LEFTWARD_LAST, *[Edge.LEFTWARD_CHAIN] * (len(row) - 2), Edge.LEFTWARD_FIRST]
        else:
            edge[row] = [Edge.CHAIN_FIRST, *[Edge.CHAIN] * (len(row) - 2), Edge.CHAIN_LAST]


def _starts_right(bridges: Bridges, left: int, right: int) -> bool:
    """Whether yarn reaches a row at its right end alone."""
    return crossing_number(right) in bridges.ways and crossing_number(left) not in bridges.ways
