# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Display: subdivision is Loop's, straight yarns stay straight, and nothing jumps at the seam of a region."""

from __future__ import annotations

import numpy as np
import pytest
from trimesh.creation import icosphere
from trimesh.remesh import subdivide_loop

from stitchmesh.mixed.cloth.cloth import Cloth
from stitchmesh.mixed.cloth.panels import Panel
from stitchmesh.mixed.cloth.seams import cloth_from_panels
from stitchmesh.mixed.enrichment.region import Region, region_around
from stitchmesh.mixed.layout.crossing_yarns import CrossingYarns
from stitchmesh.mixed.layout.weave import lay_weave
from stitchmesh.mixed.output.display import Display
from stitchmesh.mixed.output.files import one_vertex_for_each_fan
from stitchmesh.mixed.output.loop_subdivision import loop_subdivision

PLAIN = [[1, 0], [0, 1]]
ROUNDING = 1e-12
"""Coordinates of a few cm in float64, after some hundred sums."""


@pytest.fixture(scope="module")
def cloth() -> Cloth:
    return cloth_from_panels([Panel(name="patch", outline=[[0, 0], [6, 0], [6, 4], [0, 4]])], [], edge_length=0.8)


@pytest.fixture(scope="module")
def yarns(cloth: Cloth) -> CrossingYarns:
    return lay_weave(cloth, PLAIN, ends=4, picks=4)


def region_of(cloth: Cloth, yarns: CrossingYarns, chosen: np.ndarray, rings: int = 1) -> Region:
    count = len(cloth.vertices)
    return region_around(cloth.triangles, count, yarns.triangle, yarns.barycentric, chosen, rings=rings)


def middle_of(cloth: Cloth) -> np.ndarray:
    centre = cloth.rest.mean(axis=1)
    return np.flatnonzero((np.abs(centre - [3.0, 2.0]) < 1.1).all(axis=1))


def wave(points: np.ndarray) -> np.ndarray:
    """A bent sheet."""
    x, y = points[:, 0], points[:, 1]
    return np.column_stack([x, y, 0.4 * np.sin(x) + 0.2 * np.cos(1.3 * y)])


def test_subdivision_is_that_of_trimesh():
    rounds, sphere = 2, icosphere(subdivisions=1)
    stretched = sphere.vertices * [1.0, 1.5, 0.7]
    made = loop_subdivision(sphere.faces, len(stretched), rounds)
    vertices, faces = subdivide_loop(stretched, sphere.faces, rounds)
    own, theirs = (made.matrix @ stretched)[made.triangles], vertices[faces]
    assert np.allclose(np.sort(own.sum(axis=(1, 2))), np.sort(theirs.sum(axis=(1, 2))), atol=ROUNDING)
    assert np.allclose(own.mean(axis=(0, 1)), theirs.mean(axis=(0, 1)), atol=ROUNDING)


def test_weights_add_up_to_one_and_points_stay_where_they_are_in_their_triangle(cloth):
    made = loop_subdivision(cloth.triangles, len(cloth.vertices), 2)
    for weights in (made.matrix, made.linear):
        assert np.allclose(weights.sum(axis=1), 1.0, atol=ROUNDING)
    random = np.random.default_rng(0)
    triangle = random.integers(len(cloth.triangles), size=200)
    weight = random.dirichlet(np.ones(3), size=200)
    child, inside = made.children(triangle, weight)
    places = np.einsum("nk,nkd->nd", inside, (made.linear @ cloth.vertices)[made.triangles[child]])
    expected = np.einsum("nk,nkd->nd", weight, cloth.vertices[cloth.triangles[triangle]])
    assert (inside >= -ROUNDING).all()
    assert np.allclose(places, expected, atol=ROUNDING)


@pytest.mark.parametrize("kind", ["none", "middle", "all"])
def test_flat_and_stretched_cloth_shows_straight_yarns(cloth, yarns, kind):
    chosen = {"none": np.zeros(0, dtype=int), "middle": middle_of(cloth), "all": np.arange(len(cloth.triangles))}[kind]
    region = region_of(cloth, yarns, chosen)
    stretch = np.array([[1.2, 0.1, 0.0], [0.0, 0.9, 0.3], [0.0, -0.2, 1.0]])
    vertices = cloth.vertices @ stretch
    nodes = yarns.world(cloth) @ stretch
    shown = Display(cloth, yarns, region).show(vertices, nodes[region.nodes])
    assert np.allclose(shown.nodes, nodes, atol=1e-9)  # the softness of covered vertices is exact for affine maps
    if kind != "all":  # where all vertices are covered, the softness keeps a part of the initial shape
        assert np.allclose(shown.vertices, vertices, atol=1e-2)
    normal = np.cross(*(vertices[cloth.triangles[0]] - vertices[cloth.triangles[0][0]])[1:])
    flat = (shown.surface - vertices[0]) @ (normal / np.linalg.norm(normal))
    assert np.abs(flat).max(initial=0.0) < 1e-9


def test_display_is_continuous_across_the_region(cloth, yarns):
    """A node beside the hybrid region is shown as near its neighbours as elsewhere on a smooth surface."""
    region = region_of(cloth, yarns, middle_of(cloth))
    vertices = wave(cloth.vertices)
    nodes = wave(yarns.world(cloth))
    shown = Display(cloth, yarns, region).show(vertices, nodes[region.nodes])
    on_triangles = yarns.world(cloth, vertices)
    error = np.linalg.norm(shown.nodes - nodes, axis=1)
    flat = np.linalg.norm(on_triangles - nodes, axis=1)
    outside = region.node_kind == 0
    assert error[region.node_alpha == 1.0].max() < ROUNDING
    assert error.max() < flat[outside].max()  # the smooth surface is nearer than the triangles
    links = yarns.neighbours
    pairs = np.array([(i, j) for i in range(yarns.node_count) for j in links[i] if j > i])
    jump = np.linalg.norm((shown.nodes - nodes)[pairs[:, 0]] - (shown.nodes - nodes)[pairs[:, 1]], axis=1)
    across = outside[pairs[:, 0]] != outside[pairs[:, 1]]
    assert jump[across].max() < 2.0 * jump[outside[pairs].all(axis=1)].max()


def test_vertices_in_the_full_yarn_region_follow_their_nodes(cloth, yarns):
    region = region_of(cloth, yarns, np.arange(len(cloth.triangles)))
    assert not region.unknown_vertices.any()
    nodes = wave(yarns.world(cloth))
    shown = Display(cloth, yarns, region).show(np.full_like(cloth.vertices, np.nan_to_num(0.0)), nodes)
    assert np.abs(yarns.world(cloth, shown.vertices) - nodes).max() < 0.05  # a triangle of 0.8 cm on this wave
    assert len(shown.surface) == 0


def test_each_fan_of_triangles_has_a_vertex_of_its_own():
    """Two triangles that meet in vertex 2, and a third one beside the second."""
    triangles, source = one_vertex_for_each_fan(np.array([[0, 1, 2], [2, 3, 4], [2, 4, 5]]))
    assert len(source) == 7
    assert np.array_equal(source[triangles], [[0, 1, 2], [2, 3, 4], [2, 4, 5]])
    assert triangles[0, 2] != triangles[1, 0] == triangles[2, 0]
