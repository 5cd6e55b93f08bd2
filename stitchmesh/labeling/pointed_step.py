# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The labeling step that follows when a user points at a face of a partly labeled mesh.

The user points at a border to start the first row, and at further faces to make the next rows (Yuksel et al. 2012,
Figure 11).
"""

from __future__ import annotations

import numpy as np

from stitchmesh.errors import ParameterError
from stitchmesh.labeling.growth import COURSE, UNKNOWN
from stitchmesh.labeling.partial_labeling import PartialLabeling
from stitchmesh.labeling.steps import LabelStep
from stitchmesh.mesh import BORDER, IntArray


def pointed_step(labeling: PartialLabeling, side: int) -> LabelStep:
    """Return the step that grows a row where a user points.

    - A face without a row that touches a labeled course edge gets its row from this edge.
    - Else, a face without a row at a border starts a row there: along the whole border, or up to the next corners.
    - Else, any face without a row stands for the next row, if there are rows already.
    - A face with a row stands for the next row beside its row.

    Args:
        labeling: the partly labeled mesh.
        side: the side of the face that is nearest to the place.

    Raises:
        ParameterError: no row can grow there; the message says where to point instead.
    """
    face = int(labeling.mesh.side_face[side])
    if labeling.labeled[face]:
        return LabelStep("label_row_at", {"edge": _side_beside_row(labeling, side)})
    sides = _nearest_first(labeling, side)
    ready = sides[_borders_a_row(labeling, sides)]
    if len(ready):
        return LabelStep("label_row_at", {"edge": ready[0]})
    border = sides[labeling.mesh.twin[sides] == BORDER]
    if len(border):
        return LabelStep("start_at_edge", {"edge": border[0]})
    if not labeling.labeled.any():
        raise ParameterError(f"face {face}: lies at no border; point at a border, from which the first row starts")
    return LabelStep("label_rows", {"count": 1})


def free_border_sides(labeling: PartialLabeling) -> IntArray:
    """Return the sides on borders that no row has reached, at which a row can start, shape (n,)."""
    mesh = labeling.mesh
    return np.flatnonzero((mesh.twin == BORDER) & (labeling.edge_label[mesh.side_edge] == UNKNOWN))


def _nearest_first(labeling: PartialLabeling, side: int) -> IntArray:
    """The sides of the face of a side, beginning with the side itself."""
    mesh = labeling.mesh
    face = mesh.side_face[side]
    sides = np.arange(mesh.face_start[face], mesh.face_start[face + 1])
    return np.concatenate([[side], sides[sides != side]])


def _borders_a_row(labeling: PartialLabeling, sides: IntArray) -> np.ndarray:
    """Whether each side is a course edge with a labeled face across, shape (n,)."""
    mesh = labeling.mesh
    across = mesh.twin[sides]
    course = labeling.edge_label[mesh.side_edge[sides]] == COURSE
    return course & (across != BORDER) & labeling.labeled[mesh.side_face[across]]


def _side_beside_row(labeling: PartialLabeling, side: int) -> int:
    """A side, if possible of this face, between its row and a face without a row."""
    mesh = labeling.mesh
    row = labeling.row[mesh.side_face[side]]
    for sides in (_nearest_first(labeling, side), mesh.sides_of(np.flatnonzero(labeling.row == row))):
        across = mesh.twin[sides]
        free = (across != BORDER) & ~labeling.labeled[mesh.side_face[across]]
        free &= labeling.edge_label[mesh.side_edge[sides]] == COURSE
        if free.any():
            return int(sides[free][0])
    raise ParameterError(f"row {row}: has no face without a row beside it; it can only be reversed, by flip_row")
