# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The first guess of a step of backward Euler: the motion h u_n, or zero where zero has the lower potential.

Fixed coordinates have their prescribed displacement in both cases, and the guess goes no farther than the terms allow.
Numbers that depend on the length of the step lie on the device, so that the launches are captured once.
"""

from __future__ import annotations

from typing import Any

import warp as wp

from stitchmesh.compute.captured import Launcher
from stitchmesh.compute.kernel import kernel
from stitchmesh.mixed.dynamics.mixed_system import MixedSystem
from stitchmesh.mixed.dynamics.newton import NewtonState, Quadratic
from stitchmesh.mixed.dynamics.vector_sums import ReadSums
from stitchmesh.mixed.mixed_vector import MixedVector


@kernel
def guess_displacement(
    # model
    numbers: wp.array[Any],
    moves: wp.array[wp.int32],
    # state in
    velocity: wp.array[Any],
    fixed: wp.array[Any],
    # state out
    displacement: wp.array[Any],
) -> None:
    """The velocity times ``numbers[0]`` where coordinates move, and the prescribed displacement elsewhere."""
    i = wp.tid()
    displacement[i] = wp.where(moves[i] != 0, numbers[0] * velocity[i], fixed[i])


@kernel
def guess_state(
    # model
    numbers: wp.array[Any],
    # state in
    start: wp.array[Any],
    velocity: wp.array[Any],
    displacement: wp.array[Any],
    # state out
    position: wp.array[Any],
    inertia: wp.array[Any],
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
