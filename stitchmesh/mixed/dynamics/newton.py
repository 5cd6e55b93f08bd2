# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""One iteration of Newton's method with a line search, for steps in time and for equilibria.

The function to minimize over the unknowns is

    Phi(x) = V(x) + inertia(x) + damping(x),

    gradient    -f(x) + M w + c K_n d,            matrix    K(x) + c K_n + m M,

with the energy V of all terms and its forces f and Hessian K, the displacement d since the beginning of the step, and
the vector w = m d + constant of inertia and damping by mass. K_n is the never-negative Hessian at the beginning of the
step; c times K_n is the damping by stiffness. Terms store one Hessian, which is multiplied by 1 + c: its share of the
exact Hessian is 1 / (1 + c), and its share of damping is c / (1 + c). Most terms use K_n(x) for K_n; friction uses its
value at the beginning of the step. Inertia and damping are quadratic, so their change along a direction follows exactly
from two dot products. Where the change of V is lost in the rounding of its terms, the line search looks at the slope
instead.
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
from stitchmesh.mixed.dynamics.vector_sums import ReadSums, move_launch, remaining_launch, set_sum, sum_launch
from stitchmesh.mixed.mixed_vector import MixedVector

DECREASE = 1e-4
"""Part of the decrease that the linear model predicts and a step must reach (Nocedal and Wright, equation 3.4)."""
MOST_HALVINGS = 24
"""Largest number of times that a step is halved."""
RISE = 0.5
"""For a step whose change is lost in rounding: the part of the slope up to which Phi may rise again at its end
(approximate Wolfe conditions of Hager and Zhang 2005). With larger parts, a contact that opens and closes may alternate
for ever."""
NOISE = 1e4
"""Rounding of a sum of energies over its largest term, in units in the last place. It is large because elements that
are hardly strained subtract nearly equal lengths."""


@dataclass(frozen=True)
class Quadratic:
    """Coefficients of the quadratic part of Phi."""

    mass: float
    """Factor m of the mass matrix [1/s^2]."""
    stiffness: float = 0.0
    """Factor c of the Hessian at the beginning of the step."""


@dataclass(frozen=True)
class IterationReport:
    """The report of an iteration."""

    solve: SolveReport
    """How the linear solve ended."""
    step: float
    """Part of the direction by which the state moved; 0 where no part decreased Phi."""
    change: float
    """Change of Phi [erg]."""
    whole: bool
    """Whether the step was the longest one that the terms allow."""
    energies: Mapping[str, float] | None = None
    """Energies of all terms at the final position [erg], if they are known."""


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

    @property
    def vectors(self) -> tuple[MixedVector, MixedVector, MixedVector, MixedVector]:
        """All of them."""
        return self.position, self.displacement, self.inertia, self.damping


class SystemNewton:
    """Newton's method for one system."""

    def __init__(self, system: MixedSystem) -> None:
        """Allocate the vectors of an iteration."""
        self.system = system
        self.gradient_force = system.zeros()
        self._product, self._of_mass, self._trial = system.zeros(), system.zeros(), system.zeros()
        self._force = system.zeros()
        self._noise = NOISE * float(np.finfo(np.float32 if system.scalar is wp.float32 else np.float64).eps)
        self._factors, self._factors_of = wp.zeros(2, dtype=system.scalar, device=system.device), Quadratic(0.0)

    def set_downhill_force(self, state: NewtonState, quadratic: Quadratic) -> None:
        """Set ``gradient_force`` to minus the gradient of Phi [dyn]."""
        self._set_factors(quadratic)
        force, product = self.gradient_force, self._product

        def make(run: Launcher, _sums: ReadSums) -> list[Any]:
            return [
                *self.system.force_launches(state.position, force, run),
                *self.system.mass_launches(state.inertia, product, run),
                remaining_launch(force, self._factors, product, state.damping, run),
            ]

        self.system.repeated.run("downhill", (*state.vectors, force), make)

    def _set_factors(self, quadratic: Quadratic) -> None:
        """Send the coefficients of the quadratic part to the device."""
        if quadratic != self._factors_of:
            self._factors.assign([quadratic.mass, quadratic.stiffness])
            self._factors_of = quadratic

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
            state: positions, and the vectors that follow from them; changed.
            start: positions at the beginning of the step, for damping by stiffness.
            quadratic: factors of the quadratic part.
            tolerance: relative tolerance of the linear solve.
            most_iterations: largest number of iterations of the linear solve.
            energies: energies of all terms at the position, if they are known, as the report of the previous iteration
                gives them.
        """
        solver = self.system.solver
        solver.begin_solve(self.gradient_force, tolerance=tolerance, most_iterations=most_iterations)
        direction = solver.solution
        slopes, limits = self._look_along(state, start, quadratic, direction)  # a GPU goes on without the host
        report = solver.report()
        if report.iterations == 0:
            return IterationReport(report, 1.0, 0.0, True, energies)
        longest = self.system.least_limit(limits, state.position, direction) if slopes[0] < 0.0 else 0.0
        before = self.system.energies(state.position) if energies is None else energies
        step, change, after = self._search(state.position, direction, longest, slopes, before)
        self._move(state, step, direction)
        return IterationReport(report, step, change, step == longest > 0.0, after)

    def _move(self, state: NewtonState, step: float, direction: MixedVector) -> None:
        """Move the state by a part of a direction; most steps are whole, and captured."""

        def make(run: Launcher, _sums: ReadSums | None) -> list[Any]:
            return [move_launch(state.vectors, step, self._factors, direction, self._product, run)]

        if step == 1.0:
            self.system.repeated.run("whole step", (*state.vectors, direction), make)
        elif step:
            make(self.system.launch, None)

    def _look_along(
        self, state: NewtonState, start: MixedVector, quadratic: Quadratic, direction: MixedVector
    ) -> tuple[tuple[float, float, float], list[float]]:
        """Compute the values of a line search along a direction, and read them together.

        The first result holds the slope of Phi and the linear and quadratic coefficients of inertia and damping; the
        second result holds the limits of steps. ``_product`` becomes the product of the direction with the Hessian of
        damping.
        """
        damped, vectors = bool(quadratic.stiffness), (*state.vectors, start, direction)

        def make(run: Launcher, sums: ReadSums) -> list[Any]:
            """The products, dot products and limits along the direction."""
            launches = self.system.mass_launches(direction, self._of_mass, run)
            pairs = [(self.gradient_force, direction), (state.inertia, self._of_mass), (direction, self._of_mass)]
            if damped:
                launches += self.system.linear_launches(start, 0.0, run)
                launches += self.system.hessian_launches(direction, self._product, run)
                pairs += [(state.damping, direction), (direction, self._product)]
            for first, second in pairs:
                sums.add_dot(first.values, second.values)
            return launches + self.system.limit_launches(state.position, direction, run, sums)

        found = [float(value) for value in self.system.repeated.read(("look along", damped), vectors, make)]
        slope, linear, square = found[:3]
        square *= quadratic.mass
        if damped:
            linear, square = linear + quadratic.stiffness * found[3], square + quadratic.stiffness * found[4]
        return (-slope, linear, square), found[5 if damped else 3 :]

    def _search(
        self,
        position: MixedVector,
        direction: MixedVector,
        longest: float,
        slopes: tuple[float, float, float],
        before: Mapping[str, float],
    ) -> tuple[float, float, Mapping[str, float]]:
        """The largest of the steps s, s/2, s/4, ... that decreases Phi enough, the change of Phi, and the energies.

        ``slopes`` holds the slope of Phi and the linear and quadratic coefficients of inertia and damping. ``before``
        holds the energies at the position.
        """
        slope, linear, square = slopes
        noise = self._noise * max((abs(value) for value in before.values()), default=0.0)
        step = longest
        for _ in range(MOST_HALVINGS if step else 0):
            after = self._energies_along(position, step, direction)
            change = sum(after[name] - before[name] for name in before) + step * linear + 0.5 * step**2 * square
            if change <= DECREASE * step * slope:
                return step, change, after
            if change <= noise and self._slope_at_trial(direction) + linear + step * square <= RISE * -slope:
                return step, change, after
            step *= 0.5
        return 0.0, 0.0, before

    def _energies_along(self, position: MixedVector, step: float, direction: MixedVector) -> Mapping[str, float]:
        """The energies after a part of a direction, at ``_trial``; the launches for whole steps are captured."""
        if step != 1.0:
            set_sum(self._trial, 1.0, position, step, direction)
            return self.system.energies(self._trial)

        def make(run: Launcher, sums: ReadSums) -> list[Any]:
            moved = sum_launch(self._trial, 1.0, position, 1.0, direction, run)
            return [moved, *self.system.energy_launches(self._trial, run, sums)]

        found = self.system.repeated.read("whole step ahead", (self._trial, position, direction), make)
        return self.system.named_energies(found)

    def _slope_at_trial(self, direction: MixedVector) -> float:
        """Slope of the energy of all terms along the direction."""
        self.system.set_forces(self._trial, self._force)
        return -self.system.dot(self._force, direction)
