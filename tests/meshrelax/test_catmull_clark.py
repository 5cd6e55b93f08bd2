# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
from __future__ import annotations

import numpy as np
import pytest

from stitchmesh.errors import MeshError
from stitchmesh.lattice import Lattice
from stitchmesh.mesh import Mesh
from stitchmesh.meshrelax.surface.catmull_clark import (
    border_vertices,
    corner_vertices,
    limit_rule,
    linear_rule,
    refine_surface,
    smooth_rule,
    subdivide,
)
from tests.gallery import closed_cone, grid, tube
from tests.meshrelax.fabrics import cube

MESHES = {"cube": cube(), "grid": grid(3, 2), "tube": tube(5, 2), "triangles": closed_cone(5)}


@pytest.fixture(params=MESHES)
def mesh(request: pytest.FixtureRequest) -> Mesh:
    return MESHES[request.param]


def euler_characteristic(mesh: Mesh) -> int:
    return len(mesh.vertices) - len(mesh.edge_side) + mesh.face_count


def test_subdivision_preserves_the_topology(mesh: Mesh) -> None:
    fine = subdivide(subdivide(mesh))
    assert euler_characteristic(fine) == euler_characteristic(mesh)
    assert len(fine.boundary_loops) == len(mesh.boundary_loops)
    assert fine.face_count == 4 * mesh.side_count
    from_vertices = Mesh.from_polygons(fine.vertices, fine.face_vertex.reshape(-1, 4).tolist())
    np.testing.assert_array_equal(fine.twin, from_vertices.twin)


def test_weights_add_up_to_one(mesh: Mesh) -> None:
    for rule in (smooth_rule(mesh), linear_rule(mesh)):
        np.testing.assert_allclose(rule.sum(axis=1), 1.0, rtol=1e-14)  # Rounding of a sum of about ten weights.
    fine = subdivide(mesh)
    np.testing.assert_allclose(limit_rule(fine).sum(axis=1), 1.0, rtol=1e-14)


def test_limit_points_do_not_depend_on_the_level(mesh: Mesh) -> None:
    """The limit point of a vertex is the same before and after another subdivision step."""
    fine = subdivide(mesh)
    finer = subdivide(fine)
    limit = limit_rule(fine) @ fine.vertices
    np.testing.assert_allclose((limit_rule(finer) @ finer.vertices)[: len(limit)], limit, atol=1e-13)  # Rounding.


def test_the_limit_of_the_corner_of_a_cube_is_halfway_to_the_centre() -> None:
    """For n = 3 the limit is (9 S + 4 sum e + sum f) / 24; with sum e = S and sum f = -S it is S / 2."""
    vertices = limit_rule(cube()) @ cube().vertices
    np.testing.assert_allclose(vertices, 0.5 * cube().vertices, atol=1e-15)
    _, limit, _ = refine_surface(cube(), 0.1, 10_000)
    np.testing.assert_allclose(limit[:8], 0.5 * cube().vertices, atol=1e-14)


def test_a_flat_rectangle_keeps_its_shape() -> None:
    """The limit is flat, its corners do not move, and its border is on the border of the rectangle."""
    fine, limit, flat = refine_surface(grid(4, 3), 0.3, 10_000)
    np.testing.assert_array_equal(limit[:, 2], 0.0)
    for vertex in np.flatnonzero(corner_vertices(fine)):
        np.testing.assert_array_equal(limit[vertex], flat[vertex])
    border = limit[border_vertices(fine)]
    inside = np.minimum(np.minimum(border[:, 0], 4.0 - border[:, 0]), np.minimum(border[:, 1], 3.0 - border[:, 1]))
    np.testing.assert_allclose(inside, 0.0, atol=1e-13)


def test_a_uniform_grid_is_reproduced_away_from_its_border() -> None:
    """On a regular grid the limit is the bicubic B-spline, which reproduces linear functions."""
    skew = np.array([[1.0, 0.2, 0.5], [0.3, 1.0, -0.4], [0.0, 0.0, 1.0]])
    coarse = grid(8, 8)
    coarse = Mesh(coarse.vertices @ skew, coarse.face_start, coarse.face_vertex, coarse.twin)
    _, limit, flat = refine_surface(coarse, 0.5, 10_000)
    place = flat @ np.linalg.inv(skew)
    deep = ((place[:, :2] > 2.0) & (place[:, :2] < 6.0)).all(axis=1)
    np.testing.assert_allclose(limit[deep], flat[deep], atol=1e-13)


def test_the_border_of_the_limit_depends_only_on_the_border_of_the_mesh() -> None:
    coarse = tube(6, 2)
    moved = coarse.vertices + np.where(border_vertices(coarse)[:, None], 0.0, 0.7)
    changed = Mesh(moved, coarse.face_start, coarse.face_vertex, coarse.twin)
    fine, limit, _ = refine_surface(coarse, 0.3, 10_000)
    _, other, _ = refine_surface(changed, 0.3, 10_000)
    on_border = border_vertices(fine)
    np.testing.assert_allclose(limit[on_border], other[on_border], atol=1e-14)
    assert np.abs(limit - other).max() > 0.1


def test_the_number_of_faces_is_limited() -> None:
    assert refine_surface(cube(), 1e-6, 1000)[0].face_count == 6 * 4**3


def test_a_mesh_on_a_lattice_is_refused() -> None:
    flat = grid(2, 2)
    lattice = Lattice(np.array([[9.0, 0.0, 0.0], [0.0, 9.0, 0.0]]))
    repeated = Mesh(
        flat.vertices, flat.face_start, flat.face_vertex, flat.twin, lattice, np.zeros((flat.side_count, 2), dtype=int)
    )
    with pytest.raises(MeshError, match="lattice"):
        subdivide(repeated)
