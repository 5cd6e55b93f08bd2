# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The matrices of the coarse motions: P^T H P with the motions P of ``coarse_motions`` and the Hessian H.

A row belongs to one motion of one group. This motion changes the legs and the gaps of the segments that have control
points in the group. The pulls that the Hessian gives for these changes, times the motions of all groups at the control
points on which they act, are the entries of the row. One thread finds a row, in a fixed order, and only the part below
the diagonal is read. The rows of the strains come from products with a unit of each strain (``hessian_product``).

A cell can move as a whole without stiffness, and a straight piece of yarn can turn about itself. The diagonal is
therefore raised by the part ``REGULAR`` of its mean m, and for motions w of a whole cell, each of length 1 in the
unknowns, m w w^T is added: rounding leaves a small force on such motions, which must not become a large motion.
"""

from __future__ import annotations

from typing import Any

import warp as wp

from stitchmesh.compute.kernel import kernel
from stitchmesh.compute.thread_block import Slots, sum_over_block
from stitchmesh.yarnrelax.model.lattice_images import rests, sample_number
from stitchmesh.yarnrelax.model.spline import weight_row
from stitchmesh.yarnrelax.solvers.coarse_motions import (
    Groups,
    Motion,
    as_doubles,
    is_strains,
    motion_of,
    place_under,
    width_of,
)

REGULAR = wp.constant(wp.float64(1e-7))
"""Part of the mean of the diagonal that is added to it."""
DIAGONAL, MIDDLE, LENGTHS = wp.constant(0), wp.constant(1), wp.constant(4)
"""Columns of the scales of a cell: sum of the diagonal; sum of the middles of its groups; squares of the lengths of its
turns about three axes through their mean."""

Corners = wp.types.matrix(shape=(4, 3), dtype=wp.float64)


@wp.func
def unit_motion(groups: Groups, g: int, k: int, place: wp.vec3d) -> wp.vec3d:
    """The displacement of a place by the motion ``k`` of a group."""
    motion = Motion()
    motion[k] = wp.float64(1.0)
    return place_under(groups, g, place, motion)


@wp.func
def corner_motions(model: Any, groups: Groups, points: wp.array[Any], s: int, g: int, k: int) -> Corners:  # type: ignore[valid-type]
    """The displacements of the control points of a segment by the motion ``k`` of a group."""
    result = Corners()
    for corner in range(4):
        i = model.segment_points[s][corner]
        if groups.of_point[i] == g:
            result[corner] = unit_motion(groups, g, k, as_doubles(points[i]))
    return result


@wp.func
def times_leg_block(block: Any, v: wp.vec3d) -> wp.vec3d:
    """The product of a block of the legs with a vector, in double precision."""
    return wp.vec3d(
        wp.float64(block[0, 0]) * v[0] + wp.float64(block[0, 1]) * v[1] + wp.float64(block[0, 2]) * v[2],
        wp.float64(block[1, 0]) * v[0] + wp.float64(block[1, 1]) * v[1] + wp.float64(block[1, 2]) * v[2],
        wp.float64(block[2, 0]) * v[0] + wp.float64(block[2, 1]) * v[1] + wp.float64(block[2, 2]) * v[2],
    )


@wp.func
def leg_pulls(leg_hessian: wp.array2d[Any], s: int, moves: Any) -> Corners:  # type: ignore[valid-type]
    """The pulls of a segment's legs on its control points for a motion of these."""
    c0, c1, c2 = moves[1] - moves[0], moves[2] - moves[1], moves[3] - moves[2]
    h01, h02, h12 = leg_hessian[1, s], leg_hessian[2, s], leg_hessian[4, s]
    p0 = times_leg_block(leg_hessian[0, s], c0) + times_leg_block(h01, c1) + times_leg_block(h02, c2)
    p1 = times_leg_block(wp.transpose(h01), c0) + times_leg_block(leg_hessian[3, s], c1) + times_leg_block(h12, c2)
    p2 = (
        times_leg_block(wp.transpose(h02), c0) + times_leg_block(wp.transpose(h12), c1)
        + times_leg_block(leg_hessian[5, s], c2)
    )  # fmt: skip
    result = Corners()
    result[0] = -p0
    result[1] = p0 - p1
    result[2] = p1 - p2
    result[3] = p2
    return result


@wp.func
def at_sample(model: Any, basis: int, moves: Any) -> wp.vec3d:
    """The displacement of a contact sample by a motion of the control points of its segment."""
    total = wp.vec3d()
    for corner in range(4):
        total += moves[corner] * wp.float64(model.sample_basis[basis][corner])
    return total


@wp.func
def add_pulls(
    model: Any, groups: Groups, points: wp.array[Any], s: int, pulls: Any, start: int,
    matrix: wp.array[wp.float64]
) -> None:  # fmt: skip
    """Add the products of pulls on the control points of a segment with the motions of their groups to a row.

    Successive control points of one group are added together.
    """
    total = Motion()
    for corner in range(4):
        i = model.segment_points[s][corner]
        g = groups.of_point[i]
        total += motion_of(groups, g, as_doubles(points[i]), pulls[corner])
        following = wp.min(corner + 1, 3)
        if corner == 3 or groups.of_point[model.segment_points[s][following]] != g:
            for k in range(6):
                at = start + 6 * groups.number[g] + k
                matrix[at] = matrix[at] + total[k]
            total = Motion()


@wp.func
def spread(model: Any, basis: int, pull: wp.vec3d) -> Corners:  # type: ignore[valid-type]
    """The pulls on the control points of a segment of a pull on one of its contact samples."""
    result = Corners()
    for corner in range(4):
        result[corner] = pull * wp.float64(model.sample_basis[basis][corner])
    return result


@wp.func
def add_segment(
    model: Any, groups: Groups, points: wp.array[Any], leg_hessian: wp.array2d[Any],
    touching_count: wp.array[wp.int32], touching: wp.array2d[wp.int32], stiffness: wp.array2d[Any], s: int, g: int,
    k: int, start: int, matrix: wp.array[wp.float64]
) -> None:  # fmt: skip
    """Add the pulls of a segment's legs and contacts for the motion ``k`` of a group to the row of this motion."""
    moves = corner_motions(model, groups, points, s, g, k)
    pulls = leg_pulls(leg_hessian, s, moves)
    first = model.sample_start[s]
    count = model.sample_start[s + 1] - first
    for p in range(first, first + count):
        basis = weight_row(model, count, p - first)
        moved, total = at_sample(model, basis, moves), wp.vec3d()
        for c in range(touching_count[p]):
            along = as_doubles(stiffness[p, c])
            pull = along * wp.dot(along, moved)
            total += pull
            q = sample_number(model.images, touching[p, c])
            t = model.sample_segment[q]
            there = weight_row(model, model.sample_start[t + 1] - model.sample_start[t], q - model.sample_start[t])
            add_pulls(model, groups, points, t, spread(model, there, -pull), start, matrix)
        pulls += spread(model, basis, total)
    add_pulls(model, groups, points, s, pulls, start, matrix)


@kernel
def assemble_rows(
    # model
    model: Any,
    # state in
    points: wp.array[Any],
    leg_hessian: wp.array2d[Any],
    touching_count: wp.array[wp.int32],
    touching: wp.array2d[wp.int32],
    stiffness: wp.array2d[Any],
    level: wp.array[Any],
    damping: wp.array[Any],
    groups: Groups,
    # state out
    matrix: wp.array[wp.float64],
) -> None:
    """The row of one motion of a group; the row of a strain is left with 1 on the diagonal."""
    thread = wp.tid()
    g, k = thread // 6, thread % 6
    cell = groups.cell[g]
    if rests(model.images, cell):
        return
    width = width_of(groups, cell)
    start, own = groups.row[g] + k * width, 6 * groups.number[g] + k
    for column in range(width):
        matrix[start + column] = wp.float64(0.0)
    if is_strains(groups, g):
        matrix[start + own] = wp.float64(1.0)
    more = wp.float64(0.0)
    for i in range(groups.first[g], groups.last[g]):
        more += wp.float64(level[i] * damping[i])
        for slot in range(4):
            s = model.point_segments[i][slot]
            if s >= 0:
                before = wp.max(slot - 1, 0)
                if slot == 0 or groups.of_point[model.segment_points[s][before]] != g:
                    add_segment(
                        model, groups, points, leg_hessian, touching_count, touching, stiffness, s, g, k, start, matrix
                    )
    matrix[start + own] = matrix[start + own] + more


@kernel
def put_strain_row(
    # model
    model: Any,
    groups: Groups,
    k: int,
    point_count: int,
    free: wp.array[wp.vec3d],
    # state in
    product: wp.array[Any],
    coarse: wp.array2d[wp.float64],
    # state out
    matrix: wp.array[wp.float64],
) -> None:
    """The row of the strain ``k`` of each cell, from the product with a unit of it; one thread for each group."""
    g = wp.tid()
    cell = groups.cell[g]
    if rests(model.images, cell) or free[cell][k] == wp.float64(0.0):
        return
    width = width_of(groups, cell)
    start = groups.row[groups.of_cell[cell + 1] - 1] + k * width + 6 * groups.number[g]
    for column in range(6):
        value = coarse[g, column]
        if is_strains(groups, g):
            value = wp.float64(0.0)
            if column < 3:
                value = wp.float64(product[point_count + cell][column])
        matrix[start + column] = value


@kernel
def sum_scales(
    # model
    model: Any,
    groups: Groups,
    # state in
    matrix: wp.array[wp.float64],
    # state out
    scales: wp.array2d[wp.float64],
) -> None:
    """The sum of the diagonal of each cell without strains, and the sum of the middles; one block for each cell."""
    cell, lane = wp.tid()
    total = Slots()
    width = width_of(groups, cell)
    for g in range(groups.of_cell[cell] + lane, groups.of_cell[cell + 1], wp.block_dim()):
        if not is_strains(groups, g):
            for k in range(6):
                total[DIAGONAL] += matrix[groups.row[g] + k * width + 6 * groups.number[g] + k]
            for axis in range(3):
                total[MIDDLE + axis] += groups.middle[g][axis]
    sum_over_block(total, scales[cell])


@kernel
def sum_lengths(
    # model
    groups: Groups,
    # state in
    scales: wp.array2d[wp.float64],
    # state out
    lengths: wp.array2d[wp.float64],
) -> None:
    """The squares of the lengths of the turns of a cell as a whole; one block for each cell."""
    cell, lane = wp.tid()
    total = Slots()
    for g in range(groups.of_cell[cell] + lane, groups.of_cell[cell + 1], wp.block_dim()):
        for k in range(6):
            turn = turns_of_unknown(groups, g, k, scales)
            total[0] += turn[0] * turn[0]
            total[1] += turn[1] * turn[1]
            total[2] += turn[2] * turn[2]
    sum_over_block(total, lengths[cell])


@wp.func
def turns_of_unknown(groups: Groups, g: int, k: int, scales: wp.array2d[wp.float64]) -> wp.vec3d:
    """The unknown ``k`` of a group in the turns of a piece as a whole about three axes, which has no strains."""
    cell = groups.cell[g]
    count = wp.float64(groups.of_cell[cell + 1] - groups.of_cell[cell])
    middle = wp.vec3d(scales[cell, MIDDLE], scales[cell, MIDDLE + 1], scales[cell, MIDDLE + 2]) / count
    unit = wp.vec3d()
    unit[k % 3] = wp.float64(1.0)
    if k < 3:
        unit = wp.cross(groups.middle[g] - middle, unit)
    else:
        unit = unit * groups.size[g]
    return unit


@kernel
def raise_diagonal(
    # model
    model: Any,
    groups: Groups,
    turns: int,
    # state in
    scales: wp.array2d[wp.float64],
    lengths: wp.array2d[wp.float64],
    # state in and out
    matrix: wp.array[wp.float64],
) -> None:
    """Add what keeps the matrix of a cell regular to the rows of a group; one block for each group."""
    g, lane = wp.tid()
    cell = groups.cell[g]
    if rests(model.images, cell):
        return
    width, own = width_of(groups, cell), 6 * groups.number[g]
    count = wp.float64(groups.of_cell[cell + 1] - groups.of_cell[cell])
    if is_strains(groups, groups.of_cell[cell + 1] - 1):
        count -= wp.float64(1.0)
    mean = scales[cell, DIAGONAL] / (count * wp.float64(6.0))
    for column in range(lane, own + 6, wp.block_dim()):
        h = groups.of_cell[cell] + column // 6
        for k in range(6):
            more = wp.float64(0.0)
            if k == column % 6 and k < 3 and not is_strains(groups, g):
                more += mean / count
            if turns > 0:
                one, other = turns_of_unknown(groups, g, k, scales), turns_of_unknown(groups, h, column % 6, scales)
                for axis in range(3):
                    more += mean * one[axis] * other[axis] / lengths[cell, axis]
            if column == own + k:
                more += REGULAR * mean
            at = groups.row[g] + k * width + column
            matrix[at] = matrix[at] + more
