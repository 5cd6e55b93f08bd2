# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""One iteration of Newton's method with a line search, for steps in time and for equilibria.

The function to minimize over the unknowns is

    Phi(x) = V(x) + inertia(x) + damping(x),

    gradient    -f(x) + M w + c K_n d,            matrix    (1 + c) K(x) + m M,

with the energy V of all terms and its forces f and Hessian K, the displacement d since the beginning of the step, the
vector w = m d + constant of inertia and damping by mass, and c times the never-negative Hessian K_n at the beginning of
the step, which is damping by stiffness. Inertia and damping are quadratic, so that their change along a direction is
known exactly from two dot products. Where the change of V is lost in the rounding of its terms, the line search looks
at the slope instead.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
import warp as wp

from stitchmesh.compute.captured import Launcher
from stitchmesh.mixed.dynamics.conjugate_gradients import SolveReport
from stitchmesh.mixed.dynamics.mixed_system import MixedSystem
from stitchmesh.mixed.dynamics.read_sums import ReadSums
from stitchmesh.mixed.dynamics.vector_sums import move, set_sum, subtract_forces
from stitchmesh.mixed.mixed_vector import MixedVector

DECREASE = 1e-4
"""Part of the decrease of the linear model that a step must reach (Nocedal and Wright, equation 3.4)."""
MOST_HALVINGS = 24
"""Largest number of times that a step is halved."""
RISE = 0.5
"""Part of the slope up to which Phi may rise again at the end of a step whose change is lost in rounding (approximate
Wolfe conditions of Hager and Zhang 2005). Larger parts let a contact that opens and closes alternate for ever."""
NOISE = 1e4
"""Rounding of a sum of energies over its largest term, in units in the last place: elements that are hardly strained
subtract nearly equal lengths."""


@dataclass(frozen=True)
class Quadratic:
    """Coefficients of the quadratic part of Phi."""

    mass: float
    """Factor m of the mass matrix [1/s^2]."""
    stiffness: float = 0.0
    """Factor c of the Hessian at the beginning of the step."""


@dataclass(frozen=True)
class IterationReport:
    """What an iteration did."""

    solve: SolveReport
    """How the linear solve ended."""
    step: float
    """Part of the direction that was taken; 0 where no part decreased Phi."""
    change: float
    """Change of Phi [erg]."""
    whole: bool
    """Whether the longest step that the terms allow was taken."""
    energies: Mapping[str, float] | None = None
    """Energies of all terms at the position in the end [erg], where they are known."""


@dataclass(frozen=True, eq=False)
class NewtonState:
    """Vectors that an iteration changes together."""

    position: MixedVector
    """x = start + d."""
    displacement: MixedVector
    """d."""
    inertia: MixedVector
    """w."""
    damping: MixedVector
    """K_n d; stays zero without damping by stiffness."""


class Newton:
    """Newton's method for one system."""

    def __init__(self, system: MixedSystem) -> None:
        """Allocate the vectors of an iteration."""
        self.system = system
        self.gradient_force = system.zeros()
        self._product, self._of_mass, self._trial = system.zeros(), system.zeros(), system.zeros()
        self._force = system.zeros()
        self._noise = NOISE * float(np.finfo(np.float32 if system.scalar is wp.float32 else np.float64).eps)

    def set_downhill_force(self, state: NewtonState, quadratic: Quadratic) -> None:
        """Set ``gradient_force`` to minus the gradient of Phi [dyn]."""
        force = self.gradient_force
        self.system.set_forces(state.position, force)
        self.system.set_mass_product(state.inertia, self._product)
        subtract_forces(force, self._product, quadratic.stiffness, state.damping)

    def iterate(
        self,
        state: NewtonState,
        start: MixedVector,
        quadratic: Quadratic,
        tolerance: float,
        most_iterations: int,
        energies: Mapping[str, float] | None = None,
    ) -> IterationReport:
        """Move ``state`` along the solution of a linear system, after ``set_downhill_force`` and ``linearize``.

        Args:
            state: positions and what follows from them; changed.
            start: positions at the beginning of the step, for damping by stiffness.
            quadratic: factors of the quadratic part.
            tolerance: relative tolerance of the linear solve.
            most_iterations: largest number of its iterations.
            energies: energies of all terms at the position, where they are known, as the report of the iteration before
                gives them.
        """
        solver = self.system.solver
        report = solver.solve(self.gradient_force, tolerance=tolerance, most_iterations=most_iterations)
        if report.iterations == 0:
            return IterationReport(report, 1.0, 0.0, True, energies)
        direction, product = solver.solution, self._product
        slopes = self._slopes(state, start, quadratic, direction)
        longest = self.system.step_limit(state.position, direction) if slopes[0] < 0.0 else 0.0
        before = self.system.energies(state.position) if energies is None else energies
        step, change, after = self._search(state.position, direction, longest, slopes, before)
        move(state.position, state.displacement, state.inertia, step, step * quadratic.mass, direction)
        if quadratic.stiffness:
            set_sum(state.damping, 1.0, state.damping, step, product)
        return IterationReport(report, step, change, step == longest > 0.0, after)

    def _slopes(
        self, state: NewtonState, start: MixedVector, quadratic: Quadratic, direction: MixedVector
    ) -> tuple[float, float, float]:
        """Slope of Phi along a direction, and the linear and quadratic coefficients of inertia and damping.

        ``_product`` becomes the product of the direction with the Hessian of damping.
        """
        self.system.set_mass_product(direction, self._of_mass)
        vectors: tuple[MixedVector, ...] = (self.gradient_force, direction, state.inertia, self._of_mass)
        if quadratic.stiffness:
            self.system.linearize(start, 0.0)
            self.system.set_hessian_product(direction, self._product)
            vectors += state.damping, self._product

        def make(_run: Launcher, sums: ReadSums) -> list[Any]:
            for first, second in ((0, 1), (2, 3), (1, 3), (4, 1), (1, 5))[: 5 if quadratic.stiffness else 3]:
                sums.add_dot(vectors[first].values, vectors[second].values)
            return []

        slope, linear, square, *damped = (float(value) for value in self.system.repeated.read("slopes", vectors, make))
        square *= quadratic.mass
        if quadratic.stiffness:
            linear, square = linear + quadratic.stiffness * damped[0], square + quadratic.stiffness * damped[1]
        return -slope, linear, square

    def _search(
        self,
        position: MixedVector,
        direction: MixedVector,
        longest: float,
        slopes: tuple[float, float, float],
        before: Mapping[str, float],
    ) -> tuple[float, float, Mapping[str, float]]:
        """The largest of the steps s, s/2, s/4, ... that decreases Phi enough, the change of Phi, and the energies.

        ``slopes`` are the slope of Phi and the linear and quadratic coefficients of inertia and damping, ``before`` the
        energies at the position.
        """
        slope, linear, square = slopes
        noise = self._noise * max((abs(value) for value in before.values()), default=0.0)
        step = longest
        for _ in range(MOST_HALVINGS if step else 0):
            set_sum(self._trial, 1.0, position, step, direction)
            after = self.system.energies(self._trial)
            change = sum(after[name] - before[name] for name in before) + step * linear + 0.5 * step**2 * square
            if change <= DECREASE * step * slope:
                return step, change, after
            if change <= noise and self._slope_at_trial(direction) + linear + step * square <= RISE * -slope:
                return step, change, after
            step *= 0.5
        return 0.0, 0.0, before

    def _slope_at_trial(self, direction: MixedVector) -> float:
        """Slope of the energy of all terms along the direction."""
        self.system.set_forces(self._trial, self._force)
        return -self.system.dot(self._force, direction)
