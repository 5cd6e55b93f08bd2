# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Sums of whole vectors of the mixed system, and numbers that the host reads back together.

Launches compute sums, dot products and minima in a fixed order. On a GPU a reading costs as much time as some launches,
so numbers that are needed together are read together.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial
from typing import Any

import numpy as np
import warp as wp
from numpy.typing import NDArray

from stitchmesh.compute.captured import Launcher
from stitchmesh.compute.host_copy import HostCopy
from stitchmesh.compute.kernel import kernel
from stitchmesh.compute.launch import launch
from stitchmesh.compute.partial_sums import WIDTH, chunk_of, dot_parts, least_parts, part_count, sum_parts, total_parts
from stitchmesh.compute.precision import Scalar
from stitchmesh.compute.reduction import maximum, minimum
from stitchmesh.mixed.mixed_vector import MixedVector


@kernel
def scaled_sums(
    # model
    of_first: Scalar,
    of_second: Scalar,
    # state in
    first: wp.array[Scalar],
    second: wp.array[Scalar],
    # state out
    result: wp.array[Scalar],
) -> None:
    """Find a x + b y; the result may be one of the arguments."""
    i = wp.tid()
    result[i] = of_first * first[i] + of_second * second[i]


@kernel
def chosen(
    # model
    moves: wp.array[wp.int32],
    # state in
    free: wp.array[Scalar],
    fixed: wp.array[Scalar],
    # state out
    result: wp.array[Scalar],
) -> None:
    """Take one vector where coordinates move and the other one elsewhere; the result may be one of the arguments."""
    i = wp.tid()
    result[i] = wp.where(moves[i] != 0, free[i], fixed[i])


@kernel
def moved_state(
    # model
    step: Scalar,
    factors: wp.array[Scalar],
    # state in
    direction: wp.array[Scalar],
    of_damping: wp.array[Scalar],
    # state in and out
    position: wp.array[Scalar],
    displacement: wp.array[Scalar],
    inertia: wp.array[Scalar],
    damping: wp.array[Scalar],
) -> None:
    """Move by a part of a direction; inertia changes by ``factors[0]`` of it, damping by its own part."""
    i = wp.tid()
    move = step * direction[i]
    position[i] = position[i] + move
    displacement[i] = displacement[i] + move
    inertia[i] = inertia[i] + factors[0] * move
    if factors[1] > step - step:
        damping[i] = damping[i] + step * of_damping[i]


@kernel
def remaining_force(
    # model
    factors: wp.array[Scalar],
    # state in
    of_inertia: wp.array[Scalar],
    damping: wp.array[Scalar],
    # state in and out
    force: wp.array[Scalar],
) -> None:
    """Subtract forces of inertia, and ``factors[1]`` times those of damping, from a force."""
    i = wp.tid()
    force[i] = force[i] - of_inertia[i] - factors[1] * damping[i]


def sum_launch(
    result: MixedVector, of_first: float, first: MixedVector, of_second: float, second: MixedVector, launcher: Launcher
) -> Any:
    """The launch that sets a vector to a x + b y; it may be one of the arguments."""
    numbers = [result.scalar(of_first), result.scalar(of_second)]
    return launcher(scaled_sums, len(result.values), [*numbers, first.values, second.values], [result.values])


def set_sum(result: MixedVector, of_first: float, first: MixedVector, of_second: float, second: MixedVector) -> None:
    """Set a vector to a x + b y; it may be one of the arguments."""
    sum_launch(result, of_first, first, of_second, second, partial(launch, device=result.device))


def remaining_launch(
    force: MixedVector, factors: wp.array[Any], of_inertia: MixedVector, damping: MixedVector, launcher: Launcher
) -> Any:
    """The launch that subtracts the force of inertia, and factor 1 times a vector, from a force."""
    inputs = [factors, of_inertia.values, damping.values]
    return launcher(remaining_force, len(force.values), inputs, [force.values])


def choose(result: MixedVector, moves: wp.array[wp.int32], free: MixedVector, fixed: MixedVector) -> None:
    """Set a vector to ``free`` where coordinates move and to ``fixed`` elsewhere; it may be one of the arguments."""
    launch(chosen, len(moves), [moves, free.values, fixed.values], [result.values], result.device)


def move_launch(
    moved: Sequence[MixedVector],
    step: float,
    factors: wp.array[Any],
    direction: MixedVector,
    of_damping: MixedVector,
    launcher: Launcher,
) -> Any:
    """The launch that moves along a direction.

    Args:
        moved: four vectors. ``step`` times the direction is added to the positions and the displacements, factor 0
            times as much to the vector of inertia, and ``step`` times ``of_damping`` to the vector of damping.
        step: part of the direction.
        factors: both factors of the quadratic part, shape (2,).
        direction: the direction.
        of_damping: product of the direction with the Hessian of damping; not used where factor 1 is zero.
        launcher: ``launch`` or ``prepare`` with the device bound.
    """
    inputs = [direction.scalar(step), factors, direction.values, of_damping.values]
    return launcher(moved_state, len(direction.values), inputs, [vector.values for vector in moved])


def largest(vector: MixedVector) -> float:
    """Largest absolute value of a vector; not a number if one of its values is not a number."""
    return float(np.maximum(maximum(vector.values), -minimum(vector.values))) if len(vector.values) else 0.0


class ReadSums:
    """Sums and minima that launches compute and the host reads back together."""

    def __init__(self, device: wp.Device) -> None:
        """Begin without sums."""
        self._device = device
        self._counts: list[int] = []
        self._todo: list[tuple[wp.Kernel, list[Any], int]] = []
        self._host = HostCopy(wp.zeros((0, WIDTH), dtype=wp.float64, device=device))

    def add_sum(self, values: wp.array[Any]) -> None:
        """Add the sum of an array of scalars."""
        self._add(sum_parts, [values], len(values))

    def add_dot(self, first: wp.array[Any], second: wp.array[Any]) -> None:
        """Add the dot product of two arrays of scalars."""
        self._add(dot_parts, [first, second], len(first))

    def add_minimum(self, values: wp.array[Any]) -> None:
        """Add the smallest value of an array of scalars; 1e300 where there is none."""
        self._add(least_parts, [values], len(values))

    def launches(self, run: Launcher) -> list[Any]:
        """The launches that find all sums that have been added."""
        if not self._counts:
            return []
        start = np.concatenate([[0], np.cumsum(self._counts)]).astype(np.int32)
        parts = wp.zeros((max(int(start[-1]), 1), WIDTH), dtype=wp.float64, device=self._device)
        sums = wp.zeros((len(self._counts), WIDTH), dtype=wp.float64, device=self._device)
        self._host = HostCopy(sums)
        result = []
        for (kernel_of_parts, inputs, chunk), first, last in zip(self._todo, start[:-1], start[1:], strict=True):
            if last > first:
                own = parts[int(first) : int(last)]
                result.append(run(kernel_of_parts, int(last - first), [chunk, *inputs], [own]))
        starts = wp.array(start, dtype=wp.int32, device=self._device)
        minima = [kernel_of_parts is least_parts for kernel_of_parts, _inputs, _chunk in self._todo]
        of_minima = wp.array(np.array(minima, dtype=np.int32), dtype=wp.int32, device=self._device)
        self._kept = parts, starts, of_minima
        inputs = [starts, of_minima, parts]
        return [*result, run(total_parts, len(self._counts), inputs, [sums])]

    def read(self) -> NDArray[np.float64]:
        """The sums in the order in which they were added; their launches must have run."""
        return self._host.read()[:, 0]

    def _add(self, kernel_of_parts: wp.Kernel, inputs: list[Any], count: int) -> None:
        self._todo.append((kernel_of_parts, inputs, chunk_of(count, self._device)))
        self._counts.append(part_count(count, self._device))
