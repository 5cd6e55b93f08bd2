# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Kinds of cast-on and bind-off."""

from __future__ import annotations

import numpy as np
import pytest

from stitchmesh.errors import ParameterError
from stitchmesh.labeling import label
from stitchmesh.mesh import StitchMesh
from stitchmesh.mesh.stitch import Stitch
from stitchmesh.tessellate import tessellate
from stitchmesh.yarngen import generate_yarns
from stitchmesh.yarngen.bind_off import SMALL_RING_LOOPS
from stitchmesh.yarngen.clearance import smallest_distance
from stitchmesh.yarngen.finish import YarnFinish
from stitchmesh.yarngen.generate import trace_yarn_routes
from stitchmesh.yarngen.templates.edge_templates import (
    BACK_SLOT,
    FRONT_SLOT,
    Edge,
    cast_on,
    chain,
    edge_template,
    yarn_overs,
)
from stitchmesh.yarngen.templates.template import Crossing, TemplatePart
from tests.gallery import grid, tube
from tests.nightly import at_night
from tests.yarngen.templates.test_templates import crossings_between as crossings

pytestmark = pytest.mark.decides

CHAIN = YarnFinish(bind_off="chain")


def heights(first: TemplatePart, second: TemplatePart) -> list[int]:
    """1 where the first part lies in front at a crossing of the two parts, -1 where it lies behind."""
    return crossings(first, second)[0]


def flat(courses: int) -> StitchMesh:
    return tessellate(label(grid(1, 1, width=4.0, height=1.6)), stitch_width=0.5, counts={(0, 2): courses})


def round_piece() -> StitchMesh:
    return tessellate(label(tube(8, 2, radius=2.0, height=0.8)), stitch_width=0.6)


@pytest.mark.parametrize(("courses", "first"), [(4, "left"), (5, "right")])
def test_a_chain_is_worked_away_from_the_end_that_its_yarn_comes_from(courses, first):
    routes = trace_yarn_routes(flat(courses), 0.06, 12, CHAIN)
    bound = np.flatnonzero(routes.whole.stitch == Stitch.BIND_OFF)
    parts = np.bincount(routes.parts.face, minlength=routes.whole.face_count)[bound]
    # no loop is passed over the first stitch; in the last stitch one part leads through the loop to the end of the row
    assert sorted(parts.tolist()) == [3, 3, *[4] * (len(bound) - 2)]
    over = routes.parts.end_side[(routes.parts.end_slot == [FRONT_SLOT, BACK_SLOT]).all(axis=1), 0]
    assert set(routes.whole.side_role[over]) == {3 if first == "left" else 1}


def test_three_strands_cross_each_wale_side_of_a_chain():
    routes = trace_yarn_routes(round_piece(), 0.07, 12, CHAIN)
    whole = routes.whole
    count = np.bincount(routes.parts.end_side.ravel(), minlength=whole.side_count)
    of_chain = whole.stitch[whole.side_face] == Stitch.BIND_OFF
    assert (count[whole.is_wale & of_chain] == 3).all()
    assert (count[whole.is_wale & ~of_chain] == 1).all()


def test_a_bound_off_loop_comes_through_the_loop_below_and_the_one_before():
    head, over, rising, falling = chain().parts
    for leg in (rising, falling):
        # from the wrong side of the head to its right side: behind its leg, in front of its top
        assert sorted(heights(leg, head)) == [-1, 1]
        # between the two legs of the loop that is passed over: one lies in front, one behind
        assert sorted(heights(over, leg)) == [-1, 1]
    assert over.start == Crossing(3, FRONT_SLOT) and over.end == Crossing(3, BACK_SLOT)
    assert rising.end == Crossing(1, FRONT_SLOT) and falling.start == Crossing(1, BACK_SLOT)


def test_no_loop_is_passed_over_the_first_and_the_yarn_is_drawn_through_the_last():
    assert len(chain(first=True).parts) == 3
    head, over, drawn = chain(last=True).parts
    assert (drawn.start, drawn.end) == (Crossing(3), Crossing(1))
    assert heights(drawn, head) == [-1, 1], "up through the loop below"
    # behind the front leg and in front of the back leg
    assert sorted(set(heights(over, drawn))) == [-1, 1]
    assert len(chain(first=True, last=True).parts) == 2


def test_a_chain_from_the_right_is_the_mirror_image():
    for rightward, leftward in ((Edge.CHAIN, Edge.LEFTWARD_CHAIN), (Edge.CHAIN_FIRST, Edge.LEFTWARD_FIRST)):
        first, second = (edge_template(edge, 1, 1, ()) for edge in (rightward, leftward))
        points = np.concatenate([part.curve for part in first.parts]) * [-1, 1, 1] + [1, 0, 0]
        others = np.concatenate([part.curve for part in second.parts])
        np.testing.assert_allclose(np.sort(points, axis=0), np.sort(others, axis=0), atol=1e-14)


@pytest.mark.parametrize("quality", ["draft", *at_night("standard", "reference")])
@pytest.mark.parametrize("piece", [lambda: flat(4), lambda: flat(5), round_piece])
def test_a_chain_starts_at_least_one_radius_apart(piece, quality):
    """As plain stitches do; touching yarns are two radii apart. A flat piece in a chain is one yarn with two ends."""
    yarns = generate_yarns(piece(), quality=quality, finish=CHAIN)
    assert piece is round_piece or (yarns.yarn_count == 1 and not yarns.closed[0])
    radius = yarns.radius[0]
    assert radius < smallest_distance(yarns, within=2 * radius)[0] < 2 * radius


def test_the_last_loops_of_a_small_ring_are_always_drawn_together():
    fabric = tessellate(label(tube(8, 2, radius=1.0, height=0.8)), stitch_width=0.6)
    assert (fabric.row == fabric.row.max()).sum() <= SMALL_RING_LOOPS
    each = (YarnFinish(bind_off=kind) for kind in ("drawn", "chain"))
    drawn, chained = (generate_yarns(fabric, quality="draft", finish=finish) for finish in each)
    np.testing.assert_array_equal(drawn.points, chained.points)


def test_open_cast_on_loops_do_not_cross_and_backward_loops_do():
    first, second = yarn_overs(1, 1).parts
    assert heights(first, second) == []
    for n_bottom, n_top in ((0, 1), (1, 1), (2, 3)):
        ends = [(c.place, c.slot) for part in yarn_overs(n_bottom, n_top).parts for c in (part.start, part.end)]
        assert len(set(ends)) == len(ends) == 2 * n_top + 2
    first, second = cast_on(1, 1).parts
    assert heights(first, second) == [1]


def test_open_loops_start_at_least_one_radius_apart():
    yarns = generate_yarns(flat(4), quality="draft", finish=YarnFinish(cast_on="open"))
    assert yarns.yarn_count == 1
    assert smallest_distance(yarns, within=2 * yarns.radius[0])[0] > yarns.radius[0]


@pytest.mark.parametrize(
    ("choice", "message"),
    [({"bind_off": "icord"}, "bind off: got 'icord'; expected one of drawn, chain"),
     ({"cast_on": "tubular"}, "cast on: got 'tubular'; expected one of backward, open"),
     ({"longest_float": -1}, "longest float: got -1; expected 0 or more stitches")],
)  # fmt: skip
def test_unknown_finishes_are_refused(choice, message):
    with pytest.raises(ParameterError, match=message):
        generate_yarns(flat(4), finish=YarnFinish(**choice))
