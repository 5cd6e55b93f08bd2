# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Modified preconditioned conjugate gradients (Ascher and Boxerman 2003), as captured launches.

For A x = b with a preconditioner C that returns motions p = B v + F x only, from x = 0 and r = b, z = C r, d = z:

    a = r . z / d . A d,    x + a d,    r - a A d,    z = C r,    b = new r . z / old r . z,    d = z + b d

Every direction is a sum of results of C, so that the iteration stays in the filtered motions. C also replaces r by the
part of it that the filter keeps. The norm is r . z, the square of a velocity error in the metric of C, and the
iteration ends where it has fallen to ``tolerance``^2 times its first value. It also ends at a direction of negative
curvature; if this is the first direction, it is the result.

All coefficients stay on the device in a record, and dot products have a fixed order: sums of blocks, then one block
that adds them up. The host reads the record after each batch of iterations. Iterations after the end change nothing.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np
import warp as wp

from stitchmesh.compute.captured import CapturedLaunches, CopyArray, Launcher, ZeroArray
from stitchmesh.compute.kernel import kernel
from stitchmesh.compute.launch import prepare
from stitchmesh.compute.thread_block import THREADS, Slots, sum_over_block
from stitchmesh.mixed.mixed_vector import MixedVector

CHUNK = {"cuda": 4 * THREADS, "cpu": 4096}
"""Scalars of a block of a dot product."""
BATCH = {"cuda": 8, "cpu": 1}
"""Iterations between two readings of the record."""
(RZ, FIRST_RZ, ALPHA, BETA, DONE, NEGATIVE, ITERATIONS, RATIO, MOST) = range(9)
RECORD = 9
"""Entries of the record: r . z, and the first one; a; b; whether the iteration has ended, and whether at a negative
curvature; iterations so far; square of the tolerance; largest number of iterations."""

Launches = Callable[[MixedVector, MixedVector, Launcher], list[Any]]
"""From an input and an output vector to the launches that compute the output."""


@kernel
def dot_parts(
    # model
    chunk: int,
    # state in
    first: wp.array[Any],
    second: wp.array[Any],
    # state out
    parts: wp.array2d[wp.float64],
) -> None:
    """Part of a dot product of each block."""
    block, lane = wp.tid()
    total = Slots()
    for i in range(block * chunk + lane, wp.min((block + 1) * chunk, first.shape[0]), wp.block_dim()):
        total[0] += wp.float64(first[i]) * wp.float64(second[i])
    sum_over_block(total, parts[block])


@wp.func
def add_parts(parts: wp.array2d[wp.float64], lane: int, sums: wp.array2d[wp.float64]) -> wp.float64:
    """Add up the parts of all blocks, by one block of threads."""
    total = Slots()
    for block in range(lane, parts.shape[0], wp.block_dim()):
        total[0] += parts[block, 0]
    sum_over_block(total, sums[0])
    return sums[0, 0]


@kernel
def total_of_parts(
    # state in
    parts: wp.array2d[wp.float64],
    # state out
    sums: wp.array2d[wp.float64],
) -> None:
    """The dot product."""
    _block, lane = wp.tid()
    add_parts(parts, lane, sums)


@kernel
def begin(
    # state in
    parts: wp.array2d[wp.float64],
    # state in and out
    sums: wp.array2d[wp.float64],
    record: wp.array[wp.float64],
) -> None:
    """The first r . z, and a record for a new solve."""
    _block, lane = wp.tid()
    rz = add_parts(parts, lane, sums)
    zero, one = wp.float64(0.0), wp.float64(1.0)
    if lane == 0:
        record[RZ] = rz
        record[FIRST_RZ] = rz
        record[ALPHA] = zero
        record[BETA] = zero
        record[DONE] = wp.where(rz > zero, zero, one)
        record[NEGATIVE] = zero
        record[ITERATIONS] = zero


@kernel
def find_alpha(
    # state in
    parts: wp.array2d[wp.float64],
    # state in and out
    sums: wp.array2d[wp.float64],
    record: wp.array[wp.float64],
) -> None:
    """Find a = r . z / d . A d; at a negative curvature the iteration ends, the first one with a = 1."""
    _block, lane = wp.tid()
    curvature = add_parts(parts, lane, sums)
    zero, one = wp.float64(0.0), wp.float64(1.0)
    if lane == 0:
        alpha = zero
        if record[DONE] == zero:
            record[ITERATIONS] = record[ITERATIONS] + one
            if curvature > zero:
                alpha = record[RZ] / curvature
            else:
                record[NEGATIVE] = one
                record[DONE] = one
                alpha = wp.where(record[ITERATIONS] == one, one, zero)
        record[ALPHA] = alpha


@kernel
def advance(
    # state in
    record: wp.array[wp.float64],
    direction: wp.array[Any],
    product: wp.array[Any],
    # state in and out
    solution: wp.array[Any],
    residual: wp.array[Any],
) -> None:
    """Find x + a d and r - a A d."""
    i = wp.tid()
    alpha = record[ALPHA]
    if alpha != wp.float64(0.0):
        a = type(direction[i])(alpha)
        solution[i] = solution[i] + a * direction[i]
        residual[i] = residual[i] - a * product[i]


@kernel
def find_beta(
    # state in
    parts: wp.array2d[wp.float64],
    # state in and out
    sums: wp.array2d[wp.float64],
    record: wp.array[wp.float64],
) -> None:
    """Find b = new r . z / old r . z, and whether the iteration ends."""
    _block, lane = wp.tid()
    rz = add_parts(parts, lane, sums)
    zero, one = wp.float64(0.0), wp.float64(1.0)
    if lane == 0 and record[DONE] == zero:
        record[BETA] = rz / record[RZ]
        record[RZ] = rz
        small = rz <= record[RATIO] * record[FIRST_RZ]
        if small or record[ITERATIONS] >= record[MOST] or not (rz == rz):
            record[DONE] = one


@kernel
def next_direction(
    # state in
    record: wp.array[wp.float64],
    preconditioned: wp.array[Any],
    # state in and out
    direction: wp.array[Any],
) -> None:
    """Find d = z + b d."""
    i = wp.tid()
    direction[i] = preconditioned[i] + type(preconditioned[i])(record[BETA]) * direction[i]


@dataclass(frozen=True)
class SolveReport:
    """How a solve ended."""

    iterations: int
    """Number of products with A."""
    first_norm: float
    """Square root of the first r . z."""
    norm: float
    """Square root of the last r . z."""
    negative: bool
    """Whether a direction had negative curvature."""

    @property
    def reduction(self) -> float:
        """The last norm over the first one; 0 where the first one is 0."""
        return self.norm / self.first_norm if self.first_norm > 0.0 else 0.0


class ConjugateGradients:
    """A solver whose iterations are captured once and repeated."""

    def __init__(self, shape: MixedVector, products: Launches, precondition: Launches) -> None:
        """Capture the iteration.

        Args:
            shape: a vector of the shape, precision and device of the unknowns.
            products: the launches that set the second vector to A times the first one.
            precondition: the launches that set the second vector to C times the first one, and may change the first
                one by what C does not see.
        """
        self.solution, self.residual = shape.like(), shape.like()
        self._preconditioned, self._direction, self._product = shape.like(), shape.like(), shape.like()
        device = shape.device
        kind = "cuda" if device.is_cuda else "cpu"
        self._chunk = CHUNK[kind]
        self._parts = wp.zeros((-(-len(shape.values) // self._chunk), 7), dtype=wp.float64, device=device)
        self._sums = wp.zeros((1, 7), dtype=wp.float64, device=device)
        self._record = wp.zeros(RECORD, dtype=wp.float64, device=device)
        self._launcher: Launcher = partial(prepare, device=device)
        self._start = CapturedLaunches(self._start_launches(precondition), device)
        self._iteration = CapturedLaunches(self._iteration_launches(products, precondition), device, times=BATCH[kind])

    def solve(self, right: MixedVector, *, tolerance: float, most_iterations: int) -> SolveReport:
        """Solve A x = b for the current A and C; the result is ``solution``.

        Args:
            right: b.
            tolerance: part of the first norm at which the iteration ends.
            most_iterations: largest number of products with A, up to a batch.
        """
        record = np.zeros(RECORD)
        record[[RATIO, MOST]] = tolerance**2, most_iterations
        self._record.assign(record)
        self.residual.assign(right)
        self._start.launch()
        record = self._record.numpy()
        while record[DONE] == 0.0:
            self._iteration.launch()
            record = self._record.numpy()
        norms = np.sqrt(np.maximum(record[[FIRST_RZ, RZ]], 0.0))
        return SolveReport(int(record[ITERATIONS]), float(norms[0]), float(norms[1]), bool(record[NEGATIVE]))

    def _start_launches(self, precondition: Launches) -> list[Any]:
        """The launches before the first iteration."""
        z, run = self._preconditioned, self._launcher
        return [
            ZeroArray(self.solution.values),
            *precondition(self.residual, z, run),
            CopyArray(z.values, self._direction.values),
            self._dot(self.residual, z),
            run(begin, 1, [self._parts], [self._sums, self._record], tile=THREADS),
        ]

    def _iteration_launches(self, products: Launches, precondition: Launches) -> list[Any]:
        """The launches of one iteration."""
        z, direction, product, run = self._preconditioned, self._direction, self._product, self._launcher
        count = len(z.values)
        flat = [self._record, direction.values, product.values]
        return [
            *products(direction, product, run),
            self._dot(direction, product),
            run(find_alpha, 1, [self._parts], [self._sums, self._record], tile=THREADS),
            run(advance, count, flat, [self.solution.values, self.residual.values]),
            *precondition(self.residual, z, run),
            self._dot(self.residual, z),
            run(find_beta, 1, [self._parts], [self._sums, self._record], tile=THREADS),
            run(next_direction, count, [self._record, z.values], [direction.values]),
        ]

    def _dot(self, first: MixedVector, second: MixedVector) -> Any:
        """The launch that finds the parts of a dot product."""
        inputs = [self._chunk, first.values, second.values]
        return self._launcher(dot_parts, len(self._parts), inputs, [self._parts], tile=THREADS)
