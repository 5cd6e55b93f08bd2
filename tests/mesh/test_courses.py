# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Courses, neighbours along courses, and roles of sides."""

from __future__ import annotations

import numpy as np
import pytest

from stitchmesh.editing.spiral import make_spiral
from stitchmesh.mesh import BORDER, StitchMesh
from stitchmesh.mesh.courses import (
    chain_through,
    course_through,
    find_courses,
    left_neighbours,
    renumbered_rows,
    right_neighbours,
)
from tests.editing.fabrics import around, flat

pytestmark = pytest.mark.decides

FABRICS = {"flat": flat, "tube": around, "spiral": lambda: make_spiral(around())}


@pytest.fixture(params=FABRICS)
def fabric(request) -> StitchMesh:
    return FABRICS[request.param]()


@pytest.mark.parametrize("climbing", [False, True])
def test_course_through_a_face_agrees_with_the_search_for_all_courses(fabric, climbing):
    for course in find_courses(fabric, climbing=climbing):
        for place, face in enumerate(course.faces):
            found = course_through(fabric, face, climbing=climbing)
            turn = place if course.closed else 0  # A ring starts with the requested face.
            assert (found.faces, found.closed) == (course.faces[turn:] + course.faces[:turn], course.closed)


def test_each_face_is_the_left_neighbour_of_its_right_neighbour(fabric):
    right, left = right_neighbours(fabric), left_neighbours(fabric)
    faces = np.flatnonzero(right != BORDER)
    assert (left[right[faces]] == faces).all()
    assert np.count_nonzero(left != BORDER) == len(faces)


def test_a_chain_is_followed_in_both_directions_and_a_ring_once_around():
    after, before = [1, 2, 3, BORDER], [BORDER, 0, 1, 2]
    assert chain_through(2, after.__getitem__, before.__getitem__) == ((0, 1, 2, 3), False)
    assert chain_through(2, lambda at: (at + 1) % 4, lambda at: (at - 1) % 4) == ((2, 3, 0, 1), True)


def test_roles_of_selected_sides_agree_with_roles_of_all_sides(fabric):
    sides = np.arange(0, fabric.side_count, 3)
    assert (fabric.role_of(sides) == fabric.side_role[sides]).all()
    assert [fabric.role_of(side) for side in sides.tolist()] == fabric.side_role[sides].tolist()


def test_rows_that_are_not_flipped_keep_their_numbers():
    below, above = np.array([0, 1, 4, 3]), np.array([1, 2, 3, 2])  # Rows 3 and 4 grew downwards.
    assert renumbered_rows(below, above, np.zeros(5, dtype=bool)).tolist() == [0, 1, 2, 3, 4]


def test_a_flipped_row_follows_the_row_below_it():
    below, above = np.array([2, 1]), np.array([1, 0])
    assert renumbered_rows(below, above, np.array([True, True, True])).tolist() == [2, 1, 0]
    assert renumbered_rows(below[:1], above[:1], np.array([False, True, True, False])).tolist() == [0, 2, 1, 3]


def test_rows_on_a_cycle_get_every_number_once():
    """The rows of a torus have no first row; those that wait for each other keep their order."""
    below, above = np.array([1, 2, 0]), np.array([0, 1, 2])
    assert sorted(renumbered_rows(below, above, np.array([True, True, True])).tolist()) == [0, 1, 2]


def test_a_spiral_is_one_course_or_one_for_each_row():
    fabric = make_spiral(around())
    (whole,) = find_courses(fabric, climbing=True)
    assert not whole.closed
    rows = [set(fabric.row[list(course.faces)].tolist()) for course in find_courses(fabric)]
    assert sorted(row for (row,) in rows) == sorted(set(fabric.row.tolist()))
