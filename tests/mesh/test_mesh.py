# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Polygon meshes, stitch meshes and lattices: topology and outlines, and the message for each kind of invalid input."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from stitchmesh.errors import LabelError, MeshError
from stitchmesh.labeling import label
from stitchmesh.lattice import Lattice, cross_product
from stitchmesh.mesh import BORDER, Mesh
from stitchmesh.mesh.connectivity import linked_groups
from stitchmesh.mesh.polygon_mesh import outline_sides
from stitchmesh.mesh.stitch import Stitch
from tests.gallery import FLAT_AND_ROUND, grid, moebius, torus, tube

SQUARE = [[0.0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]]
EULER = {"one quad": 1, "flat": 1, "tube": 0, "narrowing tube": 0, "three around": 0, "closed cone": 1,
         "pentagons": 1, "two tubes": 0}  # fmt: skip
"""Euler characteristic: 1 for a disc, 0 for an annulus."""


@pytest.mark.parametrize("name", FLAT_AND_ROUND)
def test_euler_characteristic_is_that_of_the_surface(name):
    mesh = FLAT_AND_ROUND[name]()
    assert len(mesh.vertices) - len(mesh.edge_side) + mesh.face_count == EULER[name]


@pytest.mark.parametrize("name", FLAT_AND_ROUND)
def test_twins_are_mutual_and_borders_close(name):
    mesh = FLAT_AND_ROUND[name]()
    inner = np.flatnonzero(mesh.twin != BORDER)
    assert (mesh.twin[mesh.twin[inner]] == inner).all()
    border = np.concatenate(mesh.boundary_loops)
    assert sorted(border) == sorted(np.flatnonzero(mesh.twin == BORDER))
    for loop in mesh.boundary_loops:
        ends = mesh.face_vertex[mesh.side_next[loop]]
        assert (ends == np.roll(mesh.face_vertex[loop], -1)).all()


def test_normals_of_a_tube_point_outwards():
    mesh = tube(12, 2)
    outward = mesh.vertices * [1.0, 0.0, 1.0]
    assert (np.einsum("vd,vd->v", mesh.vertex_normal, outward) > 0).all()


def test_the_arrays_of_a_mesh_cannot_be_changed():
    with pytest.raises(ValueError, match="read-only"):
        grid(1, 1).vertices[0] = 1.0


BAD = {
    "nan": ([[np.nan, 0, 0], *SQUARE[1:]], [[0, 1, 2, 3]], "vertex 0: coordinates are not finite"),
    "range": (SQUARE, [[0, 1, 2, 9]], "face 0: vertex 9 does not exist"),
    "negative": (SQUARE, [[0, 1, 2, -1]], "face 0: vertex -1 does not exist"),
    "no faces": (SQUARE, [], "no faces"),
    "two corners": (SQUARE, [[0, 1, 2, 3], [0, 1]], "face 1: got 2 corners"),
    "repeated corner": (SQUARE, [[0, 1, 1, 3]], "face 0: vertex 1 occurs twice"),
    "duplicate": (SQUARE, [[0, 1, 2, 3], [1, 2, 3, 0]], "face 1: has the same vertices as face 0"),
    "zero area": ([[0, 0, 0], [1, 0, 0], [2, 0, 0.0]], [[0, 1, 2]], "face 0: area is zero"),
    "isolated": ([*SQUARE, [5, 5, 5]], [[0, 1, 2, 3]], "vertex 4: no face uses it"),
    "three on an edge": (
        [*SQUARE, [0, 0, 1], [1, 0, 1], [0, 0, -1], [1, 0, -1]],
        [[0, 1, 2, 3], [1, 0, 4, 5], [1, 0, 6, 7]],
        "edge 0-1: 3 faces share it",
    ),
    "turned over": ([*SQUARE, [2, 0, 0], [2, 1, 0]], [[0, 1, 2, 3], [1, 2, 5, 4]], "reverse the vertex order of face"),
    "touching fans": (
        [*SQUARE, [2, 1, 0], [2, 2, 0], [1, 2, 0]],
        [[0, 1, 2, 3], [2, 4, 5, 6]],
        "vertex 2: separate parts of the surface meet",
    ),
}


@pytest.mark.parametrize("name", BAD)
def test_each_bad_mesh_has_its_message(name):
    vertices, faces, message = BAD[name]
    with pytest.raises(MeshError, match=message) as caught:
        Mesh.from_polygons(vertices, faces)
    assert "\n" not in str(caught.value)


def test_a_moebius_strip_is_distinguished_from_faces_of_the_wrong_orientation():
    with pytest.raises(MeshError, match="one side only"):
        Mesh.from_polygons(*moebius())


def test_twins_that_are_not_the_same_edge_are_refused():
    mesh = grid(2, 1)
    twin = np.full(mesh.side_count, BORDER)
    twin[0], twin[2] = 2, 0
    with pytest.raises(MeshError, match="not the same edge reversed"):
        replace(mesh, twin=twin)


def test_cross_products_have_the_bits_of_numpy():
    first, second = np.random.default_rng(0).normal(size=(2, 5, 3))
    assert np.array_equal(cross_product(first, second), np.cross(first, second))
    assert np.array_equal(cross_product(first[0], second[0]), np.cross(first[0], second[0]))


def test_a_one_quad_torus_is_a_mesh_with_a_lattice():
    lattice = Lattice([[1.0, 0, 0], [0, 0.7, 0]])
    mesh = Mesh(
        vertices=[[0.0, 0, 0]], face_start=[0, 4], face_vertex=[0, 0, 0, 0], twin=[2, 3, 0, 1],
        lattice=lattice, corner_image=[[0, 0], [1, 0], [1, 1], [0, 1]],
    )  # fmt: skip
    np.testing.assert_allclose(mesh.side_length, [1.0, 0.7, 1.0, 0.7], rtol=1e-15)
    assert len(mesh.boundary_loops) == 0


@pytest.mark.parametrize("periods", [[[1.0, 0, 0], [2.0, 0, 0]], [[1.0, 0, 0], [np.nan, 1, 0]], [[1.0, 0, 0]]])
def test_a_lattice_spans_a_plane(periods):
    with pytest.raises(MeshError, match="lattice"):
        Lattice(periods)


def test_a_face_without_exactly_two_wale_sides_is_refused():
    fabric = label(grid(2, 2))
    with pytest.raises(LabelError, match="face 0: got 2 bottom and 1 top sides of 4"):
        replace(fabric, n_bottom=np.array([2, 1, 1, 1]))


def test_an_edge_that_is_a_wale_edge_of_only_one_face_is_refused():
    mesh = grid(2, 1)
    fabric = label(mesh)
    with pytest.raises(LabelError, match="wale to one face and course to face"):
        replace(fabric, n_bottom=np.array([2, 1]), n_top=np.array([0, 1]))


def test_a_stitch_with_the_wrong_number_of_sides_is_refused():
    fabric = label(grid(1, 1))
    with pytest.raises(LabelError, match=r"face 0: .* \(k2tog\) on 1 bottom and 1 top sides; it needs 2 and 1"):
        replace(fabric, stitch=np.array([Stitch.D12K]))


def test_groups_of_linked_things_are_numbered_by_their_first_things():
    one, other = np.array([8, 2, 5, 1]), np.array([3, 7, 2, 8])
    assert linked_groups(9, one, other).tolist() == [0, 1, 2, 1, 3, 2, 4, 2, 1]
    assert linked_groups(0, one[:0], other[:0]).tolist() == []


def test_the_outline_of_all_faces_is_the_border_of_the_mesh():
    for mesh in (grid(4, 3), tube(8, 3), torus(6, 8)):
        assert outline_sides(mesh, np.arange(mesh.face_count)).tolist() == np.flatnonzero(mesh.twin == BORDER).tolist()


def test_the_outline_of_a_block_is_as_long_as_its_perimeter():
    mesh = grid(5, 4)
    block = np.array([row * 5 + column for row in (1, 2) for column in (1, 2, 3)])
    outline = outline_sides(mesh, block)
    assert mesh.side_length[outline].sum() == 2 * (3 + 2)
    assert set(mesh.side_face[outline].tolist()) <= set(block.tolist())
