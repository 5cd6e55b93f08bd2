# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Deformation paths of yarns, the crossings of yarn through yarn on them, and which of these crossings cancel."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest

from stitchmesh.lattice import Lattice
from stitchmesh.linking import crossings_along_path
from stitchmesh.linking.cancelling_crossings import uncancelled
from stitchmesh.linking.crossings_along_path import SampledPath
from stitchmesh.linking.deformation_path import DeformationPath
from stitchmesh.linking.polygon_linking import linking_numbers
from stitchmesh.linking.pulled_through import pulled_through
from stitchmesh.linking.rings import meets_fan
from stitchmesh.linking.yarn_polylines import YarnPolylines, sampled_points
from stitchmesh.mesh import FloatArray
from stitchmesh.yarn import YarnSet
from tests.meshrelax.fabrics import rotation
from tests.shaking import shaken, shaken_many

pytestmark = pytest.mark.decides

RADIUS = 0.1


def yarns_of(*curves: FloatArray, closed: bool = False) -> YarnSet:
    return YarnSet.from_curves(curves, closed=[closed] * len(curves), radius=RADIUS)


def line(start: tuple[float, ...], end: tuple[float, ...], count: int = 40) -> FloatArray:
    return np.linspace(start, end, count)


def ring(centre: tuple[float, ...], radius: float = 0.4, count: int = 24) -> FloatArray:
    """A circle around the x axis."""
    angle = 2 * np.pi * np.arange(count) / count
    return np.array(centre) + radius * np.stack([0 * angle, np.cos(angle), np.sin(angle)], axis=1)


def sampled_path(begin: YarnSet, end: YarnSet, smoothing_steps: int = 0) -> SampledPath:
    return SampledPath.along(DeformationPath(begin, end, smoothing_steps, 16))


def random_curves(seed: int) -> YarnSet:
    """Two closed random curves that are tangled."""
    random = np.random.default_rng(seed)
    return yarns_of(*random.normal(size=(2, 12, 3)), closed=True)


def linking(yarns: YarnSet) -> int:
    curves = [range(first, last) for first, last in pairwise(YarnPolylines(yarns).start)]
    return int(linking_numbers(sampled_points(yarns), curves)[0, 1])


def test_a_path_leads_from_its_begin_to_its_end() -> None:
    begin, end = random_curves(0), random_curves(1)
    path = DeformationPath(begin, end, 3, 16)
    for time, there in ((0.0, begin), (1e-9, begin), (1.0 - 1e-9, end), (1.0, end)):
        # sums of some tens of numbers of size one, and a billionth of a path of length ten
        np.testing.assert_allclose(path.at(time).points, there.points, atol=1e-7)


def test_a_rigid_motion_is_rigid_at_all_times() -> None:
    turn = rotation(4)
    turn *= np.linalg.det(turn)
    begin = random_curves(2)
    end = replace(begin, points=begin.points @ turn.T + 7.0)
    half = DeformationPath(begin, end, 10, 16).at(0.5).points
    first, there = (points - points.mean(axis=0) for points in (begin.points, half))
    # rounding of rotations near half a turn, and of a linear system
    np.testing.assert_allclose(there @ there.T, first @ first.T, atol=1e-6)


def test_a_strip_that_curls_up_by_a_turn_and_a_half_does_not_collapse() -> None:
    """On straight lines, parts that rotate by half a turn would be points at half time; the path preserves lengths."""
    strip = [line((0.0, y, 0.0), (6.0, y, 0.0), 61) for y in np.linspace(0.0, 1.0, 5)]
    begin = yarns_of(*strip)
    angle = begin.points[:, 0] * 3 * np.pi / 6.0
    spiral = (6.0 / (3 * np.pi)) * np.stack([np.sin(angle), 0 * angle, 1.0 - np.cos(angle)], axis=1)
    spiral[:, 1] = begin.points[:, 1] + 0.2 * angle
    end = replace(begin, points=spiral)
    path = DeformationPath(begin, end, 5, 16)
    assert np.ptp(path._rotation[:, 1]) > 2.5 * np.pi  # three half turns, smoothed at the ends
    lengths = path.at(0.5).lengths / begin.lengths
    # smoothed rotations of 16 points deviate by up to a third of a radian; straight lines would shorten lengths to 0.2
    assert lengths.min() > 0.8 and lengths.max() < 1.25
    assert not sampled_path(begin, end, 5).crossings


@pytest.mark.parametrize("seed", range(3))
def test_signs_of_crossings_add_up_to_the_change_of_linking(seed: int) -> None:
    """Two rings move from one tangle to another; each crossing changes their linking number by one."""
    begin, end = random_curves(seed), random_curves(seed + 100)
    yarn = YarnPolylines(begin).yarn
    for one, two in ((begin, end), (end, begin)):
        crossings = [
            found.sign for found in sampled_path(one, two).crossings if yarn[found.first] != yarn[found.second]
        ]
        assert len(crossings) > 0
        assert sum(crossings) == linking(one) - linking(two)


def test_a_yarn_through_another_crosses_once_and_the_crossing_remains() -> None:
    lying, over = line((-2.0, 0.0, 0.0), (2.0, 0.0, 0.0)), line((0.013, -2.0, 0.3), (0.013, 2.0, 0.3))
    begin, end = yarns_of(lying, over), yarns_of(lying, over - [0.0, 0.0, 0.6])
    found = sampled_path(begin, end)
    assert len(found.crossings) == 1
    assert found.crossings[0].time == pytest.approx(0.5, abs=1e-6)  # half way of a uniform motion
    assert uncancelled(found) == found.crossings
    assert not pulled_through(begin, begin)


def test_a_ring_slides_along_a_yarn_and_is_not_taken_off_it() -> None:
    """The ring may slide along the yarn by ten of its radii, but it may not move off sideways through the yarn."""
    yarn = line((-6.0, 0.0, 0.0), (6.0, 0.0, 0.0), 120)
    begin = yarns_of(yarn, np.concatenate([ring((-2.0, 0.0, 0.0)), ring((-2.0, 0.0, 0.0))[:3]]))
    along = yarns_of(yarn, np.concatenate([ring((2.0, 0.0, 0.0)), ring((2.0, 0.0, 0.0))[:3]]))
    beside = yarns_of(yarn, np.concatenate([ring((2.0, 1.1, 0.0)), ring((2.0, 1.1, 0.0))[:3]]))
    assert not pulled_through(begin, along)
    assert len(pulled_through(begin, beside)) == 1


def curl(side: float) -> FloatArray:
    """A yarn along the x axis with one curl over itself; the part to the right is in front if ``side`` is 1."""
    angle = np.linspace(0.0, 2 * np.pi, 40)
    wound = np.stack([0.4 * np.sin(angle), 0.4 - 0.4 * np.cos(angle), 0.12 * side * np.cos(angle / 2)], axis=1)
    left = line((-3.0, 0.0, 0.12 * side), (-0.1, 0.0, 0.12 * side))
    return np.concatenate([left, wound, line((0.1, 0.0, -0.12 * side), (3.0, 0.0, -0.12 * side))])


def test_an_empty_curl_turns_over_and_one_around_a_yarn_does_not() -> None:
    through = line((0.013, 0.4, -2.0), (0.013, 0.4, 2.0))
    flipped = sampled_path(yarns_of(curl(1.0)), yarns_of(curl(-1.0)))
    assert [abs(found.sign) for found in flipped.crossings] == [1]
    assert not uncancelled(flipped)
    assert len(pulled_through(yarns_of(curl(1.0), through), yarns_of(curl(-1.0), through))) == 1


def bight(height: float) -> FloatArray:
    """A yarn below the x axis with a bight that comes up beside the axis and lies over it."""
    x = np.linspace(-3.0, 3.0, 121)
    up = np.exp(-((x / 0.5) ** 2))
    return np.stack([0.013 + x, height * up - 0.5, -0.15 + 0.0 * x], axis=1)


def test_a_bight_over_a_yarn_is_undone_unless_a_third_yarn_goes_through_it() -> None:
    """The two legs of a bight cross with opposite signs. With a yarn through the bight, both crossings remain."""
    axis = line((-3.0, 0.0, 0.0), (3.0, 0.0, 0.0), 121)
    through = line((0.013, 0.2, -2.0), (0.013, 0.2, 2.0), 61)
    under, over = bight(1.2), bight(1.2) * [1.0, 1.0, -1.0]
    found = sampled_path(yarns_of(axis, under), yarns_of(axis, over))
    assert sorted(each.sign for each in found.crossings) == [-1, 1]
    assert not uncancelled(found)
    assert len(pulled_through(yarns_of(axis, under, through), yarns_of(axis, over, through))) == 2


def test_images_cross_like_any_other_yarn() -> None:
    """Two endless yarns in a cell that is smaller than their motion: one crossing for each image that they meet."""
    lattice = Lattice(np.array([[1.0, 0.0, 0.0], [0.0, 0.5, 0.0]]))
    count = 10
    along = np.stack([np.arange(count) / count, 0.2 * np.ones(count), 0.3 * np.ones(count)], axis=1)
    across = np.stack([0.513 * np.ones(count), 0.5 * np.arange(count) / count, np.zeros(count)], axis=1)
    flat = yarns_of(along, across, closed=True)
    begin = replace(flat, lattice=lattice, lattice_step=np.array([[1, 0], [0, 1]]))
    points = begin.points.copy()
    points[:count, 2] -= 0.6
    found = sampled_path(begin, replace(begin, points=points))
    assert len(found.crossings) == 1
    assert uncancelled(found) == found.crossings
    moved = replace(begin, points=begin.points + begin.points[0] * [10.0, 0.0, 0.0])
    assert not sampled_path(begin, moved).crossings


def shaken_yarns(yarns: YarnSet, seed: int) -> YarnSet:
    return replace(yarns, points=shaken(yarns.points, seed))


@pytest.mark.parametrize("name", ["ring", "bight"])
def test_shaken_yarns_have_the_same_crossings(name: str) -> None:
    """Symmetric yarns, with edges in one plane and vertices on each other, are shaken by their last bits."""
    if name == "ring":
        yarn = line((-6.0, 0.0, 0.0), (6.0, 0.0, 0.0), 120)
        loops = [ring((x, y, 0.0)) for x, y in ((-2.0, 0.0), (2.0, 1.1))]
        begin, end = (yarns_of(yarn, np.concatenate([loop, loop[:3]])) for loop in loops)
    else:
        axis, through = line((-3.0, 0.0, 0.0), (3.0, 0.0, 0.0), 121), line((0.013, 0.2, -2.0), (0.013, 0.2, 2.0), 61)
        begin, end = (yarns_of(axis, bight(1.2) * [1.0, 1.0, side], through) for side in (1.0, -1.0))
    expected = sampled_path(begin, end)
    remaining = [(found.first, found.second, found.sign) for found in uncancelled(expected)]
    assert remaining
    for seed in range(10):
        found = sampled_path(shaken_yarns(begin, seed), shaken_yarns(end, seed + 1))
        assert [each.sign for each in found.crossings] == [each.sign for each in expected.crossings]
        assert [(each.first, each.second, each.sign) for each in uncancelled(found)] == remaining


def test_another_displacement_is_tried_where_edges_touch(monkeypatch: pytest.MonkeyPatch) -> None:
    """Without a displacement, a vertex passes through a vertex."""
    original, seeds = crossings_along_path.displacements, []

    def at_first_none(count: int, largest: float, seed: int) -> FloatArray:
        seeds.append(seed)
        return original(count, largest, seed) * (seed > 0)

    monkeypatch.setattr(crossings_along_path, "displacements", at_first_none)
    axis, across = line((-1.0, 0.0, 0.0), (1.0, 0.0, 0.0), 9), line((0.0, -1.0, 0.25), (0.0, 1.0, 0.25), 9)
    found = sampled_path(yarns_of(axis, across), yarns_of(axis, across - [0.0, 0.0, 0.5]))
    assert seeds == [0, 1]
    assert len(found.crossings) == 1


def test_a_shaken_half_turn_has_the_same_sense() -> None:
    """Fabric that is turned over, with points whose neighbours are at equal distances, and a straight yarn."""
    rows = [line((0.0, y, 0.0), (3.0, y, 0.0), 31) for y in np.arange(8) / 10.0]
    begin = yarns_of(*rows, line((0.0, 3.0, 0.0), (3.0, 3.0, 0.0), 31))
    end = replace(begin, points=begin.points * [1.0, -1.0, -1.0])
    half = [
        DeformationPath(shaken_yarns(begin, seed), shaken_yarns(end, seed + 7), 5, 16).at(0.5).points
        for seed in range(10)
    ]
    # an error of the last bit changes the angle of a rotation near half a turn by its square root at most
    np.testing.assert_allclose(half, [half[0]] * 10, atol=1e-6)


UPWARDS = np.array([0.0, 0.0, 1.0])


def test_no_edge_slips_between_the_triangles_of_a_fan() -> None:
    """Edges exactly through spokes and through the apex, shaken many times, and edges just outside."""
    angle = 2 * np.pi * np.arange(8) / 8
    corners = np.stack([np.cos(angle), np.sin(angle), 0 * angle], axis=1)
    for apex in (np.zeros(3), corners[2]):
        on_spoke = 0.5 * corners[0] + 0.5 * apex
        for place, inside in ((on_spoke, True), (corners[6] * 0.5, True), (corners[0] * 1.1, False)):
            first, second = shaken_many(line(place - UPWARDS, place + UPWARDS, 2)).transpose(1, 0, 2)
            met = [meets_fan(apex, corners, first[k : k + 1], second[k : k + 1]) for k in range(len(first))]
            assert all(met) if inside else not any(met)
