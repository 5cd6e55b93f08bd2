# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The layers of a garment with a thickness are found, and one of them is taken."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from stitchmesh.errors import ParameterError
from stitchmesh.io import read_mesh
from stitchmesh.mesh import BORDER, Mesh
from stitchmesh.mesh.layers import layer_of, parallel_layers
from tests.gallery import ROOT, torus, tube

MESHES = ROOT / "assets" / "meshes"


def with_thickness(mesh: Mesh, thickness: float) -> Mesh:
    """The mesh, its copy moved inwards along the mean normals of its vertices, and a rim at each border."""
    normal = np.zeros_like(mesh.vertices)
    np.add.at(normal, mesh.face_vertex, mesh.face_vector_area[mesh.side_face])
    inner = mesh.vertices - thickness * normal / np.linalg.norm(normal, axis=1, keepdims=True)
    faces = mesh.polygons
    count = len(mesh.vertices)
    rim = [[b, a, a + count, b + count] for a, b in zip(
        mesh.face_vertex[mesh.twin == BORDER].tolist(),
        mesh.face_vertex[mesh.side_next[mesh.twin == BORDER]].tolist(), strict=True,
    )]  # fmt: skip
    turned = [[corner + count for corner in face[::-1]] for face in faces]
    return Mesh.from_polygons(np.concatenate([mesh.vertices, inner]), [*faces, *turned, *rim])


@pytest.mark.parametrize("name", ["sweater", "poncho"])
def test_the_outer_layer_of_a_garment_with_a_thickness_is_the_garment(name):
    mesh = read_mesh(MESHES / f"{name}.obj")
    layers = parallel_layers(with_thickness(mesh, 0.3))
    assert layers is not None and layers.thickness == pytest.approx(0.3, rel=0.1)  # less where the surface bends
    outer = layer_of(with_thickness(mesh, 0.3), layers, "outer")
    np.testing.assert_array_equal(outer.vertices, mesh.vertices)
    np.testing.assert_array_equal(outer.face_vertex, mesh.face_vertex)


@pytest.mark.parametrize(("layer", "radius"), [("outer", 8.0), ("middle", 7.9), ("inner", 7.8)])
def test_each_layer_of_a_tube_lies_at_its_radius_and_faces_outwards(layer, radius):
    solid = with_thickness(tube(32, 6, radius=8.0, height=2.0), 0.2)
    layers = parallel_layers(solid)
    taken = layer_of(solid, layers, layer)
    # the faces of a tube of 32 sides are nearer by the factor cos(pi / 32), and so is the thickness that is found
    np.testing.assert_allclose(np.linalg.norm(taken.vertices[:, [0, 2]], axis=1), radius, atol=0.1 * (1 - 0.995))
    assert len(taken.boundary_loops) == 2
    outward = np.einsum("fk,fk->f", taken.face_vector_area, taken.corner_position[taken.face_start[:-1]])
    assert (outward > 0.0).all()


def test_a_mesh_of_one_layer_is_left_alone():
    for name in ("glove", "swatch"):
        assert parallel_layers(read_mesh(MESHES / f"{name}.obj")) is None
    assert parallel_layers(torus(12, 8)) is None


def test_a_flat_garment_whose_sides_join_without_a_rim_has_one_layer():
    """A tube of 20 x 20 cm that is pressed to a thickness of 0.4 cm."""
    flat = tube(40, 10, radius=10.0, height=2.0)
    assert parallel_layers(replace(flat, vertices=flat.vertices * [1.0, 1.0, 0.02])) is None


def test_an_unknown_layer_is_refused():
    solid = with_thickness(tube(8, 4), 0.1)
    with pytest.raises(ParameterError, match="layer: got 'lining'; expected one of outer, inner, middle"):
        layer_of(solid, parallel_layers(solid), "lining")
