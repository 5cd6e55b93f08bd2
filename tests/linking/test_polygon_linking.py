# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Linking numbers of closed polygons: known ones, random ones, and degenerate ones that are shaken."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest

from stitchmesh.linking.polygon_linking import linking_numbers
from stitchmesh.mesh import FloatArray, IntArray
from tests.linking.gauss_integral import gauss_integral
from tests.meshrelax.fabrics import rotation
from tests.shaking import shaken_many

pytestmark = pytest.mark.decides


def numbers(curves: list[FloatArray]) -> IntArray:
    """Linking numbers of all pairs of polygons."""
    first = np.cumsum([0, *map(len, curves)])
    return linking_numbers(np.concatenate(curves), [range(a, b) for a, b in pairwise(first)]).toarray()


def linking(first: FloatArray, second: FloatArray) -> int:
    return int(numbers([first, second])[0, 1])


SQUARE = np.array([[1.0, 1, 0], [-1, 1, 0], [-1, -1, 0], [1, -1, 0]])
"""A square, counter-clockwise seen from above."""
UPRIGHT = np.array([[0.0, 0, -1], [0.1, 0, 1], [5, 0, 1], [5, 0, -1]])
"""A curve that passes up through the square and down outside it."""


def test_a_curve_up_through_a_loop_counts_one() -> None:
    assert linking(SQUARE, UPRIGHT) == 1.0
    assert linking(UPRIGHT, SQUARE) == 1.0
    assert linking(SQUARE[::-1], UPRIGHT) == linking(SQUARE, UPRIGHT[::-1]) == -1.0
    assert linking(SQUARE, UPRIGHT + np.array([3.0, 0, 0])) == 0.0


def test_linking_numbers_equal_the_gauss_integral() -> None:
    noise = np.random.default_rng(4)
    curves = [noise.normal(size=(size, 3)) for size in (5, 9, 7, 12, 10, 11)]
    found = numbers(curves)
    expected = [[gauss_integral(one, two) if one is not two else 0.0 for two in curves] for one in curves]
    # sums of some tens of angles, each exact to 1e-16, or to the square root of 1e-16 for nearly flat solid angles
    np.testing.assert_allclose(found, expected, atol=1e-6)
    assert np.abs(found).max() >= 1


def test_polygons_with_edges_on_one_line_do_not_cross() -> None:
    """Loops and links of a flat piece have edges on one line, the line of the needle that closes them."""
    random = np.random.default_rng(5)
    arch = np.array([[0.0, 0, 0], [0.3, 0.9, 0.1], [0.7, 0.9, -0.1], [1.0, 0, 0]])
    for seed in range(100):
        turn, shift = rotation(seed), random.normal(size=3)
        beyond = arch * [1, -1, 1] + [random.uniform(1.1, 3.0), 0.0, 0.0]
        assert linking(arch @ turn.T + shift, beyond @ turn.T + shift) == 0.0


RING = np.array([[-1, 0, 0], [0, 0, 0], [1, 0, 0], [1, 0, 0], [1, 2, 0], [0, 2, 0], [-1, 2, 0.0]])
"""A flat polygon with a corner in the middle of a side and a repeated corner."""
STANDING = np.array([[0, 1, 0], [0, 1, 1], [0, -1, 1], [0, -1, 0], [0, -1, -1], [0, 1, -1.0]])
"""A polygon perpendicular to it, whose corners lie in one plane."""
DEGENERATE = {
    "linked, corners in one plane": (STANDING, 1),
    "corners above corners": (RING + np.array([0, 0, 1]), 0),
    "sides on the lines of others": (RING + np.array([4, 0, 0]), 0),
    "all in one plane, one within the other": (0.5 * RING + [0, 0.5, 0], 0),
    "one point": (RING[[0, 0, 0]] + [0.5, 1, 1], 0),
    "touching": (RING + np.array([2, 0, 0]), None),
    "a polygon and itself": (RING, None),
}


@pytest.mark.parametrize("name", DEGENERATE)
def test_shaken_degenerate_polygons_have_the_same_linking(name: str) -> None:
    """The linking is the same in all shaken copies. Polygons that touch cross an even number of times at least."""
    other, expected = DEGENERATE[name]
    rings, others = list(shaken_many(RING, 200)), list(shaken_many(other, 200))[::-1]
    found = np.diagonal(numbers([*rings, *others]), len(rings))
    # half of an odd sum of signs would be rounded down for both senses
    assert (found == -np.diagonal(numbers([*rings, *(curve[::-1] for curve in others)]), len(rings))).all()
    assert expected is None or (np.abs(found) == expected).all()


def test_linking_does_not_depend_on_where_polygons_lie() -> None:
    noise = np.random.default_rng(8)
    curves = [noise.normal(size=(size, 3)) for size in (8, 11) for _ in range(10)]
    before = numbers(curves)
    turn = rotation(3)
    np.testing.assert_array_equal(numbers([curve @ turn * np.linalg.det(turn) + 2.0 for curve in curves]), before)
    assert len(np.unique(before)) > 2
