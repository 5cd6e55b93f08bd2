# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Motion in time by backward Euler (Casafranca et al. 2020, section 4.3).

With positions x_n and velocities u_n, a time step h and Rayleigh damping by mass (a) and by stiffness (b), the
displacement d = h u of the step minimizes the incremental potential

    V(x_n + d) + 1/(2 h^2) |d - h u_n|_M^2 + a/(2 h) |d|_M^2 + b/(2 h) d' K_n d

over the motions p = B v + F x, where fixed coordinates have their prescribed displacements. The first guess is h u_n,
or zero where zero has the lower potential. The step ends when the error of the velocities is small. This error is the
root of r . z over the mass of the system, for the remaining force r and the motion z that the preconditioner finds for
it.

The matrix of an iteration is the Hessian of V at its positions, plus b / h times the Hessian that is never negative,
plus inertia. It has directions of negative curvature only where damping and inertia do not outweigh them.

Where Newton's method does not converge, the step begins again with half its length. After some steps that converge fast
the length grows again. A run depends on its state alone: a run that is stopped and resumed gives the same bits.

*First guess.* Fixed coordinates have their prescribed displacement in both cases, and the guess goes no farther than
the terms allow. Numbers that depend on the length of the step lie on the device, so that the launches are captured
once.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
import warp as wp
from numpy.typing import NDArray

from stitchmesh.compute.captured import Launcher
from stitchmesh.compute.kernel import kernel
from stitchmesh.compute.precision import Scalar
from stitchmesh.errors import ParameterError, SolverError
from stitchmesh.mixed.dynamics.mixed_system import MixedSystem
from stitchmesh.mixed.dynamics.newton import NewtonState, Quadratic, SystemNewton
from stitchmesh.mixed.dynamics.vector_sums import ReadSums, set_sum
from stitchmesh.mixed.mixed_vector import MixedVector, Parts
from stitchmesh.mixed.term import resume_terms, term_arrays
from stitchmesh.simulation.term import check_arrays


@kernel
def guess_displacement(
    # model
    numbers: wp.array[Scalar],
    moves: wp.array[wp.int32],
    # state in
    velocity: wp.array[Scalar],
    fixed: wp.array[Scalar],
    # state out
    displacement: wp.array[Scalar],
) -> None:
    """The velocity times ``numbers[0]`` where coordinates move, and the prescribed displacement elsewhere."""
    i = wp.tid()
    displacement[i] = wp.where(moves[i] != 0, numbers[0] * velocity[i], fixed[i])


@kernel
def guess_state(
    # model
    numbers: wp.array[Scalar],
    # state in
    start: wp.array[Scalar],
    velocity: wp.array[Scalar],
    displacement: wp.array[Scalar],
    # state out
    position: wp.array[Scalar],
    inertia: wp.array[Scalar],
) -> None:
    """Positions after a displacement d, and the vector of inertia m d - u / h, with m and 1 / h in ``numbers``."""
    i = wp.tid()
    position[i] = start[i] + displacement[i]
    inertia[i] = numbers[1] * displacement[i] - numbers[2] * velocity[i]


class FirstGuess:
    """The first guesses of the steps of a motion."""

    def __init__(
        self, system: MixedSystem, positions: MixedVector, velocities: MixedVector, state: NewtonState
    ) -> None:
        """Allocate.

        Args:
            system: terms, masses and unknowns.
            positions: positions at the beginning of each step.
            velocities: velocities at the beginning of each step.
            state: the state that ``set`` sets to the guess.
        """
        self._system, self._positions, self._velocities, self._state = system, positions, velocities, state
        self._product, self._fixed = system.zeros(), system.zeros()
        self._numbers = wp.zeros(3, dtype=system.scalar, device=system.device)
        self._numbers_now = (0.0, 0.0, 0.0)

    def set(self, h: float, quadratic: Quadratic, fixed: MixedVector) -> None:
        """Set the state to the guess of a step.

        Args:
            h: length of the step [s].
            quadratic: coefficients of inertia and damping.
            fixed: displacements of fixed coordinates.
        """
        state, system = self._state, self._system
        self._fixed.assign(fixed)
        self._guess(h, h, quadratic)
        part = system.step_limit(self._positions, state.displacement)
        without = self._potential_of(0.0, h, quadratic)
        if part > 0.0 and self._potential_of(part * h, h, quadratic) > without:
            self._guess(0.0, h, quadratic)
        self._set_damping(bool(quadratic.stiffness))

    def _guess(self, time: float, h: float, quadratic: Quadratic) -> None:
        """Set the state to the motion over a time, and to the prescribed motion of fixed coordinates."""
        self._set_numbers(time, h, quadratic)
        self._system.repeated.run("guess", (*self._state.vectors, self._positions), lambda run, _: self._launches(run))

    def _potential_of(self, time: float, h: float, quadratic: Quadratic) -> float:
        """Set the state to the guess, and return its potential without damping by stiffness [erg]."""
        self._set_numbers(time, h, quadratic)
        system, state = self._system, self._state

        def make(run: Launcher, sums: ReadSums) -> list[Any]:
            sums.add_dot(state.inertia.values, self._product.values)
            mass = system.mass_launches(state.inertia, self._product, run)
            return [*self._launches(run), *mass, *system.energy_launches(state.position, run, sums)]

        square, *energies = system.repeated.read("guessed potential", (*state.vectors, self._positions), make)
        return sum(system.named_energies(energies).values()) + float(square) / (2 * quadratic.mass)

    def _set_numbers(self, time: float, h: float, quadratic: Quadratic) -> None:
        """Send the numbers of both kernels to the device."""
        numbers = time, quadratic.mass, 1.0 / h
        if numbers != self._numbers_now:
            self._numbers.assign(numbers)
            self._numbers_now = numbers

    def _launches(self, run: Launcher) -> list[Any]:
        """The launches that set displacement, position and inertia."""
        system, displacement, velocity = self._system, self._state.displacement, self._velocities.values
        moved = [self._numbers, system.moves, velocity, self._fixed.values]
        placed = [self._numbers, self._positions.values, velocity, displacement.values]
        outputs = [self._state.position.values, self._state.inertia.values]
        return [
            run(guess_displacement, len(velocity), moved, [displacement.values]),
            *system.motion_launches(displacement, run),
            run(guess_state, len(velocity), placed, outputs),
        ]

    def _set_damping(self, damped: bool) -> None:
        """Set the force of damping of the displacement; zero without damping by stiffness."""
        system, state, start = self._system, self._state, self._positions

        def make(run: Launcher, _sums: ReadSums) -> list[Any]:
            linear = system.linear_launches(start, 0.0, run)
            return [*linear, *system.hessian_launches(state.displacement, state.damping, run)]

        if damped:
            system.repeated.run("guessed damping", (start, state.displacement, state.damping), make)
        else:
            state.damping.values.zero_()


CALM_STEPS = 4
"""Steps in a row that converge fast, after which the time step grows."""
GROWTH = 1.25
"""Factor by which the time step grows."""
FEW_ITERATIONS = 5
"""Newton iterations of a step that converges fast."""

PrescribedMotion = Callable[[float, float], Parts]
"""From the times [s] at which a step begins and ends to the displacements of vertices, nodes and Eulerian coordinates
[cm]; only the displacements of fixed coordinates are used. Unlike velocities, they add up without drift."""


@dataclass(frozen=True)
class DynamicsSettings:
    """Settings of a motion in time.

    Raises:
        ParameterError: a value is out of range.
    """

    time_step: float = 1e-3
    """Largest time step [s]."""
    smallest_time_step: float = 1e-8
    """Time step below which the run ends with an error [s]."""
    damping_mass: float = 0.0
    """Rayleigh damping in proportion to the mass [1/s]."""
    damping_stiffness: float = 0.0
    """Rayleigh damping in proportion to the stiffness [s]."""
    velocity_tolerance: float = 1e-2
    """Root mean square error of the velocities at which a step ends [cm/s]."""
    most_newton_iterations: int = 20
    """Newton iterations after which the step is halved."""
    solve_tolerance: float = 1e-2
    """Relative tolerance of the linear solves."""
    most_solve_iterations: int = 2000
    """Largest number of products of a linear solve."""
    exact_hessian: bool = True
    """Whether the matrix is the exact Hessian as long as no direction of negative curvature is met."""
    stiffness_in_metric: bool = True
    """Whether the preconditioner contains the diagonal of the Hessian for positions too, not only for Eulerian
    coordinates."""

    def __post_init__(self) -> None:
        positive = ("time_step", "smallest_time_step", "velocity_tolerance", "solve_tolerance")
        for name in (*positive, "damping_mass", "damping_stiffness", "most_newton_iterations", "most_solve_iterations"):
            value = getattr(self, name)
            least = "above 0" if name in positive else ("at least 1" if name.startswith("most") else "at least 0")
            wrong = value <= 0 if least == "above 0" else value < (1 if name.startswith("most") else 0)
            if wrong or not np.isfinite(value):
                raise ParameterError(f"dynamics: {name}: got {value}; expected a number {least}")


@dataclass(frozen=True)
class StepReport:
    """The report of a step."""

    time: float
    """Time at its end [s]."""
    time_step: float
    """Its length [s]."""
    newton_iterations: int
    """Newton iterations of the accepted attempt."""
    solve_iterations: int
    """Products with the matrix, of all attempts."""
    halvings: int
    """Number of attempts that did not converge."""
    velocity_error: float
    """Root mean square error of the velocities [cm/s]."""


class Dynamics:
    """A motion in time."""

    def __init__(
        self,
        system: MixedSystem,
        positions: MixedVector,
        settings: DynamicsSettings | None = None,
        *,
        velocities: MixedVector | None = None,
        prescribed: PrescribedMotion | None = None,
    ) -> None:
        """Start a motion at time 0.

        Args:
            system: terms, masses and unknowns.
            positions: positions at the beginning; copied.
            settings: time step, damping and tolerances.
            velocities: velocities at the beginning, zero by default; copied.
            prescribed: displacements of fixed coordinates, zero by default.
        """
        self.system, self.settings = system, settings or DynamicsSettings()
        self.positions = positions.copy()
        self.velocities = positions.like() if velocities is None else velocities.copy()
        self.time, self.time_step, self.calm_steps = 0.0, self.settings.time_step, 0
        self._prescribed = prescribed
        self._refusal: SolverError | None = None
        self._newton = SystemNewton(system)
        self._state = NewtonState(*(system.zeros() for _ in range(4)))
        self._still = system.zeros()
        self._guess = FirstGuess(system, self.positions, self.velocities, self._state)

    def step(self) -> StepReport:
        """Advance by one time step.

        Raises:
            SolverError: the time step has become smaller than its lower bound; if a term refuses even such a step, its
                own error is raised.
        """
        halvings, products = 0, 0
        while True:
            report = self._attempt(products, halvings)
            products = report.solve_iterations
            if report.velocity_error <= self.settings.velocity_tolerance:
                return report
            halvings, self.calm_steps = halvings + 1, 0
            self.time_step *= 0.5
            if self.time_step < self.settings.smallest_time_step:
                if self._refusal is not None:
                    raise self._refusal
                found = f"Newton's method does not converge at time {self.time:.6g} s"
                least = self.settings.smallest_time_step
                raise SolverError(f"dynamics: {found} with time steps down to {least:.3g} s: check loads and contacts")

    def energies(self) -> dict[str, float]:
        """Energy of each term and kinetic energy [erg] by name."""
        kinetic = 0.5 * self.system.dot(self.velocities, self._mass_times_velocities())
        return {**self.system.energies(self.positions), "kinetic": kinetic}

    def _mass_times_velocities(self) -> MixedVector:
        """M u with the masses at the present positions, which a new step or a resumed run computes again, too."""
        product = self.positions.like()
        self.system.update_masses(self.positions)
        self.system.set_mass_product(self.velocities, product)
        return product

    def arrays(self) -> dict[str, NDArray[Any]]:
        """All arrays that the rest of the run depends on, by name, for stopping and resuming."""
        result = {"positions": self.positions.values.numpy(), "velocities": self.velocities.values.numpy()}
        result["clock"] = np.array([self.time, self.time_step, self.calm_steps], dtype=np.float64)
        return result | term_arrays(self.system.terms)

    def resume(self, arrays: Mapping[str, NDArray[Any]]) -> None:
        """Restore the contents of ``arrays``.

        Raises:
            ParameterError: an array is missing or has another shape.
        """
        check_arrays({name: array.shape for name, array in self.arrays().items()}, arrays)
        self.positions.values.assign(arrays["positions"])
        self.velocities.values.assign(arrays["velocities"])
        self.time, self.time_step = (float(value) for value in arrays["clock"][:2])
        self.calm_steps = int(arrays["clock"][2])
        resume_terms(self.system.terms, arrays)

    def _attempt(self, products: int, halvings: int) -> StepReport:
        """Solve a step of the current length, and accept it if it converges."""
        h, self._refusal = self.time_step, None
        self.system.update_masses(self.positions)
        iterations, solves, error = 0, 0, np.inf
        try:
            for term in self.system.terms:
                term.begin_step(self.positions, self.time, h)
            iterations, solves, error = self._solve(h)
        except SolverError as refusal:  # for example a body that moves too far in this step
            self._refusal = refusal
        report = StepReport(self.time + h, h, iterations, products + solves, halvings, error)
        if error <= self.settings.velocity_tolerance:
            self._accept(report)
        return report

    def _solve(self, h: float) -> tuple[int, int, float]:
        """Minimize the incremental potential; return Newton iterations, products and the error of the velocities."""
        settings, newton, state = self.settings, self._newton, self._state
        quadratic = Quadratic(1.0 / h**2 + settings.damping_mass / h, settings.damping_stiffness / h)
        self._guess.set(h, quadratic, self._prescribed_motion(h))
        exact, solves, stuck = float(settings.exact_hessian), 0, False
        elastic = 1.0 / (1.0 + quadratic.stiffness)
        energies: Mapping[str, float] | None = None
        for iteration in range(settings.most_newton_iterations + 1):
            newton.set_downhill_force(state, quadratic)
            error = h * self.system.velocity_rms(newton.gradient_force)
            if error <= settings.velocity_tolerance or stuck or iteration == settings.most_newton_iterations:
                return iteration, solves, error
            if not np.isfinite(error):
                return iteration, solves, np.inf
            if iteration == 0:
                factors = quadratic.mass, 1.0 + quadratic.stiffness
                self.system.set_factors(*factors, state.position, stiffness_in_metric=settings.stiffness_in_metric)
            self.system.linearize(state.position, exact * elastic, 1.0 - elastic)
            tolerances = settings.solve_tolerance, settings.most_solve_iterations
            report = newton.iterate(state, self.positions, quadratic, *tolerances, energies)
            energies = report.energies
            solves, stuck = solves + report.solve.iterations, report.step == 0.0 and exact == 0.0
            exact = 0.0 if report.solve.negative or report.step == 0.0 else float(settings.exact_hessian)
        return settings.most_newton_iterations, solves, np.inf

    def _prescribed_motion(self, h: float) -> MixedVector:
        """Displacements of fixed coordinates in a step of length ``h``."""
        if self._prescribed is None:
            return self._still
        v, p, s = self._prescribed(self.time, self.time + h)
        return MixedVector.from_numpy(v, p, s, self.system.scalar, self.system.device)

    def _accept(self, report: StepReport) -> None:
        """Take over the positions and velocities of a step; lengthen the next step after a row of calm ones."""
        h = report.time_step
        self.positions.assign(self._state.position)
        set_sum(self.velocities, 1.0 / h, self._state.displacement, 0.0, self._state.displacement)
        for term in self.system.terms:
            term.end_step(self.positions, report.time, h)
        self.time = report.time
        self.calm_steps = self.calm_steps + 1 if report.newton_iterations <= FEW_ITERATIONS else 0
        if self.calm_steps >= CALM_STEPS and self.time_step < self.settings.time_step:
            self.time_step = min(self.time_step * GROWTH, self.settings.time_step)
            self.calm_steps = 0
