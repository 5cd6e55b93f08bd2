# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The entries of the assembled Hessian, gathered from the segments (``segment_hessian``, ``segment_sums``).

A block between two control points is a sum over the segments of the first and the segments of the second. A segment
that has both adds the matrix of its legs and of its own pairs; two segments that touch add the pairs between them.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import warp as wp

from stitchmesh.compute.captured import Launcher
from stitchmesh.compute.kernel import kernel
from stitchmesh.compute.precision import Mat33, Scalar, Vec3
from stitchmesh.compute.thread_block import THREADS, total_over_block
from stitchmesh.yarnrelax.collision.step_limit import STRAIN_UNIT
from stitchmesh.yarnrelax.energies.pair_stiffness import Block64, block_as_matrix
from stitchmesh.yarnrelax.hessian.matrix_pattern import MatrixPattern
from stitchmesh.yarnrelax.hessian.segment_sums import FourBlocks, SegmentSums
from stitchmesh.yarnrelax.hessian.touching_segments import TouchingSegments, place_in_list
from stitchmesh.yarnrelax.model.constants import YarnConstants
from stitchmesh.yarnrelax.model.lattice_images import cell_of
from stitchmesh.yarnrelax.model.state import State


@wp.func
def block_of_legs(leg_hessian: wp.array2d[Mat33], s: int, leg: int, other: int) -> wp.mat33d:
    """The block of two legs of a segment, of which one half is stored (``segment_hessian``)."""
    low, high = wp.min(leg, other), wp.max(leg, other)
    block = wp.mat33d(leg_hessian[(low * (5 - low)) // 2 + high, s])
    if leg > other:
        block = wp.transpose(block)
    return block


@wp.func
def block_of_corners(leg_hessian: wp.array2d[Mat33], s: int, a: int, b: int) -> wp.mat33d:
    """The block of two control points of a segment: each ends the leg before it and begins the next one."""
    block = wp.mat33d()
    if a > 0 and b > 0:
        block += block_of_legs(leg_hessian, s, a - 1, b - 1)
    if a < 3 and b < 3:
        block += block_of_legs(leg_hessian, s, a, b)
    if a > 0 and b < 3:
        block -= block_of_legs(leg_hessian, s, a - 1, b)
    if a < 3 and b > 0:
        block -= block_of_legs(leg_hessian, s, a, b - 1)
    return block


@kernel
def put_blocks(
    # model
    model: YarnConstants,
    places: wp.array[wp.vec4i],
    start: wp.array[wp.int32],
    height: wp.array[wp.int32],
    touching_count: wp.array[wp.int32],
    touching: wp.array2d[wp.int32],
    pair_base: wp.array[wp.int32],
    # state in
    leg_hessian: wp.array2d[Mat33],
    own_blocks: wp.array2d[FourBlocks],
    between: wp.array2d[FourBlocks],
    # state out
    entries: wp.array[wp.float64],
) -> None:
    """The block of two control points, at its places above and below the diagonal."""
    place = places[wp.tid()]
    i, j = place[0], place[1]
    slots, other_slots = model.point_segments[i], model.point_segments[j]
    legs = wp.mat33d()
    pairs = Block64()
    for a in range(4):
        s = slots[a]
        if s >= 0:
            for b in range(4):
                t = other_slots[b]
                if t == s:
                    legs += block_of_corners(leg_hessian, s, a, b)
                    pairs += own_blocks[s, a][b]
                if t >= s:
                    k = place_in_list(touching, s, touching_count[s], t)
                    if k >= 0:
                        pairs -= between[pair_base[s] + k, a][b]
                elif t >= 0:
                    k = place_in_list(touching, t, touching_count[t], s)
                    if k >= 0:
                        pairs -= between[pair_base[t] + k, b][a]
    total = legs + block_as_matrix(pairs)
    if i == j:  # the transposes of the legs' blocks come in another order
        total = (total + wp.transpose(total)) * wp.float64(0.5)
    for row in range(3):
        for column in range(3):
            entries[start[i] + row * height[i] + 3 * place[2] + column] = total[row, column]
            if i != j and place[3] >= 0:
                entries[start[j] + column * height[j] + 3 * place[3] + row] = total[row, column]


@kernel
def put_border(
    # model
    model: YarnConstants,
    per_unit: wp.float64,
    frame: wp.array[wp.vec3d],
    cell_start: wp.array[wp.int32],
    start: wp.array[wp.int32],
    height: wp.array[wp.int32],
    strain_start: wp.array[wp.int32],
    # state in
    exact: wp.array[Scalar],
    force: wp.array[Vec3],
    external_force: wp.array[Vec3],
    point_strains: wp.array2d[wp.mat33d],
    # state out
    entries: wp.array[wp.float64],
) -> None:
    """The derivatives by each control point and the strains of its cell, at their places on both sides.

    The internal force f on the point adds - f^T E_m du to the exact Hessian, and so its share of that.
    """
    i = wp.tid()
    slots = model.point_segments[i]
    cell = cell_of(model.images, wp.max(slots))
    total = wp.mat33d()
    for a in range(4):
        if slots[a] >= 0:
            total += point_strains[slots[a], a]
    internal = wp.vec3d(force[i])
    if external_force.shape[0] > 0:
        internal -= wp.vec3d(external_force[i])
    internal = internal * wp.float64(exact[wp.max(slots)])
    e1, e2 = frame[2 * cell], frame[2 * cell + 1]
    first, second = wp.dot(internal, e1) * per_unit, wp.dot(internal, e2) * per_unit
    total -= wp.matrix_from_cols(e1 * first, e2 * second, e2 * first)
    strain_height = 3 * (cell_start[cell + 1] - cell_start[cell]) + 3
    for row in range(3):
        for strain in range(3):
            entries[start[i] + (row + 1) * height[i] - 3 + strain] = total[row, strain]
            place = strain_start[cell] + strain * strain_height + 3 * (i - cell_start[cell]) + row
            entries[place] = total[row, strain]


@kernel
def add_point_blocks(
    # model
    start: wp.array[wp.int32],
    height: wp.array[wp.int32],
    below: wp.array[wp.int32],
    # state in
    blocks: wp.array[wp.mat33d],
    # state in and out
    entries: wp.array[wp.float64],
) -> None:
    """Add a block of each control point with itself."""
    i = wp.tid()
    block = blocks[i]
    for row in range(3):
        for column in range(3):
            entries[start[i] + column * height[i] + 3 * below[i] + row] += block[row, column]


@kernel(tile=THREADS)
def put_strain_strains(
    # model
    cell_segments: wp.array[wp.int32],
    corner: wp.array[wp.int32],
    # state in
    strain_strains: wp.array[wp.mat33d],
    # state out
    entries: wp.array[wp.float64],
) -> None:
    """The entries of two strains of a cell, the symmetric sum of the parts of its segments; one block for each cell."""
    cell, lane = wp.tid()
    part = wp.mat33d()
    for s in range(cell_segments[cell] + lane, cell_segments[cell + 1], wp.block_dim()):
        part += strain_strains[s]
    for row in range(3):
        for column in range(row + 1):
            value = total_over_block((part[row, column] + part[column, row]) * wp.float64(0.5))
            if lane == 0:
                entries[corner[9 * cell + 3 * row + column]] = value
                entries[corner[9 * cell + 3 * column + row]] = value


def entry_launches(
    state: State, exact: wp.array[Any], leg_hessian: wp.array[Any], touching: TouchingSegments,
    pattern: MatrixPattern, sums: SegmentSums, entries: wp.array[Any], launcher: Launcher,
) -> list[Any]:  # fmt: skip
    """Return the launches that write the entries of segments, pairs, samples and strains."""
    model = sums.model
    places = [pattern.start, pattern.height]
    lists = [touching.kept_count, touching.kept, pattern.pair_base]
    found = [leg_hessian, sums.own_blocks, sums.blocks]
    inputs = [model.constants, pattern.blocks, *places, *lists, *found]
    launches = [launcher(put_blocks, pattern.block_count, inputs, [entries])]
    if sums.relaxes:
        inputs = [
            model.constants, wp.float64(1.0 / float(STRAIN_UNIT)), sums.frame, model.cell_points, *places,
            pattern.strain_start, exact, state.force, state.external_force, sums.point_strains,
        ]  # fmt: skip
        launches.append(launcher(put_border, model.point_count, inputs, [entries]))
        inputs = [model.cell_segments, pattern.corner, sums.strain_strains]
        launches.append(launcher(put_strain_strains, model.cell_count, inputs, [entries]))
    return launches


def block_launches(
    pattern: MatrixPattern, point_blocks: Sequence[wp.array[Any]], entries: wp.array[Any], launcher: Launcher
) -> list[Any]:
    """Return the launches that add the blocks of terms, each of shape (N,), to the entries that are written."""
    places = [pattern.start, pattern.height, pattern.below]
    return [launcher(add_point_blocks, len(blocks), [*places, blocks], [entries]) for blocks in point_blocks]
