# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Linking numbers of known links, certificates of periodic fabrics, and detection of pull-throughs."""

from __future__ import annotations

from dataclasses import replace
from itertools import combinations, product

import numpy as np
import pytest

from stitchmesh.errors import SolverError
from stitchmesh.lattice import Lattice
from stitchmesh.linking import projection
from stitchmesh.linking.certificate import (
    changed_pairs,
    doubled_linking,
    linking_certificate,
    linkings_together,
    refuse_pull_through,
)
from stitchmesh.yarn import YarnSet, basis
from tests.linking.gauss_integral import gauss_integral
from tests.meshrelax.fabrics import rotation
from tests.shaking import shaken
from tests.yarnrelax.stockinette import FORMULA_RADIUS, periodic_patch, tube, woven_cell

pytestmark = pytest.mark.decides


def ring(centre: tuple[float, float, float], axis: int, points: int = 24) -> np.ndarray:
    angle = np.arange(points) / points * 2 * np.pi
    circle = np.roll(np.stack([0 * angle, np.cos(angle), np.sin(angle)], axis=1), axis, axis=1)
    return circle + np.asarray(centre)


def closed(*curves: np.ndarray) -> YarnSet:
    return YarnSet.from_curves(curves, closed=[True] * len(curves), radius=0.05)


def torus_link(turns: int) -> YarnSet:
    """Two strands that wind around each other ``turns`` times along a circle."""
    angle = np.arange(80) / 80 * 2 * np.pi
    strands = []
    for phase in (0.0, np.pi):
        out, up = 3 + np.cos(turns * angle + phase), np.sin(turns * angle + phase)
        strands.append(np.stack([out * np.cos(angle), out * np.sin(angle), up], axis=1))
    return closed(*strands)


@pytest.mark.parametrize("turns", [2, -3])
def test_the_linking_number_of_a_torus_link_is_its_number_of_turns(turns: int) -> None:
    yarns = torus_link(turns)
    certificate = linking_certificate(yarns)
    # parallel strands that wind in a right-handed sense have the linking number +turns
    assert abs(certificate[0, 1]) == abs(turns)
    mirrored = replace(yarns, points=yarns.points * [1.0, 1.0, -1.0])
    assert linking_certificate(mirrored)[0, 1] == -certificate[0, 1]
    assert np.sign(certificate[0, 1]) == np.sign(turns) * np.sign(linking_certificate(torus_link(1))[0, 1])


def test_shaken_yarns_have_the_same_certificate() -> None:
    """Degenerate positions: points of a ring in the plane of another, rings with equal projections, repeated points."""
    view_direction = projection.DIRECTION / np.linalg.norm(projection.DIRECTION)
    first = ring((0, 0, 0), 0)
    rings = [first, ring((0, 0, 1), 1), first + 3 * view_direction, first[[0, *range(24)]] + 6 * view_direction]
    yarns = closed(*(curve @ rotation(2) for curve in rings))
    expected = linking_certificate(yarns, device="cpu").toarray()
    assert np.abs(expected).tolist() == [[0, 1, 0, 0], [1, 0, 0, 0], [0, 0, 0, 0], [0, 0, 0, 0]]
    for seed in range(50):
        shake = replace(yarns, points=shaken(yarns.points, seed))
        np.testing.assert_array_equal(linking_certificate(shake, device="cpu").toarray(), expected)


def test_linking_numbers_of_random_loops_equal_the_gauss_integral() -> None:
    random = np.random.default_rng(11)
    yarns = closed(*(random.normal(size=(7, 3)) for _ in range(4)))
    certificate = linking_certificate(yarns).toarray()
    loops = yarns.sampled(4)
    for i in range(4):
        for j in range(i):
            assert certificate[i, j] == certificate[j, i]
            assert certificate[i, j] == round(gauss_integral(loops[i], loops[j]))


def move_head(yarns: YarnSet, yarn: int, distance: float) -> YarnSet:
    """Move the head of one loop outwards, away from the axis of the tube, by a distance [cm]."""
    points = yarns.points.copy()
    start, stop = yarns.start[yarn : yarn + 2]
    head = start + np.argmax(points[start:stop, 1])
    outwards = points[head] * [1.0, 0.0, 1.0] / np.linalg.norm(points[head, [0, 2]])
    points[head + np.arange(-2, 3)] += distance * outwards
    return replace(yarns, points=points)


def test_a_pull_through_changes_exactly_the_pair_of_yarns() -> None:
    yarns = tube(5, 6)
    before = doubled_linking(yarns)
    assert len(before.doubled) == 0  # knitting can unravel, so no two rows are linked
    # four radii inwards: the head passes the legs of the row above, which are behind it
    after = move_head(yarns, 2, -0.5)
    assert changed_pairs(before, doubled_linking(after)).tolist() == [[2, 3]]
    assert changed_pairs(linking_certificate(yarns), linking_certificate(after)).tolist() == [[2, 3]]
    assert len(changed_pairs(before, before)) == 0


def test_view_direction_scale_and_position_do_not_matter(monkeypatch: pytest.MonkeyPatch) -> None:
    # Coordinates are integers and the projection is along an axis: vertices and edges have exactly equal projections,
    # although no yarns touch.
    random = np.random.default_rng(3)
    curves = [random.integers(-2, 3, size=(10, 3)) + random.normal(size=3) * [0.0, 0.0, 0.3] for _ in range(8)]
    yarns = closed(*curves)
    expected = linking_certificate(yarns)
    assert expected.nnz > 0
    for direction in ([0.0, 0.0, 1.0], [1.0, 0.0, 1.0], [0.2, -0.9, 0.1]):
        monkeypatch.setattr(projection, "DIRECTION", np.array(direction))
        assert (linking_certificate(yarns) != expected).nnz == 0
        for scale, place in ((1e-3, 0.0), (1e3, 0.0), (1.0, 1e5)):
            assert (linking_certificate(replace(yarns, points=yarns.points * scale + place)) != expected).nnz == 0


def test_doubled_linking_numbers_of_coinciding_yarns_are_even(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(projection, "DIRECTION", np.array([1.0, 0.0, 1.0]))
    random = np.random.default_rng(5)
    shapes = random.integers(-2, 3, size=(2, 10, 3)).astype(float)
    curves = [np.roll(shapes[k % 2], k, axis=0)[:: 1 - 2 * (k % 3 == 0)] for k in range(12)]
    yarns = YarnSet.from_curves(curves, closed=[k % 4 > 1 for k in range(12)], radius=0.05)
    linking = doubled_linking(yarns)
    assert len(linking.doubled) > 0
    assert not (linking.doubled % 2).any()


def test_long_segments_are_found_among_short_ones() -> None:
    # a triangle passes through all rings; its sides are a thousand times as long as the edges of the rings
    place = np.linspace(0.0, 100.0, 41)[1:-1]
    rings = [ring((0.0, 0.0, p), 2) * [0.1, 0.1, 1.0] for p in place]
    triangle = np.array([[0.0, 0.0, -1e3], [0.0, 0.0, -500.0], [0.0, 0.0, 500.0], [0.0, 0.0, 1e3], [1e3, 0.0, 0.0]])
    certificate = linking_certificate(closed(triangle, *rings)).toarray()
    assert (np.abs(certificate[0, 1:]) == 1).all()
    assert not certificate[1:, 1:].any()


def test_the_certificate_shows_which_of_two_crossed_open_yarns_is_above() -> None:
    place = np.linspace(-2.0, 2.0, 9)
    lower = np.stack([place, 0 * place, 0 * place], axis=1)
    crossing = [
        YarnSet.from_curves(
            [lower, np.stack([0 * place, place, 0 * place + height], axis=1)], closed=[False] * 2, radius=0.05
        )
        for height in (0.5, -0.5)
    ]
    above, below = (linking_certificate(yarns)[0, 1] for yarns in crossing)
    assert abs(above - below) == 1


def periodic(curves: list[np.ndarray], steps: list[tuple[int, int]], periods: np.ndarray) -> YarnSet:
    """Closed yarns on a lattice."""
    yarns = YarnSet.from_curves(curves, closed=[True] * len(curves), radius=0.05)
    return replace(yarns, lattice=Lattice(np.asarray(periods, dtype=float)), lattice_step=np.array(steps))


def doubled_by_pair(yarns: YarnSet) -> dict[tuple[int, ...], int]:
    """Doubled linking numbers by yarn, yarn and the two numbers of the image."""
    linking = doubled_linking(yarns)
    keys = np.concatenate([linking.yarns, linking.image], axis=1).tolist()
    return dict(zip(map(tuple, keys), linking.doubled.tolist(), strict=True))


def straight(begin: tuple[float, float, float], along: tuple[float, float, float], points: int = 3) -> np.ndarray:
    return np.array(begin) + np.arange(points)[:, None] / points * np.array(along)


def test_a_woven_crossing_changes_its_sign_if_the_warp_passes_through_the_weft() -> None:
    weft = straight((0.0, 0.5, 0.0), (1.0, 0.0, 0.0))
    signs = []
    for height in (0.2, -0.2):
        warp = straight((0.5, 0.0, height), (0.0, 1.0, 0.0))
        yarns = periodic([warp, weft], [(0, 1), (1, 0)], np.eye(3)[:2])
        signs.append(doubled_by_pair(yarns))
        assert linking_certificate(yarns).toarray().tolist() == [[0, *signs[-1].values()], [*signs[-1].values(), 0]]
    # warp over weft: the rotation from (0, 1) to (1, 0) is clockwise, so the sign is negative
    assert signs == [{(0, 1, 0, 0): -1}, {(0, 1, 0, 0): 1}]


def half_pulled(yarns: YarnSet) -> YarnSet:
    """Move one side of the loop's head to the back, through a leg of the row above."""
    points = yarns.points.copy()
    head = np.argmax(points[:, 1])
    points[head : head + 3, 2] -= 3.0
    return replace(yarns, points=points)


def test_rows_of_stockinette_are_unlinked_and_a_pull_through_is_detected() -> None:
    yarns = periodic_patch(1, 1, radius=FORMULA_RADIUS)
    assert doubled_by_pair(yarns) == {}
    pulled = half_pulled(yarns)
    # each row is now linked with the row below it, once per stitch
    assert {key: abs(value) for key, value in doubled_by_pair(pulled).items()} == {(0, 0, 0, -1): 2}
    assert changed_pairs(doubled_linking(yarns), doubled_linking(pulled)).tolist() == [[0, 0]]


def random_fabric(seed: int) -> YarnSet:
    """Random curves on an oblique lattice: two rings, and yarns in three directions."""
    random = np.random.default_rng(seed)
    periods = np.array([[3.0, 0.2, 0.1], [0.8, 2.6, -0.2]])
    steps = [(0, 0), (0, 0), (1, 0), (1, 0), (0, 1), (1, -1), (2, 0)]
    curves = [
        random.uniform(-1.0, 1.0, size=(8, 3)) + np.linspace(0.0, step @ periods, 8, endpoint=False)
        for step in np.array(steps)
    ]
    return periodic(curves, steps, periods)


def spanned(image: np.ndarray, first: np.ndarray, second: np.ndarray) -> bool:
    """Whether an image is a sum of small integer multiples of two lattice steps."""
    return any((k * first + m * second == image).all() for k, m in product(range(-4, 5), repeat=2))


def signs_along_normal(yarns: YarnSet, i: int, j: int, image: np.ndarray) -> int:
    """Sum of the crossing signs of one period of yarn i and one of yarn j in an image, projected along the normal.

    All pairs of edges are tested.
    """
    periods = yarns.lattice.periods
    axes = np.linalg.inv(np.stack([*periods, np.cross(*periods)]))
    loops = []
    for yarn, curve in enumerate(yarns.sampled(4)):
        loops.append(np.concatenate([curve, curve[:1] + yarns.lattice_step[yarn] @ periods]) @ axes)
    p, q = loops[i], loops[j] + [*image, 0.0]
    a, b, c, d = p[:-1, None], p[1:, None], q[None, :-1], q[None, 1:]

    def side(x: np.ndarray, y: np.ndarray, z: np.ndarray) -> np.ndarray:
        return np.cross(y - x, z - x)[..., 2] > 0

    hit = (side(a, b, c) != side(a, b, d)) & (side(c, d, a) != side(c, d, b))
    return -int(np.sign((np.cross(b - a, d - c) * (c - a)).sum(axis=-1))[hit].sum())


def test_linking_of_random_curves_on_a_lattice_equals_a_test_of_all_images() -> None:
    yarns = random_fabric(0)
    step, rows = yarns.lattice_step, doubled_by_pair(yarns)
    left = dict(rows)
    for (i, j), image in product(
        [*combinations(range(yarns.yarn_count), 2), *((k, k) for k in range(yarns.yarn_count))],
        map(np.array, product(range(-3, 4), repeat=2)),  # images that are farther away do not cross
    ):
        if i == j and spanned(image, step[i], 0 * image):
            continue
        number = signs_along_normal(yarns, i, j, image)
        if number == 0:
            continue
        # an image and its opposite describe the same pair of copies of a yarn
        keys = [
            key for key in {*rows, *left} if key[:2] == (i, j)
            and (spanned(image - key[2:], step[i], step[j]) or (i == j and spanned(-image - key[2:], step[i], step[j])))
        ]  # fmt: skip
        key = keys[0] if keys else (i, j, *image.tolist())
        left[key] = left.get(key, 0) - (number / 2 if i == j else number)
    assert len(rows) > 10
    assert not any(left.values())


def test_the_choice_of_the_periodic_image_does_not_matter() -> None:
    yarns = random_fabric(1)
    certificate = linking_certificate(yarns)
    shift = np.array([[2, -1], [0, 3], [1, 1], [0, 0], [-2, 0], [0, 1], [5, -4]])
    moved = replace(yarns, points=yarns.points + yarns.lattice.shift(shift)[yarns.point_yarn])
    assert (linking_certificate(moved) != certificate).nnz == 0
    # each yarn begins at another control point; the points before it move on by one lattice step
    points = yarns.points.copy()
    for yarn in range(yarns.yarn_count):
        own = slice(yarns.start[yarn], yarns.start[yarn + 1])
        on = yarns.lattice.shift(yarns.lattice_step[yarn])
        points[own] = np.concatenate([points[own][4:], points[own][:4] + on])
    assert doubled_by_pair(replace(yarns, points=points)) == doubled_by_pair(yarns)


def test_the_linking_of_many_sets_of_yarns_is_that_of_each() -> None:
    sets = [periodic_patch(1, 1), woven_cell(), periodic_patch(3, 2)]
    assert len(doubled_linking(woven_cell()).doubled) > 0
    for yarns, found in zip(sets, linkings_together(sets), strict=True):
        alone = doubled_linking(yarns)
        assert found.yarn_count == alone.yarn_count
        for name in ("yarns", "image", "doubled"):
            np.testing.assert_array_equal(getattr(found, name), getattr(alone, name))


def test_yarns_closer_than_the_sag_of_a_chord_have_not_passed_through_one_another() -> None:
    """A small ring around a large one, whose curve its inner side nearly touches; short of it, or beyond."""

    def point(yarns: YarnSet, segment: int, s: float) -> np.ndarray:
        return basis(np.array([s]))[0] @ yarns.points[yarns.segment_points[segment]]

    wide = closed(ring((0, 0, 0), 2, 4))
    curve, chord = point(wide, 0, 0.125), (point(wide, 0, 0.0) + point(wide, 0, 0.25)) / 2
    outward = curve / np.linalg.norm(curve)
    angle = np.arange(8)[:, None] * np.pi / 4
    round_it = np.cos(angle) * outward + np.sin(angle) * np.array([0.0, 0.0, 1.0])
    inner = point(closed(round_it), 3, 0.0)  # the knot at the fifth control point

    def around(place: np.ndarray) -> YarnSet:
        """Both rings, with the inner side of the small one at a place."""
        return closed(ring((0, 0, 0), 2, 4), round_it - inner + place)

    apart, touching = around(0.5 * curve), around((curve + chord) / 2)
    assert changed_pairs(doubled_linking(apart), doubled_linking(touching)).tolist() == [[0, 1]]
    refuse_pull_through(apart, touching)
    with pytest.raises(SolverError, match=r"yarns 0 and 1 .*: their linking number changed"):
        refuse_pull_through(apart, around(1.05 * curve))
