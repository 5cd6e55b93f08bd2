# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Stitches in a fold that is too sharp for their yarns are moved until the yarns have room, and no others are."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

import stitchmesh as sm
from stitchmesh.errors import YarnError
from stitchmesh.mesh import Mesh, StitchMesh
from stitchmesh.patterns import read_pattern
from stitchmesh.periodic.repeat.torus import torus_mesh
from stitchmesh.yarngen.finish import YarnFinish
from stitchmesh.yarngen.room import (
    CORNER_HEIGHT,
    RINGS,
    THICKNESS_OVER_RADIUS,
    RoomyFabric,
    layers_apart,
)
from tests.gallery import grid, tube
from tests.nightly import at_night

WIDTH = 24
"""Stitches of the flat piece in a row, each 1 cm wide."""
GAP = 0.002
"""Distance of the two sides of a fold over its depth; the yarns of the sides then pass through each other."""


def flat(height: float = 24.0) -> StitchMesh:
    piece = sm.tessellate(sm.label(grid(4, 1, width=WIDTH / 4, height=height)), stitch_width=1.0)
    return replace(piece, stretch=np.ones(len(piece.edge_side)))


def folded(piece: StitchMesh, lowest: float, highest: float) -> StitchMesh:
    """The piece with a fold that is 2 cm deep from one height to another, whose two sides almost touch."""
    x, y, z = piece.vertices.T
    inside = (y > lowest) & (y < highest)
    away = x - WIDTH / 2
    deep = np.where(inside & (np.abs(away) < 2.0), 2.0 - np.abs(away), 0.0)
    return replace(piece, vertices=np.stack([np.where(deep > 0.0, WIDTH / 2 + GAP * away, x), y, z - deep], axis=1))


@cache
def fold_inside() -> StitchMesh:
    return folded(flat(), 10.0, 14.0)


@cache
def with_room(quality: str) -> RoomyFabric:
    return sm.make_room(fold_inside(), quality=quality)


@pytest.mark.parametrize("quality", ["draft", *at_night("standard", "reference")])
def test_yarns_in_a_fold_get_room_and_loops_hold(quality):
    fabric = fold_inside()
    with pytest.raises(YarnError, match=r"start .* radii apart"):
        sm.generate_yarns(fabric, quality=quality)
    room = with_room(quality)
    roomy = room.fabric
    sm.check_loops(roomy, sm.generate_yarns(roomy, quality=quality))
    moved = np.linalg.norm(roomy.vertices - fabric.vertices, axis=1)
    assert room.farthest == moved.max() > 0.0 and len(room.faces) > 0
    assert sm.make_room(roomy, quality=quality).fabric is roomy


def test_only_stitches_near_the_fold_move_and_their_stretch_follows():
    fabric = fold_inside()
    roomy = with_room("draft").fabric
    moved = np.flatnonzero(np.abs(roomy.vertices - fabric.vertices).max(axis=1))
    # Crowded stitches are within 2 cm of the fold, stitches at most 1.1 cm long, and a last ring of vertices is fixed.
    far = 2.0 + 1.1 * (RINGS + 1)
    assert np.abs(fabric.vertices[moved, 0] - WIDTH / 2).max() < far
    assert 10.0 - far < fabric.vertices[moved, 1].min() and fabric.vertices[moved, 1].max() < 14.0 + far
    sides = fabric.edge_side
    # Both are lengths in float64, divided once.
    np.testing.assert_allclose(roomy.stretch, roomy.side_length[sides] / fabric.side_length[sides], rtol=1e-12)


def test_a_fold_at_borders_gets_room_and_corners_stay():
    fabric = folded(flat(0.77), -1.0, 1.0)  # One row, so that all vertices are at the border.
    roomy = sm.make_room(fabric, quality="draft").fabric
    assert roomy is not fabric and sm.generate_yarns(roomy, quality="draft").yarn_count
    corner = np.isin(fabric.vertices[:, 0], [0.0, WIDTH])
    np.testing.assert_array_equal(roomy.vertices[corner], fabric.vertices[corner])


def test_a_stitch_between_corners_cannot_get_room():
    plain = sm.tessellate(sm.label(grid(1, 1, width=1.0, height=0.77)), stitch_width=1.0)
    fabric = replace(plain, vertices=plain.vertices * [1.0, 0.02, 1.0])
    assert sm.make_room(fabric, quality="draft").fabric is fabric
    with pytest.raises(YarnError, match="radii apart"):
        sm.generate_yarns(fabric, quality="draft")


def test_a_corner_on_a_straight_border_is_moved_away_from_its_stitch_and_nothing_else_is():
    fabric = flat(6.0)
    left, upper = fabric.vertices[:, 0] == 0.0, fabric.vertices[:, 1] == fabric.vertices[:, 1].max()
    corner = int(np.flatnonzero(left & upper)[0])
    course, wale = 1.0, float(np.ptp(np.unique(fabric.vertices[left, 1])[-2:]))
    vertices = fabric.vertices.copy()
    vertices[corner] += [0.5 * course, -0.5 * wale, 0.0]
    straight = replace(fabric, vertices=vertices)
    # A chain leans out of the fabric there and has room; a yarn that is drawn through the loops has none.
    drawn = YarnFinish(bind_off="drawn")
    with pytest.raises(YarnError, match=r"start .* radii apart"):
        sm.generate_yarns(straight, finish=drawn)
    room = sm.make_room(straight, finish=drawn)
    roomy = room.fabric
    sm.check_loops(roomy, sm.generate_yarns(roomy, finish=drawn), finish=drawn)
    sm.check_loops(straight, sm.generate_yarns(straight))
    moved = roomy.vertices - vertices
    assert np.flatnonzero(np.abs(moved).max(axis=1)).tolist() == [corner]
    # The corner moves at right angles to the border, by a part of half the distance of its neighbours.
    length = CORNER_HEIGHT * 0.5 * np.hypot(course, wale)
    away = np.array([-wale, course, 0.0]) / np.hypot(course, wale)
    np.testing.assert_allclose(moved[corner], length * away, atol=1e-12 * WIDTH)
    assert room.farthest == pytest.approx(length, rel=1e-9)


def test_a_ring_that_is_moved_all_around_keeps_its_length():
    radius = 8.0 / (2.0 * np.pi)
    fabric = sm.tessellate(sm.label(tube(8, 1, radius=radius, height=8.0)), stitch_width=1.0)
    x, y, z = fabric.vertices.T
    angle = np.arctan2(x, z)
    # Three vertices of the upper ring follow each other in the wrong order.
    angle = np.where((y == y.max()) & (np.abs(angle) < np.pi / 3.0), -0.8 * angle, angle)
    turned = replace(fabric, vertices=np.stack([radius * np.sin(angle), y, radius * np.cos(angle)], axis=1))
    roomy = sm.make_room(turned, quality="draft").fabric
    loop = next(loop for loop in fabric.boundary_loops if y[fabric.face_vertex[loop]].min() == y.max())
    before, after = (each.vertices[fabric.face_vertex[loop]] for each in (turned, roomy))
    lengths = [np.linalg.norm(np.roll(ring, -1, axis=0) - ring, axis=1).sum() for ring in (before, after)]
    assert roomy is not turned and lengths[1] == pytest.approx(lengths[0], rel=1e-9)  # scaled to it after each step
    assert (np.sin(np.diff(np.arctan2(after[:, 0], after[:, 2]))) < 0.0).all()  # Upper borders run clockwise.
    sm.check_loops(roomy, sm.generate_yarns(roomy, quality="draft"))


def test_a_fabric_on_a_lattice_and_panels_are_refused():
    with pytest.raises(YarnError, match="make_room: got a fabric on a lattice"):
        sm.make_room(torus_mesh(read_pattern("garter"), columns=4, stitch_width=1.0, stitch_height=0.7))
    with pytest.raises(YarnError, match=r"stitch PANEL .* tessellate the mesh first"):
        sm.make_room(sm.label(grid(4, 1)))


def two_layers(apart: float) -> StitchMesh:
    """Two tubes with stitches 1 cm wide, one in the other."""
    outer, inner = (tube(12, 2, radius=4.0 - inwards, height=2.0) for inwards in (0.0, apart))
    corners = np.concatenate([outer.face_vertex, inner.face_vertex + len(outer.vertices)]).reshape(-1, 4)
    both = Mesh.from_polygons(np.concatenate([outer.vertices, inner.vertices]), corners.tolist())
    return sm.tessellate(sm.label(both), stitch_width=1.0)


def test_layers_that_touch_are_moved_apart_and_loops_hold():
    """The two layers lie 2 radii apart, and loops of stockinette are about 4 radii thick."""
    fabric, radius = two_layers(0.25), 0.125
    half = len(fabric.vertices) // 2
    with pytest.raises(YarnError, match=r"face \d+ and \d+: yarns start .* radii apart, .* make room"):
        sm.generate_yarns(fabric, yarn_radius=radius, quality="draft")
    room = sm.make_room(fabric, yarn_radius=radius, quality="draft")
    roomy = room.fabric
    yarns = sm.generate_yarns(roomy, yarn_radius=radius, quality="draft")
    sm.check_loops(roomy, yarns)
    around = np.linalg.norm(roomy.vertices[:, [0, 2]], axis=1)
    outward = np.sort(around)[half:].mean() - np.sort(around)[:half].mean()
    # vertices lie on chords and across from the faces between others, so that not all move by exactly the same
    assert outward == pytest.approx(THICKNESS_OVER_RADIUS * radius, rel=0.1)
    assert room.faces and room.farthest < 0.5  # half of a stitch


def test_layers_with_room_stay_where_they_are():
    fabric = two_layers(1.0)
    assert layers_apart(fabric, 0.625) is fabric
    room = sm.make_room(fabric, yarn_radius=0.125)
    assert room.fabric is fabric and room.faces == () and room.farthest == 0.0
