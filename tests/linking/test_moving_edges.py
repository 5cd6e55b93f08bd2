# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Crossings of edges that move on straight lines: each crossing is counted once, whatever the rounding."""

from __future__ import annotations

import numpy as np
import pytest

from stitchmesh.linking import moving_edges
from stitchmesh.linking.general_position import DISPLACEMENT, WholeUnits, displacements
from stitchmesh.linking.moving_edges import EdgeCrossings, EdgePairs, NotInGeneralPosition, edge_crossings
from stitchmesh.mesh import FloatArray, IntArray
from tests.nightly import at_night, mostly_at_night
from tests.shaking import SHAKES, shaken_many

pytestmark = pytest.mark.decides

UNITS = WholeUnits.fitting(64.0)


def polygon(*corners: tuple[float, ...]) -> FloatArray:
    return np.array(corners, dtype=np.float64)


def pairs_of(a: FloatArray, b: FloatArray) -> EdgePairs:
    """All edges of closed polygons a, shape (2, n, i, 3), with all of b, shape (2, n, j, 3), in the order (n, i, j)."""
    u, v = np.roll(a, -1, axis=2) - a, np.roll(b, -1, axis=2) - b
    shape = (*a.shape[:3], b.shape[2], 3)
    w = b[:, :, None, :] - a[:, :, :, None]
    return EdgePairs(
        *(np.broadcast_to(part, shape).reshape(2, -1, 3) for part in (u[:, :, :, None], v[:, :, None, :], w))
    )


def counted(a: FloatArray, b: FloatArray, seed: int = 0) -> tuple[IntArray, IntArray]:
    """Numbers of crossings, and sums of their signs, of n motions of two closed polygons, shape (n,) each.

    ``a`` and ``b`` have the shape (moments, n, corners, 3).
    """
    moved = displacements(a.shape[2] + b.shape[2], DISPLACEMENT, seed)
    a, b = UNITS.rounded(a + moved[: a.shape[2]]), UNITS.rounded(b + moved[a.shape[2] :])
    count, size = np.zeros((2, a.shape[1]), dtype=np.int64), a.shape[2] * b.shape[2]
    for moment in range(len(a) - 1):
        found = edge_crossings(pairs_of(a[moment : moment + 2], b[moment : moment + 2]), UNITS.unit)
        np.add.at(count[0], found.pair // size, 1)
        np.add.at(count[1], found.pair // size, found.sign)
    return count[0], count[1]


SQUARE = polygon((-1, 0, 0), (0, 0, 0), (1, 0, 0), (1, 2, 0), (-1, 2, 0))
"""A square with a corner in the middle of the side through which other curves enter."""
REPEATED = SQUARE[[0, 1, 1, 1, 2, 2, 3, 4]]
"""The square with repeated corners."""
UPRIGHT = polygon((0, 0, 0), (0, 0, 1), (0, -2, 1), (0, -2, -1), (0, 0, -1), (0, 0, 0))
"""A curve whose first side, divided in the middle, passes through the square first."""


def along(curve: FloatArray, *shifts: tuple[float, ...]) -> FloatArray:
    """The curve at each moment, shifted, shape (moments, corners, 3)."""
    return np.stack([curve + np.array(shift, dtype=np.float64) for shift in shifts])


MOTIONS = {
    "vertex through vertex between moments": (SQUARE, along(UPRIGHT, (0, -1, 0), (0, 1, 0)), 1, None),
    "vertex on vertex at a moment": (SQUARE, along(UPRIGHT, (0, -1, 0), (0, 0, 0), (0, 1, 0)), 1, None),
    "and back": (SQUARE, along(UPRIGHT, (0, -1, 0), (0, 0, 0), (0, -1, 0)), 0, None),
    "edge through vertex": (SQUARE, along(UPRIGHT[1:-1], (0, -1, 0), (0, 0, 0), (0, 1, 0)), 1, 1),
    "vertex through edge": (SQUARE, along(UPRIGHT[:-1], (0.5, -1, 0), (0.5, 0, 0), (0.5, 1, 0)), 1, 1),
    "repeated points": (REPEATED, along(UPRIGHT, (0, -1, 0), (0, 0, 0), (0, 1, 0)), 1, None),
    "rest on an edge": (SQUARE, along(UPRIGHT, (0, -1, 0), (0, 0, 0), (0, 0, 0), (0, 1, 0)), 1, None),
    "one plane at a moment": (SQUARE, along(SQUARE, (0.5, 0.5, 1), (0.5, 0.5, 0), (0.5, 0.5, -1)), 0, 2),
    "one plane all the time": (SQUARE, along(SQUARE, (-4, 0.5, 0), (4, 0.5, 0)), 0, None),
    "edges on one line": (SQUARE, along(SQUARE, (0.5, 0, 1), (0.5, 0, 0), (0.5, 0, -1)), 0, None),
    "a curve through itself": (SQUARE, along(SQUARE, (0, 0, 1), (0, 0, -1)), 0, None),
    "a single point": (SQUARE, along(SQUARE[[1, 1, 1]], (0, -1, 0), (0, 0, 0), (0, 1, 0)), 0, None),
}
"""For each motion: a curve at rest, a moving curve, the change of the linking number, and the number of crossings if
the motion determines it."""


@pytest.mark.parametrize("name", mostly_at_night(MOTIONS, by_day=[*MOTIONS][:2]))
def test_shaken_motions_have_the_same_crossings(name: str) -> None:
    """In all shaken copies the linking number changes as it must, and all counts are equal."""
    still, moving, change, number = MOTIONS[name]
    a, b = shaken_many(np.stack([still] * len(moving))), shaken_many(moving)
    count, total = counted(np.moveaxis(a, 0, 1), np.moveaxis(b, 0, 1))
    assert len(total) == SHAKES
    assert (np.abs(total) == change).all() and (total == total[0]).all()
    assert (count == count[0]).all()
    assert number is None or count[0] == number


@pytest.mark.parametrize("seed", at_night(0, 1))
def test_motions_between_grid_points_end_with_the_correct_linking(seed: int) -> None:
    """The corners of two curves move between 5^3 grid points, where they meet at all times, and each motion is shaken.

    Before and after the motion the curves are unlinked, or linked as a motion without degeneracies links them.
    """
    random = np.random.default_rng(seed)
    b = random.integers(-2, 3, (3, 100, 6, 3)).astype(np.float64)
    b[0] = b[0] + [9.0, 0.0, 0.0]
    straight = along(UPRIGHT, (0.25, -9.0, 0.25), (0.25, 1.0, 0.25))
    b[2] = straight[1] if seed else b[2] - [9.0, 0.0, 0.0]
    shakes = shaken_many(b, 10).transpose(1, 0, 2, 3, 4).reshape(3, -1, 6, 3)
    a = np.broadcast_to(SQUARE, (3, shakes.shape[1], 5, 3))
    for displaced in range(2):
        count, total = counted(a, shakes, displaced)
        assert (total == (counted(a[:2, :1], straight[:, None])[1][0] if seed else 0)).all()
        assert (count.reshape(10, -1) == count.reshape(10, -1)[0]).all()


def random_pairs(count: int) -> EdgePairs:
    """Pairs with coordinates of a few bits, so that many edges touch, and with a small displacement."""
    random = np.random.default_rng(5)
    values = random.integers(-3, 4, (3, 2, count, 3)) + random.uniform(-1e-6, 1e-6, (3, 1, count, 3))
    return EdgePairs(*UNITS.rounded(values))


def as_set(found: EdgeCrossings) -> list[tuple[int, float, int]]:
    return sorted(zip(found.pair.tolist(), np.round(found.time, 9).tolist(), found.sign.tolist(), strict=True))


def test_whole_numbers_and_double_precision_find_the_same_crossings(monkeypatch: pytest.MonkeyPatch) -> None:
    pairs = random_pairs(3000)
    fast = as_set(edge_crossings(pairs, UNITS.unit))
    monkeypatch.setattr(moving_edges, "ROUNDING", 1e9)  # no result is certain in double precision
    assert as_set(edge_crossings(pairs, UNITS.unit)) == fast
    assert len(fast) > 100


def test_constructed_crossings_are_found_at_their_times() -> None:
    random = np.random.default_rng(2)
    time, s, t = random.uniform(0.1, 0.9, (3, 200, 1))
    u, v, speed = random.normal(size=(3, 2, 200, 3))
    at = [np.array((1 - time) * part[0] + time * part[1]) for part in (u, v)]
    met = s * at[0] - t * at[1]
    w = np.stack([met - time * speed[0], met + (1 - time) * speed[0]])
    found = edge_crossings(EdgePairs(*(UNITS.rounded(part) for part in (u, v, w))), UNITS.unit)
    nearest = [np.abs(found.time[found.pair == k] - time[k]).min() for k in range(200)]
    # rounding to units of 2^-40, divided by speeds and angles that are small in some of the 200 cases
    assert max(nearest) < 1e-6


def test_edges_that_touch_are_refused() -> None:
    u, v = polygon((1, 0, 0)), polygon((0, 1, 0))
    touching = EdgePairs(np.stack([u, u]), np.stack([v, v]), np.stack([v * 0, v * 0 - [[0, 0, 1]]]))
    with pytest.raises(NotInGeneralPosition, match="1 pairs of moving edges"):
        edge_crossings(touching, UNITS.unit)
