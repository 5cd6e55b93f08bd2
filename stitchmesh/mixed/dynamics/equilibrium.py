# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Static equilibrium of the mixed system by Newton's method on the energy.

Each iteration minimizes V(x + d) + 1/(2 h^2) |d|_M^2 over the motions d once. It is a step in time from rest; its
length h grows as long as whole steps decrease the energy, and shrinks otherwise. Far from the equilibrium the matrix is
the one that is never negative. Near it, where the largest unbalanced force has fallen to a part of its first value, the
matrix is the exact Hessian, with which the iteration converges fast. After a direction of negative curvature, the
search returns to the matrix that is never negative.

At an equilibrium all terms may update their lasting values, for example friction anchors. The search goes on until the
updates change nothing.

A search depends on its positions, its own numbers and the lasting values of the terms: a search that is stopped after
an iteration and resumed gives the same bits.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from stitchmesh.errors import ParameterError
from stitchmesh.mixed.dynamics.mixed_system import MixedSystem
from stitchmesh.mixed.dynamics.newton import IterationReport, NewtonState, Quadratic, SystemNewton
from stitchmesh.mixed.dynamics.vector_sums import largest
from stitchmesh.mixed.mixed_vector import MixedVector
from stitchmesh.progress import Progress, relaxing_progress

NEAR = 1e-2
"""Part of the first unbalanced force below which the exact Hessian is used."""
AfterIteration = Callable[[int, float], None]
"""Called with the number of iterations so far and the largest unbalanced force [dyn]. It may raise an exception to stop
the search; the search may later run on from there."""
LONGER, SHORTER, KEEPS = 4.0, 0.25, 0.25
"""Factors of the pseudo time step after a whole step and after a short step, and the part that a step must reach not to
count as short."""


@dataclass(frozen=True)
class EquilibriumSettings:
    """Settings of a static equilibrium.

    Raises:
        ParameterError: a value is out of range.
    """

    force_tolerance: float = 1e-3
    """Largest unbalanced force on a vertex, node or Eulerian coordinate [dyn]."""
    most_iterations: int = 500
    """Largest number of Newton iterations."""
    first_time_step: float = 1e-2
    """First pseudo time step [s]."""
    longest_time_step: float = 1e3
    """Largest pseudo time step [s]."""
    solve_tolerance: float = 5e-2
    """Relative tolerance of the linear solves far from the equilibrium."""
    near_solve_tolerance: float = 1e-3
    """Relative tolerance of the linear solves with the exact Hessian."""
    most_solve_iterations: int = 2000
    """Largest number of products of a linear solve."""
    most_updates: int = 20
    """Largest number of updates of lasting values; with 0, friction holds everything where it began."""

    def __post_init__(self) -> None:
        for name in self.__dataclass_fields__:
            value, least = getattr(self, name), "of at least 0" if name == "most_updates" else "above 0"
            if not (np.isfinite(value) and (value > 0 or (value == 0 and name == "most_updates"))):
                raise ParameterError(f"equilibrium: {name}: got {value}; expected a number {least}")


@dataclass(frozen=True)
class EquilibriumReport:
    """The report of a search."""

    converged: bool
    """Whether the largest unbalanced force is within the tolerance."""
    iterations: int
    """Newton iterations."""
    solve_iterations: int
    """Products with the matrix."""
    unbalanced_force: float
    """Largest unbalanced force [dyn]."""
    energy: float
    """Energy of all terms [erg]."""


def unwatched(iterations: int, force: float) -> None:
    """Do nothing after an iteration (an ``AfterIteration`` function)."""


def find_equilibrium(
    system: MixedSystem,
    positions: MixedVector,
    settings: EquilibriumSettings | None = None,
    *,
    time: float = 0.0,
    after_iteration: AfterIteration = unwatched,
) -> EquilibriumReport:
    """Move positions to a static equilibrium; fixed coordinates stay.

    Args:
        system: terms, masses and unknowns.
        positions: where the search begins; changed to the equilibrium.
        settings: tolerances.
        time: the time of moving bodies and other loads [s].
        after_iteration: called after each iteration, and after each update of lasting values.
    """
    return EquilibriumSearch(system, positions, settings, time=time).run(after_iteration)


class EquilibriumSearch:
    """A search for an equilibrium that may be stopped and resumed."""

    def __init__(
        self,
        system: MixedSystem,
        positions: MixedVector,
        settings: EquilibriumSettings | None = None,
        *,
        time: float = 0.0,
    ) -> None:
        """Begin a search, with the arguments of ``find_equilibrium``."""
        self.system, self.positions, self.time = system, positions, time
        self.settings = settings or EquilibriumSettings()
        self._newton = SystemNewton(system)
        self._filtered = system.zeros()
        self._state = NewtonState(positions, *(system.zeros() for _ in range(3)))
        self._time_step, self._exact, self._first_force = self.settings.first_time_step, 0.0, 0.0
        self._iterations, self._products = 0, 0
        self._updates, self._updated_at = 0, -1

    def run(self, after_iteration: AfterIteration = unwatched) -> EquilibriumReport:
        """Search until updates change nothing, or the iterations are used up."""
        force = self._balance()
        while self._iterations < self.settings.most_iterations:
            if force > self.settings.force_tolerance:
                self._follow(self._iterate(force))
            elif self._updates < self.settings.most_updates and self._iterations != self._updated_at:
                self._update()
            else:
                break
            force = self._balance()
            after_iteration(self._iterations, force)
        energy = sum(self.system.energies(self.positions).values())
        converged = force <= self.settings.force_tolerance
        return EquilibriumReport(converged, self._iterations, self._products, force, energy)

    def numbers(self) -> NDArray[np.float64]:
        """The numbers that, with positions and terms, the search depends on, for stopping and resuming."""
        counts = self._iterations, self._products, self._updates, self._updated_at
        return np.array([*counts, self._time_step, self._exact, self._first_force], dtype=np.float64)

    def resume(self, numbers: NDArray[np.float64]) -> None:
        """Go on from ``numbers``; the caller restores positions and terms."""
        self._iterations, self._products, self._updates, self._updated_at = (int(number) for number in numbers[:4])
        self._time_step, self._exact, self._first_force = (float(number) for number in numbers[4:])

    def _update(self) -> None:
        """Let the terms update their lasting values."""
        for term in self.system.terms:
            term.end_step(self.positions, self.time, 0.0)
        self._updates, self._updated_at = self._updates + 1, self._iterations

    def _balance(self) -> float:
        """Prepare the terms and the forces of an iteration; return the largest unbalanced force."""
        self.system.update_masses(self.positions)
        for term in self.system.terms:
            term.begin_step(self.positions, self.time, 0.0)
        for vector in (self._state.displacement, self._state.inertia):
            vector.values.zero_()
        self._newton.set_downhill_force(self._state, self._quadratic)
        self.system.set_filtered(self._newton.gradient_force, self._filtered)
        force = largest(self._filtered)
        self._first_force = max(self._first_force, force)
        return force

    def _iterate(self, force: float) -> IterationReport:
        """One iteration of Newton's method."""
        if force > NEAR * self._first_force:
            self._exact = 0.0
        self.system.set_factors(self._quadratic.mass, 1.0, self.positions, stiffness_in_metric=True)
        self.system.linearize(self.positions, self._exact)
        self._iterations += 1
        tolerance = self.settings.near_solve_tolerance if self._exact else self.settings.solve_tolerance
        most = self.settings.most_solve_iterations
        report = self._newton.iterate(self._state, self.positions, self._quadratic, tolerance, most)
        self._products += report.solve.iterations
        return report

    def _follow(self, report: IterationReport) -> None:
        """Choose the pseudo time step and the matrix of the next iteration."""
        good = report.whole and not report.solve.negative
        factor = LONGER if good else (1.0 if report.step >= KEEPS and not report.solve.negative else SHORTER)
        self._time_step = min(self._time_step * factor, self.settings.longest_time_step)
        self._exact = 1.0 if good else 0.0

    @property
    def _quadratic(self) -> Quadratic:
        return Quadratic(1.0 / self._time_step**2)


def search_progress(
    stage: str, found: int, count: int, progress: Progress, *, tolerance: float, most_iterations: int
) -> AfterIteration:
    """Return a function that reports the iterations of a search.

    Args:
        stage: name of the stage.
        found: number of equilibria before this one.
        count: number of all equilibria.
        progress: called with the completed part of all searches and a line of text.
        tolerance: unbalanced force at which the search ends [dyn].
        most_iterations: largest number of iterations of the search.
    """

    def of_all(stage: str, done: float, note: str) -> None:
        progress(stage, min((found + done) / count, 1.0), note)

    return relaxing_progress(stage, tolerance, of_all, max_iterations=most_iterations)
