# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Tube meshes: closed surfaces with outward normals, the volume of the yarn, twist-free frames, and strands."""

from __future__ import annotations

import numpy as np
import pytest

from stitchmesh.mesh.tube_mesh import HIDDEN, TubeMesh, repeating_tubes, tubes_around

RADIUS = 0.1


def knot(count: int) -> np.ndarray:
    """A trefoil knot: a closed curve whose twist-free frame does not return to its start, because it has torsion."""
    t = 2 * np.pi * np.arange(count) / count
    return np.stack([np.sin(t) + 2 * np.sin(2 * t), np.cos(t) - 2 * np.cos(2 * t), -np.sin(3 * t)], axis=1)


def ellipse(count: int) -> np.ndarray:
    t = 2 * np.pi * np.arange(count) / count
    return np.stack([2 * np.sin(t), 0 * t, np.cos(t)], axis=1)


def helix(count: int) -> np.ndarray:
    t = np.linspace(0, 6 * np.pi, count)
    return np.stack([np.cos(t), np.sin(t), 0.3 * t], axis=1)


def ring_area(sides: int) -> float:
    """Area of the polygon that approximates the round section [cm^2]."""
    return sides / 2 * np.sin(2 * np.pi / sides) * RADIUS**2


def volume(tubes: TubeMesh) -> float:
    a, b, c = (tubes.vertices[tubes.triangles[:, k]] for k in range(3))
    return float(np.einsum("ij,ij->", a, np.cross(b, c))) / 6


def length(points: np.ndarray, closed: bool) -> float:
    steps = np.diff(np.concatenate([points, points[:1]]) if closed else points, axis=0)
    return float(np.linalg.norm(steps, axis=1).sum())


@pytest.mark.parametrize("closed", [True, False])
def test_every_edge_is_shared_by_two_triangles_in_opposite_directions(closed):
    corners = tubes_around([knot(40), helix(30)], [closed, False], RADIUS, sides=5).triangles
    sides = np.concatenate([corners[:, [0, 1]], corners[:, [1, 2]], corners[:, [2, 0]]])
    forward = {tuple(side) for side in sides.tolist()}
    assert len(forward) == len(sides)
    assert {(b, a) for a, b in forward} == forward


@pytest.mark.parametrize(("curve", "closed"), [(ellipse, True), (helix, False)])
@pytest.mark.parametrize("sides", [3, 8])
def test_volume_is_section_times_length_to_the_second_order(curve, closed, sides):
    """The centroid of the section lies on the curve, so that Pappus's theorem holds.

    The errors of the chords, and of rings normal to the mean of two chords, are of order h^2.
    """
    counts = np.array([200, 400, 800])
    errors = []
    for count in counts:
        points = curve(count)
        expected = ring_area(sides) * length(points, closed)
        errors.append(abs(volume(tubes_around([points], [closed], RADIUS, sides=sides)) / expected - 1))
    rate = -np.polyfit(np.log(counts), np.log(errors), 1)[0]
    assert rate == pytest.approx(2, abs=0.2)
    assert errors[-1] < 1e-3  # The direction changes by less than 0.03 per step, and 0.03^2 < 1e-3.


def test_normals_are_unit_vectors_that_point_away_from_the_curve():
    points = helix(100)
    tubes = tubes_around([points], [False], RADIUS, sides=6)
    np.testing.assert_allclose(np.linalg.norm(tubes.normals, axis=1), 1.0, rtol=1e-12)  # Rounding error of float64.
    np.testing.assert_allclose(points[tubes.ring] + RADIUS * tubes.normals, tubes.vertices, atol=1e-12)


def turns(tubes: TubeMesh, points: np.ndarray, sides: int) -> np.ndarray:
    """Twist between consecutive rings: the angle about the tangent between their first normals.

    The first normal is carried to the next ring by the smallest rotation between the tangents before the comparison.
    """
    normal = tubes.normals.reshape(-1, sides, 3)[:, 0]
    tangent = np.roll(points, -1, axis=0) - np.roll(points, 1, axis=0)
    tangent /= np.linalg.norm(tangent, axis=1, keepdims=True)
    following, ahead = np.roll(normal, -1, axis=0), np.roll(tangent, -1, axis=0)
    lean = np.einsum("ij,ij->i", ahead, normal) / (1 + np.einsum("ij,ij->i", ahead, tangent))
    carried = normal - (tangent + ahead) * lean[:, None]
    return np.arctan2(
        np.einsum("ij,ij->i", np.cross(carried, following), ahead), np.einsum("ij,ij->i", carried, following)
    )


def test_a_closed_tube_distributes_its_remaining_turn_uniformly():
    points = knot(200)
    turn = turns(tubes_around([points], [True], RADIUS, sides=9), points, 9)
    np.testing.assert_allclose(turn, turn.mean(), atol=1e-9)  # Rounding error of sums of 200 angles in float64.
    assert np.abs(turn.mean()) <= np.pi / 200 + 1e-9


def test_tubes_made_together_equal_tubes_made_one_by_one():
    curves, closed, radius = [knot(30), helix(20), knot(50)], [True, False, True], [0.1, 0.2, 0.3]
    together = tubes_around(curves, closed, radius, sides=6)
    first = 0
    for curve, flag, size in zip(curves, closed, radius, strict=True):
        alone = tubes_around([curve], [flag], size, sides=6)
        part = slice(first, first + len(alone.vertices))
        # The angles of a later tube are differences of sums over all tubes before it.
        np.testing.assert_allclose(together.vertices[part], alone.vertices, atol=1e-9)
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


def wave(count: int) -> tuple[np.ndarray, np.ndarray]:
    """A space curve that continues in a shifted copy of itself, and the shift."""
    t = 2 * np.pi * np.arange(count) / count
    points = np.stack([t, np.sin(t) + 0.3 * np.cos(2 * t), 0.5 * np.cos(t + 0.4)], axis=1)
    return points, np.array([[2 * np.pi, 0.0, 0.0]])


def test_a_repeating_tube_ends_in_the_ring_with_which_its_copy_begins():
    points, shift = wave(40)
    rings = repeating_tubes([points], shift, RADIUS, sides=7).vertices.reshape(-1, 7, 3)
    np.testing.assert_allclose(rings[-2], rings[1] + shift, atol=1e-12)  # Rounding error of float64.
    # The ring beyond each joint is the next ring of the copy, except that it is thinner.
    middle = rings[2].mean(axis=0) + shift
    np.testing.assert_allclose(rings[-1] - middle, HIDDEN * (rings[2] - rings[2].mean(axis=0)), atol=1e-12)


def test_a_repeating_tube_without_shift_is_the_closed_tube():
    ring = repeating_tubes([knot(30)], np.zeros((1, 3)), RADIUS, sides=5)
    closed = tubes_around([knot(30)], [True], RADIUS, sides=5)
    np.testing.assert_allclose(ring.vertices.reshape(-1, 5, 3)[1:-2], closed.vertices.reshape(-1, 5, 3), atol=1e-12)
