# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""What a state keeps when its region grows and shrinks."""

from __future__ import annotations

import numpy as np
import pytest

from stitchmesh.errors import ParameterError
from stitchmesh.mixed.enrichment.region import YARNS, embed
from stitchmesh.mixed.region_change import MovedState, move_state, moved_values, place_hidden_vertices
from tests.mixed.placement.sheets import sheet

SHEET = sheet(8, 3)
PATCH = SHEET.patch
COUNT = len(PATCH.nodes)
REST = PATCH.nodes[:, :2].copy()
NONE = SHEET.region(np.zeros(0, dtype=int))
SMALL, LARGE = (SHEET.region(PATCH.near((0.5, 0.5), size)) for size in (0.2, 0.35))
BEND = np.column_stack([PATCH.vertices[:, :2] * [1.1, 0.95], 0.3 * PATCH.vertices[:, 0] ** 2])


def on_triangles(vertices: np.ndarray) -> np.ndarray:
    return np.einsum("nk,nkd->nd", PATCH.node_weight, vertices[PATCH.triangles[PATCH.node_triangle]])


def grown(region, vertices: np.ndarray = BEND) -> MovedState:
    none = np.zeros((0, 3)), np.zeros((0, 2))
    return move_state(NONE, region, vertices, *none, REST)


def test_new_nodes_start_on_the_triangles_with_the_coordinates_of_the_layout() -> None:
    state = grown(LARGE)
    assert np.abs(state.nodes - on_triangles(BEND)[LARGE.nodes]).max() < 1e-14  # rounding
    assert np.array_equal(state.sliding, REST[LARGE.nodes])
    assert np.array_equal(state.vertices, BEND)


def test_old_nodes_keep_places_and_coordinates_where_yarns_stay() -> None:
    start = grown(SMALL)
    nodes = start.nodes + 0.01 * np.random.default_rng(3).normal(size=start.nodes.shape)
    sliding = start.sliding + 0.02
    state = move_state(SMALL, LARGE, BEND, nodes, sliding, REST)
    now_full = LARGE.node_kind[SMALL.nodes] == YARNS
    assert now_full.any()
    assert np.array_equal(state.nodes[LARGE.node_number[SMALL.nodes]][now_full], nodes[now_full])
    assert np.array_equal(state.sliding[LARGE.node_number[SMALL.nodes]], sliding)


@pytest.mark.parametrize(("old", "new"), [(SMALL, LARGE), (LARGE, SMALL)])
def test_the_result_is_a_motion_of_the_new_region(old, new) -> None:
    start = grown(old)
    nodes = start.nodes + 0.02 * np.random.default_rng(4).normal(size=start.nodes.shape)
    state = move_state(old, new, BEND, nodes, start.sliding, REST)
    # rounding of sums of some tens of nodes
    assert np.abs(embed(new).constraint(state.vertices, state.nodes)).max() < 1e-12


def test_hidden_vertices_are_found_again_from_the_yarns() -> None:
    state = grown(LARGE)
    hidden = ~LARGE.unknown_vertices
    assert hidden.any()
    lost = np.where(hidden[:, None], 0.0, BEND)
    found = place_hidden_vertices(LARGE, lost, state.nodes)
    # springs that keep wrong differences pull with 1e-6 of the stiffness of a node, over distances of 1 cm
    assert np.abs(found - BEND).max() < 1e-5
    assert np.abs(place_hidden_vertices(LARGE, BEND, state.nodes) - BEND).max() < 1e-5


def test_vertices_without_nodes_follow_their_neighbours() -> None:
    bare = sheet(4, 1)
    region = bare.region(np.arange(len(bare.patch.triangles)))
    shift = np.array([3.0, -1.0, 2.0])
    found = place_hidden_vertices(region, bare.patch.vertices, bare.patch.nodes + shift)
    assert np.isfinite(found).all()
    assert np.abs(found - bare.patch.vertices - shift).max() < 1e-2  # the springs hold the whole with 1e-6 of theirs


def test_values_of_nodes_move_with_them() -> None:
    values = np.arange(len(SMALL.nodes), dtype=float)
    moved = moved_values(SMALL, LARGE, values, np.full(COUNT, -1.0))
    assert np.array_equal(moved[LARGE.node_number[SMALL.nodes]], values)
    assert (moved == -1.0).sum() == len(LARGE.nodes) - len(SMALL.nodes)


def test_other_layouts_and_shapes_are_refused() -> None:
    start = grown(SMALL)
    with pytest.raises(ParameterError, match="expected the same"):
        other = sheet(4, 3).region(np.zeros(0, dtype=int))
        move_state(SMALL, other, BEND, start.nodes, start.sliding, REST)
    with pytest.raises(ParameterError, match="arrays of shapes"):
        move_state(SMALL, LARGE, BEND, start.nodes[1:], start.sliding, REST)
