# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Loops of relaxed swatches: they are linked as their stitches require, and pull-through of yarn is found."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import stitchmesh as sm
from stitchmesh.errors import YarnError
from stitchmesh.periodic.repeat.drawn_swatch import draw_swatch
from stitchmesh.periodic.sampling.sampling import refined
from stitchmesh.periodic.swatch_options import SwatchOptions
from stitchmesh.quality import PRESETS
from stitchmesh.yarn import YarnSet
from tests.nightly import at_night
from tests.patterns.test_leaf_corpus import NAMES
from tests.periodic.free_cells import free_swatch

pytestmark = pytest.mark.decides

OTHERS = ["garter", "cartridge-belt-rib", "jacquard2", "rope-cable"]
"""Patterns whose stitches occur in plain knit, a slipped stitch or a tuck too, and a cable, which takes long."""


def at_rest(name: str) -> tuple[sm.StitchMesh, YarnSet]:
    swatch = free_swatch(name)
    assert swatch.fabric is not None
    return swatch.fabric, swatch.yarns


@pytest.mark.parametrize("name", ["stockinette", "linen-stitch", "half-cardigan", *at_night(*OTHERS)])
def test_loops_of_a_relaxed_swatch_are_linked_as_its_stitches_require(name: str) -> None:
    fabric, yarns = at_rest(name)
    # twice the smallest initial clearance: some yarn has moved far enough to pass through another yarn
    drawn = sm.generate_yarns(fabric, quality=refined(PRESETS["draft"]))
    assert np.abs(yarns.points - drawn.points).max() > 0.5 * yarns.radius[0]
    sm.check_loops(fabric, yarns)


@pytest.mark.parametrize("name", ["linen-stitch", *at_night("rope-cable")])
def test_a_loop_lifted_out_of_another_is_found(name: str) -> None:
    """The upper part of a loop moves eight radii to the front, through the loop worked into it and all its images."""
    fabric, yarns = at_rest(name)
    knit = fabric.stitch == sm.Stitch.KNIT
    head = (yarns.face == np.flatnonzero(knit)[0]) & (yarns.part == 0)
    points = yarns.points.copy()
    points[head, 2] += 8.0 * yarns.radius[0]
    with pytest.raises(YarnError, match=r"face \d+: its yarn passed through that of face \d+ since it was generated"):
        sm.check_loops(fabric, replace(yarns, points=points))


@pytest.mark.nightly
@pytest.mark.parametrize("name", NAMES)
def test_loops_of_a_relaxed_cell_of_the_corpus_are_linked_as_its_stitches_require(name: str) -> None:
    fabric, drawn = draw_swatch(sm.read_pattern(name), SwatchOptions(), PRESETS["draft"])
    assert fabric is not None
    leaf = sm.YarnMaterial.named("leaf")
    sm.check_loops(fabric, sm.relax_yarns(drawn, material=leaf, quality="draft", device="cpu").yarns)


def test_yarn_moved_to_the_other_side_of_a_slipped_loop_is_found() -> None:
    """In linen stitch, yarn moves from the front to the back and passes both legs of a loop in opposite senses."""
    fabric, yarns = at_rest("linen-stitch")
    slipped = np.flatnonzero(fabric.stitch == sm.Stitch.SLIP_FRONT)[0]
    own = yarns.face == slipped
    passing = own & (yarns.part == yarns.part[own].max())
    points = yarns.points.copy()
    points[passing, 2] -= 8.0 * yarns.radius[0]
    with pytest.raises(YarnError, match="since it was generated"):
        sm.check_loops(fabric, replace(yarns, points=points))


def test_only_one_of_yarns_and_stitches_on_a_lattice_is_refused() -> None:
    fabric, yarns = at_rest("stockinette")
    with pytest.raises(YarnError, match="of the yarns and the stitch mesh only one has a lattice"):
        sm.check_loops(fabric, replace(yarns, lattice=None, lattice_step=None))
