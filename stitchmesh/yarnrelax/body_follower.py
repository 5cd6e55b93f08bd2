# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The simulation of yarns that follow a moving body, from one frame of the body to the next.

In a time step the surface moves by at most a fifth of the reach of a contact sample. It therefore cannot pass a sample
between two evaluations of the forces. Candidate lists and step budgets are the same as in a relaxation
(``relaxation_loop``), so no yarn passes through another one.

The body may carry control points (``motion.carried_points``). The body takes the whole force on such a point, and the
step of the point leads to its place on the body. A waistband or a seam that is sewn on holds yarn in this way.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
import warp as wp
from numpy.typing import NDArray

from stitchmesh.compute.captured import Launcher
from stitchmesh.compute.kernel import kernel
from stitchmesh.compute.precision import Scalar, Vec3
from stitchmesh.errors import SolverError
from stitchmesh.quality import Quality
from stitchmesh.yarn import YarnSet
from stitchmesh.yarnrelax.collision.step_limit import smallest_distances, yarn_place
from stitchmesh.yarnrelax.constraints.pins import held_coordinates, hold, pinned_points
from stitchmesh.yarnrelax.energies.body import DEPTH
from stitchmesh.yarnrelax.energies.term import Constraint, Coupling, YarnChoice
from stitchmesh.yarnrelax.loop_state import carried_arrays, resume_from_arrays
from stitchmesh.yarnrelax.model.constants import Model
from stitchmesh.yarnrelax.model.material import YarnMaterial
from stitchmesh.yarnrelax.model.spline import place_contact_samples
from stitchmesh.yarnrelax.model.state import State, shortened
from stitchmesh.yarnrelax.motion.carried_points import CarryingSurface
from stitchmesh.yarnrelax.motion.moving_body import MovingBody, MovingBodyTerm
from stitchmesh.yarnrelax.motion.moving_surface import MovingSurface
from stitchmesh.yarnrelax.relaxation_loop import RelaxationLoop
from stitchmesh.yarnrelax.simulation import YarnSimulation
from stitchmesh.yarnrelax.solvers.dynamics import YarnDynamics


@kernel
def carry(
    # model
    carried: wp.array[wp.int32],
    # state in
    places: wp.array[Vec3],
    points: wp.array[Vec3],
    limit: wp.array[Scalar],
    # state out
    step: wp.array[Vec3],
) -> None:
    """Step of each carried point to its place on the body, no longer than its limit."""
    k = wp.tid()
    i = carried[k]
    step[i] = shortened(places[k] - points[i], limit[i])


class CarriedPoints(Constraint):
    """Control points that a body carries, on a device."""

    def __init__(self, model: Model, surface: MovingSurface, points: NDArray[np.int64]) -> None:
        """Bind the control points where the yarns were given; the surface is at its first time."""
        self.carried = model.integers(points)
        self._coupling = held_coordinates(self.carried, model.point_count)
        self.surface = CarryingSurface(model, surface.topology, surface.constants.corners)
        self.places = model.upload(model.to_device(model.yarns.points[points]), 3)
        """Where the body carries the points [units], shape (n, 3)."""
        self.bound = self.surface.bind(self.places)
        self._frames = model.empty(len(points), 3), model.empty(len(points), 3)

    def filter_forces(self, force: wp.array[Any], launcher: Launcher) -> list[Any]:
        """Return the launch that sets the forces on carried points to zero."""
        return [launcher(hold, len(self.carried), [self.carried], [force])]

    def coupling(self) -> Coupling:
        """Return a row for each coordinate of the carried points."""
        return self._coupling

    def filter_steps(self, state: State, step: wp.array[Any], limit: wp.array[Any], launcher: Launcher) -> list[Any]:
        """Return the launches that lead carried points to their places on the body."""
        return [
            *self.surface.launches(launcher),
            self.bound.launch(self.places, *self._frames, launcher),
            launcher(carry, len(self.carried), [self.carried, self.places, state.points, limit], [step]),
        ]


@dataclass(frozen=True, eq=False)
class FollowInputs:
    """The inputs that decide a run."""

    yarns: YarnSet
    body: MovingBody
    material: YarnMaterial
    """The material, with the drag as its global damping."""
    quality: Quality
    terms: tuple[YarnChoice, ...]
    device: wp.Device


@dataclass(frozen=True, eq=False)
class FollowState:
    """A run between two frames of the body."""

    frame: int
    """Frame of the body."""
    steps: int
    """Number of time steps so far."""
    margin: float
    """Margin of the candidate lists [units]."""
    lists_age: int
    """Iterations since the candidate lists were made."""
    arrays: Mapping[str, NDArray[Any]]
    """``carried_arrays`` by name."""


class BodyFollower:
    """Yarns and a moving body on a device."""

    def __init__(self, inputs: FollowInputs) -> None:
        """Place the yarns at rest where they were given, and the body at its first time.

        Raises:
            ParameterError: a choice does not fit the yarns.
            SolverError: yarns are too close to each other, or too deep in the body.
        """
        self.inputs, self.times = inputs, inputs.body.moving.motion.times
        terms = [*inputs.terms, inputs.body]
        self.simulation = YarnSimulation.start(inputs.yarns, inputs.material, inputs.quality, inputs.device, terms)
        term, solver = self.simulation.terms[-1], self.simulation.solver
        assert isinstance(term, MovingBodyTerm)
        assert isinstance(solver, YarnDynamics)
        self.term, self.solver = term, solver
        if inputs.body.carried is not None:
            points = pinned_points(inputs.yarns, inputs.body.carried)
            self.simulation.constraints.append(CarriedPoints(self.simulation.model, term.surface, points))
        self.loop = RelaxationLoop(self.simulation, inputs.quality.tolerance)
        self.frame, self.steps = 0, 0
        term.surface.clock = solver.clock.now
        solver.clock.now.assign(np.array([0.0, float(self.times[0])]))
        self.gap = self._checked_gap()

    def advance(self) -> None:
        """Simulate to the next frame of the body.

        Raises:
            SolverError: a number is not finite, or a yarn is too deep in the body; the message names the frame.
        """
        end, surface = float(self.times[self.frame + 1]), self.term.surface
        surface.begin(self.frame)
        self.term.forget_distances()
        self.solver.clock.run_until(end, self._longest_step())
        while self.solver.time < end:
            self.loop.iterate(1)
            self.steps += self.simulation.graph_iterations
        surface.place()
        self.frame += 1
        self.gap = self._checked_gap()

    def yarns(self) -> YarnSet:
        """The yarns at the present frame."""
        return self.simulation.current_yarns()

    def report(self) -> dict[str, Any]:
        """Return figures of the present frame as plain numbers."""
        simulation = self.simulation
        self.loop.search_contacts()
        nearest = smallest_distances(simulation.model, simulation.state, simulation.candidates)
        return {
            "frame": self.frame,
            "time": float(self.times[self.frame]),
            "steps": self.steps,
            "kinetic_energy": self.solver.kinetic_energy(),
            "min_distance_over_radius": float(nearest[0]),
            "body_gap_over_reach": self.gap,
        }

    def state(self) -> FollowState:
        """Return everything that decides how the run continues after the present frame."""
        arrays = {name: array.numpy() for name, array in carried_arrays(self.simulation).items()}
        margin = float(self.simulation.candidates.margins[0])
        return FollowState(self.frame, self.steps, margin, int(self.loop.lists_age[0]), arrays)

    def resume(self, state: FollowState) -> None:
        """Continue from a state of the same run.

        Raises:
            ParameterError: an array is missing or has another shape.
        """
        resume_from_arrays(self.simulation, state.arrays, state.margin)
        self.loop.lists_age[0] = state.lists_age
        self.frame = state.frame
        self.steps = state.steps
        self.term.surface.begin(max(self.frame - 1, 0))

    def _longest_step(self) -> float:
        """Time in which the surface moves by a fifth of the smallest reach [s]."""
        speed = self.term.surface.speed(self.frame)
        reach = float(self.simulation.model.radius.min() + float(self.term.thickness))
        return 0.2 * reach / speed if speed > 0.0 else np.inf

    def _checked_gap(self) -> float:
        """Return the smallest signed distance of a sample from the body, over the reach of the sample.

        Raises:
            SolverError: the distance is not finite, or so small that the body cannot push the yarn out any more.
        """
        simulation, model = self.simulation, self.simulation.model
        place_contact_samples(model, simulation.state, model.launch)
        frame = f"frame {self.frame} ({self.times[self.frame]:g} s)"
        if not np.isfinite(simulation.state.points.numpy()).all():
            raise SolverError(f"{frame}: got positions that are not finite; expected finite ones; raise the drag")
        gaps = self.term.gaps(simulation.state)
        least = int(gaps.argmin())
        if self.term.closed and gaps[least] < -DEPTH:
            segment = int(np.searchsorted(model.sample_start, least, side="right") - 1)
            where = yarn_place(model.yarns, int(model.yarns.segment_points[segment, 1]))
            found = f"{-gaps[least]:.3g} reaches inside the body; expected at most {float(DEPTH):g}"
            raise SolverError(f"{frame}: {where}: {found}; give the body more frames, or move the yarns out of it")
        return float(gaps[least])
