# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The mean winding number of surfaces, and meshes that are turned inside out."""

from __future__ import annotations

from dataclasses import fields

import numpy as np
import pytest

from stitchmesh.io import read_mesh
from stitchmesh.mesh import BORDER, Mesh
from stitchmesh.mesh.orientation import INSIDE_OUT, is_inside_out, mean_winding_number, turn_inside_out
from tests.gallery import GARMENTS, grid, shared, torus, tube

pytestmark = pytest.mark.decides


def sphere(around: int = 24) -> Mesh:
    """A closed surface of quads: a cube whose faces are grids, moved onto the unit sphere."""
    span = np.linspace(-1.0, 1.0, around + 1)
    a, b = np.meshgrid(span, span, indexing="ij")
    vertices: dict[tuple[float, ...], int] = {}
    faces = []
    for axis in range(3):
        for sign in (-1.0, 1.0):
            points = np.zeros((around + 1, around + 1, 3))
            points[..., axis], points[..., (axis + 1) % 3], points[..., (axis + 2) % 3] = sign, a, b
            number = np.array([[vertices.setdefault(tuple(p), len(vertices)) for p in row] for row in points])
            for i in range(around):
                for j in range(around):
                    face = [number[i, j], number[i + 1, j], number[i + 1, j + 1], number[i, j + 1]]
                    faces.append(face if sign > 0 else face[::-1])
    points = np.array(list(vertices))
    return Mesh.from_polygons(points / np.linalg.norm(points, axis=1, keepdims=True), faces)


def arc(degrees: float) -> Mesh:
    """A long part of a tube that goes round by an angle, with outward normals."""
    flat = grid(24, 40, width=1.0 / 24, height=0.5)
    angle = np.radians(degrees) * flat.vertices[:, 0]
    return Mesh(
        np.stack([np.sin(angle), flat.vertices[:, 1], np.cos(angle)], axis=1),
        flat.face_start, flat.face_vertex, flat.twin,
    )  # fmt: skip


def test_a_closed_surface_has_one_half():
    """Distant dipoles leave an error of a few thousandths, and the centres lie inside."""
    assert mean_winding_number(sphere()) == pytest.approx(0.5, abs=0.01)
    assert mean_winding_number(torus(32, 64)) == pytest.approx(0.5, abs=0.01)


def test_a_flat_piece_has_none():
    """All offsets lie in the plane, so that only rounding remains."""
    assert mean_winding_number(grid(7, 5)) == pytest.approx(0.0, abs=1e-12)


@pytest.mark.parametrize("degrees", [60, 120, 180, 270])
def test_a_part_of_a_tube_has_its_angle_over_four_pi(degrees):
    """By the inscribed angle theorem, if the tube is long; the ends of this one take up to a tenth."""
    assert mean_winding_number(arc(degrees)) == pytest.approx(np.radians(degrees) / (4 * np.pi), rel=0.1)


@pytest.mark.parametrize("path", GARMENTS, ids=lambda path: path.stem)
def test_no_garment_is_called_inside_out_and_each_turned_one_is(path):
    mesh = read_mesh(path)
    assert not is_inside_out(mesh)
    assert mean_winding_number(turn_inside_out(mesh)) == pytest.approx(-mean_winding_number(mesh), abs=1e-9)
    assert is_inside_out(turn_inside_out(mesh)) == (path.stem != "swatch")


@pytest.mark.parametrize("name", ["makehuman-helper-skirt", "makehuman-helper-tights", "makehuman-body"])
def test_real_clothes_are_the_right_side_out(name):
    assert mean_winding_number(read_mesh(shared(f"meshes/{name}.obj"), unit="dm")) > -INSIDE_OUT


def test_a_slightly_curved_piece_has_no_inside():
    assert not is_inside_out(turn_inside_out(arc(60)))


def edges_of(mesh: Mesh) -> set[tuple[int, int]]:
    """The two vertices of each edge, the lower number first."""
    ends = np.sort([mesh.face_vertex[mesh.edge_side], mesh.face_vertex[mesh.side_next[mesh.edge_side]]], axis=0)
    return set(zip(*ends.tolist(), strict=True))


def test_turning_keeps_edges_and_turning_twice_is_the_same_mesh():
    mesh = read_mesh(GARMENTS[0])
    turned = turn_inside_out(mesh)
    np.testing.assert_allclose(turned.face_vector_area, -mesh.face_vector_area, atol=1e-12)
    assert edges_of(turned) == edges_of(mesh)
    assert np.count_nonzero(turned.twin == BORDER) == np.count_nonzero(mesh.twin == BORDER)
    again = turn_inside_out(turned)
    for part in fields(Mesh):
        np.testing.assert_array_equal(getattr(again, part.name), getattr(mesh, part.name))


def test_the_number_does_not_depend_on_place_and_size():
    mesh = tube(12, 6)
    moved = Mesh(mesh.vertices * 7.0 + [30.0, -5.0, 2.0], mesh.face_start, mesh.face_vertex, mesh.twin)
    assert mean_winding_number(moved) == pytest.approx(mean_winding_number(mesh), abs=1e-9)
