# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Every stitch, alone, beside and above others: each piece is one yarn, linked as its stitches define.

The linking is tested before and after relaxation. Stitches that are mirror images of each other, or each other turned
over, have templates of the same symmetry, and so have the pieces made of them. The tests therefore combine each stitch
that has a drawing with each other one, and a fixed part of all pairs of all stitches.
"""

from __future__ import annotations

from dataclasses import replace
from itertools import product

import numpy as np
import pytest

from stitchmesh.mesh import StitchMesh
from stitchmesh.mesh.stitch import CODES, VOCABULARY, Stitch
from stitchmesh.yarn import YarnSet
from stitchmesh.yarngen import generate_yarns, mean_stitch_width
from stitchmesh.yarngen.clearance import smallest_distance
from stitchmesh.yarngen.loop_check.loop_linking import check_loops
from stitchmesh.yarngen.templates.table import drawings
from stitchmesh.yarngen.templates.template import RADIUS_OVER_WIDTH
from stitchmesh.yarnrelax import relax_yarns
from stitchmesh.yarnrelax.constraints.pins import Pins
from stitchmesh.yarnrelax.energies.point_load import PointLoad
from tests.nightly import at_night
from tests.yarngen.samplers import Block, above, beside, placements, sampler, side_by_side, sides_of, tops

pytestmark = pytest.mark.decides

KNIT = Stitch.KNIT
DRAWN_THROUGH = [KNIT, *(CODES[code] for code in drawings())]
ALL = list(VOCABULARY)
BATCH = 64
"""Number of pieces that are generated at once."""
ALONE, PAIRED, SHIFTED = 0.9, 0.7, 0.4
"""Smallest distances of generated yarns, over the radius: for a stitch among knit stitches, for pairs, and for pairs
that overlap partly. They are the measured values minus a tenth; touching yarns are 2 apart."""


def under_a_plain_row(block: Block) -> Block:
    return [*block, [KNIT] * tops(block[-1])]


def assert_linked_and_apart(blocks: list[Block], floor: float) -> None:
    for first in range(0, len(blocks), BATCH):
        pieces = [under_a_plain_row(block) for block in blocks[first : first + BATCH]]
        fabric = side_by_side([sampler(piece) for piece in pieces])
        yarns = generate_yarns(fabric, quality="draft")
        assert yarns.yarn_count == len(pieces) and not yarns.closed.any(), "a piece is one yarn"
        check_loops(fabric, yarns)
        radius = RADIUS_OVER_WIDTH * mean_stitch_width(fabric)
        distance, point = smallest_distance(yarns, floor * radius)
        assert distance == np.inf, f"{distance / radius:.2f} radii in {pieces[yarns.point_yarn[point]]}"


def test_each_stitch_among_knit_ones() -> None:
    assert_linked_and_apart([[[KNIT, KNIT, stitch, KNIT, KNIT]] for stitch in ALL], ALONE)


@pytest.mark.nightly
def test_drawn_stitches_side_by_side() -> None:
    assert_linked_and_apart([beside(left, right) for left, right in product(DRAWN_THROUGH, DRAWN_THROUGH)], PAIRED)


@pytest.mark.nightly
def test_drawn_stitches_on_top_of_one_another() -> None:
    worked = [stitch for stitch in DRAWN_THROUGH if sides_of(stitch)[0]]
    assert_linked_and_apart([above(lower, upper) for lower, upper in product(DRAWN_THROUGH, worked)], PAIRED)


@pytest.mark.parametrize("step", [97, *at_night(1)])  # a prime step, so that every stitch occurs
def test_any_two_stitches_in_any_place(step: int) -> None:
    worked = [stitch for stitch in ALL if sides_of(stitch)[0]]
    next_to = [beside(left, right) for left, right in product(ALL, ALL)]
    on_top = [above(a, b, place) for a, b in product(ALL, worked) for place in placements(a, b)]
    assert_linked_and_apart([*next_to[::step], *on_top[::step]], SHIFTED)


def many_stitches(stitches: list[Stitch]) -> StitchMesh:
    """A row of stitches between knit stitches, below two plain rows."""
    row = [KNIT, KNIT, *(each for stitch in stitches for each in (stitch, KNIT)), KNIT]
    return sampler([*under_a_plain_row([row]), [KNIT] * tops(row)])


def height(fabric: StitchMesh, yarns: YarnSet) -> float:
    """Mean height of the last row [cm]."""
    return float(yarns.points[fabric.row[yarns.face] == fabric.row.max(), 1].mean())


def untensioned(fabric: StitchMesh) -> YarnSet:
    """Yarns that rest at their drawn lengths, also at the edges: the load alone then changes the height."""
    yarns = generate_yarns(fabric, quality="draft")
    return replace(yarns, rest_length=yarns.lengths)


@pytest.mark.parametrize("part", at_night(0, 1, 2))
def test_stitches_stay_linked_when_the_fabric_is_pulled(part: int) -> None:
    """The cast-on is held and the last row is pulled by 250 dyn a stitch, the weight of about a quarter of a gramme."""
    fabric = many_stitches(ALL[part::3])
    yarns = untensioned(fabric)
    last = np.flatnonzero(fabric.row == fabric.row.max())
    result = relax_yarns(
        yarns, quality="draft", device="cpu",
        terms=[Pins(faces=np.flatnonzero(fabric.row == 0)), PointLoad((0.0, 250.0 * len(last), 0.0), faces=last)],
    )  # fmt: skip
    assert result.report["converged"]
    assert height(fabric, result.yarns) > 1.1 * height(fabric, yarns)
    check_loops(fabric, result.yarns)


def every_family() -> StitchMesh:
    """A fabric with a stitch of every family."""
    return many_stitches([CODES[code] for code in ("p", "y", "d12k", "b", "kp", "d21p", "sk", "d213k", "x", "kyk")])


def test_every_family_of_stitches_is_linked_at_rest_as_before() -> None:
    fabric = every_family()
    rest = relax_yarns(untensioned(fabric), quality="draft", device="cpu", keep_shape=fabric)
    assert rest.report["converged"]
    check_loops(fabric, rest.yarns)


@pytest.mark.parametrize("seed", at_night(0, 1, 2))
def test_a_fabric_at_rest_is_longer_when_pulled_and_linked_as_before(seed: int) -> None:
    """The fabric is relaxed in its shape, then held at its cast-on and pulled at its last row.

    The starts differ by 1e-5 cm, which is enough for legs of slipped stitches to reach quite different positions.
    """
    fabric = every_family()
    yarns = untensioned(fabric)
    nudged = replace(yarns, points=yarns.points + 1e-5 * np.random.default_rng(seed).normal(size=yarns.points.shape))
    rest = relax_yarns(nudged, quality="draft", device="cpu", keep_shape=fabric)
    check_loops(fabric, rest.yarns)
    last = np.flatnonzero(fabric.row == fabric.row.max())
    pulled = relax_yarns(
        rest.yarns, quality="draft", device="cpu",
        terms=[Pins(faces=np.flatnonzero(fabric.row == 0)), PointLoad((0.0, 100.0 * len(last), 0.0), faces=last)],
    )  # fmt: skip
    assert rest.report["converged"] and pulled.report["converged"]
    # Decreases have no more yarn than plain stitches, so that the load lengthens the fabric by 3 % only.
    assert height(fabric, pulled.yarns) > 1.02 * height(fabric, rest.yarns)
    check_loops(fabric, pulled.yarns)
