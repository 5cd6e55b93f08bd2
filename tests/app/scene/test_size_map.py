# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The map of the sizes of stitches: colours, outlines and sides."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from stitchmesh.app.scene.drawing import Colours
from stitchmesh.app.scene.size_map import DIVERGING, PLAIN, SizeMap, edges, outline
from stitchmesh.mesh.change import UNKNOWN_STRETCH
from tests.meshrelax.fabrics import grid_fabric, rectangle_points

FABRIC = grid_fabric(rectangle_points(6, 4, 6.0, 4.0))
FLAT = np.ones(len(FABRIC.edge_side))


def colours_of(fabric, measure="size"):
    surface = SizeMap(fabric).surface(fabric, measure)
    assert isinstance(surface.colours, Colours)
    return surface.colours.palette[surface.colours.index]


def test_a_fabric_without_stretch_has_one_colour():
    assert SizeMap(FABRIC).surface(FABRIC, "size").colours == PLAIN


def test_twice_and_half_the_width_have_the_colours_of_both_ends():
    stretch = FLAT.copy()
    course = ~FABRIC.is_wale
    stretch[FABRIC.side_edge[course & (FABRIC.row[FABRIC.side_face] == 0)]] = 4.0
    stretch[FABRIC.side_edge[course & (FABRIC.row[FABRIC.side_face] == 3)]] = 0.1
    found = colours_of(replace(FABRIC, stretch=stretch), "width")
    triangles = found.reshape(FABRIC.face_count, 2, 3)  # a quad has two triangles, which come one after another
    assert (triangles[FABRIC.row == 0] == DIVERGING[-1]).all() and (triangles[FABRIC.row == 3] == DIVERGING[0]).all()


def test_stitches_of_unknown_size_are_plain_and_average_ones_have_the_colour_in_the_middle_of_the_scale():
    stretch = FLAT.copy()
    stretch[FABRIC.side_edge[FABRIC.side_face == 0]] = UNKNOWN_STRETCH
    found = colours_of(replace(FABRIC, stretch=stretch))
    assert (found[:2] == PLAIN).all()
    middle = DIVERGING[len(DIVERGING) // 2]  # The others are average; the palette has an odd number of rounded colours.
    assert np.abs(found[2:].astype(int) - middle).max() <= 1


def test_frames_of_a_relaxation_share_their_triangles():
    size_map = SizeMap(FABRIC)
    moved = replace(FABRIC, vertices=FABRIC.vertices + 1.0, stretch=FLAT)
    assert size_map.surface(FABRIC, "size").triangles is size_map.surface(moved, "size").triangles


def test_the_outline_of_a_row_is_its_border_and_every_side_is_drawn_once():
    lines = outline(FABRIC, FABRIC.row == 1)
    length = np.linalg.norm(lines.segments[:, 1] - lines.segments[:, 0], axis=1).sum()
    np.testing.assert_allclose(length, 2 * (6.0 + 1.0))
    assert len(edges(FABRIC).segments) == len(FABRIC.edge_side)
