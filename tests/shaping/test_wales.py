# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Wale edges between two courses: as few increases and decreases as the counts need, spread out."""

from __future__ import annotations

import numpy as np
import pytest

from stitchmesh.shaping.chains import Chain, Grafts, divide, owners
from stitchmesh.shaping.wales import MOVES, join_courses


def ring(count: int, height: float) -> np.ndarray:
    """A closed course of stitches of width 1."""
    radius = count / (2 * np.pi)
    angle = 2 * np.pi * np.arange(count + 1) / count
    return np.stack([radius * np.cos(angle), radius * np.sin(angle), np.full(count + 1, height)], axis=1)


@pytest.mark.decides
@pytest.mark.parametrize(("below", "above"), [(40, 40), (43, 40), (6, 13), (60, 61)])
def test_a_row_has_as_many_increases_or_decreases_as_its_counts_differ(below, above):
    wales = join_courses(ring(below, 0.0), ring(above, 0.8), 1.0, np.zeros(below + 1))
    loops, made = np.diff(wales.below), np.diff(wales.above)
    assert loops.sum() == below and made.sum() == above
    assert all((int(a), int(b)) in MOVES for a, b in zip(loops, made, strict=True))
    assert np.abs(made - loops).sum() == abs(above - below)


def test_increases_are_spread_evenly():
    wales = join_courses(ring(60, 0.0), ring(64, 0.8), 1.0, np.zeros(61))
    places = np.flatnonzero(np.diff(wales.above) == 2)
    # Four increases in 60 stitches are 15 apart; the first and the last share the joined vertex between them.
    assert np.abs(np.diff(places) - 15).max() <= 1


def test_increases_keep_away_from_marked_vertices():
    penalty = np.zeros(41)
    penalty[15:26] = 50.0
    wales = join_courses(ring(40, 0.0), ring(41, 0.8), 1.0, penalty)
    place = int(np.flatnonzero(np.diff(wales.above) == 2)[0])
    assert not 15 <= place <= 25


def test_courses_that_differ_too_much_cannot_be_joined():
    assert join_courses(ring(6, 0.0), ring(19, 0.8), 1.0, np.zeros(7)) is None


def test_a_course_is_divided_between_two_limbs_that_share_a_graft():
    course = Chain((*range(10), 0), tuple(range(100, 110)))
    made = []

    def graft(first: int, last: int) -> Chain:
        made.append((first, last))
        return Chain((first, 50, last), (200, 201))

    owner = np.array([0, 0, 0, 0, 0, 1, 1, 1, 1, 1])
    one, other = divide(course, owner, [True, True], Grafts(graft))
    assert len(made) == 1  # Both limbs use the same edges, one in each direction.
    assert one.edges == (100, 101, 102, 103, 104, 200, 201) and one.closed
    assert other.edges == (105, 106, 107, 108, 109, 201, 200) and other.closed


def test_a_course_is_cut_where_rows_end_at_a_slit():
    course = Chain((*range(6), 0), tuple(range(6)))
    parts = divide(course, np.array([0, 0, 0, 1, 1, 1]), [False, False], Grafts(lambda a, b: Chain((a, b), (9,))))
    assert [part.edges for part in parts] == [(0, 1, 2), (3, 4, 5)]


def test_single_edges_are_given_to_the_limb_around_them():
    x = np.arange(12.0)
    points = np.stack([x, np.zeros(12), np.zeros(12)], axis=1)
    beside = points + np.array([0.0, 1.0, 0.0])
    lines = [beside[:6], np.concatenate([beside[6:], [[2.0, 0.1, 0.0]]])]
    assert owners(points, lines, closed=False).tolist() == [0] * 6 + [1] * 6
