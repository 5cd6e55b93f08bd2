# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Yarns leave the balances from which their energy falls, in the same bits each time, and stay in minima."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from stitchmesh.compute.device import device_named
from stitchmesh.quality import PRESETS
from stitchmesh.yarn import YarnSet
from stitchmesh.yarnrelax import YarnMaterial, relax_yarns
from stitchmesh.yarnrelax.hessian.factored_matrix import factored
from stitchmesh.yarnrelax.newton import BALANCED, MOVE, SHORTER, SMALLEST_MOVE
from stitchmesh.yarnrelax.relaxation_loop import RelaxationLoop
from stitchmesh.yarnrelax.simulation import YarnSimulation
from stitchmesh.yarnrelax.solvers.newton_system import SIGNIFICANT
from stitchmesh.yarnrelax.together.relax_cells import relax_cells
from tests.yarnrelax.hessian.scenes import assembled_hessian
from tests.yarnrelax.rings import RADIUS, height, ring

pytestmark = pytest.mark.decides
DOUBLE = replace(PRESETS["draft"], precision="float64")
MATERIAL = YarnMaterial.named().of_radius(RADIUS)
OPEN, CURLED = ring(0.5), ring(1.5)


def relaxed(yarns: YarnSet, **options: Any) -> Any:
    return relax_yarns(yarns, **({"material": MATERIAL, "quality": DOUBLE, "device": "cpu"} | options))


def loop_at(yarns: YarnSet, material: YarnMaterial = MATERIAL, **options: Any) -> RelaxationLoop:
    simulation = YarnSimulation.start(yarns, material, DOUBLE, device_named("cpu"), **options)
    loop = RelaxationLoop(simulation, DOUBLE.tolerance, DOUBLE.largest_change)
    loop.start()
    return loop


def negative_eigenvalues(simulation: YarnSimulation) -> int:
    """Number of eigenvalues of the Hessian that are negative and count, of coordinates that are free."""
    matrix, count = assembled_hessian(simulation), 3 * simulation.model.point_count
    chosen = np.arange(count)
    if simulation.strain is not None:
        chosen = np.append(chosen, count + np.flatnonzero(simulation.strain.host_free[0] > 0.0))
    own = matrix[chosen][:, chosen].tocsc()
    return factored(own, SIGNIFICANT * float(np.median(own.diagonal()))).negative_count


def test_a_ring_that_is_curled_more_than_its_circle_leaves_its_plane_and_another_one_stays() -> None:
    """No force leads out of the circle, and the energy of overcurved rings falls when they fold (Mouthuy et al. 2012).

    The rest length of the ring makes its circle a little smaller, without a Newton step.
    """
    for yarns, folds in ((CURLED, True), (OPEN, False)):
        loop = loop_at(yarns)
        loop.advance()
        assert (negative_eigenvalues(loop.simulation) > 0) == folds
        assert loop.last[0].residual < 1e-9 and height(loop.simulation.good_yarns()) == 0.0
        energy = loop.last[0].energy
        loop.run(20_000)
        assert loop.at_rest[0] and negative_eigenvalues(loop.simulation) == 0
        assert (height(loop.simulation.good_yarns()) > 1.0) == folds
        assert (loop.last[0].energy < 0.1 * energy) == folds


def test_a_state_of_rest_stays_in_place() -> None:
    exact = replace(DOUBLE, tolerance=1e-3, largest_change=4e-3)  # at the tolerance of draft, rings still fold a little
    rest = relaxed(CURLED, quality=exact)
    again = relaxed(rest.yarns, quality=exact)
    assert rest.report["converged"] and again.report["converged"]
    moved = np.linalg.norm(again.yarns.points - rest.yarns.points, axis=1).max()
    assert moved < MOVE * RADIUS


def test_each_ring_of_a_batch_stays_or_leaves_by_itself() -> None:
    batch = relax_cells([OPEN, CURLED], materials=[MATERIAL] * 2, quality=DOUBLE, device="cpu")
    assert batch.report["converged"] == 2
    assert height(batch.cells[0].yarns) == 0.0 and height(batch.cells[1].yarns) > 1.0


def test_a_move_away_from_a_balance_has_the_given_length() -> None:
    loop = loop_at(CURLED)
    loop.advance()
    newton, every = loop.newton, np.ones(1, dtype=bool)
    assert newton is not None
    before = loop.simulation.state.points.numpy().copy()
    newton.find_steps(every, every, np.ones(len(every)))
    assert newton.leaving[0] and newton.remaining_changes(every, loop.last.size)[0] is None
    newton.move(every, np.ones(1))
    moved = np.linalg.norm(loop.simulation.state.points.numpy() - before, axis=1)
    assert moved.max() == pytest.approx(MOVE, rel=1e-9)  # coordinates of some tens of radii are rounded
    loop.step_back(every)
    newton.note_moves(lowered=~every)
    newton.find_steps(every, every, np.ones(len(every)))
    assert newton.steps.known[0] and newton.steps.leaves_balance[0]
    assert np.linalg.norm(newton.steps.motion, axis=1).max() == pytest.approx(MOVE * SHORTER, rel=1e-12)


def test_a_balance_that_only_leads_down_by_tiny_moves_counts_as_rest(monkeypatch: pytest.MonkeyPatch) -> None:
    """Here no move leads down: each is tried at a quarter of the length of the one before it."""
    is_acceptable, tried = RelaxationLoop.is_acceptable, list[float]()

    def refuse_to_leave(loop: RelaxationLoop, *arguments: Any) -> Any:
        assert loop.newton is not None
        if loop.newton.leaving[0] and (not tried or tried[-1] != loop.newton.away[0]):
            tried.append(float(loop.newton.away[0]))
        return is_acceptable(loop, *arguments) & ~loop.newton.leaving

    monkeypatch.setattr(RelaxationLoop, "is_acceptable", refuse_to_leave)
    found = relaxed(CURLED)
    assert found.report["converged"] and found.report["remaining_change"]["rms_radii"] < BALANCED
    assert height(found.yarns) == 0.0
    assert tried == [MOVE * SHORTER**count for count in range(len(tried))]
    assert SHORTER * tried[-1] < SMALLEST_MOVE <= tried[-1]
