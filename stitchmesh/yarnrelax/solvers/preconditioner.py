# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The preconditioner of the quasistatic solver: the inverse of a block of stiffness for each control point.

The solver needs no true masses; it scales its steps by upper bounds of the stiffness at each control point. For an
energy with Hessian H, the row sums D_i = sum_j |H_ij| bound H by the diagonal D (Gershgorin), so steps F_i / D_i lower
the energy. For each segment, with B' and B'' the derivatives of the four basis functions at the rest shape:

    stretch, length   2 (k_len + k_length) / (l l0)  int |B'_i| sum_j |B'_j|      along the yarn
    bending           2 k_bend / l^3                 int |B''_i| sum_j |B''_j|    across the yarn

The sums of both hold in all directions, even with the dependence of bending on y', because stretch is much stiffer.
Contact adds its own row sums, which change (``contact``).

These row sums bound the stiffness at a control point by one number. But a yarn is far stiffer along itself than across,
and a contact is stiff in one direction only. Each control point therefore gets a block,

    B = sum over its segments of (a (T + g (I - T)) + b u I)  +  c I  +  2 sum over its samples of w K

where a are the row sums of stretch and length along the yarn, and b the row sums of bending at rest. T is the segment's
mean t t^T. u is its mean (l / |y'|)^4, by which bending grows where the parameter speed is low. c are the row sums of
further terms, w is the weight of the point in a sample, and K = sum of E'' n n^T is the contact stiffness of the
sample. A stretched yarn is also stiff across itself, like a string: by the part g = 1 - l / |y'| > 0 of a, with u^(1/4)
for l / |y'|. A strain of one hundredth adds more stiffness across the yarn than bending has.

The blocks bound the Hessian by v.Hv <= 1.2 v.Bv; the factor is needed because the segment turns while T is a mean.
Bending alone exceeds its part, because curvature depends on y' too: at even speed, in units of |y'|, with k = |y''|,

    d^2 (kappa^2) / 2  <=  (|dy''| + 4 k |dy'|)^2,    dy' along the yarn.

The neglected part acts along the yarn, where stretch is hundreds of times stiffer, and does not show in the sum.
The blocks and their inverses are computed in every iteration, because contacts appear and disappear.
"""

from __future__ import annotations

import functools
from typing import Any, TypeAlias

import numpy as np
import warp as wp
from numpy.typing import NDArray

from stitchmesh.compute.captured import Launcher
from stitchmesh.compute.kernel import kernel
from stitchmesh.compute.kernel_variants import named_type
from stitchmesh.compute.precision import ScalarType, Vec3, Vec6, Vec7, vector
from stitchmesh.compute.threads import each_block
from stitchmesh.yarn import basis_derivative
from stitchmesh.yarnrelax.model.constants import Model, YarnConstants
from stitchmesh.yarnrelax.model.spline import weight_row
from stitchmesh.yarnrelax.model.state import State


def stiffness_row_sums(model: Model) -> NDArray[np.float64]:
    """Row sums of the stiffness of stretch, length and bending at each control point [erg / unit^2], shape (N,)."""
    along, across = stretch_row_sums(model), bend_row_sums(model)
    along += across
    return _at_points(model, along)


def bend_stiffness(model: Model) -> NDArray[np.float64]:
    """Row sums of the stiffness of bending at each control point [erg / unit^2], shape (N,)."""
    return _at_points(model, bend_row_sums(model))


def _at_points(model: Model, rows: NDArray[np.float64]) -> NDArray[np.float64]:
    points = model.yarns.segment_points.ravel()
    return np.bincount(points, weights=rows.ravel(), minlength=model.point_count).astype(np.float64)


def stretch_row_sums(model: Model) -> NDArray[np.float64]:
    """Row sums along the yarn, for each of a segment's four control points [erg / unit^2], shape (S, 4)."""
    return _row_sums(model, slice(0, 2), _swept_rows(1), 1)


def bend_row_sums(model: Model) -> NDArray[np.float64]:
    """Row sums across the yarn, for each of a segment's four control points [erg / unit^2], shape (S, 4)."""
    return _row_sums(model, slice(2, 3), _swept_rows(2), 3)


def _row_sums(
    model: Model, columns: slice, swept: NDArray[np.float64], power: int
) -> NDArray[np.float64]:
    """Return four integrals times 2 k / l^power, where k is the sum of some columns of the stiffness, shape (S, 4)."""
    stiffness, length, rows = model.segment_stiffness, model.rest_length, np.empty((model.segment_count, 4))

    def fill(some: slice) -> None:
        own = stiffness[some, columns].sum(axis=1, keepdims=True)
        rows[some] = 2 * own * swept / length[some, None] ** power

    each_block(fill, len(rows))
    return rows


def _swept_rows(order: int) -> NDArray[np.float64]:
    """Return the integrals of |B_i| sum_j |B_j| with first or second derivatives of the basis functions, shape (4,).

    The magnitudes are inside the integral, because the direction of the yarn turns along a segment.
    """
    nodes, weights = np.polynomial.legendre.leggauss(8)  # the kinks of the magnitudes leave an error of 0.1 %
    s = (nodes + 1) / 2
    second = np.stack([1 - s, 3 * s - 2, 1 - 3 * s, s], axis=1)
    size = np.abs(basis_derivative(s) if order == 1 else second)
    return np.asarray((weights / 2) @ (size * size.sum(axis=1, keepdims=True)))


@wp.func
def inverse_block(b: Vec6) -> Any:
    """Inverse of a symmetric 3 x 3 matrix (xx, yy, zz, xy, xz, yz)."""
    xx, yy, zz = b[1] * b[2] - b[5] * b[5], b[0] * b[2] - b[4] * b[4], b[0] * b[1] - b[3] * b[3]
    xy, xz, yz = b[4] * b[5] - b[3] * b[2], b[3] * b[5] - b[4] * b[1], b[3] * b[4] - b[5] * b[0]
    scale = type(xx)(1.0) / (b[0] * xx + b[3] * xy + b[4] * xz)
    return type(b)(xx * scale, yy * scale, zz * scale, xy * scale, xz * scale, yz * scale)


@wp.func
def times_block(b: Vec6, v: Vec3) -> Any:
    """A symmetric block times a vector."""
    return type(v)(
        b[0] * v[0] + b[3] * v[1] + b[4] * v[2],
        b[3] * v[0] + b[1] * v[1] + b[5] * v[2],
        b[4] * v[0] + b[5] * v[1] + b[2] * v[2],
    )


BoundArrays: TypeAlias = Any
"""The struct of row sums of stiffness, in either precision."""


@functools.cache
def _bounds_struct(scalar: ScalarType) -> Any:
    """Return the struct for row sums of stiffness: of segments along and across the yarn, (S,), and of terms, (N,)."""
    fours = wp.array(dtype=vector(4, scalar))
    annotations = {"along": fours, "across": fours, "further": wp.array(dtype=scalar)}
    return wp.struct(type(f"Bounds_{scalar.__name__}", (), {"__annotations__": annotations}))


named_type("BoundArrays", lambda form: [_bounds_struct(form.scalar)])


def put_bounds(
    model: Model, along: NDArray[np.float64], across: NDArray[np.float64], further: NDArray[np.float64]
) -> Any:
    """Return the row sums of stiffness on the device, as a struct for kernels.

    Args:
        model: the yarns.
        along: row sums along the yarn at each segment's four control points [erg / unit^2], shape (S, 4).
        across: row sums across the yarn at these points, shape (S, 4).
        further: row sums of further terms at each control point, shape (N,).
    """
    bounds = _bounds_struct(model.scalar)()
    bounds.along, bounds.across = model.upload(along, 4), model.upload(across, 4)
    bounds.further = model.upload(np.maximum(further, np.finfo(np.float32).tiny))
    return bounds


@wp.func
def preconditioner_at(
    model: YarnConstants, i: int, bounds: Any, segment_block: wp.array[Vec7], sample_block: wp.array[Vec6],
    preconditioner: wp.array[Vec6]
) -> None:  # fmt: skip
    """Write the preconditioner of a control point [unit^2 / erg]."""
    slots = model.point_segments[i]
    block = type(preconditioner[0])()
    level = bounds.further[i]
    for slot in range(4):
        s = slots[slot]
        if s >= 0:
            mean = segment_block[s]
            directed = type(block)(mean[0], mean[1], mean[2], mean[3], mean[4], mean[5])
            tight = wp.max(type(level)(1.0) - wp.sqrt(wp.sqrt(mean[6])), level - level)
            block += directed * (bounds.along[s][slot] * (type(level)(1.0) - tight))
            level += mean[6] * bounds.across[s][slot] + tight * bounds.along[s][slot]
            first = model.sample_start[s]
            count = model.sample_start[s + 1] - first
            row = weight_row(model, count, 0)
            for k in range(count):
                block += sample_block[first + k] * (type(level)(2.0) * model.sample_basis[row + k][slot])
    block += type(block)(level, level, level, level - level, level - level, level - level)
    preconditioner[i] = inverse_block(block)


@kernel
def find_preconditioner(
    # model
    model: YarnConstants,
    bounds: BoundArrays,
    # state in
    segment_block: wp.array[Vec7],
    sample_block: wp.array[Vec6],
    # state out
    preconditioner: wp.array[Vec6],
) -> None:
    """The preconditioner of each control point."""
    preconditioner_at(model, wp.tid(), bounds, segment_block, sample_block, preconditioner)


def preconditioner_launch(model: Model, bounds: Any, state: State, launcher: Launcher) -> Any:
    """Return the launch that finds the preconditioner of each control point."""
    inputs = [model.constants, bounds, state.segment_block, state.sample_block]
    return launcher(find_preconditioner, model.point_count, inputs, [state.preconditioner])
