# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Turns of short rows: where their tips lie, and that their loops hold wherever they lie."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from stitchmesh.editing.short_rows import short_rows
from stitchmesh.errors import YarnError
from stitchmesh.mesh import StitchMesh
from stitchmesh.mesh.change import apply_change
from stitchmesh.mesh.courses import course_through
from stitchmesh.mesh.turns import TIP, find_turns, turn_edges, with_tips_placed
from stitchmesh.meshrelax import relax_mesh
from stitchmesh.yarngen import check_loops, generate_yarns
from tests.editing.fabrics import around, face_at, flat
from tests.gallery import grid, tube

pytestmark = pytest.mark.decides


def turned(fabric: StitchMesh, faces: list[int]) -> StitchMesh:
    for change in short_rows(fabric, faces):
        fabric = apply_change(fabric, change)
    return fabric


@cache
def flat_with_turns() -> StitchMesh:
    made = turned(flat(6, 4), [6 * 2 + column for column in range(1, 5)])
    return relax_mesh(made, surface=grid(6, 4, height=0.72)).fabric


@cache
def tube_with_turns() -> StitchMesh:
    fabric = around(24, 8)
    made = turned(fabric, list(course_through(fabric, face_at(fabric, 3, 0)).faces[4:14]))
    return relax_mesh(made, surface=tube(24, 8, radius=4.0, height=0.72)).fabric


@pytest.mark.parametrize("make", [flat_with_turns, tube_with_turns])
def test_the_two_rows_of_a_turn_meet_at_the_tip_and_at_the_base(make):
    fabric = make()
    turns = find_turns(fabric)
    ends = np.sort(np.stack([turns.tip, turns.base], axis=1), axis=1)
    edges = np.flatnonzero(turn_edges(fabric))
    side = fabric.edge_side[edges]
    found = np.sort(np.stack([fabric.face_vertex[side], fabric.face_vertex[fabric.side_next[side]]], axis=1), axis=1)
    assert len(turns.tip) == 2 and len(edges) == 4
    assert sorted(map(tuple, found.tolist())) == sorted([*map(tuple, ends.tolist())] * 2)


@pytest.mark.parametrize("make", [flat_with_turns, tube_with_turns])
def test_relaxed_tips_lie_a_part_of_a_course_edge_from_the_base(make):
    fabric = make()
    turns = find_turns(fabric)
    tip, base, inner = (fabric.vertices[vertex] for vertex in (turns.tip, turns.base, turns.inner))
    # The tip is computed as base + TIP (inner - base); 1e-12 cm is its rounding at coordinates of some centimetres.
    assert np.abs((tip - base) - TIP * (inner - base)).max() < 1e-12


def test_vertices_that_are_held_are_not_placed():
    fabric = tube_with_turns()
    turns = find_turns(fabric)
    vertices = fabric.vertices.copy()
    vertices[turns.tip] = vertices[turns.base] + 0.3 * (vertices[turns.inner] - vertices[turns.base])
    moved = replace(fabric, vertices=vertices)
    held = np.ones(len(vertices), dtype=bool)
    held[turns.tip[0]] = False
    placed = with_tips_placed(moved, held)
    assert (placed.vertices[turns.tip[0]] == vertices[turns.tip[0]]).all()
    assert (placed.vertices[turns.tip[1]] != vertices[turns.tip[1]]).any()


@pytest.mark.parametrize("make", [flat_with_turns, tube_with_turns])
@pytest.mark.parametrize("tip", [0.02, 0.6])
def test_loops_hold_at_a_turn_wherever_its_tip_lies(make, tip):
    """The link around a turn begins at a loop and threads it: without a cut at the turn its closure would decide."""
    fabric = make()
    turns = find_turns(fabric)
    vertices = fabric.vertices.copy()
    vertices[turns.tip] = vertices[turns.base] + tip * (vertices[turns.inner] - vertices[turns.base])
    moved = replace(fabric, vertices=vertices)
    check_loops(moved, generate_yarns(moved, quality="draft"))


def test_a_stitch_beside_a_turn_that_lies_on_the_wrong_side_is_found():
    """The cut at a turn hides no fault: where its last stitch is mirrored, yarn has passed through yarn."""
    fabric = flat_with_turns()
    yarns = generate_yarns(fabric, quality="draft")
    points = yarns.points.copy()
    points[yarns.face == fabric.face_count - 1, 2] *= -1.0
    with pytest.raises(YarnError, match="through"):
        check_loops(fabric, replace(yarns, points=points))
