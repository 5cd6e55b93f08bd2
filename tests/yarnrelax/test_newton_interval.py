# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""An interval of Newton's method: factors serve for shorter moves and for further steps, and rest is the same."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from stitchmesh.compute.device import device_named
from stitchmesh.quality import PRESETS
from stitchmesh.yarnrelax import RelaxCell, YarnMaterial
from stitchmesh.yarnrelax.assessment import Assessments
from stitchmesh.yarnrelax.energies.term import YarnChoice
from stitchmesh.yarnrelax.friction.friction import Friction
from stitchmesh.yarnrelax.newton import Newton
from stitchmesh.yarnrelax.newton_interval import TRIES
from stitchmesh.yarnrelax.newton_moves import NewtonMoves
from stitchmesh.yarnrelax.relaxation_loop import RelaxationLoop
from stitchmesh.yarnrelax.renewal import renew_at_rest
from stitchmesh.yarnrelax.simulation import YarnSimulation
from tests.yarnrelax.stockinette import periodic_patch, woven_cell

KALDOR, FREE = YarnMaterial.named("kaldor-simulation"), RelaxCell()
FINE = replace(PRESETS["draft"], precision="float64", tolerance=1e-6, largest_change=1e-6)
CELLS = [(periodic_patch(1, 1), KALDOR), (woven_cell(), KALDOR)]


def near_rest(terms: list[YarnChoice]) -> RelaxationLoop:
    """Two cells that Newton's method is about to end."""
    simulation = YarnSimulation(CELLS, FINE, device_named("cpu"), terms, cells=[FREE, FREE])
    loop = RelaxationLoop(simulation, FINE.tolerance, FINE.largest_change)
    loop.start()
    while not loop.ending.all():
        loop.advance(~loop.ending)
    return loop


def counted(monkeypatch: pytest.MonkeyPatch, owner: type, name: str) -> list[int]:
    """A list that gets an entry whenever a method is called."""
    calls, method = list[int](), getattr(owner, name)

    def call(*given: Any, **named: Any) -> Any:
        calls.append(1)
        return method(*given, **named)

    monkeypatch.setattr(owner, name, call)
    return calls


def test_cells_that_follow_their_steps_come_to_the_same_rest_with_fewer_factors(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    factors, ends = counted(monkeypatch, Newton, "_systems"), []
    for follows in (True, False):
        if not follows:
            monkeypatch.setattr(Newton, "factors_hold", lambda newton, cells, fall: cells & False)
        factors.clear()
        loop = near_rest([Friction(0.3)])
        while (moving := ~loop.at_rest | renew_at_rest(loop)).any():
            loop.advance(moving)
            assert loop.iteration < 10_000
        ends.append((len(factors), loop.simulation.good_cells(), loop.last.energy))
    assert ends[0][0] < ends[1][0]
    # of second order in what is left, and what slides depends on the steps by which it does
    np.testing.assert_allclose(ends[0][2], ends[1][2], rtol=1e-7)
    for first, second in zip(ends[0][1], ends[1][1], strict=True):
        assert first.lattice is not None and second.lattice is not None
        # what may be left of the size at rest, in both
        np.testing.assert_allclose(first.lattice.periods, second.lattice.periods, atol=10 * FINE.largest_change)


def test_a_move_in_which_the_energy_rises_is_tried_shorter_with_the_same_factors(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    loop, refused = near_rest([]), np.array([True, False])
    factors, shortened = (counted(monkeypatch, *of) for of in ((Newton, "_systems"), (NewtonMoves, "begin_less")))
    monkeypatch.setattr(Newton, "factors_hold", lambda newton, cells, fall: cells & False)
    acceptable, judged = RelaxationLoop.is_acceptable, []

    def refuse_twice(loop: RelaxationLoop, *given: Any) -> np.ndarray:
        judged.append(1)
        return acceptable(loop, *given) & ~(refused & (len(judged) < 3))

    monkeypatch.setattr(RelaxationLoop, "is_acceptable", refuse_twice)
    before = loop.last.energy
    loop.advance()
    found = len(factors)
    assert len(shortened) == 2 < TRIES
    assert (loop.last.energy < before).all() and (loop.step_scale == 1.0).all()
    assert loop.newton is not None and loop.newton.moves.last.part[0] < 0.5
    assert found <= 2  # one where no Hessian is negative, and one with a mixture


def test_a_step_that_leads_to_the_other_side_of_a_valley_is_shortened(monkeypatch: pytest.MonkeyPatch) -> None:
    """There the energy is the same: rounding would allow it, and the next step would lead back."""
    loop, first = near_rest([]), np.array([True, False])
    shortened, assess, found = counted(monkeypatch, NewtonMoves, "begin_less"), YarnSimulation.assess_cells, []

    def no_fall(simulation: YarnSimulation, cells: np.ndarray | None = None) -> Assessments:
        now = assess(simulation, cells)
        found.append(now.energy[0])
        if len(found) > 1:
            return now
        energies = {name: np.where(first, loop.last.energies[name], own) for name, own in now.energies.items()}
        return replace(now, energies=energies)

    monkeypatch.setattr(YarnSimulation, "assess_cells", no_fall)
    monkeypatch.setattr(Newton, "factors_hold", lambda newton, cells, fall: cells & False)
    before = loop.last.energy[0]
    loop.advance()
    assert loop.newton is not None and len(shortened) == 1 and loop.newton.moves.last.part[0] == 0.5
    assert loop.last.energy[0] == found[1] < before
