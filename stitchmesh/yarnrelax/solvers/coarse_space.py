# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The coarse part of the preconditioner of Newton's method: rigid motions of pieces of yarn, strains of the cell.

The blocks at the control points are stiff, because yarn hardly stretches, and conjugate gradients need many products
until a motion of one of them has reached a whole stitch. The soft motions of a fabric move and turn pieces of yarn
almost rigidly. Each cell is therefore divided into groups of successive control points of a yarn, with the six motions

    u_i = t + w x (x_i - c) / s,        c the middle of the group, s its size

and the strains of the cell are added where the cell relaxes. With the matrix P of these motions, the preconditioner is

    C = blocks at the control points  +  P (P^T H P)^-1 P^T

with H the matrix of Gauss and Newton (two-level additive Schwarz; Toselli and Widlund 2005, section 3). The small
matrix is assembled on the device, row by row in a fixed order, and inverted on the host once in each Newton step, in a
fixed order.
"""

from __future__ import annotations

from itertools import pairwise
from typing import Any

import numpy as np
import warp as wp
from numpy.typing import NDArray

from stitchmesh.compute.captured import CapturedLaunches, Launcher
from stitchmesh.compute.kernel import kernel
from stitchmesh.yarnrelax.hessian.hessian_product import Hessian
from stitchmesh.yarnrelax.model.constants import Model
from stitchmesh.yarnrelax.model.lattice_images import sample_number
from stitchmesh.yarnrelax.model.spline import weight_row

SHORTEST_RUN = 12
"""Control points of the shortest group."""
MOST_UNKNOWNS = 240
"""Motions of the groups of one cell."""
LARGEST_CELL = 4096
"""Control points of the largest cell: in larger ones the groups would be too long to be rigid."""
REGULAR = 1e-7
"""Part of the mean of the diagonal that is added to it: a straight piece of yarn turns about itself without energy."""

Motion = wp.types.vector(length=6, dtype=wp.float64)


@wp.struct
class Groups:
    """Groups of control points: their ranges, cells and first unknowns; the group of each control point."""

    of_point: wp.array[wp.int32]
    first: wp.array[wp.int32]
    last: wp.array[wp.int32]
    cell: wp.array[wp.int32]
    unknown: wp.array[wp.int32]
    middle: wp.array[wp.vec3d]
    size: wp.array[wp.float64]


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
def leg_block(leg_hessian: wp.array2d[Any], s: int, j: int, k: int) -> wp.mat33d:
    """The block of the legs j and k of a segment, zero beyond the three legs."""
    result = wp.mat33d()
    three = int(3)
    if j >= 0 and k >= 0 and j < 3 and k < 3:
        low, high = wp.min(j, k), wp.max(j, k)
        block = leg_hessian[low * 3 - (low * (low + 1)) // 2 + high, s]
        if j > k:
            block = wp.transpose(block)
        for row in range(three):
            for column in range(three):
                result[row, column] = wp.float64(block[row, column])
    return result


@wp.func
def point_block(leg_hessian: wp.array2d[Any], s: int, slot: int, other: int) -> wp.mat33d:
    """The block of two control points of a segment."""
    own = leg_block(leg_hessian, s, slot - 1, other - 1) + leg_block(leg_hessian, s, slot, other)
    return own - leg_block(leg_hessian, s, slot - 1, other) - leg_block(leg_hessian, s, slot, other - 1)


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
    count = wp.float64(groups.last[g] - groups.first[g])
    for i in range(groups.first[g], groups.last[g]):
        total += as_doubles(points[i])
    middle = total / count
    for i in range(groups.first[g], groups.last[g]):
        away = as_doubles(points[i]) - middle
        square += wp.dot(away, away)
    groups.middle[g] = middle
    groups.size[g] = wp.max(wp.sqrt(square / count), wp.float64(1.0e-3))


@wp.func
def add_contact_row(
    model: Any, groups: Groups, points: wp.array[Any], weight: wp.float64, pull: wp.vec3d, s: int, basis: int, own: Any,
    first: int, matrix: wp.array2d[wp.float64]
) -> None:  # fmt: skip
    """Add ``own`` times the motion of a sample along ``pull`` to the columns of the groups of its segment."""
    total = Motion()
    three, four, six = int(3), int(4), int(6)  # loops over names are not unrolled
    for corner in range(four):
        i = model.segment_points[s][corner]
        g = groups.of_point[i]
        share = weight * wp.float64(model.sample_basis[basis][corner])
        total += motion_of(groups, g, as_doubles(points[i]), pull) * share
        ends = True
        if corner < three:
            ends = groups.of_point[model.segment_points[s][corner + 1]] != g
        if ends:
            for row in range(six):
                for column in range(six):
                    matrix[first + row, groups.unknown[g] + column] += own[row] * total[column]
            total = Motion()


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
    matrices: wp.array3d[wp.float64],
) -> None:
    """The rows of a group in the matrix of its cell."""
    g = wp.tid()
    three, four, six = int(3), int(4), int(6)  # loops over names are not unrolled
    matrix = matrices[groups.cell[g]]
    first = groups.unknown[g]
    for row in range(six):
        for column in range(matrix.shape[1]):
            matrix[first + row, column] = wp.float64(0.0)
    for i in range(groups.first[g], groups.last[g]):
        place = as_doubles(points[i])
        for row in range(six):
            matrix[first + row, first + row] += wp.float64(level[i] * damping[i])
        for slot in range(four):
            s = model.point_segments[i][slot]
            if s >= 0:
                for other in range(four):
                    j = model.segment_points[s][other]
                    h = groups.of_point[j]
                    block = point_block(leg_hessian, s, slot, other)
                    for axis in range(three):
                        unit = wp.vec3d()
                        unit[axis] = wp.float64(1.0)
                        there = motion_of(groups, h, as_doubles(points[j]), unit)
                        here = motion_of(groups, g, place, wp.vec3d(block[0, axis], block[1, axis], block[2, axis]))
                        for row in range(six):
                            for column in range(six):
                                matrix[first + row, groups.unknown[h] + column] += here[row] * there[column]
                is_first = True
                if slot > 0:
                    is_first = groups.of_point[model.segment_points[s][slot - 1]] != g
                if is_first:
                    start = model.sample_start[s]
                    count = model.sample_start[s + 1] - start
                    for k in range(count):
                        p = start + k
                        basis = weight_row(model, count, k)
                        for c in range(touching_count[p]):
                            pull = as_doubles(stiffness[p, c])
                            own = Motion()
                            for corner in range(slot, four):
                                j = model.segment_points[s][corner]
                                if groups.of_point[j] == g:
                                    share = wp.float64(model.sample_basis[basis][corner])
                                    own += motion_of(groups, g, as_doubles(points[j]), pull) * share
                            one = wp.float64(1.0)
                            add_contact_row(model, groups, points, one, pull, s, basis, own, first, matrix)
                            q = sample_number(model.images, touching[p, c])
                            t = model.sample_segment[q]
                            others = model.sample_start[t + 1] - model.sample_start[t]
                            there_basis = weight_row(model, others, q - model.sample_start[t])
                            add_contact_row(model, groups, points, -one, pull, t, there_basis, own, first, matrix)


@wp.func
def restricted(groups: Groups, g: int, points: wp.array[Any], vectors: wp.array[Any]) -> Motion:  # type: ignore[valid-type]
    """The product of the motions of a group with vectors at its control points."""
    total = Motion()
    for i in range(groups.first[g], groups.last[g]):
        total += motion_of(groups, g, as_doubles(points[i]), as_doubles(vectors[i]))
    return total


@kernel
def restrict_vectors(
    # model
    groups: Groups,
    group_count: int,
    point_count: int,
    strain_unknown: int,
    # state in
    points: wp.array[Any],
    vectors: wp.array[Any],
    # state out
    coarse: wp.array2d[wp.float64],
) -> None:
    """The product of all coarse motions of a group, or of the strains of a cell, with vectors of the entries."""
    g = wp.tid()
    if g < group_count:
        total = restricted(groups, g, points, vectors)
        for k in range(6):
            coarse[groups.cell[g], groups.unknown[g] + k] = total[k]
    else:
        cell = g - group_count
        value = as_doubles(vectors[point_count + cell])
        for k in range(3):
            coarse[cell, strain_unknown + k] = value[k]


@kernel
def multiply_inverse(
    # state in
    inverse: wp.array3d[Any],
    coarse: wp.array2d[wp.float64],
    # state out
    motion: wp.array2d[wp.float64],
) -> None:
    """The product of the inverse of each cell with its coarse vector."""
    cell, row = wp.tid()
    total = wp.float64(0.0)
    for column in range(inverse.shape[2]):
        total += wp.float64(inverse[cell, row, column]) * coarse[cell, column]
    motion[cell, row] = total


@wp.func
def first_three(values: wp.array[wp.float64], k: int) -> wp.vec3d:
    """Three successive values."""
    return wp.vec3d(values[k], values[k + 1], values[k + 2])


@wp.func
def moved(groups: Groups, g: int, place: wp.vec3d, motion: wp.array2d[wp.float64]) -> wp.vec3d:
    """The displacement of a place in a group."""
    values, k = motion[groups.cell[g]], groups.unknown[g]
    turned = wp.cross(first_three(values, k + 3), (place - groups.middle[g]) / groups.size[g])
    return first_three(values, k) + turned


@kernel
def prolong_motions(
    # model
    groups: Groups,
    point_count: int,
    strain_unknown: int,
    # state in
    points: wp.array[Any],
    motion: wp.array2d[wp.float64],
    # state out
    vectors: wp.array[Any],
) -> None:
    """Add the coarse motions to vectors of the entries."""
    i = wp.tid()
    if i < point_count:
        more = moved(groups, groups.of_point[i], as_doubles(points[i]), motion)
    else:
        more = first_three(motion[i - point_count], strain_unknown)
    vectors[i] = vectors[i] + type(vectors[i])(
        type(vectors[i][0])(more[0]), type(vectors[i][0])(more[1]), type(vectors[i][0])(more[2])
    )


class CoarseSpace:
    """The coarse motions of cells on a device."""

    def __init__(self, model: Model, strains: int) -> None:
        """Divide the yarns into groups; ``strains`` is the number of cells that relax."""
        self.model, self.strains, device = model, strains, model.device
        ranges = _ranges(model)
        cell, first, last = np.array(ranges).T
        counts = np.bincount(cell, minlength=model.cell_count)
        self.unknowns = 6 * int(counts.max()) + (3 if strains else 0)
        self.strain_unknown = self.unknowns - 3
        self.starts = starts = np.concatenate([[0], np.cumsum(counts)])
        self.groups = Groups()
        self.groups.of_point = model.integers(np.repeat(np.arange(len(cell)), last - first))
        self.groups.first, self.groups.last = model.integers(first), model.integers(last)
        self.groups.cell = model.integers(cell)
        self.groups.unknown = model.integers(6 * (np.arange(len(cell)) - starts[cell]))
        self.groups.middle = wp.zeros(len(cell), dtype=wp.vec3d, device=device)
        self.groups.size = wp.zeros(len(cell), dtype=wp.float64, device=device)
        self.count = len(cell)
        cells, n = model.cell_count, self.unknowns
        self.used = 6 * counts
        """Unknowns of the groups of each cell, shape (C,)."""
        self.free = np.zeros((cells, 3))
        """Whether each strain of each cell is free, 1 or 0, shape (C, 3)."""
        self.host_inverse = np.zeros((cells, n, n))
        self.matrices = wp.zeros((cells, n, n), dtype=wp.float64, device=device)
        self.inverse = wp.zeros((cells, n, n), dtype=wp.float64, device=device)
        self.coarse = wp.zeros((cells, n), dtype=wp.float64, device=device)
        self.motion = wp.zeros((cells, n), dtype=wp.float64, device=device)
        entries = model.point_count + strains
        self.unit, self.product = model.empty(entries, 3), model.empty(entries, 3)

    def prepare(
        self, hessian: Hessian, points: wp.array[Any], level: wp.array[Any], damping: wp.array[Any]
    ) -> None:
        """Capture the launches that assemble the matrices; ``level`` and ``damping`` of the entries, shape (E,)."""
        launcher, pairs, model = self.model.prepare, hessian.touching, self.model
        if hessian.strain is not None:
            self.free = hessian.strain.host_free
        inputs = [model.constants, points, hessian.leg_hessian, pairs.count, pairs.entries, pairs.stiffness,
                  level, damping, self.groups]  # fmt: skip
        self._assemble = CapturedLaunches([
            launcher(place_groups, self.count, [points, self.groups], []),
            launcher(assemble_rows, self.count, inputs, [self.matrices]),
        ], model.device)  # fmt: skip
        self._strain_column = CapturedLaunches([
            *hessian.product_launches(self.unit, self.product, launcher),
            self._restrict(points, self.product, launcher),
        ], model.device) if self.strains else None  # fmt: skip

    def invert(self, cells: NDArray[np.bool_]) -> None:
        """Assemble the matrices of the current state, and invert those of some cells; ``cells`` has the shape (C,)."""
        self._assemble.launch()
        matrices = self.matrices.numpy()
        if self._strain_column is not None:
            matrices = self._with_strain_columns(matrices)
        for cell in np.flatnonzero(cells).tolist():
            used = np.arange(self.used[cell])
            if self.strains:
                used = np.concatenate([used, self.strain_unknown + np.flatnonzero(self.free[cell])])
            own = matrices[cell][np.ix_(used, used)]
            own = (own + own.T) / 2
            mean = np.diagonal(own)[: self.used[cell]].mean()
            own[np.diag_indices_from(own)] += REGULAR * mean
            whole = self._free_motions(cell)
            own[: self.used[cell], : self.used[cell]] += whole.T @ whole * mean
            self.host_inverse[cell] = 0.0
            self.host_inverse[cell][np.ix_(used, used)] = inverse_in_order(own)
        self.inverse.assign(self.host_inverse)

    def apply_launches(
        self, points: wp.array[Any], residual: wp.array[Any], vectors: wp.array[Any], launcher: Launcher
    ) -> list[Any]:
        """The launches that add the coarse part of the preconditioned ``residual`` to ``vectors``, both (E, 3)."""
        multiply = launcher(multiply_inverse, (self.model.cell_count, self.unknowns), [self.inverse, self.coarse],
                            [self.motion])  # fmt: skip
        inputs = [self.groups, self.model.point_count, self.strain_unknown, points, self.motion]
        prolong = launcher(prolong_motions, self.model.point_count + self.strains, inputs, [vectors])
        return [self._restrict(points, residual, launcher), multiply, prolong]

    def _free_motions(self, cell: int) -> NDArray[np.float64]:
        """Motions of a cell as a whole, which have no stiffness, in the unknowns of its groups, shape (3 or 6, G).

        Rounding leaves a small force on them, which must not become a large motion.
        """
        groups = slice(self.starts[cell], self.starts[cell + 1])
        middle, size = self.groups.middle.numpy()[groups], self.groups.size.numpy()[groups]
        shift = np.tile(np.eye(3, 6), (1, len(size)))
        if self.model.on_lattice:
            return shift / np.sqrt(len(size))
        turn = np.zeros((3, len(size), 6))
        away = middle - middle.mean(axis=0)
        for axis, unit in enumerate(np.eye(3)):
            turn[axis, :, :3], turn[axis, :, 3:] = np.cross(unit, away), unit * size[:, None]
        rows = turn.reshape(3, -1)
        return np.concatenate([shift / np.sqrt(len(size)), rows / np.linalg.norm(rows, axis=1, keepdims=True)])

    def _restrict(self, points: wp.array[Any], vectors: wp.array[Any], launcher: Launcher) -> Any:
        inputs = [self.groups, self.count, self.model.point_count, self.strain_unknown, points, vectors]
        return launcher(restrict_vectors, self.count + self.strains, inputs, [self.coarse])

    def _with_strain_columns(self, matrices: NDArray[np.float64]) -> NDArray[np.float64]:
        """The matrices with the columns and rows of the strains: products with a unit of each strain."""
        assert self._strain_column is not None
        whole = matrices.copy()
        for k in range(3):
            units = np.zeros((len(self.unit), 3))
            units[self.model.point_count :, k] = 1.0
            self.unit.assign(units)
            self._strain_column.launch()
            column = self.coarse.numpy()
            whole[:, :, self.strain_unknown + k] = whole[:, self.strain_unknown + k, :] = column
        return whole


def inverse_in_order(matrix: NDArray[np.float64]) -> NDArray[np.float64]:
    """Inverse of a symmetric positive definite matrix by elimination (Gauss and Jordan), which needs no pivots.

    A linear algebra library divides this work between as many threads as there are cores, and its bits differ from
    machine to machine. Here each element is computed by the same operations everywhere.
    """
    inverse, part = matrix.copy(), np.empty_like(matrix)
    for k in range(len(inverse)):
        column = inverse[:, k].copy()
        inverse[k] /= column[k]
        inverse[:, k] = 0.0
        inverse[k, k] = 1.0 / column[k]
        column[k] = 0.0
        np.multiply(column[:, None], inverse[k], out=part)
        inverse -= part
    return inverse


def _ranges(model: Model) -> list[tuple[int, int, int]]:
    """The groups: cell, first control point and end."""
    ranges = []
    for cell in range(model.cell_count):
        count = int(model.point_start[cell + 1] - model.point_start[cell])
        run = max(SHORTEST_RUN, -(-6 * count // MOST_UNKNOWNS))
        for yarn in range(model.yarn_start[cell], model.yarn_start[cell + 1]):
            start, end = int(model.yarns.start[yarn]), int(model.yarns.start[yarn + 1])
            pieces = max(round((end - start) / run), 1)
            borders = np.linspace(start, end, pieces + 1).round().astype(int)
            ranges += [(cell, int(a), int(b)) for a, b in pairwise(borders)]
    return ranges


def suits_coarse_space(model: Model) -> bool:
    """Whether all cells are small enough to be divided into short groups."""
    return bool(np.diff(model.point_start).max() <= LARGEST_CELL)
