# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""An assessment interval that is divided into parts has the bits of a whole interval, with each solver."""

from __future__ import annotations

import itertools
from dataclasses import replace

import numpy as np
import pytest

from stitchmesh.compute.device import device_named
from stitchmesh.periodic.relaxation.continuation import stretch_cell
from stitchmesh.quality import quality_named
from stitchmesh.yarn import YarnSet
from stitchmesh.yarnrelax import RelaxCell, YarnMaterial
from stitchmesh.yarnrelax.relaxation_loop import RelaxationLoop
from stitchmesh.yarnrelax.simulation import YarnSimulation
from stitchmesh.yarnrelax.stepwise_loop import StepwiseLoop
from tests.yarnrelax.stockinette import periodic_patch

ITERATIONS = 60
"""Long enough for several candidate lists, and before the first Newton step."""
STRETCHED = stretch_cell(periodic_patch(2, 2), 1.0, 1.3)
"""Stockinette far from rest, whose cell shrinks."""


def loop_of(
    yarns: YarnSet, solver: str, cell: RelaxCell | None, kind: type[RelaxationLoop] = StepwiseLoop
) -> RelaxationLoop:
    """Return the relaxation of a cell before its first iteration."""
    quality = replace(quality_named("draft"), solver=solver)
    if solver == "dynamics":
        quality = replace(quality, precision="float64")  # the precision for which other tests compile its kernels
    simulation = YarnSimulation.start(yarns, YarnMaterial.named(), quality, device_named("cpu"), cell=cell)
    loop = kind(simulation, quality.tolerance, quality.largest_change)
    loop.start()
    return loop


@pytest.mark.parametrize(
    ("yarns", "solver", "cell"),
    [
        (STRETCHED, "quasistatic", RelaxCell()),  # all iterations of an interval in one launch
        (stretch_cell(periodic_patch(5, 5), 1.0, 1.3), "quasistatic", RelaxCell()),  # too large for that
        (STRETCHED, "dynamics", None),
    ],
    ids=["fused", "large", "dynamics"],
)
def test_parts_of_intervals_have_the_bits_of_whole_intervals(yarns, solver, cell):
    whole, divided = loop_of(yarns, solver, cell, RelaxationLoop), loop_of(yarns, solver, cell)
    whole.run(ITERATIONS)
    assert whole.iteration == ITERATIONS  # not at rest before
    for most in itertools.cycle((3, 19, 2)):
        made = divided.advance_partly(most)
        # a part ends where the interval ends
        assert made == most or divided.is_between_intervals
        if divided.iteration == ITERATIONS:  # iterations of whole intervals
            break
    assert np.array_equal(whole.simulation.good_yarns().points, divided.simulation.good_yarns().points)
    assert np.array_equal(divided.simulation.current_yarns().points, divided.simulation.good_yarns().points)
    assert list(whole.last) == list(divided.last)
    assert whole.simulation.candidates.margins == divided.simulation.candidates.margins


def test_the_current_yarns_move_within_an_interval_and_the_accepted_ones_do_not():
    loop = loop_of(STRETCHED, "quasistatic", RelaxCell())
    first = loop.simulation.good_yarns()
    assert loop.advance_partly(3) == 3 and not loop.is_between_intervals
    assert np.array_equal(loop.simulation.good_yarns().points, first.points)
    moved = loop.simulation.current_yarns()
    assert np.abs(moved.points - first.points).max() > 0.0
    assert not np.array_equal(moved.lattice.periods, first.lattice.periods)
    assert loop.advance_partly(100) == 17 and loop.is_between_intervals
