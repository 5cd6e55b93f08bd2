# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""A relaxation does as many iterations as its limit allows, completes a Newton step that has begun, and says so."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise
from typing import Any

import numpy as np
import pytest

from stitchmesh.quality import PRESETS, Solver
from stitchmesh.yarnrelax import Relaxation, RelaxCell, YarnMaterial, relax_yarns, simulation
from stitchmesh.yarnrelax.friction.friction import Friction
from stitchmesh.yarnrelax.load_steps import LoadStep, relax_through_steps
from stitchmesh.yarnrelax.newton_interval import STEP_COST
from stitchmesh.yarnrelax.together.relax_cells import relax_cells
from tests.yarnrelax.stockinette import periodic_patch, tube, woven_cell

FREE = RelaxCell(shear=False)
QUALITY = replace(PRESETS["draft"], tolerance=1e-9, largest_change=1e-9)


def relaxed(most: int, **options: Any) -> Relaxation:
    quality = replace(QUALITY, max_iterations=most)
    return relax_yarns(periodic_patch(1, 1), quality=quality, device="cpu", **options)


@pytest.mark.parametrize("solver", ["quasistatic", "dynamics"])
@pytest.mark.parametrize("most", [0, 27])
def test_the_limit_is_reached_exactly(solver: Solver, most: int) -> None:
    quality = replace(QUALITY, solver=solver, max_iterations=most)
    made = relax_yarns(tube(3, 6), quality=quality, device="cpu")
    assert made.report["iterations"] == made.history[-1]["iteration"] == most


def test_a_newton_step_that_has_begun_is_completed() -> None:
    counts = [entry["iteration"] for entry in relaxed(4000, cell=FREE).history]
    first, last = next(pair for pair in pairwise(counts) if pair[1] - pair[0] == STEP_COST["cpu"])
    for most, reached in ((first, first), (first + 1, last), (last - 1, last), (last, last)):
        made = relaxed(most, cell=FREE)
        assert made.report["iterations"] == reached and not made.report["converged"]


def test_each_cell_of_a_batch_ends_at_the_limit() -> None:
    cells = [periodic_patch(1, 1), woven_cell()]
    for most, beyond in ((7, 0), (53, STEP_COST["cpu"])):
        quality = replace(QUALITY, precision="float64", max_iterations=most)  # rounding would end it before
        made = relax_cells(cells, free=[FREE, FREE], quality=quality, device="cpu")
        assert all(most <= cell.report["iterations"] < most + max(beyond, 1) for cell in made.cells)


def test_each_load_step_of_a_path_ends_at_the_limit() -> None:
    quality, steps = replace(QUALITY, max_iterations=13), [LoadStep(), LoadStep(friction=0.5)]
    found = relax_through_steps(
        periodic_patch(1, 1), steps, terms=[Friction(0.3)], material=YarnMaterial.named(), quality=quality,
        cell=FREE, device="cpu",
    )  # fmt: skip
    assert [step.iterations for step in found] == [13, 13]


def test_a_launch_of_several_time_steps_does_not_exceed_the_limit(monkeypatch: pytest.MonkeyPatch) -> None:
    """On a GPU a launch does five of them, and has no means to stop within."""
    steps = replace(QUALITY, solver="dynamics", max_iterations=7)
    single = relax_yarns(tube(3, 6), quality=steps, device="cpu")
    monkeypatch.setattr(simulation, "GRAPH_ITERATIONS", {"cpu": 5})
    several = relax_yarns(tube(3, 6), quality=steps, device="cpu")
    assert several.report["iterations"] == single.report["iterations"] == 7
    np.testing.assert_array_equal(several.yarns.points, single.yarns.points)
