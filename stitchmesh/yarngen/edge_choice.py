# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Choice of the template for each face of a first or last row, by the selected cast-on and bind-off."""

from __future__ import annotations

import numpy as np

from stitchmesh.mesh import BORDER, IntArray, StitchMesh
from stitchmesh.mesh.courses import course_through
from stitchmesh.mesh.stitch import Stitch
from stitchmesh.yarngen.bridges import Bridges, crossing_number
from stitchmesh.yarngen.finish import YarnFinish
from stitchmesh.yarngen.templates.edge_templates import Edge


def choose_edges(whole: StitchMesh, bridges: Bridges, finish: YarnFinish, drawn: IntArray) -> IntArray:
    """Template of each face of a first or last row (``Edge``), shape (F,).

    Args:
        whole: the stitch mesh with its bind-off row.
        bridges: the row ends; a bind-off row is worked away from the end at which the yarn arrives.
        finish: the selected cast-on and bind-off.
        drawn: top sides of the stitches below through which a yarn is drawn with any bind-off (``drawn_sides``).
    """
    edge = np.full(whole.face_count, Edge.BY_STITCH)
    if finish.cast_on == "open":
        edge[whole.stitch == Stitch.CAST_ON] = Edge.YARN_OVERS
    if finish.bind_off == "chain":
        _choose_chains(whole, bridges, edge, whole.side_face[whole.twin[drawn]])
    return edge


def _choose_chains(whole: StitchMesh, bridges: Bridges, edge: IntArray, drawn: IntArray) -> None:
    """Set the templates of all rows that are bound off in a chain; some faces keep their drawn-through yarn."""
    bound = whole.stitch == Stitch.BIND_OFF
    bound[drawn] = False
    edge[bound] = Edge.CHAIN
    for face in np.flatnonzero(bound & (whole.twin[whole.left_wale] == BORDER)).tolist():
        row = list(course_through(whole, face, climbing=True).faces)
        if len(row) == 1:
            edge[face] = Edge.CHAIN_ALONE
        elif _yarn_arrives_right(bridges, int(whole.left_wale[face]), int(whole.right_wale[row[-1]])):
            edge[row] = [Edge.LEFTWARD_LAST, *[Edge.LEFTWARD_CHAIN] * (len(row) - 2), Edge.LEFTWARD_FIRST]
        else:
            edge[row] = [Edge.CHAIN_FIRST, *[Edge.CHAIN] * (len(row) - 2), Edge.CHAIN_LAST]


def _yarn_arrives_right(bridges: Bridges, left: int, right: int) -> bool:
    """Whether the yarn arrives at the right end of a row and not at its left end."""
    return crossing_number(right) in bridges.paths and crossing_number(left) not in bridges.paths
