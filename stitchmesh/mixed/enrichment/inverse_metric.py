# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Inverse blocks of the metric D of a preconditioner.

Vertices and nodes have blocks of 3 x 3. Free nodes with Eulerian coordinates have a block of 5 x 5, kept as a block of
3 x 3, columns, and the Schur complement of the coordinates. The D^-1 of fixed coordinates is zero.

In the hybrid region D has one of three forms (``BY_MASSES``, ``ONE_NUMBER``, ``BLOCKS``). Blocks of hybrid vertices and
nodes are nearly singular where yarns resist bending much less than stretch. ``SHARE`` of the mean of their diagonal is
added to them, which keeps their condition number below 300 and costs no iterations.
"""

from __future__ import annotations

from typing import Any

import warp as wp

from stitchmesh.compute.kernel import kernel
from stitchmesh.compute.thread_block import Slots, sum_over_block

FIXED, FREE, COUPLED = 0, 1, 2
"""Kinds of vertices and nodes: with a prescribed velocity; free, outside the constraint E (v, p) = 0; free, within
it."""
BY_MASSES, ONE_NUMBER, BLOCKS = 0, 1, 2
"""Forms of D in the hybrid region: the masses, the mean of the diagonal of each block, or whole blocks."""
SHARE = 1e-2
"""Part of the mean of its diagonal that is added to the diagonal of a block in the hybrid region."""
LEAST_NODE, LEAST_VERTEX = 1e-6, 1e-5
"""Lower bounds of masses in D. For a node: this part of the mean mass of the nodes. For a vertex: this part of its
diagonal entry of B'MpB, the mass of the nodes on it. A vertex without mass moves with the nodes by the constraint
alone, and its D^-1 would not be finite."""
POSITIVE = wp.constant(1.0e-9)
"""Smallest minor of a block with a unit mean diagonal that is inverted as a block."""


@wp.func
def mean_of_diagonal(block: Any, size: int, smallest: Any) -> Any:
    """Mean of a diagonal, at least ``smallest``."""
    total = type(smallest)(0.0)
    for k in range(size):
        total += block[k, k]
    return wp.max(total / type(smallest)(size), smallest)


@wp.func
def scalar_block(block: Any, size: int, value: Any) -> Any:
    """A multiple of the identity, of the type of ``block``."""
    result = block - block
    for k in range(size):
        result[k, k] = value
    return result


@wp.func
def inverse_3(block: Any, smallest: Any) -> Any:
    """Inverse of a block; of its mean where the block is not positive."""
    one = type(smallest)(1.0)
    mean = mean_of_diagonal(block, 3, smallest)
    unit = block * (one / mean)
    minor = unit[0, 0] * unit[1, 1] - unit[0, 1] * unit[1, 0]
    determinant = wp.determinant(unit)
    least = type(smallest)(POSITIVE)
    result = scalar_block(block, 3, one / mean)
    if unit[0, 0] > least and minor > least and determinant > least:
        result = wp.inverse(unit) * (one / mean)
    return result


@wp.func
def inverse_2(block: Any, smallest: Any) -> Any:
    """Inverse of a block; of its mean where the block is not positive."""
    one = type(smallest)(1.0)
    mean = mean_of_diagonal(block, 2, smallest)
    unit = block * (one / mean)
    least = type(smallest)(POSITIVE)
    result = scalar_block(block, 2, one / mean)
    if unit[0, 0] > least and wp.determinant(unit) > least:
        result = wp.inverse(unit) * (one / mean)
    return result


@wp.func
def inverse_where(block: Any, free: wp.vec2i, smallest: Any) -> Any:
    """Inverse of the rows and columns of the free coordinates; zero for the others."""
    one = type(smallest)(1.0)
    result = block - block
    if free[0] != 0 and free[1] != 0:
        result = inverse_2(block, smallest)
    else:
        for k in range(2):
            if free[k] != 0:
                result[k, k] = one / wp.max(block[k, k], smallest)
    return result


@wp.func
def inverse_of_coupled(block: Any, form: int, smallest: Any, extra: Any, of_masses: Any) -> Any:
    """Inverse of a block in the hybrid region, which is exactly symmetric."""
    one, half = type(smallest)(1.0), type(smallest)(0.5)
    mean = mean_of_diagonal(block, 3, smallest)
    result = scalar_block(block, 3, of_masses)
    if form == wp.static(ONE_NUMBER):
        result = scalar_block(block, 3, one / wp.max(mean, extra))
    if form == wp.static(BLOCKS):
        added = type(smallest)(wp.static(SHARE)) * mean + extra
        result = inverse_3(block + scalar_block(block, 3, added), smallest)
        result = (result + wp.transpose(result)) * half
    return result


@kernel
def invert_metric(
    # model
    kind: wp.array[wp.int32],
    least_mass: wp.array[Any],
    inverse_mass: wp.array[Any],
    form: int,
    factor: wp.array[Any],
    # state in
    blocks: wp.array[Any],
    extra: wp.array[Any],
    # state out
    inverse: wp.array[Any],
    number: wp.array[Any],
) -> None:
    """Inverse blocks of D of positions, zero for what is fixed, and the mean of D of what is coupled."""
    i = wp.tid()
    block, of_mass = blocks[i], factor[0]
    smallest, of_masses = least_mass[i] * of_mass, inverse_mass[i] / of_mass
    result, mean = block - block, of_mass - of_mass
    if kind[i] == wp.static(FREE):
        result = inverse_3(block, smallest)
    if kind[i] == wp.static(COUPLED):
        result = inverse_of_coupled(block, form, smallest, extra[i], of_masses)
        mean = mean_of_diagonal(block, 3, smallest)
    inverse[i] = result
    number[i] = mean


@kernel
def bound_vertices(
    # model
    start: wp.array[wp.int32],
    node: wp.array[wp.int32],
    square: wp.array[wp.float64],
    # state in
    of_nodes: wp.array[Any],
    # state out
    sums: wp.array2d[wp.float64],
    extra: wp.array[Any],
) -> None:
    """Lower bounds of D of coupled vertices: a part of what the nodes have on it, the sum of B^2 D.

    One block of threads finds the sum of each vertex.
    """
    i, lane = wp.tid()
    total = Slots()
    for k in range(start[i] + lane, start[i + 1], wp.block_dim()):
        total[0] += square[k] * wp.float64(of_nodes[node[k]])
    sum_over_block(total, sums[i])
    if lane == 0:
        extra[i] = type(extra[i])(wp.float64(wp.static(LEAST_VERTEX)) * sums[i, 0])


@kernel
def invert_sliding_metric(
    # model
    kind: wp.array[wp.int32],
    slides: wp.array[wp.vec2i],
    least_mass: wp.array[Any],
    factor: wp.array[Any],
    # state in
    node_inverse: wp.array[Any],
    blocks: wp.array[Any],
    coupling_u: wp.array[Any],
    coupling_v: wp.array[Any],
    # state out
    inverse: wp.array[Any],
    inverse_u: wp.array[Any],
    inverse_v: wp.array[Any],
) -> None:
    """Inverse blocks of the Schur complement of D for the Eulerian coordinates, and D^-1 times their columns."""
    i = wp.tid()
    by_u, by_v = node_inverse[i] * coupling_u[i], node_inverse[i] * coupling_v[i]
    if kind[i] != wp.static(FREE) or slides[i][0] == 0:
        by_u = by_u - by_u
    if kind[i] != wp.static(FREE) or slides[i][1] == 0:
        by_v = by_v - by_v
    inverse_u[i] = by_u
    inverse_v[i] = by_v
    pair = blocks[i]
    mixed = wp.dot(by_v, coupling_u[i])
    pair[0, 0] = pair[0, 0] - wp.dot(by_u, coupling_u[i])
    pair[1, 1] = pair[1, 1] - wp.dot(by_v, coupling_v[i])
    pair[0, 1] = pair[0, 1] - mixed
    pair[1, 0] = pair[1, 0] - mixed
    inverse[i] = inverse_where(pair, slides[i], least_mass[i] * factor[0])
