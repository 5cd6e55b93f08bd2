# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The forces of an iteration, from the contact samples to the sum at each control point.

Each control point gathers from its segments and their samples, always in the same order, so that no sum depends on the
order in which threads run.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Any

import warp as wp

from stitchmesh.compute.captured import Launcher
from stitchmesh.compute.kernel import kernel
from stitchmesh.compute.precision import Scalar, Vec3, Vec4, load_vector
from stitchmesh.yarnrelax.collision.narrow_phase import Candidates
from stitchmesh.yarnrelax.energies.contact import contact_forces
from stitchmesh.yarnrelax.energies.segment_forces import samples_and_segment_forces
from stitchmesh.yarnrelax.energies.term import OnYarns
from stitchmesh.yarnrelax.model.constants import Model, YarnConstants
from stitchmesh.yarnrelax.model.lattice_images import cell_of, rests
from stitchmesh.yarnrelax.model.spline import weight_row
from stitchmesh.yarnrelax.model.state import State


@wp.func
def leg_forces_on(leg_force: wp.array2d[Vec3], s: int, slot: int) -> Any:
    """Force of a segment's legs on the control point in a slot: the end of the leg before, the start of the next."""
    force = type(leg_force[0, 0])()
    if slot > 0:
        force += leg_force[slot - 1, s]
    if slot < 3:
        force -= leg_force[slot, s]
    return force


@wp.func
def sample_forces_on(model: YarnConstants, sample_force: wp.array[Vec4], s: int, slot: int) -> Any:
    """Force of a segment's samples on the control point in a slot, and the row sum of its stiffness."""
    total = type(sample_force[0])()
    first = model.sample_start[s]
    count = model.sample_start[s + 1] - first
    row = weight_row(model, count, 0)
    for k in range(count):
        total += load_vector(sample_force, first + k) * model.sample_basis[row + k][slot]
    return total


@wp.func
def gather_at(
    model: YarnConstants, i: int, point_stiffness: wp.array[Scalar], leg_force: wp.array2d[Vec3],
    sample_force: wp.array[Vec4], external_force: wp.array[Vec3], force: wp.array[Vec3], stiffness: wp.array[Scalar]
) -> None:  # fmt: skip
    """Write the force on a control point, and the row sum of stiffness there (``preconditioner``)."""
    slots = model.point_segments[i]
    total = type(leg_force[0, 0])()
    contact = type(sample_force[0])()
    for slot in range(4):
        s = slots[slot]
        if s >= 0:
            total += leg_forces_on(leg_force, s, slot)
            contact += sample_forces_on(model, sample_force, s, slot)
    if external_force.shape[0] > 0:
        total += external_force[i]
    force[i] = total + type(total)(contact[0], contact[1], contact[2])
    stiffness[i] = point_stiffness[i] + contact[3] * type(contact[3])(2.0)


@kernel
def gather_forces(
    # model
    model: YarnConstants,
    point_stiffness: wp.array[Scalar],
    # state in
    leg_force: wp.array2d[Vec3],
    sample_force: wp.array[Vec4],
    external_force: wp.array[Vec3],
    # state out
    force: wp.array[Vec3],
    stiffness: wp.array[Scalar],
) -> None:
    """Force on each control point, and the row sum of stiffness there."""
    i = wp.tid()
    if not rests(model.images, cell_of(model.images, wp.max(model.point_segments[i]))):
        gather_at(model, i, point_stiffness, leg_force, sample_force, external_force, force, stiffness)


@kernel
def clear_vectors(
    # state out
    vectors: wp.array[Vec3],
) -> None:
    """Set an array to zero, in a launch like others."""
    i = wp.tid()
    vectors[i] = type(vectors[0])()


def force_launches(
    model: Model,
    state: State,
    candidates: Candidates,
    terms: Sequence[OnYarns],
    point_stiffness: wp.array[Any],
    launcher: Launcher,
) -> list[Any]:
    """Return the launches that place the samples and leave the sum of all forces in ``state.force``."""
    launches = [segment_launch(model, state, (1.0, 1.0, 1.0), launcher)]
    launches.append(contact_launch(model, state, candidates, launcher))
    if terms:
        launches.append(launcher(clear_vectors, model.point_count, [], [state.external_force]))
        launches += [launch for term in terms for launch in term.forces(state, state.forces, launcher)]
    return [*launches, gather_launch(model, state, point_stiffness, launcher)]


def segment_launch(model: Model, state: State, terms: Iterable[float], launcher: Launcher) -> Any:
    """Return the launch that places samples and finds leg forces; ``terms``: 1 or 0 for stretch, length and bending."""
    kernel = samples_and_segment_forces(model.quadrature_points, state.cell_relaxes)
    outputs = [state.samples, state.leg_force, state.segment_block, state.segment_virial]
    return launcher(kernel, model.segment_count, [model.constants, model.numbers(*terms), state.points], outputs)


def contact_launch(model: Model, state: State, candidates: Candidates, launcher: Launcher) -> Any:
    """Return the launch that finds the contact force on each sample."""
    kernel = contact_forces(model.scalar, model.entries_at_once, state.cell_relaxes)
    inputs = [model.constants, candidates.count, candidates.lists, state.samples]
    outputs = [state.sample_force, state.sample_block, state.sample_virial]
    return launcher(kernel, model.sample_count, inputs, outputs)


def gather_launch(model: Model, state: State, point_stiffness: wp.array[Any], launcher: Launcher) -> Any:
    """Return the launch that sums leg forces, contact forces and external forces at the control points."""
    inputs = [model.constants, point_stiffness, state.leg_force, state.sample_force, state.external_force]
    return launcher(gather_forces, model.point_count, inputs, [state.force, state.stiffness])
