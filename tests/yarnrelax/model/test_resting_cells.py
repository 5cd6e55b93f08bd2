# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Launches leave out the cells that rest, and compute all others as if these were not there."""

from __future__ import annotations

import numpy as np

from stitchmesh.compute.device import device_named
from stitchmesh.yarnrelax import RelaxCell, YarnMaterial
from stitchmesh.yarnrelax.newton import Newton
from stitchmesh.yarnrelax.relaxation_loop import RelaxationLoop
from stitchmesh.yarnrelax.simulation import YarnSimulation
from tests.yarnrelax.hessian.scenes import DOUBLE
from tests.yarnrelax.stockinette import periodic_patch, woven_cell

KALDOR = YarnMaterial.named("kaldor-simulation")
CELLS = [periodic_patch(1, 1), woven_cell(), periodic_patch(1, 2)]
SOME = np.array([True, False, True])


def batch() -> YarnSimulation:
    """The cells on the device, free to relax."""
    given = [(yarns, KALDOR) for yarns in CELLS]
    return YarnSimulation(given, DOUBLE, device_named("cpu"), cells=[RelaxCell()] * len(CELLS))


def points_of(simulation: YarnSimulation, cell: int) -> np.ndarray:
    """The control points of a cell."""
    return np.array(simulation.state.points.numpy()[slice(*simulation.model.point_start[cell : cell + 2])])


def do_newton_step(simulation: YarnSimulation, cells: np.ndarray) -> None:
    """A step of some cells, no further than the step limit."""
    newton = Newton(simulation)
    newton.find_steps(cells, balanced=cells, size=np.ones(len(cells)))
    newton.move(cells, np.ones(len(CELLS)))


def test_a_newton_step_moves_each_cell_as_if_the_others_were_not_there() -> None:
    some, others = batch(), batch()
    before = points_of(some, 1)
    do_newton_step(some, SOME)
    assert np.array_equal(points_of(some, 1), before)
    do_newton_step(others, ~SOME)
    both = batch()
    do_newton_step(both, np.ones(3, dtype=bool))
    for cell, simulation in ((0, some), (1, others), (2, some)):
        assert np.array_equal(points_of(both, cell), points_of(simulation, cell))
    assert not some.model.resting.numpy().any()


def test_an_interval_of_some_cells_leaves_the_others_where_they_are() -> None:
    simulation = batch()
    loop = RelaxationLoop(simulation, DOUBLE.tolerance)
    loop.start()
    before, assessed = points_of(simulation, 1), loop.last[1]
    loop.advance(SOME)
    assert loop.iterations.tolist() == [20, 0, 20]
    assert np.array_equal(points_of(simulation, 1), before) and loop.last[1] == assessed
    again = simulation.assess_cells()[1]
    assert again.energies == assessed.energies and again.residual == assessed.residual
