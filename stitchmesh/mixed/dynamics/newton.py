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

from dataclasses import dataclass

import numpy as np
import warp as wp

from stitchmesh.mixed.dynamics.conjugate_gradients import SolveReport
from stitchmesh.mixed.dynamics.mixed_system import MixedSystem
from stitchmesh.mixed.dynamics.vector_sums import dot, set_sum
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
        self._product, self._trial = system.zeros(), system.zeros()
        self._force = system.zeros()
        self._noise = NOISE * float(np.finfo(np.float32 if system.scalar is wp.float32 else np.float64).eps)

    def set_downhill_force(self, state: NewtonState, quadratic: Quadratic) -> None:
        """Set ``gradient_force`` to minus the gradient of Phi [dyn]."""
        force = self.gradient_force
        self.system.set_forces(state.position, force)
        self.system.set_mass_product(state.inertia, self._product)
        set_sum(force, 1.0, force, -1.0, self._product)
        if quadratic.stiffness:
            set_sum(force, 1.0, force, -quadratic.stiffness, state.damping)

    def iterate(
        self,
        state: NewtonState,
        start: MixedVector,
        quadratic: Quadratic,
        tolerance: float,
        most_iterations: int,
    ) -> IterationReport:
        """Move ``state`` along the solution of a linear system, after ``set_downhill_force`` and ``linearize``.

        Args:
            state: positions and what follows from them; changed.
            start: positions at the beginning of the step, for damping by stiffness.
            quadratic: factors of the quadratic part.
            tolerance: relative tolerance of the linear solve.
            most_iterations: largest number of its iterations.
        """
        solver = self.system.solver
        report = solver.solve(self.gradient_force, tolerance=tolerance, most_iterations=most_iterations)
        if report.iterations == 0:
            return IterationReport(report, 1.0, 0.0, True)
        direction, product = solver.solution, self._product
        slope = -dot(self.gradient_force, direction)
        self.system.set_mass_product(direction, product)
        linear, square = dot(state.inertia, product), quadratic.mass * dot(direction, product)
        if quadratic.stiffness:
            self.system.linearize(start, 0.0)
            self.system.set_hessian_product(direction, product)
            linear += quadratic.stiffness * dot(state.damping, direction)
            square += quadratic.stiffness * dot(direction, product)
        longest = self.system.step_limit(state.position, direction) if slope < 0.0 else 0.0
        step, change = self._search(state.position, direction, longest, (slope, linear, square))
        set_sum(state.position, 1.0, state.position, step, direction)
        set_sum(state.displacement, 1.0, state.displacement, step, direction)
        set_sum(state.inertia, 1.0, state.inertia, step * quadratic.mass, direction)
        if quadratic.stiffness:
            set_sum(state.damping, 1.0, state.damping, step, product)
        return IterationReport(report, step, change, step == longest > 0.0)

    def _search(
        self, position: MixedVector, direction: MixedVector, longest: float, slopes: tuple[float, float, float]
    ) -> tuple[float, float]:
        """The largest of the steps s, s/2, s/4, ... that decreases Phi enough, and the change of Phi.

        ``slopes`` are the slope of Phi and the linear and quadratic coefficients of inertia and damping.
        """
        slope, linear, square = slopes
        before = self.system.energies(position)
        noise = self._noise * max((abs(value) for value in before.values()), default=0.0)
        step = longest
        for _ in range(MOST_HALVINGS if step else 0):
            set_sum(self._trial, 1.0, position, step, direction)
            after = self.system.energies(self._trial)
            change = sum(after[name] - before[name] for name in before) + step * linear + 0.5 * step**2 * square
            if change <= DECREASE * step * slope:
                return step, change
            if change <= noise and self._slope_at_trial(direction) + linear + step * square <= RISE * -slope:
                return step, change
            step *= 0.5
        return 0.0, 0.0

    def _slope_at_trial(self, direction: MixedVector) -> float:
        """Slope of the energy of all terms along the direction."""
        self.system.set_forces(self._trial, self._force)
        return -dot(self._force, direction)
