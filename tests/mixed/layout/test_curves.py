# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Yarn curves for display: they pass the displaced nodes, touch at crossings, and follow the cloth in space."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from stitchmesh.errors import StitchMeshError
from stitchmesh.io import read_yarns, write_yarns
from stitchmesh.mixed.cloth.seams import cloth_from_panels
from stitchmesh.mixed.layout.curves import interpolating_points, yarn_curves
from stitchmesh.mixed.layout.knit import lay_knit
from stitchmesh.mixed.layout.weave import lay_weave
from tests.mixed.cloth.panel_shapes import rectangle, side_by_side
from tests.mixed.layout.test_weave import PLAIN, TWILL


def woven(matrix=PLAIN):
    cloth = cloth_from_panels([rectangle(4.0, 3.0)], [], edge_length=1.0)
    return cloth, lay_weave(cloth, matrix, ends=3.0, picks=3.0)


def knots(curves) -> list[np.ndarray]:
    """The points at which the segments of each yarn meet."""
    return curves.sampled(1)


def test_splines_pass_their_points_and_end_there():
    rng = np.random.default_rng(3)
    points, start = rng.normal(size=(12, 3)), np.array([0, 2, 5, 12])
    control, control_start = interpolating_points(points, start)
    np.testing.assert_array_equal(control_start - start, [0, 2, 4, 6])
    for k in range(3):
        own = control[control_start[k] : control_start[k + 1]]
        passed = (own[:-2] + 4 * own[1:-1] + own[2:]) / 6
        np.testing.assert_allclose(passed, points[start[k] : start[k + 1]], atol=1e-14)  # rounding of the solution
        bend = [own[0] - 2 * own[1] + own[2], own[-1] - 2 * own[-2] + own[-3]]
        np.testing.assert_allclose(bend, 0.0, atol=1e-14)


def test_woven_yarns_pass_over_and_under_by_their_sides():
    cloth, yarns = woven(TWILL)
    curves = yarn_curves(cloth, yarns, radius=0.05)
    assert curves.yarn_count == yarns.yarn_count
    height = np.concatenate([points[:, 2] for points in knots(curves)])
    sign = np.where(yarns.yarn_coordinate == 0, 1, -1) * yarns.side[yarns.yarn_node]
    np.testing.assert_allclose(height, 0.05 * sign, atol=1e-14)


@pytest.mark.parametrize(("spacing", "crimp"), [(2.0, 0.1435), (3.0, 0.0585)])
def test_a_plain_weave_is_shown_with_nearly_the_crimp_of_peirces_geometry(spacing, crimp):
    """Peirce: rigid round yarns of diameter d at distances of ``spacing`` d, which are arcs and straight lines."""
    cloth = cloth_from_panels([rectangle(4.0, 3.0)], [], edge_length=1.0)
    yarns = lay_weave(cloth, PLAIN, ends=3.0, picks=3.0)
    curve = yarn_curves(cloth, yarns, radius=1.0 / 3.0 / spacing / 2.0).sampled(32)[4]
    along = int(np.abs(curve[-1] - curve[0]).argmax())
    inner = curve[(curve[:, along] > 1.0) & (curve[:, along] < 3.0)]
    length = np.linalg.norm(np.diff(inner, axis=0), axis=1).sum()
    found = length / abs(inner[-1, along] - inner[0, along]) - 1.0
    # a cubic spline between the same crests is nearly a sine, whose crimp has other parts of fourth order in d / p
    assert found == pytest.approx(crimp, rel=0.12)


def test_yarns_of_different_radii_touch():
    cloth, yarns = woven()
    radius = np.where(yarns.yarn_family == 0, 0.03, 0.05)
    curves = yarn_curves(cloth, yarns, radius=radius)
    height = np.concatenate([points[:, 2] for points in knots(curves)])
    apart = np.abs(height[yarns.node_passage[:, 0]] - height[yarns.node_passage[:, 1]])
    np.testing.assert_allclose(apart, 0.08, rtol=1e-12)
    np.testing.assert_array_equal(curves.radius, radius)


def test_knitted_yarns_have_one_more_point_within_each_contact_and_touch_there():
    cloth = cloth_from_panels([rectangle(5.0, 4.0)], [], edge_length=1.0)
    yarns = lay_knit(cloth, [[1]], wale_spacing=0.5, course_spacing=0.4)
    curves = yarn_curves(cloth, yarns, radius=0.05)
    points = np.concatenate(knots(curves))
    assert len(points) == len(yarns.yarn_node) + 2 * len(yarns.stitch_contacts)
    middle = yarns.position[yarns.stitch_contacts].mean(axis=1)
    flat = np.linalg.norm(points[None, :, :2] - middle[:, None], axis=2)
    assert (np.count_nonzero(np.isclose(flat, 0.05, atol=1e-12), axis=1) == 2).all()


def test_loops_of_a_knit_do_not_pass_through_one_another():
    from scipy.spatial import cKDTree

    cloth = cloth_from_panels([rectangle(5.0, 4.0)], [], edge_length=1.0)
    yarns = lay_knit(cloth, [[1]], wale_spacing=0.5, course_spacing=0.4)
    sampled = yarn_curves(cloth, yarns, radius=0.05).sampled(12)
    points, yarn = np.concatenate(sampled), np.repeat(np.arange(len(sampled)), [len(one) for one in sampled])
    pairs = cKDTree(points).query_pairs(0.1, output_type="ndarray")
    pairs = pairs[yarn[pairs[:, 0]] != yarn[pairs[:, 1]]]
    nearest = np.linalg.norm(points[pairs[:, 0]] - points[pairs[:, 1]], axis=1).min(initial=0.1)
    assert nearest > 0.75 * 0.1  # the splines bulge between the points at which the yarns just touch


def test_curves_follow_nodes_and_cloth_in_space():
    cloth, yarns = woven()
    turn = np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]]) @ np.array(
        [[1, 0, 0], [0, 0, -1.0], [0, 1, 0]]
    )
    moved = cloth.vertices @ turn.T + [1.0, 2.0, 3.0]
    flat = yarn_curves(cloth, yarns, radius=0.05)
    placed = yarn_curves(cloth, yarns, radius=0.05, vertices=moved)
    np.testing.assert_allclose(placed.points, flat.points @ turn.T + [1.0, 2.0, 3.0], atol=1e-12)
    given = yarn_curves(cloth, yarns, radius=0.05, nodes=yarns.world(cloth, moved), vertices=moved)
    np.testing.assert_array_equal(given.points, placed.points)
    by_copy = yarn_curves(replace(cloth, vertices=moved), yarns, radius=0.05)
    np.testing.assert_array_equal(by_copy.points, placed.points)


def test_rods_are_yarns_along_the_seam(tmp_path):
    cloth = side_by_side(8.0, 8.0)
    yarns = lay_weave(cloth, PLAIN, ends=2.0, picks=2.0)
    curves = yarn_curves(cloth, yarns, radius=0.05)
    rod = knots(curves)[-1]
    np.testing.assert_allclose(rod[:, [0, 2]], [[10.0, 0.0]] * len(rod), atol=1e-12)
    path = tmp_path / "weave.bcc"
    write_yarns(path, curves)
    assert len(read_yarns(path).points) == len(curves.points)


@pytest.mark.parametrize(
    ("fields", "message"),
    [({"radius": -1.0}, "radius"), ({"radius": 0.1, "nodes": np.zeros((3, 3))}, "nodes: got shape")],
)
def test_what_is_refused(fields, message):
    with pytest.raises(StitchMeshError, match=message):
        yarn_curves(*woven(), **fields)
