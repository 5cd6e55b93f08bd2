# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Faces that cross each other, against a test of every pair by another method."""

from __future__ import annotations

import numpy as np
import pytest

from stitchmesh.errors import ParameterError
from stitchmesh.io import read_mesh
from stitchmesh.mesh import Mesh
from stitchmesh.mesh.repair import repair_mesh, self_intersections
from tests.gallery import grid, shared, torus

pytestmark = pytest.mark.decides


def together(first: Mesh, second: Mesh, shift: list[float]) -> Mesh:
    faces = first.polygons + [[v + len(first.vertices) for v in face] for face in second.polygons]
    return Mesh.from_polygons(np.concatenate([first.vertices, second.vertices + np.array(shift)]), faces)


def upright(mesh: Mesh) -> Mesh:
    """A mesh of the x-y plane in the x-z plane."""
    return Mesh(mesh.vertices[:, [0, 2, 1]], mesh.face_start, mesh.face_vertex, mesh.twin)


def pierces(triangle: np.ndarray, start: np.ndarray, end: np.ndarray) -> bool:
    """Whether a segment passes through a triangle: the solution of three equations in its own coordinates."""
    a, b, c = triangle
    u, v, t = np.linalg.solve(np.stack([b - a, c - a, start - end], axis=1), start - a)
    return bool(0 < t < 1 and u > 0 and v > 0 and u + v < 1)


def crossing(first: np.ndarray, second: np.ndarray) -> bool:
    return any(
        pierces(one, other[k], other[(k + 1) % 3])
        for one, other in ((first, second), (second, first))
        for k in range(3)
    )


def test_loose_triangles_cross_where_their_sides_pierce_each_other():
    rng = np.random.default_rng(0)
    points = rng.uniform(0, 1, (60, 1, 3)) + rng.uniform(-0.3, 0.3, (60, 3, 3))
    mesh = Mesh.from_polygons(points.reshape(-1, 3), np.arange(180).reshape(-1, 3).tolist())
    expected = [(i, j) for i in range(60) for j in range(i + 1, 60) if crossing(points[i], points[j])]
    assert len(expected) > 20
    assert self_intersections(mesh).tolist() == [list(pair) for pair in expected]


def test_a_crossing_through_an_inner_edge_counts_and_one_on_the_border_does_not():
    spike = Mesh.from_polygons([[0, 0, -1], [0, 0, 1], [0.3, 0.4, 2]], [[0, 1, 2]])
    away = Mesh.from_polygons(spike.vertices * [-1.0, 1.0, 1.0], [[0, 1, 2]])
    inner = together(grid(2, 2), spike, [1.0, 1.0, 0.0])
    assert self_intersections(inner).tolist() == [[0, 4], [1, 4], [2, 4], [3, 4]]
    for height in (1.0, 0.5):  # A vertex of the border, and a point of one of its edges.
        assert self_intersections(together(grid(2, 2), away, [0.0, height, 0.0])).tolist() == []


def test_faces_that_share_a_vertex_or_lie_in_one_plane_do_not_count():
    assert self_intersections(together(grid(3, 3), grid(3, 3), [0.4, 0.3, 0.0])).tolist() == []
    fan = [[0, 0, 0], [4, 0, 0], [0, 4, 0], [1, 1, -1], [1, 1, 1]]
    assert self_intersections(Mesh.from_polygons(fan, [[0, 1, 2], [0, 2, 3], [0, 3, 4]])).tolist() == []


def test_tori_through_each_other_cross_and_linked_ones_do_not():
    mesh = torus(24, 48)
    through = together(mesh, mesh, [1.3, 0.2, 0.1])
    pairs = self_intersections(through)
    assert len(pairs) > 50
    some = self_intersections(through, most=5).tolist()
    assert len(some) == 5 and all(pair in pairs.tolist() for pair in some)
    assert (pairs[:, 0] < mesh.face_count).all()
    assert (pairs[:, 1] >= mesh.face_count).all()
    linked = together(mesh, upright(mesh), [3.0, 0.0, 0.0])
    assert self_intersections(linked).tolist() == []
    with pytest.raises(ParameterError, match="most: got 0; expected a whole number of at least 1"):
        self_intersections(mesh, most=0)


def test_a_body_does_not_cross_itself():
    assert self_intersections(read_mesh(shared("meshes/makehuman-body.obj"), unit="dm")).tolist() == []


def test_parts_of_a_crowded_edge_do_not_cross():
    """The copies of the vertices are at one position, so that the parts touch."""
    vertices = [[0, 0, 0], [0, 0, 1], [1, 0, 1], [1, 0, 0], [-1, 0, 1], [-1, 0, 0], [0, 1, 1], [0, 1, 0]]
    mesh = repair_mesh(vertices, [[0, 1, 2, 3], [1, 0, 5, 4], [0, 1, 6, 7]]).mesh
    assert self_intersections(mesh).tolist() == []
