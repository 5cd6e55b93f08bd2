# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Pointing at a border starts a row, and pointing on labels the whole mesh."""

from __future__ import annotations

import numpy as np
import pytest

from stitchmesh.errors import ParameterError
from stitchmesh.labeling import PartialLabeling, start_labeling
from stitchmesh.labeling.steps import apply_label_step, free_border_sides, pointed_step
from stitchmesh.mesh import BORDER
from tests.gallery import grid, torus, tube

pytestmark = pytest.mark.decides


def pointed(labeling: PartialLabeling, side: int) -> PartialLabeling:
    return apply_label_step(labeling, pointed_step(labeling, side))


def first_border(labeling: PartialLabeling) -> int:
    return int(labeling.mesh.boundary_loops[0][0])


def test_a_border_starts_the_first_row():
    empty = start_labeling(tube(8, 5))
    side = first_border(empty)
    started = pointed(empty, side)
    assert started.row_count == 1
    assert started.labeled[empty.mesh.side_face[side]]
    assert (started.row == empty.start_at_edge(side).row).all()


@pytest.mark.parametrize("mesh", [tube(8, 5), grid(6, 4)], ids=["tube", "grid"])
def test_pointing_at_the_last_row_again_and_again_labels_all(mesh):
    labeling = pointed(start_labeling(mesh), int(mesh.boundary_loops[0][0]))
    while not labeling.labeled.all():
        last = int(np.flatnonzero(labeling.row == labeling.row_count - 1)[0])
        rows = labeling.row_count
        labeling = pointed(labeling, int(mesh.face_start[last]))
        assert labeling.row_count == rows + 1


def test_a_face_beside_a_row_gets_the_next_row():
    labeling = pointed(start_labeling(tube(8, 5)), first_border(start_labeling(tube(8, 5))))
    mesh = labeling.mesh
    across = mesh.twin[mesh.sides_of(np.flatnonzero(labeling.labeled))]
    beside = across[(across != BORDER) & ~labeling.labeled[mesh.side_face[across]]]
    for side in beside.tolist():
        assert pointed(labeling, side).labeled[mesh.side_face[side]]


def test_a_face_far_from_all_rows_stands_for_the_next_row():
    labeling = start_labeling(tube(8, 7)).label_rows(1)
    mesh = labeling.mesh
    at_border = np.zeros(mesh.face_count, dtype=bool)
    at_border[mesh.side_face[mesh.twin == BORDER]] = True
    near = np.zeros(mesh.face_count, dtype=bool)
    across = mesh.twin[mesh.sides_of(np.flatnonzero(labeling.labeled))]
    near[mesh.side_face[across[across != BORDER]]] = True
    far = np.flatnonzero(~at_border & ~near)
    assert pointed(labeling, int(mesh.face_start[far[0]])).row_count == 2


def test_a_mesh_without_rows_wants_a_border_first():
    mesh = grid(5, 5)
    at_border = np.unique(mesh.side_face[mesh.twin == BORDER])
    inner = np.setdiff1d(np.arange(mesh.face_count), at_border)[0]
    with pytest.raises(ParameterError, match=f"face {inner}: lies at no border; point at a border"):
        pointed_step(start_labeling(mesh), int(mesh.face_start[inner]))
    with pytest.raises(ParameterError, match="lies at no border"):
        pointed_step(start_labeling(torus(6, 8)), 0)


def test_a_row_between_rows_cannot_grow():
    with pytest.raises(ParameterError, match="row 0: has no face without a row beside it"):
        side = int(start_labeling(tube(8, 5)).mesh.boundary_loops[0][0])
        pointed_step(start_labeling(tube(8, 5)).start_at_border(side).label_all(), side)


def test_free_borders_are_those_that_no_row_has_reached():
    empty = start_labeling(tube(8, 5))
    assert len(free_border_sides(empty)) == 16
    started = pointed(empty, first_border(empty))
    assert len(free_border_sides(started)) == 8
    assert len(free_border_sides(started.label_all())) == 0
