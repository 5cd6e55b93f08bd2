# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Yarns of stitch meshes: the same loops as those of a chart, garments, divisions, shaping and slipped stitches."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from stitchmesh.errors import ParameterError
from stitchmesh.labeling import label
from stitchmesh.mesh import TOP
from stitchmesh.mesh.stitch import Stitch
from stitchmesh.mixed.cloth.from_stitches import cloth_from_stitches
from stitchmesh.mixed.cloth.seams import cloth_from_panels
from stitchmesh.mixed.layout.embedding import rest_positions
from stitchmesh.mixed.layout.from_stitches import lay_stitches
from stitchmesh.mixed.layout.knit import lay_knit
from stitchmesh.mixed.layout.stitch_division import divide_stitches
from stitchmesh.tessellate import tessellate
from tests.gallery import grid, tube
from tests.mixed.cloth.panel_shapes import rectangle
from tests.mixed.cloth.test_cloth_from_stitches import garment
from tests.nightly import at_night

SIZE = {"stitch_width": 1.6, "course_height": 1.2}


def flat(columns: int = 6, rows: int = 5):
    fabric = tessellate(label(grid(columns, rows, width=1.6, height=1.2)), stitch_width=1.6, stitch_height=1.2)
    return fabric, cloth_from_stitches(fabric, **SIZE)


def test_a_flat_piece_has_the_yarns_of_a_chart_of_the_same_size():
    fabric, cloth = flat()
    yarns = lay_stitches(cloth, fabric, **SIZE)
    panel = cloth_from_panels([rectangle(6 * 1.6, 5 * 1.2)], [], edge_length=2.0)
    chart = lay_knit(panel, [[1]], wale_spacing=1.6, course_spacing=1.2)
    assert yarns.node_count == chart.node_count and yarns.yarn_count == chart.yarn_count
    np.testing.assert_array_equal(np.diff(yarns.yarn_start), np.diff(chart.yarn_start))
    for ours, theirs in ((yarns, chart),):
        np.testing.assert_array_equal(ours.yarn_coordinate, theirs.yarn_coordinate)
        np.testing.assert_array_equal(ours.side[ours.yarn_node], theirs.side[theirs.yarn_node])
        length = [one.rest_sliding[one.yarn_node, one.yarn_coordinate] for one in (ours, theirs)]
        np.testing.assert_allclose(length[0], length[1], atol=1e-12)  # a sum of 50 steps
        turn = [one.rest_turn[one.yarn_node, one.yarn_coordinate] for one in (ours, theirs)]
        np.testing.assert_allclose(turn[0], turn[1], atol=1e-12)
    np.testing.assert_array_equal(yarns.stitch_left, chart.stitch_left)


@pytest.mark.parametrize(("name", "divisions"), [("hat", 2), *at_night(("sweater", 1), ("sock", 3))])
def test_garments(name, divisions):
    fabric = garment(name)
    cloth = cloth_from_stitches(fabric, **SIZE)
    yarns = lay_stitches(cloth, fabric, **SIZE, divisions=divisions)
    made = rest_positions(cloth, yarns.triangle, yarns.barycentric)
    np.testing.assert_allclose(made, yarns.position, atol=1e-9)  # coordinates of 100 cm, rounded a few times
    loops = fabric.face_count * divisions**2
    assert 3.5 * loops < yarns.node_count < 4.5 * loops
    assert yarns.yarn_count == {"sweater": 3, "hat": 1, "sock": 1}[name]  # a spiral for the body and for each sleeve
    assert (np.bincount(yarns.yarn_node, minlength=yarns.node_count) == 2).all()
    step = np.diff(yarns.rest_sliding[yarns.yarn_node, yarns.yarn_coordinate])
    inner = np.diff(yarns.passage_yarn) == 0
    assert step[inner].min() > 0.1 * 1.2 / divisions  # a tenth of a course


def test_a_tube_is_one_spiral():
    fabric = tessellate(label(tube(8, 4)), stitch_width=1.6, stitch_height=1.2)
    yarns = lay_stitches(cloth_from_stitches(fabric, **SIZE), fabric, **SIZE)
    assert yarns.yarn_count == 1
    assert (yarns.node_yarn == 0).all()
    step = np.diff(yarns.rest_sliding[yarns.yarn_node, yarns.yarn_coordinate])
    assert step.max() < np.hypot(1.6, 1.2)  # also from one round to the next


def test_sides_follow_knit_and_purl():
    fabric, cloth = flat()
    purl = replace(fabric, stitch=np.where(fabric.stitch == Stitch.KNIT, Stitch.PURL, fabric.stitch))
    knit_yarns, purl_yarns = lay_stitches(cloth, fabric, **SIZE), lay_stitches(cloth, purl, **SIZE)
    np.testing.assert_array_equal(knit_yarns.side, -purl_yarns.side)


def test_a_slipped_loop_is_worked_by_the_row_above():
    fabric, cloth = flat()
    stitch = fabric.stitch.copy()
    row = np.sort(np.unique(fabric.row))[2]
    slipped = int(np.flatnonzero(fabric.row == row)[3])
    stitch[slipped] = Stitch.SLIP_BACK
    yarns = lay_stitches(cloth, replace(fabric, stitch=stitch), **SIZE)
    plain = lay_stitches(cloth, fabric, **SIZE)
    assert yarns.node_count == plain.node_count - 4
    family = np.diff(yarns.yarn_start)
    assert (family == np.diff(plain.yarn_start) - np.array([0, 0, 8, 0, 0])).all()  # the row passes by, without nodes
    step = np.diff(yarns.rest_sliding[yarns.yarn_node, yarns.yarn_coordinate])
    assert step[np.diff(yarns.passage_yarn) == 0].max() > 1.2  # the loop of the row below is one course longer


def test_division_keeps_the_surface_and_the_loops():
    k, fabric = 3, garment("sock")
    divided = divide_stitches(fabric, k)
    small = divided.fabric
    np.testing.assert_array_equal(np.bincount(divided.parent), k * k)
    total = np.zeros((fabric.face_count, 3))
    np.add.at(total, divided.parent, small.face_vector_area)
    np.testing.assert_allclose(total, fabric.face_vector_area, atol=1e-12)  # the area vector depends on the border only
    before = sum(len(loop) for loop in fabric.boundary_loops)
    assert sum(len(loop) for loop in small.boundary_loops) == k * before
    tops = np.count_nonzero(small.side_role == TOP), np.count_nonzero(fabric.side_role == TOP)
    across = np.count_nonzero(fabric.n_top > fabric.n_bottom), np.count_nonzero(fabric.n_top < fabric.n_bottom)
    assert tops[0] == k * (k * fabric.face_count + across[0]) and tops[1] == fabric.face_count + across[0]
    assert across[1] > 0


def test_what_is_refused():
    fabric, cloth = flat()
    with pytest.raises(ParameterError, match="division of stitches: got 0; expected a number of at least 1"):
        lay_stitches(cloth, fabric, **SIZE, divisions=0)
    other, _ = flat(3, 3)
    with pytest.raises(ParameterError, match="the triangles are not those of the fabric"):
        lay_stitches(cloth, other, **SIZE)
    with pytest.raises(ParameterError, match="expected a StitchMesh"):
        lay_stitches(cloth, cloth, **SIZE)
    one_row, its_cloth = flat(4, 1)
    with pytest.raises(ParameterError, match="knit: no yarn has two nodes on the cloth"):
        lay_stitches(its_cloth, one_row, **SIZE)
