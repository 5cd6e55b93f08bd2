# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The record of an iteration of conjugate gradients on a device, and the coefficients that follow from it.

There are two records. One kernel reads the first record and writes the second one with a. Another kernel reads the
second record and writes the first one with b. All blocks of threads of a kernel can therefore compute the coefficient
by themselves, and one of them writes it.

The end of an iteration projects z and finds the next direction in one launch. Let z = D^-1 r before the projection, and
z - D^-1 E' mu, r - E' mu after it. Then E (z - D^-1 E' mu) = 0 leaves

    (r - E' mu) . (z - D^-1 E' mu) = r . z - mu . E z,

so b = new r . z / old r . z is known before the projection is made. The r of the previous iteration satisfies
E D^-1 r = 0. All that is subtracted therefore belongs to the product A d of this iteration, and the rounding falls with
r.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import warp as wp

from stitchmesh.compute.kernel import kernel
from stitchmesh.compute.thread_block import THREADS, Slots, sum_over_block
from stitchmesh.mixed.enrichment.projection import CouplingArrays, change_of_node, change_of_vertex
from stitchmesh.mixed.mixed_vector import BlockArrays, MixedArrays, MixedVector

(RZ, FIRST_RZ, ALPHA, BETA, DONE, NEGATIVE, ITERATIONS, RATIO, MOST) = range(9)
RECORD = 9
"""Number of entries of the record: r . z and the first r . z; a; b; whether the iteration has ended, and whether at a
negative curvature; iterations so far; square of the tolerance; largest number of iterations."""


@wp.func
def copy_record(record: wp.array[wp.float64], after: wp.array[wp.float64]):  # type: ignore[no-untyped-def]
    """Copy a record."""
    for k in range(wp.static(RECORD)):
        after[k] = record[k]


@wp.func
def record_alpha(
    curvature: wp.float64, record: wp.array[wp.float64], writes: bool, after: wp.array[wp.float64]
) -> wp.float64:
    """The coefficient a = r . z / d . A d; at a negative curvature the iteration ends, the first one with a = 1."""
    zero, one = wp.float64(0.0), wp.float64(1.0)
    active = record[DONE] == zero
    alpha = zero * curvature
    if active:
        if curvature > zero:
            alpha = record[RZ] / curvature
        else:
            alpha = wp.where(record[ITERATIONS] == zero, one, zero)
    if writes:
        copy_record(record, after)
        after[ALPHA] = alpha
        if active:
            after[ITERATIONS] = record[ITERATIONS] + one
            if not curvature > zero:
                after[NEGATIVE] = one
                after[DONE] = one
    return alpha


@wp.func
def record_beta(rz: wp.float64, record: wp.array[wp.float64], writes: bool, after: wp.array[wp.float64]) -> wp.float64:
    """The coefficient b = new r . z / old r . z, and whether the iteration ends."""
    zero, one = wp.float64(0.0), wp.float64(1.0)
    active = record[DONE] == zero
    beta = record[BETA] * one
    if active:
        beta = rz / record[RZ]
    if writes:
        copy_record(record, after)
        if active:
            after[BETA] = beta
            after[RZ] = rz
            small = rz <= record[RATIO] * record[FIRST_RZ]
            if small or record[ITERATIONS] >= record[MOST] or not (rz == rz):
                after[DONE] = one
    return beta


@dataclass(frozen=True, eq=False)
class Advance:
    """The vectors and records with which an iteration moves the solution along its direction and finds the next one."""

    record: wp.array[Any]
    """The record before the iteration; at its end, the record with b."""
    after: wp.array[Any]
    """The record with a."""
    curvature: wp.array[Any]
    """Parts of d . A d."""
    parts: wp.array[Any]
    """Memory for the parts of r . z."""
    sums: wp.array[Any]
    """Memory for the sum of each block."""
    active: wp.array[Any]
    """Set to 1 where the iteration goes on, and to 0 at its end."""
    direction: MixedVector
    """d."""
    product: MixedVector
    """A d."""
    solution: MixedVector
    """x, changed to x + a d."""


@wp.func
def projected_square(
    parts: wp.array2d[wp.float64],
    residual: wp.array2d[wp.float64],
    multiplier: wp.array2d[wp.float64],
    lane: int,
    sums: wp.array[wp.float64],
) -> wp.float64:
    """Find r . z - mu . E z, by one block of threads; ``sums`` is memory of this block."""
    total = Slots()
    for part in range(lane, parts.shape[0], wp.block_dim()):
        total[0] += parts[part, 0]
    for row in range(lane, residual.shape[0], wp.block_dim()):
        for axis in range(3):
            total[0] -= residual[row, axis] * multiplier[row, axis]
    sum_over_block(total, sums)
    return sums[0]


@kernel(tile=THREADS)
def next_direction(
    # model
    coupling: CouplingArrays,
    inverse: BlockArrays,
    chunk: int,
    # state in
    record: wp.array[wp.float64],
    parts: wp.array2d[wp.float64],
    residual: wp.array2d[wp.float64],
    multiplier: wp.array2d[wp.float64],
    motion: MixedArrays,
    # state in and out
    force: MixedArrays,
    direction: MixedArrays,
    # state out
    sums: wp.array2d[wp.float64],
    after: wp.array[wp.float64],
    active: wp.array[wp.int32],
) -> None:
    """Find r - E' mu, b and d = z - D^-1 E' mu + b d, and whether the iteration goes on."""
    block, lane = wp.tid()
    rz = projected_square(parts, residual, multiplier, lane, sums[block])
    writes = block == 0 and lane == 0
    ratio = record_beta(rz, record, writes, after)
    if writes:
        active[0] = wp.where(after[DONE] == wp.float64(0.0), 1, 0)
    vertex_count, node_count = motion.vertices.shape[0], motion.nodes.shape[0]
    for i in range(block * chunk + lane, wp.min((block + 1) * chunk, vertex_count + node_count), wp.block_dim()):
        if i < vertex_count:
            beta = type(motion.vertices[i][0])(ratio)
            turned = motion.vertices[i] + direction.vertices[i] * beta
            if coupling.of_vertex_start[i] < coupling.of_vertex_start[i + 1]:
                change = change_of_vertex(coupling, multiplier, i, motion.vertices[i])
                force.vertices[i] = force.vertices[i] + change
                turned += inverse.vertices[i] * change
            direction.vertices[i] = turned
        else:
            j = i - vertex_count
            share = type(motion.nodes[j][0])(ratio)
            moved = motion.nodes[j] + direction.nodes[j] * share
            if coupling.of_node_start[j] < coupling.of_node_start[j + 1]:
                pull = change_of_node(coupling, multiplier, j, motion.nodes[j])
                force.nodes[j] = force.nodes[j] + pull
                moved += inverse.nodes[j] * pull
            direction.nodes[j] = moved
            direction.sliding[j] = motion.sliding[j] + direction.sliding[j] * share
