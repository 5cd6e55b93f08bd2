# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The quasistatic solver takes the steps of L-BFGS, and plain steps or none in the defined exceptions."""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np

from stitchmesh.compute.device import device_named
from stitchmesh.quality import PRESETS
from stitchmesh.yarn import YarnSet, basis_derivative
from stitchmesh.yarnrelax import YarnMaterial
from stitchmesh.yarnrelax.energies import by_term
from stitchmesh.yarnrelax.model.spline import place_contact_samples
from stitchmesh.yarnrelax.simulation import YarnSimulation
from stitchmesh.yarnrelax.solvers.lbfgs_steps import ITERATION, PAIRS, PLAIN, SLOTS, SMOOTHING, WAITING
from stitchmesh.yarnrelax.solvers.solver import ASSESSMENT_INTERVAL
from tests.yarnrelax.loops import loop_of
from tests.yarnrelax.stockinette import tube

DOUBLE = replace(PRESETS["draft"], precision="float64")
LEAF = YarnMaterial.named("leaf")
MEMORY = SLOTS - 1
"""Pairs that are kept."""


def started(yarns: YarnSet, material: YarnMaterial = LEAF) -> YarnSimulation:
    simulation = YarnSimulation.start(yarns, material, DOUBLE, device_named("cpu"))
    simulation.solver.begin(np.array([ASSESSMENT_INTERVAL]))
    return simulation


def record_of(simulation: YarnSimulation) -> np.ndarray:
    return simulation.solver.arrays()["record"].numpy()[0].copy()


def blocks(rows: np.ndarray) -> np.ndarray:
    """Symmetric matrices from (xx, yy, zz, xy, xz, yz), shape (N, 3, 3)."""
    return rows[:, [0, 3, 4, 3, 1, 5, 4, 5, 2]].reshape(-1, 3, 3)


@dataclass
class Textbook:
    """L-BFGS by Nocedal and Wright, algorithm 7.4, on arrays of all control points."""

    moves: list[np.ndarray] = field(default_factory=list)
    gradient_change: list[np.ndarray] = field(default_factory=list)
    scale: float = 1.0

    def accept(self, move: np.ndarray, change: np.ndarray, preconditioner: np.ndarray) -> bool:
        """Store a pair (move, change of the gradient) if its curvature is positive; return whether it was stored."""
        curvature = (move * change).sum()
        if curvature <= 1e-8 * np.linalg.norm(move) * np.linalg.norm(change):
            return False
        self.moves, self.gradient_change = [*self.moves, move][-MEMORY:], [*self.gradient_change, change][-MEMORY:]
        preconditioned = (change * np.einsum("nij,nj->ni", preconditioner, change)).sum()
        self.scale = float(np.clip(curvature / preconditioned, 0.05, 4.0))
        return True

    def step(self, force: np.ndarray, preconditioner: np.ndarray) -> np.ndarray:
        pairs = list(zip(self.moves, self.gradient_change, strict=True))
        rest, alphas = force.copy(), []
        for move, change in reversed(pairs):
            alphas.append((move * rest).sum() / (move * change).sum())
            rest -= alphas[-1] * change
        step = self.scale * np.einsum("nij,nj->ni", preconditioner, rest)
        for (move, change), alpha in zip(pairs, reversed(alphas), strict=True):
            step += move * (alpha - (change * step).sum() / (move * change).sum())
        return step


def iterate(simulation: YarnSimulation, growth: np.ndarray | None = None) -> np.ndarray:
    """Run one iteration, with ``growth`` added to the forces if it is given; return the forces that were used."""
    state = simulation.state
    force = np.zeros(0)
    for launch in simulation.iterations.launches:
        launch.launch()
        if launch.kernel.key == "gather_forces":
            if growth is not None:
                state.force.assign(state.force.numpy() + growth)
            force = state.force.numpy().copy()
    return force


def limit_step(simulation: YarnSimulation, step: np.ndarray, before: np.ndarray) -> np.ndarray:
    """The step, shortened to the limits of an iteration."""
    state = simulation.state
    room = state.budget.numpy() - np.linalg.norm(before - state.listed_points.numpy(), axis=1)
    limit = np.minimum(simulation.step_fraction, room)
    return step * np.minimum(1.0, limit / np.linalg.norm(step, axis=1))[:, None]


def partly_relaxed_tube() -> YarnSimulation:
    """A partly relaxed tube with an empty L-BFGS memory, and budgets so large that no cell waits for new lists."""
    simulation = started(tube(3, 6))
    for _ in range(3):
        loop_of(simulation).iterate(ASSESSMENT_INTERVAL)
    simulation.search_contacts()
    simulation.state.budget.fill_(10.0)
    simulation.solver.restart(np.ones(1))
    simulation.solver.begin(np.array([ASSESSMENT_INTERVAL]))
    return simulation


def compare_with_textbook(simulation: YarnSimulation, count: int, bad: int = -1) -> tuple[Textbook, list[float]]:
    """Compare ``count`` iterations with the textbook's. In iteration ``bad``, the forces grow along the last move.

    Returns:
        The textbook's memory, and the iterations whose pairs were not stored.
    """
    book, left_out = Textbook(), []
    last_points = last_force = None
    for turn in range(count):
        before = simulation.state.points.numpy().copy()
        growth = None
        if turn == bad:
            growth = 1e5 * (before - last_points)
        force = iterate(simulation, growth)
        preconditioner = blocks(simulation.state.preconditioner.numpy())
        if last_points is not None and not book.accept(before - last_points, last_force - force, preconditioner):
            left_out.append(turn)
        assert record_of(simulation)[PAIRS] == len(book.moves)
        expected = limit_step(simulation, book.step(force, preconditioner), before)
        moved = simulation.state.points.numpy() - before
        # rounding of float64 sums of some thousand products; the recursion and nearly parallel pairs amplify it
        np.testing.assert_allclose(moved, expected, atol=1e-8 * np.abs(expected).max(), err_msg=f"iteration {turn}")
        last_points, last_force = before, force
    return book, left_out


def test_steps_are_those_of_the_textbook() -> None:
    book, left_out = compare_with_textbook(partly_relaxed_tube(), ASSESSMENT_INTERVAL - SMOOTHING)
    assert len(book.moves) == MEMORY  # more pairs occurred than the memory holds
    assert not left_out


def test_a_pair_along_which_forces_grow_is_left_out() -> None:
    simulation = partly_relaxed_tube()
    book, left_out = compare_with_textbook(simulation, 5, bad=3)
    # the force that one iteration adds vanishes in the next, so the next pair has positive curvature again
    assert left_out == [3]
    assert len(book.moves) == 3


def test_the_last_iterations_of_an_interval_are_plain_and_do_not_change_the_memory() -> None:
    simulation = partly_relaxed_tube()
    for _ in range(ASSESSMENT_INTERVAL - SMOOTHING):
        iterate(simulation)
    kept = None
    for _ in range(SMOOTHING):
        before = simulation.state.points.numpy().copy()
        force = iterate(simulation)
        now = record_of(simulation)
        assert now[PLAIN] == 1.0
        assert kept is None or (now[:2] == kept[:2]).all()
        kept = now
        expected = limit_step(simulation, 1.6 * force / simulation.state.stiffness.numpy()[:, None], before)
        # float64 rounding of coordinates of a dozen units
        np.testing.assert_allclose(simulation.state.points.numpy() - before, expected, atol=1e-14 * 20)
    assert kept is not None and kept[ITERATION] == ASSESSMENT_INTERVAL


def test_all_points_wait_if_one_has_used_its_budget() -> None:
    simulation = partly_relaxed_tube()
    for _ in range(5):
        iterate(simulation)
    state = simulation.state
    spent, budget = 17, state.budget.numpy().copy()
    travelled = np.linalg.norm(state.points.numpy()[spent] - state.listed_points.numpy()[spent])
    budget[spent] = travelled / 0.75  # the point has used more than seven tenths of its budget
    state.budget.assign(budget)
    before, turn, pairs = state.points.numpy().copy(), record_of(simulation)[ITERATION], record_of(simulation)[PAIRS]
    for _ in range(3):
        iterate(simulation)
    assert record_of(simulation)[WAITING] == 1.0
    assert np.array_equal(state.points.numpy(), before)
    assert record_of(simulation)[ITERATION] == turn
    assert simulation.solver.progress(simulation.inputs, 1).waiting.all()
    simulation.search_contacts()  # new budgets
    iterate(simulation)
    assert record_of(simulation)[WAITING] == 0.0
    assert not np.array_equal(state.points.numpy(), before)
    # the last move before the wait gives an ordinary pair; the iterations without motion give none
    assert pairs < record_of(simulation)[PAIRS] <= pairs + 1


def energy(simulation: YarnSimulation) -> float:
    model, state = simulation.model, simulation.state
    place_contact_samples(model, state, model.launch)
    return sum(by_term.energies(model, state, simulation.candidates, ()).values())


def test_a_stretched_straight_yarn_relaxes_in_few_iterations() -> None:
    """For displacements along the line, the stretch energy is quadratic with a condition number (segments / pi)^2."""
    segments = 40
    place = np.arange(segments + 3) * 0.3
    rest = 0.3 + 0.03 * np.cos(np.arange(segments))
    yarns = YarnSet.from_curves(
        [place[:, None] * [1.0, 0.0, 0.0]], closed=[False], radius=0.125, rest_lengths=[rest]
    )
    simulation = started(yarns, YarnMaterial(2000.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.006, segment_length=0.3))
    nodes, weights = np.polynomial.legendre.leggauss(3)
    speeds = np.zeros((3 * segments, len(place)))
    for segment in range(segments):
        speeds[3 * segment : 3 * segment + 3, segment : segment + 4] = basis_derivative((nodes + 1) / 2)
    factors = np.sqrt(2000.0 / 0.3 * np.repeat(rest, 3) * np.tile(weights / 2, segments))
    strains = speeds * (factors / np.repeat(rest, 3))[:, None]
    least = ((strains @ np.linalg.lstsq(strains, factors, rcond=None)[0] - factors) ** 2).sum()
    start = energy(simulation) - least
    for _ in range(3):
        loop_of(simulation).iterate(ASSESSMENT_INTERVAL)
    # Steps along the forces would leave (1 - 2 / 160)^120 = 0.2 of this energy. L-BFGS leaves less than 1e-9 of it.
    assert -1e-12 * least < energy(simulation) - least < 1e-9 * start
