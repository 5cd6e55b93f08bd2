# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Static equilibrium of the mixed system by Newton's method on the energy.

Each iteration minimizes V(x + d) + 1/(2 h^2) |d|_M^2 over the motions d once: a step in time from rest, whose length h
grows as long as whole steps decrease the energy, and shrinks otherwise. Far from the equilibrium the matrix is the one
that is never negative. Near it, where the largest unbalanced force has fallen to a part of its first value, the matrix
is the exact Hessian, with which the iteration converges fast. After a direction of negative curvature the other matrix
is used again.

At an equilibrium all terms may update what lasts from step to step, for example friction anchors. The search goes on
until the updates change nothing.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from stitchmesh.errors import ParameterError
from stitchmesh.mixed.dynamics.mixed_system import MixedSystem
from stitchmesh.mixed.dynamics.newton import IterationReport, Newton, NewtonState, Quadratic
from stitchmesh.mixed.dynamics.vector_sums import largest
from stitchmesh.mixed.mixed_vector import MixedVector

NEAR = 1e-2
"""Part of the first unbalanced force below which the exact Hessian is used."""
LONGER, SHORTER, KEEPS = 4.0, 0.25, 0.25
"""Factors of the pseudo time step after a whole step and after a short one; part of a step that is not short."""


@dataclass(frozen=True)
class EquilibriumSettings:
    """Choices of a static equilibrium.

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
    """Largest number of updates of what lasts from step to step."""

    def __post_init__(self) -> None:
        for name in self.__dataclass_fields__:
            value = getattr(self, name)
            if not (np.isfinite(value) and value > 0):
                raise ParameterError(f"equilibrium: {name}: got {value}; expected a number above 0")


@dataclass(frozen=True)
class EquilibriumReport:
    """How the search ended."""

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


def find_equilibrium(
    system: MixedSystem,
    positions: MixedVector,
    settings: EquilibriumSettings | None = None,
) -> EquilibriumReport:
    """Move positions to a static equilibrium; what is fixed stays.

    Args:
        system: terms, masses and unknowns.
        positions: where the search begins; changed to the equilibrium.
        settings: tolerances.
    """
    search = _Search(system, positions, settings or EquilibriumSettings())
    return search.run()


class _Search:
    """The search for an equilibrium."""

    def __init__(self, system: MixedSystem, positions: MixedVector, settings: EquilibriumSettings) -> None:
        self.system, self.positions, self.settings = system, positions, settings
        self.newton = Newton(system)
        self.filtered = system.zeros()
        self.state = NewtonState(positions, *(system.zeros() for _ in range(3)))
        self.time_step, self.exact, self.first_force = settings.first_time_step, 0.0, 0.0
        self.iterations, self.products = 0, 0

    def run(self) -> EquilibriumReport:
        """Search until updates change nothing."""
        force = self._relax()
        for _ in range(self.settings.most_updates):
            if force > self.settings.force_tolerance or self.iterations >= self.settings.most_iterations:
                break
            for term in self.system.terms:
                term.end_step(self.positions, 0.0, 0.0)
            before = self.iterations
            force = self._relax()
            if self.iterations == before:
                break
        energy = sum(self.system.energies(self.positions).values())
        converged = force <= self.settings.force_tolerance
        return EquilibriumReport(converged, self.iterations, self.products, force, energy)

    def _relax(self) -> float:
        """Iterate until forces balance; return the largest unbalanced force."""
        while True:
            self.system.update_masses(self.positions)
            for term in self.system.terms:
                term.begin_step(self.positions, 0.0, 0.0)
            force = self._unbalanced_force()
            if not force > self.settings.force_tolerance or self.iterations >= self.settings.most_iterations:
                return force
            self._follow(self._iterate(force))

    def _unbalanced_force(self) -> float:
        """Set the forces and return the largest unbalanced one."""
        for vector in (self.state.displacement, self.state.inertia):
            vector.values.zero_()
        self.newton.set_downhill_force(self.state, self._quadratic)
        self.system.set_filtered(self.newton.gradient_force, self.filtered)
        force = largest(self.filtered)
        self.first_force = max(self.first_force, force)
        return force

    def _iterate(self, force: float) -> IterationReport:
        """One iteration of Newton's method."""
        if force > NEAR * self.first_force:
            self.exact = 0.0
        self.system.set_factors(self._quadratic.mass, 1.0, self.positions, stiffness_in_metric=True)
        self.system.linearize(self.positions, self.exact)
        self.iterations += 1
        tolerance = self.settings.near_solve_tolerance if self.exact else self.settings.solve_tolerance
        most = self.settings.most_solve_iterations
        report = self.newton.iterate(self.state, self.positions, self._quadratic, tolerance, most)
        self.products += report.solve.iterations
        return report

    def _follow(self, report: IterationReport) -> None:
        """Choose the pseudo time step and the matrix of the next iteration."""
        good = report.whole and not report.solve.negative
        factor = LONGER if good else (1.0 if report.step >= KEEPS and not report.solve.negative else SHORTER)
        self.time_step = min(self.time_step * factor, self.settings.longest_time_step)
        self.exact = 1.0 if good else 0.0

    @property
    def _quadratic(self) -> Quadratic:
        return Quadratic(1.0 / self.time_step**2)
