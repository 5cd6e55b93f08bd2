# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The surfaces of the benchmarks of knitting: topology, orientation, size and symmetry."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

import stitchmesh as sm
from benchmarks.scenes import surface_shapes as shapes
from stitchmesh.errors import MeshError
from stitchmesh.mesh import BORDER, IntArray, Mesh
from stitchmesh.yarngen.bridges import crossing_number
from stitchmesh.yarngen.row_ends import finish_row_ends
from tests.gallery import grid
from tests.nightly import mostly_at_night

TOPOLOGY = {
    "cylinder": (0, 2),
    "sphere": (2, 0),
    "torus": (0, 0),
    "y_junction": (-1, 3),
    "genus_2": (-2, 0),
    "flat_disc": (1, 1),
    "camisole": (-2, 4),
    "hoodie": (-2, 4),
    "cardigan": (-1, 3),
    "glove": (1, 1),
    "octopus": (2, 0),
}
"""Euler characteristic and number of borders of one surface of each kind."""
BY_DAY = ("sphere", "torus", "camisole", "flat_disc")


@cache
def shape(name: str) -> Mesh:
    """A shape, made once for all tests."""
    return shapes.SHAPES[name]()


def euler_characteristic(mesh: Mesh) -> int:
    return len(mesh.vertices) - len(mesh.edge_side) + mesh.face_count


def parts(corners: IntArray) -> int:
    """Number of parts that are not connected."""
    first, second = corners[:, [0, 1]].T, corners[:, [1, 2]].T
    ends, count = np.concatenate([first, second], axis=1), int(corners.max()) + 1
    links = coo_array((np.ones(ends.shape[1]), tuple(ends)), shape=(count, count))
    return connected_components(links, directed=False)[0]


def enclosed_volume(mesh: Mesh) -> float:
    """Volume inside triangles, and inside cones that close the borders from their middles."""
    triangles = [mesh.vertices[mesh.face_vertex.reshape(-1, 3)]]
    for loop in mesh.boundary_loops:
        start, end = mesh.vertices[mesh.face_vertex[loop]], mesh.vertices[mesh.face_vertex[mesh.side_next[loop]]]
        triangles.append(np.stack([end, start, np.broadcast_to(start.mean(axis=0), start.shape)], axis=1))
    return float(np.linalg.det(np.concatenate(triangles)).sum() / 6.0)


@pytest.mark.parametrize("name", mostly_at_night(TOPOLOGY, by_day=BY_DAY))
def test_a_shape_is_one_surface_of_even_triangles_that_faces_outwards(name):
    mesh = shape(name)
    assert (np.diff(mesh.face_start) == 3).all()
    assert (euler_characteristic(mesh), len(mesh.boundary_loops)) == TOPOLOGY[name]
    assert parts(mesh.face_vertex.reshape(-1, 3)) == 1
    if np.ptp(mesh.vertices[:, 2]) == 0.0:
        assert (mesh.face_vector_area[:, 2] > 0.0).all()
    else:
        assert enclosed_volume(mesh) > 0.0
    edge = {"glove": 0.5, "octopus": 0.6}.get(name, 1.0)
    # The steps of remeshing aim at this length and leave a quarter of it at least.
    assert abs(np.median(mesh.side_length) - edge) < 0.1 * edge
    assert mesh.side_length.min() > 0.25 * edge and mesh.side_length.max() < 2.0 * edge


def test_simple_shapes_lie_on_their_surfaces():
    radius = np.linalg.norm(shape("sphere").vertices, axis=1)
    x, y, z = shape("torus").vertices.T
    # The last of Newton's steps starts within a tenth of an edge of the surface, where it ends within 1e-4 cm.
    assert np.abs(radius - 8.0).max() < 1e-4
    assert np.abs(np.hypot(np.hypot(x, z) - 12.0, y) - 4.0).max() < 1e-2


def test_triangles_of_a_garment_keep_its_topology():
    mesh = sm.read_mesh("sweater")
    coarse = shapes.triangulated(mesh)
    assert np.array_equal(coarse.vertices, mesh.vertices)
    assert coarse.face_count == mesh.side_count - 2 * mesh.face_count
    fine = shapes.triangulated(mesh, 2.0)
    assert fine.side_length.max() <= 2.0
    assert np.linalg.norm(fine.face_vector_area, axis=1).sum() == pytest.approx(  # Halved edges keep their triangles.
        np.linalg.norm(coarse.face_vector_area, axis=1).sum(), rel=1e-12
    )
    for triangles in (coarse, fine):
        assert (np.diff(triangles.face_start) == 3).all()
        assert euler_characteristic(triangles) == euler_characteristic(mesh)
        assert len(triangles.boundary_loops) == len(mesh.boundary_loops)


def test_the_diagonals_of_neighbouring_quads_alternate():
    faces = shapes.triangulated(grid(2, 1)).face_vertex.reshape(-1, 3).tolist()
    assert faces == [[0, 1, 4], [0, 4, 3], [2, 5, 4], [2, 4, 1]]


def test_a_moebius_strip_is_one_surface_with_one_border_that_no_mesh_takes():
    points, corners = shapes.moebius_polygons()
    edges = np.sort(corners[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), axis=1)
    edges, faces = np.unique(edges, axis=0, return_counts=True)
    border = edges[faces == 1]
    _, numbered = np.unique(border, return_inverse=True)
    assert faces.max() == 2 and len(points) - len(edges) + len(corners) == 0
    assert parts(corners) == 1 and (np.bincount(border.ravel())[np.unique(border)] == 2).all()
    assert parts(numbered.reshape(-1, 2)[:, [0, 1, 0]]) == 1
    with pytest.raises(MeshError):
        Mesh.from_polygons(points, corners.tolist())


@pytest.mark.nightly
def test_rows_of_the_vest_end_at_its_armholes_also_beside_a_decrease_of_which_one_loop_is_cast_on():
    fabric = sm.shape_fabric(shape("vest"), stitch_width=1.2, progress=False).fabric
    finished = finish_row_ends(fabric)
    ends = np.flatnonzero((fabric.twin == BORDER) & fabric.is_wale)
    assert len(ends) > 100
    crossings = {crossing_number(int(side)) for side in ends}
    assert crossings <= finished.paths.keys() | finished.tails.keys()
