# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Faces divided into triangles by their ears."""

from __future__ import annotations

import numpy as np
import pytest

from stitchmesh.mesh import Mesh
from stitchmesh.mesh.face_triangles import MOST_CORNERS, clip_ears, face_triangles, pair_keys

SHAPES = {
    "pentagon with a straight corner": [(0, 0), (1, 0), (2, 0), (2, 2), (0, 2)],
    "triangle with three straight corners on a side": [(0, 0), (1, 0), (2, 0), (3, 0), (4, 0), (2, 3)],
    "L": [(0, 0), (3, 0), (3, 1), (1, 1), (1, 3), (0, 3)],
    "U": [(0, 0), (3, 0), (3, 3), (2, 3), (2, 1), (1, 1), (1, 3), (0, 3)],
    "arrowhead whose ends are near each other": [(0, 0), (10, 0.1), (9, 0), (10, -0.1)],
    "rectangle": [(0, 0), (2, 0), (2, 1), (0, 1)],
}


def areas(points: np.ndarray, triangles: np.ndarray) -> np.ndarray:
    """Areas of triangles in the plane z = 0, positive anticlockwise."""
    one, two, three = (points[triangles[:, k], :2] for k in range(3))
    return 0.5 * np.cross(np.pad(two - one, ((0, 0), (0, 1))), np.pad(three - one, ((0, 0), (0, 1))))[:, 2]


def in_space(shape: list[tuple[float, float]]) -> np.ndarray:
    points = np.pad(np.array(shape, dtype=float), ((0, 0), (0, 1)))
    way = np.sign(np.cross(points, np.roll(points, -1, axis=0))[:, 2].sum())
    return points if way > 0 else points[::-1]


@pytest.mark.decides
@pytest.mark.parametrize("name", SHAPES)
def test_ears_cover_a_polygon_and_are_the_same_for_every_first_corner(name):
    points = in_space(SHAPES[name])
    numbers = np.random.default_rng(1).permutation(len(points))
    found = set()
    for turn in range(len(points)):
        own, vertex = np.roll(points, turn, axis=0), np.roll(numbers, turn)
        ears = clip_ears(own, vertex, np.array([len(own)]))
        area = areas(own, ears.triangles)
        assert ears.whole.all() and area.min() > 1e-3
        whole = 0.5 * np.cross(own, np.roll(own, -1, axis=0))[:, 2].sum()
        assert area.sum() == pytest.approx(whole, rel=1e-12)  # Rounding of a few sums.
        found.add(frozenset(frozenset(vertex[triangle].tolist()) for triangle in ears.triangles))
    assert len(found) == 1


def test_many_stars_are_divided_together():
    """Stars around a point, which every corner sees, so that no star crosses itself."""
    rng = np.random.default_rng(0)
    angle, reach = np.sort(rng.uniform(0, 2 * np.pi, (40, 15))), rng.uniform(1.0, 4.0, (40, 15))
    points = np.stack([reach * np.cos(angle), reach * np.sin(angle), np.zeros((40, 15))], axis=2)
    ears = clip_ears(points.reshape(-1, 3), np.arange(600), np.full(40, 15))
    assert ears.whole.all()
    for own, triangles in zip(points, ears.triangles.reshape(40, 13, 3), strict=True):
        whole = 0.5 * np.cross(own, np.roll(own, -1, axis=0))[:, 2].sum()
        area = areas(points.reshape(-1, 3), triangles)
        assert area.min() > 0.0
        assert area.sum() == pytest.approx(whole, rel=1e-12)  # Rounding of 13 sums.


def test_a_quad_is_cut_along_the_diagonal_whose_worse_triangle_is_better():
    points = np.array([[0, 0, 0], [2, 0, 0], [3, 1, 0], [1, 1, 0]], dtype=float)  # Diagonals of sqrt(10) and sqrt(2).
    triangles = clip_ears(points, np.array([5, 2, 7, 1]), np.array([4])).triangles
    assert {frozenset(triangle) for triangle in triangles.tolist()} == {frozenset({0, 1, 3}), frozenset({1, 2, 3})}


def test_a_pair_of_vertices_that_is_taken_is_no_diagonal():
    square, vertex, size = in_space([(0, 0), (1, 0), (1, 1), (0, 1)]), np.arange(4), np.array([4])
    for one, other in ((0, 2), (1, 3)):
        ears = clip_ears(square, vertex, size, pair_keys(np.array([other]), np.array([one])))
        shared = set(ears.triangles[0].tolist()) & set(ears.triangles[1].tolist())
        assert ears.whole.all() and shared == {0, 1, 2, 3} - {one, other}


def test_a_polygon_whose_parts_cancel_is_not_covered():
    crossed = np.array([[0, 0, 0], [2, 0, 0], [0, 2, 0], [2, 2, 0]], dtype=float)
    ears = clip_ears(crossed, np.arange(4), np.array([4]))
    assert not ears.whole.any() and ears.triangles.shape == (2, 3)


def test_a_polygon_of_very_many_corners_is_a_fan_that_is_not_called_whole():
    angle = np.linspace(0.0, 2.0 * np.pi, MOST_CORNERS + 1, endpoint=False)
    points = np.stack([np.cos(angle), np.sin(angle), 0.0 * angle], axis=1)
    ears = clip_ears(points, np.arange(len(points)), np.array([len(points)]))
    assert not ears.whole.any() and ears.triangles.shape == (MOST_CORNERS - 1, 3)
    assert areas(points, ears.triangles).sum() == pytest.approx(np.pi, rel=1e-5)  # A polygon in a circle.


# A quad, a triangle and a pentagon; the pentagon is not planar.
MESH = Mesh.from_polygons(
    [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0), (2, 0.5, 0.2), (2, 1.5, 0.4), (1, 2, 0), (0, 2, 0.3)],
    [(0, 1, 2, 3), (1, 4, 2), (3, 2, 5, 6, 7)],
)


def test_the_triangles_of_each_face_in_turn_use_all_its_corners_and_no_other():
    found = face_triangles(MESH)
    assert found.face.tolist() == [0, 0, 1, 2, 2, 2]
    for face in range(MESH.face_count):
        assert set(found.corners[found.face == face].ravel()) == set(MESH.sides_of(np.array([face])))


def test_the_vector_areas_of_the_triangles_add_up_to_those_of_the_faces():
    found = face_triangles(MESH)
    one, two, three = (MESH.corner_position[found.corners[:, k]] for k in range(3))
    area = np.zeros((MESH.face_count, 3))
    np.add.at(area, found.face, 0.5 * np.cross(two - one, three - one))
    np.testing.assert_allclose(area, MESH.face_vector_area, atol=1e-15)  # Sums of a few products near 1.


def test_two_quads_that_share_two_sides_form_a_mesh_of_triangles():
    """A roof over a vertex of two faces. The diagonal between the ends of the common sides is shorter in both."""
    points = [(-1, 0, 0), (0, 0, 0.4), (1, 0, 0), (0, 2.5, 0.1), (0, -2.5, 0.1)]
    mesh = Mesh.from_polygons(points, [(0, 1, 2, 3), (2, 1, 0, 4)])
    triangles = mesh.face_vertex[face_triangles(mesh).corners]
    assert Mesh.from_polygons(points, triangles.tolist()).face_count == 4
    found = {frozenset(triangle) for triangle in triangles.tolist()}
    assert found == {frozenset(three) for three in ((0, 1, 3), (1, 2, 3), (1, 2, 4), (0, 1, 4))}
