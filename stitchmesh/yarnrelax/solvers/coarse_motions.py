# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The coarse motions of cells: rigid motions of groups of control points, and the strains of each cell.

A group is a run of successive control points of a yarn, with the middle c and the size s, and it moves by

    u_i = t + w x (x_i - c) / s

with the six unknowns (t, w). Where cells relax, the last group of each cell has no control points: its first three
unknowns are the strains of the cell, and the other three stay zero. A cell that is too large to be divided has no
groups. The matrices of all cells stand in one array without gaps, because cells differ in size.
"""

from __future__ import annotations

from itertools import pairwise
from typing import Any

import numpy as np
import warp as wp

from stitchmesh.compute.kernel import kernel
from stitchmesh.compute.thread_block import Slots, sum_over_block
from stitchmesh.yarnrelax.model.constants import Model
from stitchmesh.yarnrelax.model.lattice_images import rests

SHORTEST_RUN, LONGEST_RUN = 12, 102
"""Control points of the shortest and of the longest group: a longer piece of yarn does not move like a rigid one."""
MOST_UNKNOWNS = 240
"""Motions of the groups of a cell whose groups are shorter than the longest run."""
LARGEST_CELL = 25_000
"""Control points of the largest cell that is divided: the work of an inverse grows with the cube of the groups."""

Motion = wp.types.vector(length=6, dtype=wp.float64)


@wp.struct
class Groups:
    """Groups of control points; the group of each control point, -1 where its cell has none.

    Of each group: the range of its control points, which is empty for strains; its cell; its number in the cell; where
    its first row stands in the array of matrices. Of each cell: its first group, and the last entry is the end.
    """

    of_point: wp.array[wp.int32]
    first: wp.array[wp.int32]
    last: wp.array[wp.int32]
    cell: wp.array[wp.int32]
    number: wp.array[wp.int32]
    row: wp.array[wp.int32]
    of_cell: wp.array[wp.int32]
    middle: wp.array[wp.vec3d]
    size: wp.array[wp.float64]


@wp.func
def width_of(groups: Groups, cell: int) -> int:
    """Rows and columns of the matrix of a cell."""
    return 6 * (groups.of_cell[cell + 1] - groups.of_cell[cell])


@wp.func
def is_strains(groups: Groups, g: int) -> bool:
    """Whether a group is that of the strains of its cell."""
    return groups.first[g] == groups.last[g]


@wp.func
def as_doubles(v: Any) -> wp.vec3d:
    """A vector in double precision."""
    return wp.vec3d(wp.float64(v[0]), wp.float64(v[1]), wp.float64(v[2]))


@wp.func
def motion_of(groups: Groups, g: int, place: wp.vec3d, pull: wp.vec3d) -> Motion:  # type: ignore[valid-type]
    """The product of the six motions of a group at a place with a vector there."""
    turn = wp.cross((place - groups.middle[g]) / groups.size[g], pull)
    return Motion(pull[0], pull[1], pull[2], turn[0], turn[1], turn[2])


@wp.func
def place_under(groups: Groups, g: int, place: wp.vec3d, motion: Any) -> wp.vec3d:
    """The displacement of a place by a motion of its group."""
    turned = wp.cross(wp.vec3d(motion[3], motion[4], motion[5]), (place - groups.middle[g]) / groups.size[g])
    return wp.vec3d(motion[0], motion[1], motion[2]) + turned


@kernel
def place_groups(
    # state in
    points: wp.array[Any],
    # state in and out
    groups: Groups,
) -> None:
    """The middle and the size of each group."""
    g = wp.tid()
    total, square = wp.vec3d(), wp.float64(0.0)
    count = wp.max(wp.float64(groups.last[g] - groups.first[g]), wp.float64(1.0))
    for i in range(groups.first[g], groups.last[g]):
        total += as_doubles(points[i])
    middle = total / count
    for i in range(groups.first[g], groups.last[g]):
        away = as_doubles(points[i]) - middle
        square += wp.dot(away, away)
    groups.middle[g] = middle
    groups.size[g] = wp.max(wp.sqrt(square / count), wp.float64(1.0e-3))


@kernel
def restrict_vectors(
    # model
    model: Any,
    groups: Groups,
    # state in
    points: wp.array[Any],
    vectors: wp.array[Any],
    # state out
    coarse: wp.array2d[wp.float64],
) -> None:
    """The product of the motions of each group with vectors of the entries; one block for each group."""
    g, lane = wp.tid()
    if rests(model.images, groups.cell[g]):
        return
    total = Slots()
    for i in range(groups.first[g] + lane, groups.last[g], wp.block_dim()):
        own = motion_of(groups, g, as_doubles(points[i]), as_doubles(vectors[i]))
        for k in range(6):
            total[k] += own[k]
    if is_strains(groups, g) and lane == 0:
        value = as_doubles(vectors[groups.first[g]])
        for k in range(3):
            total[k] = value[k]
    sum_over_block(total, coarse[g])


@kernel
def add_coarse_motions(
    # model
    model: Any,
    groups: Groups,
    # state in
    points: wp.array[Any],
    inverse: wp.array[wp.float64],
    coarse: wp.array2d[wp.float64],
    # state in and out
    motion: wp.array2d[wp.float64],
    vectors: wp.array[Any],
) -> None:
    """Add the motion of each group, the rows of the inverse times a coarse vector; one block for each group."""
    g, lane = wp.tid()
    cell = groups.cell[g]
    if rests(model.images, cell):
        return
    width, first = width_of(groups, cell), groups.of_cell[cell]
    total = Slots()
    for column in range(lane, width, wp.block_dim()):
        value = coarse[first + column // 6, column % 6]
        for k in range(6):
            total[k] += inverse[groups.row[g] + k * width + column] * value
    sum_over_block(total, motion[g])
    own = motion[g]
    moves = Motion(own[0], own[1], own[2], own[3], own[4], own[5])
    for i in range(groups.first[g] + lane, groups.last[g], wp.block_dim()):
        vectors[i] = plus(vectors[i], place_under(groups, g, as_doubles(points[i]), moves))
    if is_strains(groups, g) and lane == 0:
        entry = groups.first[g]
        vectors[entry] = plus(vectors[entry], wp.vec3d(moves[0], moves[1], moves[2]))


@wp.func
def plus(vector: Any, more: wp.vec3d) -> Any:
    """The sum of a vector and one in double precision."""
    return vector + type(vector)(type(vector[0])(more[0]), type(vector[0])(more[1]), type(vector[0])(more[2]))


def put_groups(model: Model, strains: int) -> Groups:
    """The groups of all cells on the device; ``strains`` is the number of cells that relax."""
    ranges = [each for cell in range(model.cell_count) for each in _ranges(model, cell, strains)]
    cell, first, last = np.array(ranges).reshape(-1, 3).T
    starts = np.searchsorted(cell, np.arange(model.cell_count + 1))
    number, width = np.arange(len(cell)) - starts[cell], 6 * np.diff(starts)
    matrix = np.concatenate([[0], np.cumsum(width**2)])
    of_point = np.full(model.point_count, -1)
    for group, (start, end) in enumerate(zip(first, last, strict=True)):
        of_point[start:end] = group
    groups = Groups()
    groups.of_point, groups.of_cell = model.integers(of_point), model.integers(starts)
    groups.first, groups.last = model.integers(first), model.integers(last)
    groups.cell, groups.number = model.integers(cell), model.integers(number)
    groups.row = model.integers(matrix[cell] + 6 * number * width[cell])
    groups.middle = wp.zeros(len(cell), dtype=wp.vec3d, device=model.device)
    groups.size = wp.zeros(len(cell), dtype=wp.float64, device=model.device)
    return groups


def _ranges(model: Model, cell: int, strains: int) -> list[tuple[int, int, int]]:
    """The groups of a cell: cell, first control point and end."""
    count = int(model.point_start[cell + 1] - model.point_start[cell])
    if count > LARGEST_CELL:
        return []
    run = min(max(SHORTEST_RUN, -(-6 * count // MOST_UNKNOWNS)), LONGEST_RUN)
    ranges = []
    for yarn in range(model.yarn_start[cell], model.yarn_start[cell + 1]):
        start, end = int(model.yarns.start[yarn]), int(model.yarns.start[yarn + 1])
        pieces = max(round((end - start) / run), 1)
        borders = np.linspace(start, end, pieces + 1).round().astype(int)
        ranges += [(cell, int(a), int(b)) for a, b in pairwise(borders)]
    own = model.point_count + cell
    return [*ranges, (cell, own, own)] if strains else ranges


def suits_coarse_space(model: Model) -> bool:
    """Whether some cell is small enough to be divided into groups."""
    return bool(np.diff(model.point_start).min() <= LARGEST_CELL)
