# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Motion in time: L's Algorithm 1 (section 3.1), semi-implicit Euler with lumped masses.

    v <- v + dt M^-1 (F - dD/dv),     x <- x + dt v

F are the forces of all energies, D is the dissipation (``damping``), dt the time step of all control points, and M the
mass. The mass m l of each segment is shared among its control points by (1, 11, 11, 1) / 24
(``material``). Constraints reduce the velocity together with the step. Time is in seconds and lengths are in units
(``constants``), so a mass m [g] is m unit^2 in erg s^2 / unit^2.

The common time step is the longest one that is stable and moves no control point too far.

Stability. Semi-implicit Euler with mass M, stiffness K and damping C is, in every mode,

    x_(n+1) - 2 x_n + x_(n-1) = - dt^2 M^-1 K x_n - dt M^-1 C (x_n - x_(n-1))

and stays bounded while dt^2 K + 2 dt C < 4 M. Row sums bound a matrix by its diagonal (Gershgorin). It is therefore
sufficient that at each control point, with w^2 = (row sum of K) / m and g = (row sum of C) / m,

    dt^2 w^2 + 2 dt g <= 4     or     dt <= 4 / (g + sqrt(g^2 + 4 w^2)),

which is 2 / w without damping. The stiffness belongs to the state before the step, and contacts become stiffer during
the step, so only a part of this time step is used.

Distance. Let a control point of velocity v and acceleration a move by at most e. Its time step is at most

    dt = [- |v| + sqrt(|v|^2 + 4 e |a|)] / (2 |a|)  =  2 e / (|v| + sqrt(|v|^2 + 4 e |a|))

which is L's eq (2), derived in its appendix A, with control points instead of samples. The weights of the spline are
not negative and sum to one, so that no sample moves farther than its control points. e is the smaller of two lengths:
the largest move of an iteration, and the remaining budget of the control point (``step_limit``).
"""

from __future__ import annotations

from typing import Any

import numpy as np
import warp as wp
from numpy.typing import NDArray

from stitchmesh.compute.captured import Launcher
from stitchmesh.compute.kernel import kernel
from stitchmesh.compute.precision import Scalar, Vec3, Vec4
from stitchmesh.compute.reduction import maximum, ordered_sum, strand_maxima, strands_for
from stitchmesh.errors import ParameterError
from stitchmesh.yarnrelax.collision.step_limit import measure_budget_use
from stitchmesh.yarnrelax.energies.evaluation import sample_forces_on
from stitchmesh.yarnrelax.model.constants import Model, YarnConstants
from stitchmesh.yarnrelax.model.material import point_masses
from stitchmesh.yarnrelax.model.state import USED_UP, room_left, shortened
from stitchmesh.yarnrelax.solvers.damping import ContactDamping, drag_on, drag_rows, segment_drag
from stitchmesh.yarnrelax.solvers.solver import Progress, Solver, SolverInputs

LONGEST_TIME_STEP = 4e-4
"""Longest time step [s] (L section 3.1)."""
STABLE_PART = wp.constant(0.8)
"""Part of the longest stable time step that is used. Measured on knitting without damping: at 0.8 and below the energy
stays within a few percent, at 1 the energy doubles."""


@wp.func
def stable_time(stiffness: Scalar, damping: Scalar) -> Any:
    """Longest stable time step for row sums of stiffness and damping over mass."""
    size = damping + wp.sqrt(damping * damping + type(damping)(4.0) * stiffness)
    return type(damping)(4.0 * STABLE_PART) / wp.max(size, type(damping)(1.0e-30))


@wp.func
def time_within(reach: Scalar, speed: Scalar, acceleration: Scalar) -> Any:
    """Longest time step that stays within a reach (L eq 2)."""
    fast = speed + wp.sqrt(speed * speed + type(speed)(4.0) * reach * acceleration)
    return type(speed)(2.0) * reach / wp.max(fast, type(speed)(1.0e-30))


@kernel
def set_time_step(
    # model
    bounds: wp.array[wp.float64],
    # state in
    maxima: wp.array[wp.float64],
    step_scale: wp.array[wp.float64],
    # state out
    clock: wp.array[wp.float64],
) -> None:
    """Set the shortest time step and advance the time; one thread. ``maxima`` are those of minus the time steps.

    ``bounds`` are the longest time step and the time at which the motion ends; there the time step is 0.
    """
    shortest = bounds[0]
    for k in range(maxima.shape[0]):
        if -maxima[k] < shortest:  # a value that is not a number is ignored here; the forces show it
            shortest = -maxima[k]
    step, left = shortest * step_scale[0], bounds[1] - clock[1]
    if step >= left:
        clock[0] = left
        clock[1] = bounds[1]
    else:
        clock[0] = step
        clock[1] = clock[1] + step


class Clock:
    """Time and the time step, on a device."""

    def __init__(self, count: int, device: wp.Device) -> None:
        """Start at time 0, for ``count`` control points."""
        self.now = wp.zeros(2, dtype=wp.float64, device=device)
        """The last time step, and the time since the start [s]."""
        self.step_scale = wp.ones(1, dtype=wp.float64, device=device)
        """Scale of time steps."""
        self.bounds = wp.array([LONGEST_TIME_STEP, np.inf], dtype=wp.float64, device=device)
        """Longest time step, and the time at which the motion ends [s]."""
        self.many = wp.zeros(strands_for(count), dtype=wp.float64, device=device)
        self.few = wp.zeros(32, dtype=wp.float64, device=device)  # partial results that the last thread combines

    def run_until(self, end: float, longest: float = LONGEST_TIME_STEP) -> None:
        """Let the motion end at a time, with time steps of at most ``longest`` [s]."""
        self.bounds.assign(np.array([min(longest, LONGEST_TIME_STEP), end]))

    def launches(self, longest: wp.array[Any], launcher: Launcher) -> list[Any]:
        """Return the launches that advance the time by the shortest of the control points' longest time steps."""
        largest, smallest = wp.float64(1.0), wp.float64(-1.0)
        return [
            launcher(strand_maxima, len(self.many), [smallest, longest], [self.many]),
            launcher(strand_maxima, len(self.few), [largest, self.many], [self.few]),
            launcher(set_time_step, 1, [self.bounds, self.few, self.step_scale], [self.now]),
        ]


@kernel
def accelerate(
    # model
    model: YarnConstants,
    step_limit: Scalar,
    mass: wp.array[Scalar],
    drag: wp.array[Vec4],
    drag_row: wp.array[Scalar],
    # state in
    points: wp.array[Vec3],
    listed_points: wp.array[Vec3],
    budget: wp.array[Scalar],
    force: wp.array[Vec3],
    velocity: wp.array[Vec3],
    sample_damping: wp.array[Vec4],
    # state out
    stiffness: wp.array[Scalar],
    acceleration: wp.array[Vec3],
    limit: wp.array[Scalar],
    longest: wp.array[Scalar],
) -> None:
    """Acceleration of each control point, its largest move, and its longest time step.

    The mass replaces the row sum of stiffness, because constraints distribute their reactions by the mass here.
    """
    i = wp.tid()
    slots = model.point_segments[i]
    net = force[i]
    loss = model.sample_basis[0] - model.sample_basis[0]
    for slot in range(4):
        s = slots[slot]
        if s >= 0:
            net += drag_on(model, drag, velocity, s, slot)
            if sample_damping.shape[0] > 0:
                loss += sample_forces_on(model, sample_damping, s, slot)
    here = mass[i]
    net = (net + type(net)(loss[0], loss[1], loss[2])) / here
    allowed = wp.min(step_limit, room_left(points, listed_points, budget, i))
    stable = stable_time(stiffness[i] / here, (drag_row[i] + loss[3] * type(here)(2.0)) / here)
    longest[i] = wp.min(stable, time_within(allowed, wp.length(velocity[i]), wp.length(net)))
    acceleration[i] = net
    limit[i] = allowed
    stiffness[i] = here


@kernel
def propose_moves(
    # state in
    clock: wp.array[wp.float64],
    acceleration: wp.array[Vec3],
    limit: wp.array[Scalar],
    # state out
    velocity: wp.array[Vec3],
    step: wp.array[Vec3],
) -> None:
    """New velocities and the moves that follow; the limit removes no more than rounding."""
    i = wp.tid()
    time_step = type(limit[i])(clock[0])
    velocity[i] = velocity[i] + acceleration[i] * time_step
    step[i] = shortened(velocity[i] * time_step, limit[i])


@kernel
def apply_moves(
    # state in
    clock: wp.array[wp.float64],
    step: wp.array[Vec3],
    # state out
    points: wp.array[Vec3],
    velocity: wp.array[Vec3],
) -> None:
    """Move, and find the velocity from the move after the constraints."""
    i = wp.tid()
    points[i] = points[i] + step[i]
    time_step = type(step[i][0])(clock[0])
    if time_step > type(time_step)(0.0):
        velocity[i] = step[i] / time_step


@kernel
def kinetic_energies(
    # model
    mass: wp.array[Scalar],
    # state in
    velocity: wp.array[Vec3],
    # state out
    energy: wp.array[Scalar],
) -> None:
    """Kinetic energy [erg] of each control point."""
    i = wp.tid()
    energy[i] = wp.dot(velocity[i], velocity[i]) * mass[i] * type(mass[i])(0.5)


class YarnDynamics(Solver):
    """Motion of yarns with mass.

    Raises:
        ParameterError: a yarn has no mass, or a cell is to relax.
    """

    needs_blocks = False
    stops_by_itself = False
    allowed_rise = 0.05

    def __init__(self, model: Model, further: NDArray[np.float64], strains: int = 0, *, alone: bool = True) -> None:
        """Begin with zero velocities; the stiffness of further terms is part of ``state.stiffness``."""
        if model.cell_count > 1:
            raise ParameterError("dynamics: cells move in one time; relax them one by one, or quasistatically")
        if strains:
            raise ParameterError("dynamics: a cell has no mass to relax with; use the solver quasistatic")
        count = model.point_count
        self.model = model
        self.mass = model.upload(point_masses(model) * model.unit**2)
        self.drag, self.drag_row = model.upload(segment_drag(model), 4), model.upload(drag_rows(model))
        self.damping, self.clock = ContactDamping(model), Clock(count, model.device)
        self.velocity, self.acceleration, self.step = (model.empty(count, 3) for _ in range(3))
        self.limit, self.longest = model.empty(count), model.empty(count)

    def launches(self, inputs: SolverInputs, launcher: Launcher) -> list[Any]:
        """Damp, accelerate, choose the time step, propose, constrain, move."""
        state, model, now = inputs.state, self.model, self.clock.now
        read = [model.constants, model.number(inputs.step_fraction), self.mass, self.drag, self.drag_row,
                state.points, state.listed_points, state.budget, state.force, self.velocity,
                self.damping.force]  # fmt: skip
        written = [state.stiffness, self.acceleration, self.limit, self.longest]
        launches = self.damping.launches(state, inputs.candidates, self.velocity, launcher)
        launches.append(launcher(accelerate, model.point_count, read, written))
        launches += self.clock.launches(self.longest, launcher)
        read = [now, self.acceleration, self.limit]
        launches.append(launcher(propose_moves, model.point_count, read, [self.velocity, self.step]))
        for constraint in inputs.constraints:
            launches += constraint.filter_steps(state, self.step, self.limit, launcher)
        launches.append(launcher(apply_moves, model.point_count, [now, self.step], [state.points, self.velocity]))
        return launches

    def restart(self, step_scale: NDArray[np.float64], cells: NDArray[np.bool_] | None = None) -> None:
        """Set velocities to zero, and scale time steps by ``step_scale``."""
        self.velocity.zero_()
        self.set_step_scale(step_scale)

    def set_step_scale(self, step_scale: NDArray[np.float64]) -> None:
        """Scale time steps by ``step_scale``."""
        self.clock.step_scale.fill_(float(step_scale[0]))

    def begin(self, wanted: NDArray[np.int64], done: int = 0) -> None:
        """Count iterations from ``done``."""
        self.done = done

    def progress(self, inputs: SolverInputs, launched: int) -> Progress:
        """Count the launched iterations, and measure how far control points have moved on these candidate lists."""
        self.done += launched
        state = inputs.state
        used = self.model.empty(len(state.points))
        self.model.launch(measure_budget_use, len(used), [state.points, state.listed_points, state.budget], [used])
        used_up = np.array([maximum(used) > USED_UP])
        return Progress(np.array([self.done]), used_up, used_up)

    def arrays(self) -> dict[str, wp.array[Any]]:
        """Return velocities [unit / s], time step and time [s], and the scale of time steps."""
        return {"velocity": self.velocity, "clock": self.clock.now, "step_scale": self.clock.step_scale}

    @property
    def time(self) -> float:
        """Time since the start [s]."""
        return float(self.clock.now.numpy()[1])

    @property
    def time_step(self) -> float:
        """The last time step [s]."""
        return float(self.clock.now.numpy()[0])

    def kinetic_energy(self) -> float:
        """Return the kinetic energy [erg]."""
        energy = self.model.empty(self.model.point_count)
        self.model.launch(kinetic_energies, len(energy), [self.mass, self.velocity], [energy])
        return ordered_sum(energy)
