# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Regions chosen by error within a budget, and their changes."""

from __future__ import annotations

import numpy as np
import pytest

from stitchmesh.errors import ParameterError
from stitchmesh.mixed.adaptive_region import changed_triangles, detail_errors
from stitchmesh.mixed.cloth.from_stitches import cloth_from_stitches
from stitchmesh.mixed.enrichment.region import HYBRID, TRIANGLES, YARNS
from stitchmesh.mixed.placement.chosen_region import (
    NodeBudget,
    best_closure,
    choose_triangles,
    reach_of,
    simulated_nodes,
    triangles_of_faces,
    triangles_of_panels,
)
from stitchmesh.selection import select
from tests.editing.fabrics import flat
from tests.mixed.placement.sheets import WEAVE, sheet

SHEET = sheet(10)
CORNERS, HOME = SHEET.patch.triangles, SHEET.patch.node_triangle
CENTRE = SHEET.cloth.rest.mean(axis=1)
ALL = NodeBudget(nodes=len(HOME))


def bump(x: float, y: float, width: float = 0.15) -> np.ndarray:
    return np.exp(-((CENTRE[:, 0] - x) ** 2 + (CENTRE[:, 1] - y) ** 2) / (2.0 * width**2))


def choose(error: np.ndarray, budget: int, **options: object) -> np.ndarray:
    return choose_triangles(CORNERS, HOME, error, NodeBudget(nodes=budget), **options)


@pytest.mark.parametrize(("rings", "budget"), [(1, 0), (1, 150), (2, 400)])
def test_a_region_keeps_to_its_budget(rings: int, budget: int) -> None:
    chosen = choose(bump(0.4, 0.5), budget, rings=rings)
    region = SHEET.region(chosen, rings)
    assert len(region.nodes) == simulated_nodes(CORNERS, HOME, chosen, rings=rings) <= budget


def test_a_region_grows_around_its_first_triangle_before_another_begins() -> None:
    error = bump(0.25, 0.25) + 0.9 * bump(0.75, 0.75)
    small = CENTRE[choose(error, 120)]
    assert (small.sum(axis=1) < 1.0).all()
    large = CENTRE[choose(error, 360)]
    assert (large.sum(axis=1) > 1.2).any()


def test_triangles_of_equal_error_are_taken_by_their_numbers() -> None:
    costs = np.array([simulated_nodes(CORNERS, HOME, [t]) for t in range(len(CORNERS))])
    equal = costs == np.sort(costs)[10]
    assert equal.sum() > 1
    assert np.flatnonzero(equal)[0] in choose(equal.astype(float), int(costs[equal][0]))


def test_a_region_grows_with_the_error_and_shrinks_behind_it() -> None:
    first = choose(bump(0.3, 0.5), 200)
    moved = changed_triangles(CORNERS, HOME, bump(0.8, 0.5), first, NodeBudget(nodes=200))
    assert CENTRE[moved].mean(axis=0)[0] > 0.6 > CENTRE[first].mean(axis=0)[0]


def test_a_small_change_of_the_error_leaves_the_region_as_it_is() -> None:
    first = choose(bump(0.5, 0.5), 200)
    again = changed_triangles(CORNERS, HOME, bump(0.53, 0.5), first, NodeBudget(nodes=200))
    assert np.array_equal(again, first)
    eager = changed_triangles(CORNERS, HOME, bump(0.53, 0.5), first, NodeBudget(nodes=200), kept=1.0, worth=1.0)
    assert not np.array_equal(eager, first)


def test_a_smaller_budget_shrinks_the_region_at_once() -> None:
    first = choose(bump(0.5, 0.5), 200)
    smaller = changed_triangles(CORNERS, HOME, bump(0.5, 0.5), first, NodeBudget(nodes=100))
    assert simulated_nodes(CORNERS, HOME, smaller) <= 100
    assert set(smaller) < set(first)


def test_wrinkled_yarns_count_as_the_compression_that_they_take_up() -> None:
    region = SHEET.region(choose(bump(0.5, 0.5), 200))
    vertices = SHEET.patch.vertices
    flat = SHEET.patch.nodes[region.nodes]
    amplitude, squared_size = 0.01, 2.0 * SHEET.cloth.rest_area[0]
    wavy = flat + np.array([0.0, 0.0, amplitude])
    found = detail_errors(SHEET.cloth, region, WEAVE, vertices, wavy)
    strain = np.pi**2 * amplitude**2 / (2.0 * squared_size)
    stiffness = np.sqrt(WEAVE.stretch_course * WEAVE.stretch_wale)
    with_yarns = region.triangle_kind != TRIANGLES
    assert np.allclose(found[with_yarns], stiffness * strain**2 / 2.0 * SHEET.cloth.rest_area[0], rtol=1e-10)
    assert np.array_equal(found[~with_yarns], np.zeros((~with_yarns).sum()))
    # squares of rounding of positions; yarns on the triangles need no yarns
    assert detail_errors(SHEET.cloth, region, WEAVE, vertices, flat).max() < 1e-40
    assert set(np.unique(region.triangle_kind)) == {TRIANGLES, HYBRID, YARNS}


def test_impossible_errors_budgets_rings_and_factors_are_refused() -> None:
    with pytest.raises(ParameterError, match="expected 200 errors"):
        choose(np.full(200, np.nan), 100)
    with pytest.raises(ParameterError, match="got -1 nodes"):
        NodeBudget(nodes=-1)
    with pytest.raises(ParameterError, match="per_node is 0"):
        NodeBudget.of_seconds(1.0, base=0.0, per_node=0.0)
    with pytest.raises(ParameterError, match="hybrid rings"):
        choose(np.ones(200), 100, rings=0)
    with pytest.raises(ParameterError, match="factors"):
        changed_triangles(CORNERS, HOME, np.ones(200), [0], ALL, kept=0.5)


def test_the_best_closure_is_the_best_of_all_regions_for_its_nodes() -> None:
    """Among all regions of a small sheet that simulate no more nodes, none removes more error."""
    small = sheet(3)
    corners, home = small.patch.triangles, small.patch.node_triangle
    count = len(corners)
    error = np.random.default_rng(5).uniform(size=count) ** 4
    reach, nodes = reach_of(corners, 1), np.bincount(home, minlength=count)
    reached = reach.toarray().astype(bool)
    masks = (np.arange(2**count)[:, None] >> np.arange(count)) & 1
    simulated = (masks @ reached > 0) @ nodes
    removed = masks @ error
    for budget in (int(0.4 * nodes.sum()), int(0.7 * nodes.sum()), int(nodes.sum())):
        found = best_closure(reach, nodes, error, budget)
        used = simulated_nodes(corners, home, found)
        assert used <= budget
        # capacities are whole numbers of 2^-29 of the error
        assert error[found].sum() >= removed[simulated <= used].max() - 1e-6


def test_what_a_closure_leaves_of_the_budget_is_filled() -> None:
    error = bump(0.3, 0.3) + bump(0.8, 0.7, 0.1)
    for budget in (60, 150, 300):
        chosen = choose(error, budget)
        closure = best_closure(reach_of(CORNERS, 1), np.bincount(HOME, minlength=len(CORNERS)), error, budget)
        assert error[chosen].sum() >= error[closure].sum()


def test_a_panel_is_all_its_triangles() -> None:
    assert np.array_equal(triangles_of_panels(SHEET.cloth, "sheet"), np.arange(200))


def test_stitches_of_a_selection_are_all_their_triangles() -> None:
    fabric = flat(5, 4)
    cloth = cloth_from_stitches(fabric, stitch_width=0.5, course_height=0.4)
    faces = select(fabric, "rows 2-3")
    found = triangles_of_faces(fabric, faces)
    assert len(found) == 2 * len(faces)
    own = set(map(int, fabric.face_vertex[np.isin(fabric.side_face, faces)]))
    assert set(map(int, cloth.triangles[found].ravel())) == own


def test_wrong_panels_and_faces_are_refused() -> None:
    with pytest.raises(ParameterError, match="got panel 'sleeve'"):
        triangles_of_panels(SHEET.cloth, "sleeve")
    with pytest.raises(ParameterError, match="got face 99"):
        triangles_of_faces(flat(5, 4), [99])
