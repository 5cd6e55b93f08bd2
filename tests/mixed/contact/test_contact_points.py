# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Contact points: areas, density, shares, seams, and the map to and from vertices and nodes."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
import warp as wp

from stitchmesh.errors import ParameterError
from stitchmesh.mixed.contact.contact_points import join_points, points_at_nodes
from stitchmesh.mixed.contact.pair_lists import seam_neighbours
from stitchmesh.mixed.contact.point_map import PointMap
from tests.mixed.contact.sheets import cpu, launcher, sheet, state_of, together


def test_areas_add_up_to_the_cloth_whatever_the_spacing():
    cloth = sheet(3, 2.0)
    for spacing in (5.0, 0.5, 0.11, np.inf):
        points, _links = cloth.points(0.1, spacing=spacing)
        assert points.area.sum() == pytest.approx(4.0)
        places = points.places(cloth.vertices, np.zeros((0, 3)))
        assert len(np.unique(places.round(12), axis=0)) == len(points)
        assert places[:, :2] == pytest.approx(points.rest)
    assert len(cloth.points(0.1, spacing=np.inf)[0]) == len(cloth.vertices)


def test_triangles_of_different_sizes_share_the_points_of_their_sides():
    cloth = sheet(1, 1.0)
    middle = np.array([[0.0, 0.0, 0.0]])  # one of the two triangles is divided at the middle of the diagonal
    a, b, c = cloth.triangles[0]
    triangles = np.array([[a, b, 4], [b, c, 4], cloth.triangles[1]])
    vertices = np.concatenate([cloth.vertices, middle])
    uneven = replace(
        cloth, vertices=vertices, triangles=triangles, rest=vertices[triangles][:, :, :2], panel=np.zeros(3, dtype=int)
    )
    points, links = uneven.points(0.1, spacing=1.0)
    assert len(links.panel) == 0
    assert points.area.sum() == pytest.approx(1.0)


def test_coarse_points_have_large_spheres_against_layers():
    cloth = sheet(2, 2.0)  # sides of 1 and 1.41 cm
    for options, parts in (({}, 4), ({"most_parts": 1}, 1), ({"spacing": 0.8}, 2)):
        points, _links = cloth.points(0.1, **options)
        assert points.layer_radius == pytest.approx(0.5 * np.sqrt(2.0) / parts)
        assert points.radius == pytest.approx(0.05)
    assert cloth.points(0.1, most_parts=32)[0].layer_radius == pytest.approx(0.05)


def test_weights_leave_triangles_out():
    cloth = sheet(4, 1.0)
    weight = (cloth.rest[:, :, 0].mean(axis=1) < 0.0).astype(float)
    points, _links = cloth.points(0.1, weight=weight)
    assert points.area.sum() == pytest.approx(0.5)
    assert points.rest[:, 0].max() <= 1e-12


def test_panels_that_share_vertices_are_linked():
    left, right = sheet(4, 1.0), sheet(4, 1.0, shift=0.0)
    cloth = together(left, right)
    # the border x = 1/2 of the first panel is sewn to the border x = -1/2 of the second one
    sewn = cloth.triangles.copy()
    sewn[(sewn >= 25) & (sewn < 30)] -= 5
    points, links = replace(cloth, triangles=sewn).points(0.1, most_parts=4)
    assert points.layer_radius == pytest.approx(0.05)  # sides of 0.25 and 0.35 cm in 4 parts
    assert (links.panel == [0, 1]).all()
    assert links.rest[:, 0, 0] == pytest.approx(0.5) and links.rest[:, 1, 0] == pytest.approx(-0.5)
    assert links.rest[:, 0, 1] == pytest.approx(links.rest[:, 1, 1])
    pairs = seam_neighbours(points, links)
    row = np.repeat(np.arange(len(points)), np.diff(pairs.start))
    # a path over the seam, on a line across it, is as long as the difference of the places along both panels
    along = points.rest + np.column_stack([points.panel, np.zeros(len(points))])
    straight = np.linalg.norm(along[row] - along[pairs.point], axis=1)
    assert straight.max() < 0.2
    facing = (np.abs(along[:, None] - along[None])[:, :, 1] < 1e-9) & (points.panel[:, None] != points.panel[None])
    expected = facing & (np.abs(along[:, None, 0] - along[None, :, 0]) < 0.2 - 1e-9)
    listed = np.zeros_like(expected)
    listed[row, pairs.point] = True
    assert listed[expected].all() and (listed == listed.T).all() and not listed.diagonal().any()


def test_places_and_forces_are_the_matrix_of_shares_and_its_transpose():
    cloth = sheet(3, 1.0)
    on_triangles, _links = cloth.points(0.1, node_count=2)
    at_nodes = points_at_nodes(16, panel=[0, 0], rest=[[0, 0], [0.1, 0]], area=0.01, weight=[1.0, 0.5], thickness=0.1)
    points = join_points([on_triangles, at_nodes])
    rng = np.random.default_rng(0)
    nodes = rng.normal(size=(2, 3))
    state, force = state_of(cloth.vertices, nodes), rng.normal(size=(len(points), 3))
    mapped = PointMap.of(points, wp.float64, cpu())
    place = mapped.vectors()
    mapped.place(state, place, launcher())
    assert place.numpy() == pytest.approx(points.places(cloth.vertices, nodes))
    target = state.like()
    mapped.spread(wp.array(force, dtype=wp.vec3d, device=cpu()), target, launcher())
    v, p, s = target.numpy()
    work = (place.numpy() * force).sum()
    assert (v * cloth.vertices).sum() + (p * nodes).sum() == pytest.approx(work)
    assert np.concatenate([v, p]).sum(axis=0) == pytest.approx(force.sum(axis=0))
    assert not s.any()


def test_refuses():
    good = sheet(1, 1.0).points(2.0)[0]
    with pytest.raises(ParameterError, match=r"^contact points: share: got shape \(3, 3\); expected \(4, 3\)$"):
        replace(good, share=good.share[:3])
    with pytest.raises(ParameterError, match=r"point 2: got the positions \[9, 9, 9\]; expected 0 to 3$"):
        replace(good, index=np.where(np.arange(4)[:, None] == 2, 9, good.index))
    with pytest.raises(ParameterError, match=r"area of point 1: got -1\.0; expected a positive number$"):
        replace(good, area=np.array([1.0, -1.0, 1.0, 1.0]))
    with pytest.raises(ParameterError, match="not finite"):
        replace(good, rest=np.full((4, 2), np.nan))
    with pytest.raises(ParameterError, match="sets for one cloth"):
        join_points([good, sheet(2, 1.0).points(2.0)[0]])
