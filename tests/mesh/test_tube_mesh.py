# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Tubes are closed surfaces that face outward and have the volume of their yarn."""

from __future__ import annotations

import numpy as np
import pytest

from stitchmesh.mesh.tube_mesh import TubeMesh, tubes_around

RADIUS = 0.1


def knot(count: int) -> np.ndarray:
    """A trefoil: closed, and its frames come back turned, for it has torsion."""
    t = 2 * np.pi * np.arange(count) / count
    return np.stack([np.sin(t) + 2 * np.sin(2 * t), np.cos(t) - 2 * np.cos(2 * t), -np.sin(3 * t)], axis=1)


def ellipse(count: int) -> np.ndarray:
    t = 2 * np.pi * np.arange(count) / count
    return np.stack([2 * np.sin(t), 0 * t, np.cos(t)], axis=1)


def helix(count: int) -> np.ndarray:
    t = np.linspace(0, 6 * np.pi, count)
    return np.stack([np.cos(t), np.sin(t), 0.3 * t], axis=1)


def ring_area(sides: int) -> float:
    """Area of the polygon that stands for the round section."""
    return sides / 2 * np.sin(2 * np.pi / sides) * RADIUS**2


def euler_characteristic(tubes: TubeMesh) -> int:
    corners = tubes.triangles
    edges = np.sort(np.concatenate([corners[:, [0, 1]], corners[:, [1, 2]], corners[:, [2, 0]]]), axis=1)
    return len(np.unique(corners)) - len(np.unique(edges, axis=0)) + len(corners)


def volume(tubes: TubeMesh) -> float:
    a, b, c = (tubes.vertices[tubes.triangles[:, k]] for k in range(3))
    return float(np.einsum("ij,ij->", a, np.cross(b, c))) / 6


def length(points: np.ndarray, closed: bool) -> float:
    steps = np.diff(np.concatenate([points, points[:1]]) if closed else points, axis=0)
    return float(np.linalg.norm(steps, axis=1).sum())


@pytest.mark.parametrize(("closed", "expected"), [(True, 0), (False, 2)])
def test_euler_characteristic_is_of_a_torus_or_a_ball(closed, expected):
    assert euler_characteristic(tubes_around([knot(40)], [closed], RADIUS, sides=7)) == expected


@pytest.mark.parametrize("closed", [True, False])
def test_every_edge_joins_two_triangles_that_run_against_each_other(closed):
    corners = tubes_around([knot(40), helix(30)], [closed, False], RADIUS, sides=5).triangles
    sides = np.concatenate([corners[:, [0, 1]], corners[:, [1, 2]], corners[:, [2, 0]]])
    forward = {tuple(side) for side in sides.tolist()}
    assert len(forward) == len(sides)
    assert {(b, a) for a, b in forward} == forward


@pytest.mark.parametrize(("curve", "closed"), [(ellipse, True), (helix, False)])
@pytest.mark.parametrize("sides", [3, 8])
def test_volume_is_section_times_length_to_the_second_order(curve, closed, sides):
    """By Pappus, for the section's centre lies on the curve; chords and rings across their mean are off by h^2."""
    counts = np.array([200, 400, 800])
    errors = []
    for count in counts:
        points = curve(count)
        expected = ring_area(sides) * length(points, closed)
        errors.append(abs(volume(tubes_around([points], [closed], RADIUS, sides=sides)) / expected - 1))
    rate = -np.polyfit(np.log(counts), np.log(errors), 1)[0]
    assert rate == pytest.approx(2, abs=0.2)
    assert errors[-1] < 1e-3  # the steps turn by less than 0.03


@pytest.mark.parametrize("sides", [3, 8])
def test_volume_of_a_turned_tube_is_off_by_its_diagonals_only(sides):
    """A quad turned by d is cut by its diagonal: off by half a tetrahedron, tan(pi / sides) / 3 * d of the volume."""
    count = 800
    points = knot(count)
    error = volume(tubes_around([points], [True], RADIUS, sides=sides)) / (ring_area(sides) * length(points, True)) - 1
    assert abs(error) <= np.tan(np.pi / sides) / 3 * np.pi / count + 1e-4  # and the second order, as above


def test_triangles_face_the_way_of_their_normals():
    tubes = tubes_around([knot(300)], [True], RADIUS, sides=8)
    a, b, c = (tubes.vertices[tubes.triangles[:, k]] for k in range(3))
    facing = np.einsum("ij,ij->i", np.cross(b - a, c - a), tubes.normals[tubes.triangles[:, 0]])
    assert (facing > 0).all()


def test_normals_are_units_that_point_from_the_curve():
    points = helix(100)
    tubes = tubes_around([points], [False], RADIUS, sides=6)
    np.testing.assert_allclose(np.linalg.norm(tubes.normals, axis=1), 1.0, rtol=1e-12)  # float64
    np.testing.assert_allclose(points[tubes.ring] + RADIUS * tubes.normals, tubes.vertices, atol=1e-12)


def turns(tubes: TubeMesh, points: np.ndarray, sides: int) -> np.ndarray:
    """Angle about the tangent between the first normals of successive rings, beyond the turn of the tangent itself."""
    normal = tubes.normals.reshape(-1, sides, 3)[:, 0]
    tangent = np.roll(points, -1, axis=0) - np.roll(points, 1, axis=0)
    tangent /= np.linalg.norm(tangent, axis=1, keepdims=True)
    following, ahead = np.roll(normal, -1, axis=0), np.roll(tangent, -1, axis=0)
    lean = np.einsum("ij,ij->i", ahead, normal) / (1 + np.einsum("ij,ij->i", ahead, tangent))
    carried = normal - (tangent + ahead) * lean[:, None]
    return np.arctan2(
        np.einsum("ij,ij->i", np.cross(carried, following), ahead), np.einsum("ij,ij->i", carried, following)
    )


def test_a_closed_tube_spreads_its_leftover_turn_evenly():
    points = knot(200)
    turn = turns(tubes_around([points], [True], RADIUS, sides=9), points, 9)
    np.testing.assert_allclose(turn, turn.mean(), atol=1e-9)  # sums of 200 angles in float64
    assert np.abs(turn.mean()) <= np.pi / 200 + 1e-9


def test_a_flat_ring_has_no_twist_at_all():
    angle = 2 * np.pi * np.arange(60) / 60
    ring = np.stack([np.cos(angle), np.sin(angle), 0 * angle], axis=1)
    turn = turns(tubes_around([ring], [True], RADIUS, sides=4), ring, 4)
    np.testing.assert_allclose(turn, 0.0, atol=1e-12)


def test_many_tubes_are_the_tubes_one_by_one():
    curves, closed, radius = [knot(30), helix(20), knot(50)], [True, False, True], [0.1, 0.2, 0.3]
    together = tubes_around(curves, closed, radius, sides=6)
    first = 0
    for curve, flag, size in zip(curves, closed, radius, strict=True):
        alone = tubes_around([curve], [flag], size, sides=6)
        part = slice(first, first + len(alone.vertices))
        np.testing.assert_allclose(together.vertices[part], alone.vertices, atol=1e-9)  # angles summed from afar
        first = part.stop
    assert volume(together) == pytest.approx(
        sum(volume(tubes_around([c], [f], r, sides=6)) for c, f, r in zip(curves, closed, radius, strict=True))
    )


def test_repeated_points_and_cusps_stay_finite():
    points = np.array([[0, 0, 0], [0, 0, 0], [1, 0, 0], [2, 0, 0], [1, 0, 0], [1, 1, 0.0]])
    for closed in (True, False):
        tubes = tubes_around([points], [closed], RADIUS, sides=5)
        assert np.isfinite(tubes.vertices).all()
        np.testing.assert_allclose(np.linalg.norm(tubes.normals, axis=1), 1.0, rtol=1e-12)
