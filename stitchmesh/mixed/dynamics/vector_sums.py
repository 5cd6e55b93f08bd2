# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Sums of whole vectors of the mixed system."""

from __future__ import annotations

from typing import Any

import numpy as np
import warp as wp

from stitchmesh.compute.kernel import kernel
from stitchmesh.compute.launch import launch
from stitchmesh.compute.reduction import maximum, minimum
from stitchmesh.mixed.mixed_vector import MixedVector


@kernel
def scaled_sums(
    # model
    of_first: Any,
    of_second: Any,
    # state in
    first: wp.array[Any],
    second: wp.array[Any],
    # state out
    result: wp.array[Any],
) -> None:
    """Find a x + b y; the result may be one of the arguments."""
    i = wp.tid()
    result[i] = of_first * first[i] + of_second * second[i]


@kernel
def chosen(
    # model
    moves: wp.array[wp.int32],
    # state in
    free: wp.array[Any],
    fixed: wp.array[Any],
    # state out
    result: wp.array[Any],
) -> None:
    """Take one vector where coordinates move and the other one elsewhere; the result may be one of the arguments."""
    i = wp.tid()
    result[i] = wp.where(moves[i] != 0, free[i], fixed[i])


@kernel
def moved_state(
    # model
    step: Any,
    of_inertia: Any,
    # state in
    direction: wp.array[Any],
    # state in and out
    position: wp.array[Any],
    displacement: wp.array[Any],
    inertia: wp.array[Any],
) -> None:
    """Add a part of a direction to positions and displacements, and another part to the vector of inertia."""
    i = wp.tid()
    position[i] = position[i] + step * direction[i]
    displacement[i] = displacement[i] + step * direction[i]
    inertia[i] = inertia[i] + of_inertia * direction[i]


@kernel
def remaining_force(
    # model
    of_damping: Any,
    # state in
    of_inertia: wp.array[Any],
    damping: wp.array[Any],
    # state in and out
    force: wp.array[Any],
) -> None:
    """Subtract forces of inertia and damping from a force."""
    i = wp.tid()
    force[i] = force[i] - of_inertia[i] - of_damping * damping[i]


def set_sum(result: MixedVector, of_first: float, first: MixedVector, of_second: float, second: MixedVector) -> None:
    """Set a vector to a x + b y; it may be one of the arguments."""
    numbers = [result.scalar(of_first), result.scalar(of_second)]
    count = len(result.values)
    launch(scaled_sums, count, [*numbers, first.values, second.values], [result.values], result.device)


def subtract_forces(force: MixedVector, of_inertia: MixedVector, of_damping: float, damping: MixedVector) -> None:
    """Subtract the force of inertia, and ``of_damping`` times a vector, from a force."""
    inputs = [force.scalar(of_damping), of_inertia.values, damping.values]
    launch(remaining_force, len(force.values), inputs, [force.values], force.device)


def choose(result: MixedVector, moves: wp.array[wp.int32], free: MixedVector, fixed: MixedVector) -> None:
    """Set a vector to ``free`` where coordinates move and to ``fixed`` elsewhere; it may be one of the arguments."""
    launch(chosen, len(moves), [moves, free.values, fixed.values], [result.values], result.device)


def move(
    position: MixedVector,
    displacement: MixedVector,
    inertia: MixedVector,
    step: float,
    of_inertia: float,
    direction: MixedVector,
) -> None:
    """Add ``step`` times a direction to positions and displacements, and ``of_inertia`` times it to ``inertia``."""
    scalar = position.scalar
    inputs = [scalar(step), scalar(of_inertia), direction.values]
    outputs = [position.values, displacement.values, inertia.values]
    launch(moved_state, len(position.values), inputs, outputs, position.device)


def largest(vector: MixedVector) -> float:
    """Largest absolute value of a vector; not a number where one of them is not."""
    return float(np.maximum(maximum(vector.values), -minimum(vector.values))) if len(vector.values) else 0.0
