# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Borders: the loops at the edge of a garment keep their place (Y section 6.3, eq 5).

For each loop S_j of the border, a hard constraint:

    C_j = sum over i in S_j of q_i  -  sum over i in S_j of q0_i  =  0

The constraint acts on every control point of the loop with the same force, so each step loses that force times the
mobility of its point. The drift that the constraint removes is measured from the start, so that rounding errors do not
accumulate. The steps are then shortened to the step limits by one common factor, which keeps their mean at zero.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
import warp as wp
from scipy.sparse import csr_array, kron

from stitchmesh.compute.captured import Launcher
from stitchmesh.compute.kernel import kernel
from stitchmesh.compute.precision import Scalar, Vec3
from stitchmesh.mesh import StitchMesh
from stitchmesh.yarnrelax.energies.shape_patches import loops_of
from stitchmesh.yarnrelax.energies.term import Constraint, ConstraintChoice, Coupling
from stitchmesh.yarnrelax.model.constants import Model
from stitchmesh.yarnrelax.model.state import State


@kernel
def hold_loops(
    # model
    held: wp.array[wp.int32],
    loop_start: wp.array[wp.int32],
    loop_points: wp.array[wp.int32],
    home: wp.array[Vec3],
    # state in
    points: wp.array[Vec3],
    stiffness: wp.array[Scalar],
    limit: wp.array[Scalar],
    # state out
    step: wp.array[Vec3],
) -> None:
    """Remove the motion of the mean from the steps of each border loop, then shorten all steps by one factor."""
    loop = held[wp.tid()]
    first, last = loop_start[loop], loop_start[loop + 1]
    drift = type(points[0])()
    whole = limit[0] - limit[0]
    for k in range(first, last):
        i = loop_points[k]
        drift += points[i] + step[i] - home[i]
        whole += type(whole)(1.0) / stiffness[i]
    pull = drift / whole
    scale = type(whole)(1.0)
    for k in range(first, last):
        i = loop_points[k]
        step[i] = step[i] - pull / stiffness[i]
        length = wp.length(step[i])
        if length * scale > limit[i]:
            scale = limit[i] / length
    for k in range(first, last):
        step[loop_points[k]] = step[loop_points[k]] * scale


@kernel
def centre_forces(
    # model
    held: wp.array[wp.int32],
    loop_start: wp.array[wp.int32],
    loop_points: wp.array[wp.int32],
    # state out
    force: wp.array[Vec3],
) -> None:
    """Subtract the mean, which the constraint carries, from the forces of each border loop."""
    loop = held[wp.tid()]
    first, last = loop_start[loop], loop_start[loop + 1]
    mean = type(force[0])()
    for k in range(first, last):
        mean += force[loop_points[k]]
    mean = mean / type(mean[0])(last - first)
    for k in range(first, last):
        force[loop_points[k]] = force[loop_points[k]] - mean


@dataclass(frozen=True, eq=False)
class KeepBorders(ConstraintChoice):
    """The loops at the edge of a garment keep their place."""

    fabric: StitchMesh
    """The fabric from which the yarns were generated."""

    def on(self, model: Model) -> Borders:
        """Send the loops to the device of a model.

        Raises:
            ParameterError: the yarns were not generated from this fabric.
        """
        loops = loops_of(model.yarns, self.fabric)
        return Borders(
            held=model.integers(loops.held),
            loop_start=model.integers(loops.points.start),
            loop_points=model.integers(loops.points.entry),
            home=model.upload(model.to_device(model.yarns.points), 3),
        )


@dataclass(frozen=True, eq=False)
class Borders(Constraint):
    """Loops with a constant mean position, on the device."""

    held: wp.array[Any]
    """Numbers of the loops whose mean position is constant."""
    loop_start: wp.array[Any]
    """Where each loop's control points start, shape (L + 1,)."""
    loop_points: wp.array[Any]
    """Control points of the loops."""
    home: wp.array[Any]
    """Control points at the start, shape (N, 3)."""

    def filter_forces(self, force: wp.array[Any], launcher: Launcher) -> list[Any]:
        """Return the launch that subtracts the reactions of the border from the forces."""
        return [launcher(centre_forces, len(self.held), [self.held, self.loop_start, self.loop_points], [force])]

    def coupling(self) -> Coupling:
        """Return the rows that sum the coordinates of each loop."""
        return self._coupling

    @cached_property
    def _coupling(self) -> Coupling:
        start, points = self.loop_start.numpy(), self.loop_points.numpy()
        shape = len(start) - 1, len(self.home)
        loops = csr_array((np.ones(len(points)), points, start), shape=shape)
        return Coupling(csr_array(kron(loops[self.held.numpy()], np.eye(3))))

    def filter_steps(self, state: State, step: wp.array[Any], limit: wp.array[Any], launcher: Launcher) -> list[Any]:
        """Return the launch that removes the motion of the mean from the steps of each border loop."""
        inputs = [self.held, self.loop_start, self.loop_points, self.home, state.points, state.stiffness, limit]
        return [launcher(hold_loops, len(self.held), inputs, [step])]
