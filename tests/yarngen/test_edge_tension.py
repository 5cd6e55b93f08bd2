# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""First and last rows and ribs at edges are worked with shorter loops; all other stitches keep their length."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from stitchmesh.mesh import StitchMesh
from stitchmesh.mesh.stitch import Stitch
from stitchmesh.yarngen import generate_yarns
from stitchmesh.yarngen.edge_tension import CAST_ON, CHAIN, LONGEST, RIB
from stitchmesh.yarngen.finish import YarnFinish
from stitchmesh.yarngen.generate import trace_yarn_routes
from tests.hand_knitting.stitch_charts import chart_fabric

WIDE = 20
"""Loops of a round: more than those of a small ring, which is drawn together in any case."""


CHAINED = YarnFinish(bind_off="chain")


def tube(*rows: str) -> StitchMesh:
    """A tube whose rows repeat two stitches above a cast-on row."""
    return chart_fabric([" ".join(["co"] * WIDE), *[" ".join([row] * (WIDE // 2)) for row in rows]], ring=True)


def tension_of_rows(fabric: StitchMesh, finish: YarnFinish = CHAINED) -> list[float]:
    """The tension of each row, the same for all its faces; the bind-off row comes last."""
    routes = trace_yarn_routes(fabric, 0.05, 12, finish)
    found = []
    for row in np.unique(routes.whole.row):
        (tension,) = set(routes.tension[routes.whole.row == row].tolist())
        found.append(tension)
    return found


@pytest.mark.parametrize(
    ("rows", "ribs"),
    [
        (["k p", "k p", "k k", "k k"], [1, 1, 0, 0]),
        (["k k", "k p", "k p"], [0, 1, 1]),  # a neck, below the bind-off
        (["k p", "k p", "k k", "k p", "k p"], [1, 1, 0, 1, 1]),
        (["k k", "k p", "k p", "k k"], [0, 0, 0, 0]),  # a rib at no edge
        (["k p", "k p", "k p", "k p"], [0, 0, 0, 0]),  # a rib all over, in which no needle changes
        (["k p", "p k", "k p", "k k"], [0, 0, 0, 0]),  # moss stitch
        (["p p", "k k", "p p", "k k"], [0, 0, 0, 0]),  # garter stitch
        (["k p", "k k", "k k"], [0, 0, 0]),  # one row is no rib
    ],
)
def test_ribs_between_an_edge_and_other_stitches_have_shorter_loops(rows, ribs):
    assert tension_of_rows(tube(*rows)) == [CAST_ON, *(RIB if rib else 1.0 for rib in ribs), CHAIN]


def test_a_loop_that_is_drawn_out_at_the_end_of_a_row_is_not_longer_than_the_others():
    """The last face of a flat piece is drawn out to twice its width; its chain has at rest what the others have."""
    fabric = chart_fabric([" ".join(["co"] * WIDE), *[" ".join(["k"] * WIDE)] * 3])
    vertices = fabric.vertices.copy()
    last = vertices[:, 0] == vertices[:, 0].max()
    vertices[last, 0] += 1.0
    routes = trace_yarn_routes(replace(fabric, vertices=vertices), 0.05, 12, CHAINED)
    at_rest = np.bincount(routes.parts.face, routes.parts.lengths) * routes.tension
    for made, tension in ((Stitch.BIND_OFF, CHAIN), (Stitch.CAST_ON, CAST_ON)):
        faces = routes.whole.stitch == made
        own = np.median(at_rest[faces])
        assert (at_rest[faces] <= LONGEST * own * (1.0 + 1e-9)).all(), "rounding"
        assert (routes.tension[faces] < tension).sum() == 1 and (routes.tension[faces] <= tension).all()


def test_open_loops_and_drawn_yarns_keep_their_length():
    assert tension_of_rows(tube("k k", "k k"), YarnFinish("drawn", "open")) == [1.0, 1.0, 1.0, 1.0]


def test_a_small_ring_is_drawn_together_without_the_tension_of_a_chain():
    fabric = chart_fabric(["co co co co co co", *["k k k k k k"] * 2], ring=True)
    assert tension_of_rows(fabric) == [CAST_ON, 1.0, 1.0, 1.0]


def test_the_yarn_inside_a_backward_loop_is_as_long_at_rest_as_its_tension_says():
    fabric = tube("k k", "k k")
    yarns = generate_yarns(fabric, quality="standard")
    inside = (fabric.stitch[yarns.face[yarns.segment_points]] == Stitch.CAST_ON).all(axis=1)
    assert inside.any()
    np.testing.assert_allclose(yarns.rest_length[inside] / yarns.lengths[inside], CAST_ON, rtol=1e-12)  # rounding
