# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The end of an iteration of conjugate gradients: the projection of z and the next direction in one launch.

With z = D^-1 r before the projection and z - D^-1 E' mu, r - E' mu after it, E (z - D^-1 E' mu) = 0 leaves

    (r - E' mu) . (z - D^-1 E' mu) = r . z - mu . E z,

so that b = new r . z / old r . z is known before the projection is made. All that is subtracted belongs to the product
A d of this iteration, because r of the iteration before satisfies E D^-1 r = 0: the rounding falls with r.
"""

from __future__ import annotations

from typing import Any

import warp as wp

from stitchmesh.compute.kernel import kernel
from stitchmesh.compute.thread_block import Slots, sum_over_block
from stitchmesh.mixed.enrichment.projection import CouplingArrays, change_of_node, change_of_vertex
from stitchmesh.mixed.enrichment.solve_record import DONE, record_beta


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


@kernel
def next_direction(
    # model
    coupling: CouplingArrays,
    inverse: Any,
    chunk: int,
    # state in
    record: wp.array[wp.float64],
    parts: wp.array2d[wp.float64],
    residual: wp.array2d[wp.float64],
    multiplier: wp.array2d[wp.float64],
    motion: Any,
    # state in and out
    force: Any,
    direction: Any,
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
