# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Edges that the user labels by hand: faces with any two wale edges, rows that divide and join, and refusals."""

from __future__ import annotations

import numpy as np
import pytest

from stitchmesh.errors import LabelError
from stitchmesh.labeling import PartialLabeling, start_labeling
from stitchmesh.labeling.growth import COURSE, WALE
from stitchmesh.mesh import Mesh
from stitchmesh.meshrelax import relax_mesh
from stitchmesh.tessellate import tessellate
from stitchmesh.yarngen import generate_yarns
from tests.gallery import grid, tube
from tests.labeling.test_label import assert_rows
from tests.labeling.test_partial_labeling import bits, row_by_row

pytestmark = pytest.mark.decides


def vertex(columns: int, column: int, row: int) -> int:
    """Number of a vertex of ``grid``."""
    return row * (columns + 1) + column


def mitred(size: int) -> PartialLabeling:
    """A square whose rows turn a right angle on its diagonal, where wale edges are neighbours; only those are set."""
    labeling = start_labeling(grid(size, size, width=3.0, height=3.0))
    for place in range(size):
        low, right = vertex(size, place, place), vertex(size, place + 1, place)
        above, opposite = vertex(size, place, place + 1), vertex(size, place + 1, place + 1)
        labeling = labeling.set_edge((low, above), "wale").set_edge((low, right), "wale")
        labeling = labeling.set_edge((right, opposite), "course").set_edge((above, opposite), "course")
    return labeling


def test_rows_turn_a_corner_where_wale_edges_are_neighbours():
    """The row of the face (k, k) of the diagonal has the faces below it and those on its left: 2 k + 1 faces."""
    labeling = mitred(4)
    assert np.flatnonzero(labeling.labeled).tolist() == [0, 5, 10, 15], "a face is labeled when its edges are"
    fabric = labeling.label_all().finish()
    assert_rows(fabric)
    assert np.bincount(fabric.row).tolist() == [1, 3, 5, 7]
    corner = np.arange(4) * 5
    assert (fabric.n_bottom[corner] + fabric.n_top[corner] == 2).all()
    assert (fabric.n_bottom[corner] * fabric.n_top[corner] == 0).all()
    assert not fabric.mismatched.any()
    relaxed = relax_mesh(tessellate(fabric, stitch_width=1.0), surface=labeling.mesh).fabric
    assert generate_yarns(relaxed, yarn_radius=0.1, quality="draft").yarn_count > 0


def test_growth_respects_labels_of_edges_that_were_set_before():
    """Two edges of each face of the diagonal are enough if the row reaches the face through one of them."""
    size = 3
    labeling = start_labeling(grid(size, size))
    for place in range(size):
        low = vertex(size, place, place)
        labeling = labeling.set_edge((low, low + 1), "wale").set_edge((low, low + size + 1), "wale")
    grown = labeling.start_at_edge((vertex(size, size, 0), vertex(size, size, 1))).label_all()
    assert grown.labeled.all()
    assert np.bincount(grown.row).tolist() == [5, 3, 1]


def test_an_edge_set_wrongly_names_the_faces_at_fault_and_the_rest_stays():
    mesh = tube(8, 3)
    whole = start_labeling(mesh).label_all()
    wrong = whole.set_edge((8, 9), "wale")
    assert np.flatnonzero(~wrong.labeled).tolist() == [0, 8]
    assert [fault.reason.split(";")[0] for fault in wrong.faults] == [
        f"face {face}: has 3 wale edges, but a face needs exactly 2" for face in (0, 8)
    ]
    with pytest.raises(LabelError, match="has 3 wale edges"):
        wrong.finish()
    back = wrong.set_edge((8, 9), "course")
    assert back.labeled.all() and bits(back.finish()) == bits(whole.finish())


def test_a_cleared_edge_is_labeled_again_by_the_next_rows():
    mesh = tube(8, 3)
    whole = start_labeling(mesh).label_all()
    for edge in [(8, 9), (0, 8), (0, 1)]:
        cleared = whole.set_edge(edge, None)
        assert not cleared.labeled.all() and cleared.faults == ()
        assert bits(row_by_row(cleared).finish()) == bits(whole.finish())


def test_a_row_that_is_cut_twice_has_two_numbers():
    """A ring without two of its faces is two rows; the rows after it move up."""
    mesh = tube(8, 3)
    whole = start_labeling(mesh).label_all()
    cut = whole.set_edge((8 + 0, 16 + 0), None).set_edge((8 + 4, 16 + 4), None)
    middle = cut.row[8:16]
    assert sorted(set(middle[middle >= 0])) == [1, 2] and set(cut.row[16:24]) == {3}
    assert bits(cut.label_all().finish()) == bits(whole.finish())


def test_two_rows_become_one_when_a_face_joins_them():
    """On a flat strip, the faces on both sides of a gap have rows of opposite directions; the joined row has one."""
    mesh = grid(5, 1)
    ends = start_labeling(mesh)
    for column, direction in ((0, 1), (4, -1)):
        edges = [(column, column + 1), (6 + column, 7 + column)][::direction]
        for edge in edges:
            ends = ends.set_edge(edge, "course")
        for edge in [(column, 6 + column), (column + 1, 7 + column)][::direction]:
            ends = ends.set_edge(edge, "wale")
    assert ends.row_count == 2
    joined = ends.label_all()
    assert joined.labeled.all() and joined.row_count == 1
    assert_rows(joined.finish())


def test_labels_by_hand_that_leave_no_two_wale_edges_are_refused():
    labeling = start_labeling(grid(1, 1)).set_edge((0, 1), "wale").set_edge((0, 2), "wale")
    with pytest.raises(LabelError, match=r"edge \d-\d: cannot be wale, because two other edges of face 0"):
        labeling.set_edge((1, 3), "wale")
    courses = start_labeling(grid(1, 1)).set_edge((0, 1), "course").set_edge((2, 3), "course")
    with pytest.raises(LabelError, match=r"cannot be course, because face 0 would have 1 wale edges left and needs 2"):
        courses.set_edge((1, 3), "course")


def test_an_edge_by_hand_that_leaves_a_choice_is_named():
    """The edge opposite to the border needs a second wale edge, and either side is possible."""
    labeling = start_labeling(grid(1, 1)).set_edge((2, 3), "wale").start_at_edge((0, 1))
    (fault,) = labeling.faults
    assert fault.faces == (0,)
    assert "edge 3-2 was set to wale by hand, which does not fit the rows" in fault.reason
    assert labeling.set_edge((1, 3), "wale").label_all().labeled.all()


def test_a_row_from_the_side_leaves_no_choice():
    """The row of the face beside it enters through one wale edge; the other one was set by hand."""
    labeling = start_labeling(grid(3, 3)).set_edge((5, 6), "wale").start_at_edge((1, 2)).label_all()
    assert labeling.labeled[1] and labeling.row[1] == labeling.row[2] and labeling.row[1] == labeling.row[4]


@pytest.mark.parametrize("seed", range(4))
def test_random_labels_keep_every_value_consistent(seed):
    """Whatever edges are set and cleared, the value passes its own check, and its rows are faces joined by wales."""
    mesh = [grid(5, 4), tube(6, 4)][seed % 2]
    random = np.random.default_rng(seed)
    labeling = start_labeling(mesh)
    if seed % 3:
        labeling = labeling.label_rows(2)
    for _ in range(25):
        side = int(random.integers(mesh.side_count))
        choice = ["course", "wale", None][int(random.integers(3))]
        try:
            labeling = labeling.set_edge(side, choice)
        except LabelError:
            continue
        if random.random() < 0.3:
            labeling = labeling.label_all()
        if labeling.row_count and random.random() < 0.3:
            labeling = labeling.flip_row(int(random.choice(np.flatnonzero(labeling.labeled))))
        assert_rows_are_joined_faces(mesh, labeling)


def assert_rows_are_joined_faces(mesh: Mesh, labeling: PartialLabeling) -> None:
    """Check that labeled neighbours across a wale edge are in one row, the one on the right of the other."""
    inner = np.flatnonzero((mesh.twin >= 0) & (labeling.edge_label[mesh.side_edge] == WALE))
    faces, across = mesh.side_face[inner], mesh.side_face[mesh.twin[inner]]
    both = labeling.labeled[faces] & labeling.labeled[across]
    assert (labeling.row[faces[both]] == labeling.row[across[both]]).all()
    is_right = labeling.right_wale[faces[both]] == inner[both]
    enters_left = labeling.left_wale[across[both]] == mesh.twin[inner[both]]
    assert (is_right == enters_left).all()
    course = labeling.edge_label[mesh.side_edge[labeling.left_wale[labeling.labeled]]]
    assert (course == WALE).all() and COURSE not in course
