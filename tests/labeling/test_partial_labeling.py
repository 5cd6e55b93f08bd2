# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Labeling step by step: each step is a new value, and all steps together are the labeling in one call."""

from __future__ import annotations

from dataclasses import fields, replace

import numpy as np
import pytest

from stitchmesh.errors import LabelError, ParameterError
from stitchmesh.io import read_mesh
from stitchmesh.labeling import PartialLabeling, label, start_labeling
from stitchmesh.labeling.growth import COURSE
from stitchmesh.mesh import BORDER, Mesh, StitchMesh
from stitchmesh.mesh.courses import find_courses
from stitchmesh.tessellate import tessellate
from tests.gallery import FLAT_AND_ROUND, GARMENTS, grid, odd_corner, torus, tube

pytestmark = pytest.mark.decides

GLOVE = next(path for path in GARMENTS if path.stem == "glove")


def bits(value: StitchMesh | PartialLabeling) -> dict[str, bytes]:
    """Every array of a value as bytes."""
    arrays = {part.name: getattr(value, part.name) for part in fields(value)}
    return {name: array.tobytes() for name, array in arrays.items() if isinstance(array, np.ndarray)}


def row_by_row(labeling: PartialLabeling) -> PartialLabeling:
    """Label one row more until all faces are labeled."""
    while not labeling.labeled.all():
        labeling = labeling.label_rows(1)
    return labeling


def triangulated(mesh: Mesh) -> Mesh:
    """The same surface with each quad divided into two triangles."""
    quads = mesh.face_vertex.reshape(-1, 4).tolist()
    return Mesh.from_polygons(mesh.vertices, [t for a, b, c, d in quads for t in ([a, b, c], [a, c, d])])


def piece_and_odd_corner(columns: int = 9) -> Mesh:
    """A flat piece, and a part without rows beside it."""
    flat, odd = grid(columns, 3), odd_corner()
    vertices = np.concatenate([flat.vertices, odd.vertices + np.array([30.0, 0.0, 0.0])])
    faces = np.concatenate([flat.face_vertex, odd.face_vertex + len(flat.vertices)]).reshape(-1, 4)
    return Mesh.from_polygons(vertices, faces.tolist())


MESHES = {**FLAT_AND_ROUND, "glove": lambda: read_mesh(GLOVE)}


@pytest.mark.parametrize("make", MESHES.values(), ids=MESHES)
def test_row_after_row_is_the_labeling_in_one_call(make):
    mesh = make()
    whole = bits(label(mesh))
    assert bits(row_by_row(start_labeling(mesh)).finish()) == whole
    assert bits(start_labeling(mesh).label_rows(7).label_all().finish()) == whole


def test_starts_and_flips_in_steps_are_those_of_the_call():
    mesh = tube(8, 5)
    edges = [(8 * 5 + 1, 8 * 5), (0, 8)]
    steps = start_labeling(mesh).start_at_edge(edges[0]).label_all().flip_row(9)
    assert bits(steps.finish()) == bits(label(mesh, seeds=edges[:1], flip=[9]))
    assert bits(start_labeling(mesh).start_at_edge(edges[1]).label_all().finish()) == bits(label(mesh, seeds=edges[1:]))


def test_rows_can_be_labeled_by_ones_and_by_threes():
    mesh = tube(8, 6)
    three = start_labeling(mesh).label_rows(3)
    assert three.row_count == 3 and np.count_nonzero(three.labeled) == 24
    assert bits(three) == bits(start_labeling(mesh).label_rows(1).label_rows(1).label_rows(1))
    assert bits(three.label_rows(99)) == bits(three.label_all())


def test_a_start_at_a_border_goes_up_to_its_corners_or_around_them():
    """The border of a flat piece has four corners. As a whole it makes the corner faces start rows of their own."""
    mesh = grid(4, 3)
    side = start_labeling(mesh).start_at_edge((0, 1))
    whole = start_labeling(mesh).start_at_border((0, 1))
    border = mesh.side_edge[mesh.twin == BORDER]
    assert np.count_nonzero(side.edge_label[border] == COURSE) == 4
    assert (whole.edge_label[border] == COURSE).all()
    assert bits(label(mesh, seeds=[(0, 1)])) == bits(side.label_all().finish())


def test_a_start_at_an_inner_edge_takes_its_edge_loop():
    labeling = start_labeling(torus(6, 8)).start_at_edge((0, 1))
    assert np.count_nonzero(labeling.labeled) == 6 and labeling.row_count == 1


def test_one_row_at_a_course_edge_that_the_user_names():
    """The rows below and above the third border of rows of the tube wait; the user takes the one at the named edge."""
    mesh = tube(8, 6)
    middle = start_labeling(mesh).start_at_edge((24, 25))
    assert set(np.flatnonzero(middle.labeled)) == set(range(24, 32))
    upper = middle.label_row_at((32, 33))
    assert set(np.flatnonzero(upper.labeled)) == set(range(24, 40))
    lower = middle.label_row_at((24, 25))
    assert set(np.flatnonzero(lower.labeled)) == set(range(16, 32))


def test_a_labeled_mesh_becomes_a_labeling_and_the_same_mesh_again():
    fabric = label(read_mesh(GLOVE), flip=[5])
    assert len(find_courses(fabric)) == fabric.row.max() + 1, "each row of labeling is a course"
    labeling = PartialLabeling.of_rows(fabric)
    assert bits(labeling.finish()) == bits(fabric)
    assert labeling.flip_row(5).mismatched_sides().size != labeling.mismatched_sides().size


def test_a_flipped_row_keeps_its_direction_when_more_rows_are_labeled():
    mesh = tube(8, 4)
    flipped = start_labeling(mesh).label_rows(2).flip_row(8)
    assert flipped.row_is_reversed.tolist() == [False, True]
    assert flipped.label_all().row_is_reversed.tolist() == [False, True, False, False]


def test_rows_are_numbered_anew_after_flips():
    """With all rows flipped, the highest row is knitted first; one flipped row has no seams that match."""
    mesh = tube(8, 4)
    labeling = start_labeling(mesh).label_all()
    assert labeling.flip_row(8).finish().row.reshape(4, 8)[:, 0].tolist() == [0, 1, 2, 3]
    assert labeling.flip_row(8).flip_row(16).finish().row.reshape(4, 8)[:, 0].tolist() == [0, 2, 1, 3]
    for face in (0, 8, 16, 24):
        labeling = labeling.flip_row(face)
    turned = labeling.finish()
    assert turned.row.reshape(4, 8)[:, 0].tolist() == [3, 2, 1, 0]
    assert not turned.mismatched.any()


def test_the_sides_that_do_not_match_are_those_of_the_finished_mesh():
    labeling = start_labeling(read_mesh(GLOVE)).label_all()
    assert 2 * len(labeling.mismatched_sides()) == labeling.finish().mismatched.sum()
    flipped = labeling.flip_row(40)
    assert 2 * len(flipped.mismatched_sides()) == flipped.finish().mismatched.sum() > 0


def test_faces_that_cannot_be_labeled_are_named_and_the_rest_stays():
    mesh = piece_and_odd_corner()
    labeling = start_labeling(mesh).label_all()
    assert labeling.labeled[:27].all() and not labeling.labeled[27:].all()
    faults = [fault for fault in labeling.faults if "both wale and course" in fault.reason]
    assert faults and all(set(fault.faces) <= {27, 28, 29} for fault in faults)
    with pytest.raises(LabelError, match=r"face \d+ and \d+: edge \d+-\d+ would be both wale and course") as error:
        labeling.finish()
    assert error.value.labeling is labeling


def test_unfinished_rows_are_no_fault_but_cannot_be_finished():
    labeling = start_labeling(tube(8, 4)).label_rows(2)
    assert labeling.faults == ()
    with pytest.raises(LabelError, match="16 of 32 faces have no row yet; label more rows"):
        labeling.finish()


def test_a_mesh_of_triangles_is_called_one():
    mesh = triangulated(tube(8, 3))
    with pytest.raises(LabelError, match="these are triangles: 48 of 48 faces; rows need quads"):
        label(mesh)


MESH = tube(8, 3)
EMPTY = start_labeling(MESH)
HALF = EMPTY.label_rows(2)
REFUSED = {
    "no edge": (lambda: EMPTY.start_at_edge((0, 5)), ParameterError, "edge 0-5: no edge joins these vertices"),
    "no side": (lambda: EMPTY.start_at_edge(9999), ParameterError, "there is no side 9999"),
    "no border": (lambda: EMPTY.start_at_border((8, 9)), ParameterError, "edge .*: does not lie on a border; edges of"),
    "closed": (lambda: start_labeling(torus(6, 8)).start_at_border((0, 1)), ParameterError, "the mesh has no border"),
    "wale": (lambda: HALF.start_at_edge((0, 8)), LabelError, "would be both course and wale"),
    "nothing left": (lambda: HALF.label_all().label_rows(1), ParameterError, "nothing is left to label: all 24 faces"),
    "no start": (lambda: start_labeling(torus(6, 8)).label_rows(1), ParameterError, "nothing can be labeled"),
    "no rows": (lambda: HALF.label_rows(0), ParameterError, "rows: got 0; expected at least 1"),
    "not a course": (lambda: HALF.label_row_at((0, 8)), ParameterError, "is not a labeled course edge"),
    "row there": (lambda: HALF.label_row_at((0, 1)), ParameterError, "no row can be labeled here"),
    "no face": (lambda: HALF.flip_row(99), ParameterError, "flip: face 99 does not exist; the mesh has faces 0 to 23"),
    "no row yet": (lambda: HALF.flip_row(23), ParameterError, "flip: face 23 has no row yet"),
    "no label": (lambda: HALF.set_edge((0, 1), "blue"), ParameterError, "got 'blue'; expected course, wale"),
    "stitches": (
        lambda: PartialLabeling.of_rows(tessellate(HALF.label_all().finish(), stitch_width=1.0)),
        ParameterError, "face 0: is a stitch already; reverse its row by the edit flip_row",
    ),
    "not a mesh": (lambda: start_labeling([1, 2]), ParameterError, "start_labeling: got"),
}  # fmt: skip


@pytest.mark.parametrize("name", REFUSED)
def test_bad_steps_are_refused_in_one_line_and_change_nothing(name):
    step, kind, message = REFUSED[name]
    kept = bits(EMPTY), bits(HALF)
    with pytest.raises(kind, match=message) as error:
        step()
    assert "\n" not in str(error.value)
    assert (bits(EMPTY), bits(HALF)) == kept


def test_arrays_that_contradict_each_other_are_refused():
    labeling = start_labeling(tube(8, 3)).label_rows(2)
    for name, value in [
        ("row", np.where(labeling.row == 0, 5, labeling.row)),
        ("row", labeling.row[:-1]),
        ("left_wale", labeling.right_wale),
        ("edge_label", np.full_like(labeling.edge_label, -1)),
        ("edge_label", labeling.edge_label + 5),
        ("waiting", np.array([10_000])),
        ("seeded", np.zeros(9, dtype=bool)),
    ]:
        with pytest.raises(LabelError):
            replace(labeling, **{name: value})
