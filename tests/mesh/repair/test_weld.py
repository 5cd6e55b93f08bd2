# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Vertices at one position become one vertex, and faces do not vanish by it."""

from __future__ import annotations

import numpy as np
import pytest

from stitchmesh.errors import ParameterError
from stitchmesh.mesh import Mesh
from stitchmesh.mesh.repair import RepairOptions, repair_mesh
from tests.gallery import grid, tube
from tests.mesh.repair.soups import actions, cut, ring, shape, triangles, unchanged

pytestmark = pytest.mark.decides


def seamed_tube() -> tuple[np.ndarray, list[list[int]]]:
    """A tube whose vertices along one line exist twice, as along the seam of a texture."""
    mesh = tube(6, 3)
    own = {vertex: len(mesh.vertices) + place for place, vertex in enumerate(range(0, 24, 6))}
    faces = [[own.get(v, v) if number % 6 == 5 else v for v in face] for number, face in enumerate(mesh.polygons)]
    return np.concatenate([mesh.vertices, mesh.vertices[::6]]), faces


def test_the_seam_of_a_texture_is_closed():
    vertices, faces = seamed_tube()
    assert len(Mesh.from_polygons(vertices, faces).boundary_loops) == 1
    repaired = repair_mesh(vertices, faces)
    assert shape(repaired.mesh) == shape(tube(6, 3))
    assert [(action.text, action.where) for action in repaired.actions] == [
        ("4 vertices at equal positions were welded", (24, 25, 26, 27))
    ]


def test_the_default_distance_is_a_millionth_of_the_diagonal():
    vertices, faces = cut(*ring())
    diagonal = np.linalg.norm(np.ptp(vertices, axis=0))
    away = np.random.default_rng(0).uniform(-1.0, 1.0, vertices.shape)
    # Two points are moved apart by at most 2 sqrt(3) times the factor, which is 0.7 and 7 of the weld distance.
    assert repair_mesh(vertices + 0.2e-6 * diagonal * away, faces).mesh.boundary_loops == ()
    assert repair_mesh(vertices + 2e-6 * diagonal * away, faces).mesh.boundary_loops != ()


def test_with_distance_zero_only_equal_positions_are_welded():
    vertices, faces = cut(*ring())
    assert repair_mesh(vertices, faces, RepairOptions(weld_distance=0.0)).mesh.boundary_loops == ()
    vertices[0] += 1e-12
    assert repair_mesh(vertices, faces, RepairOptions(weld_distance=0.0)).mesh.boundary_loops != ()


def test_a_thin_face_does_not_vanish():
    """The two ends of its short side are nearer than the weld distance, and both are on the border."""
    vertices = [[0, 0, 0], [2, 0, 0], [2, 0.1, 0], [2, 2, 0], [4, 0, 0]]
    faces = [[0, 1, 2], [0, 2, 3], [1, 4, 2]]
    repaired = repair_mesh(vertices, faces, RepairOptions(weld_distance=0.2))
    assert repaired.mesh.polygons == faces
    assert repaired.actions == ()


def test_a_chain_of_near_vertices_does_not_become_one_vertex():
    """Each vertex of the dense border is near the next one, and a copy of the strip lies along it."""
    strip = grid(10, 1, width=0.1, height=4.0)
    below = strip.vertices * [1.0, -1.0, 1.0] + [0.01, 0.0, 0.0]
    faces = strip.polygons + [[v + 22 for v in reversed(face)] for face in strip.polygons]
    coarse = grid(4, 4, width=8.0, height=8.0)  # The median edge is long, so that the distance is accepted.
    vertices = np.concatenate([strip.vertices, below, coarse.vertices + np.array([0.0, 50.0, 0.0])])
    faces += [[v + 44 for v in face] for face in coarse.polygons]
    repaired = repair_mesh(vertices, faces, RepairOptions(weld_distance=0.15))
    assert actions(repaired) == {"welded vertices": 11}
    assert repaired.mesh.face_count == 36


def test_a_face_smaller_than_the_distance_vanishes():
    vertices = [[0, 0, 0], [4, 0, 0], [4.001, 0, 0], [4, 0.001, 0], [4, 4, 0], [8, 8, 0]]
    repaired = repair_mesh(vertices, [[0, 1, 4], [1, 2, 3], [2, 5, 3]], RepairOptions(weld_distance=0.01))
    assert repaired.mesh.face_count == 2
    assert actions(repaired)["faces without area"] == 1


def test_closed_surfaces_that_touch_are_left_alone():
    """Two boxes share the position of a face; no vertex of either is on a border."""
    box = np.array([[x, y, z] for x in (0.0, 1.0) for y in (0.0, 1.0) for z in (0.0, 1.0)])
    faces = [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]]
    both = faces + [[v + 8 for v in face] for face in faces]
    assert unchanged(Mesh.from_polygons(np.concatenate([box, box + np.array([1.0, 0.0, 0.0])]), both))


def test_a_stray_triangle_far_away_does_not_make_the_distance_large():
    vertices, faces = ring()
    far = np.array([[1e9, 0, 0], [1e9, 1, 0], [1e9, 0, 1.0]])
    number = len(vertices)
    repaired = repair_mesh(np.concatenate([vertices, far]), [*faces, [number, number + 1, number + 2]])
    assert repaired.components[0].boundary_loops == ()


def test_a_distance_beyond_the_edges_is_refused():
    mesh = grid(3, 3)
    with pytest.raises(ParameterError, match=r"weld_distance: got 0.6 cm; half of all edges are shorter than 1 cm"):
        repair_mesh(mesh.vertices, triangles(mesh), RepairOptions(weld_distance=0.6))


def test_zeros_of_both_signs_are_equal():
    vertices = [[0.0, 0, 0], [1, 0, 0], [0, 1, 0], [-0.0, -0.0, 0], [0, 1, -0.0], [-1, 0, 0]]
    assert repair_mesh(vertices, [[0, 1, 2], [3, 4, 5]]).mesh.edge_side.size == 5
