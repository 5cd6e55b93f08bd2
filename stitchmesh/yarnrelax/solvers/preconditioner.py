# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""How far a control point gives way to a force: the preconditioner of the quasistatic solver.

The row sums of ``stiffness`` bound the stiffness at a control point by one number. But a yarn is far stiffer along
itself than across, and a contact is stiff in one direction alone. So each control point gets a block,

    B = sum over its segments of (a (T + g (I - T)) + b u I)  +  c I  +  2 sum over its samples of w K

with the row sums a of stretch and length along the yarn and b of bending at rest, T the segment's mean t t^T and u its
mean (l / |y'|)^4, which is what bending grows by where the curve runs slowly, c the row sums of further terms, w the
weight of the point in a sample, and K = sum of E'' n n^T the contact stiffness of the sample. A taut yarn is stiff
across itself too, as a string is: by the part g = 1 - l / |y'| > 0 of a, with u^(1/4) for l / |y'|. A strain of one
hundredth so adds more than bending has.

The blocks bound the Hessian by v.Hv <= 1.2 v.Bv, for the segment turns while T is a mean. Bending alone exceeds its
part, since curvature depends on y' too: at even speed, in units of |y'|, with k = |y''|,

    d^2 (kappa^2) / 2  <=  (|dy''| + 4 k |dy'|)^2,    dy' along the yarn.

What is left out acts along the yarn, where stretch is hundreds of times stiffer, and does not show in the sum.
The compliance is the inverse of B, found anew in every iteration: contacts come and go.
"""

from __future__ import annotations

import functools
from typing import Any

import warp as wp

from stitchmesh.compute.kernel import kernel
from stitchmesh.compute.precision import vector
from stitchmesh.yarnrelax.model.spline import weight_row


@wp.func
def inverse_block(b: Any) -> Any:
    """Inverse of a symmetric 3 x 3 matrix (xx, yy, zz, xy, xz, yz)."""
    xx, yy, zz = b[1] * b[2] - b[5] * b[5], b[0] * b[2] - b[4] * b[4], b[0] * b[1] - b[3] * b[3]
    xy, xz, yz = b[4] * b[5] - b[3] * b[2], b[3] * b[5] - b[4] * b[1], b[3] * b[4] - b[5] * b[0]
    scale = type(xx)(1.0) / (b[0] * xx + b[3] * xy + b[4] * xz)
    return type(b)(xx * scale, yy * scale, zz * scale, xy * scale, xz * scale, yz * scale)


@wp.func
def times_block(b: Any, v: Any) -> Any:
    """A symmetric block times a vector."""
    return type(v)(
        b[0] * v[0] + b[3] * v[1] + b[4] * v[2],
        b[3] * v[0] + b[1] * v[1] + b[5] * v[2],
        b[4] * v[0] + b[5] * v[1] + b[2] * v[2],
    )


@functools.cache
def bounds_struct(scalar: Any) -> Any:
    """Row sums of stiffness: of each segment along and across the yarn, shape (S,), and of further terms, (N,)."""
    fours = wp.array(dtype=vector(4, scalar))
    annotations = {"along": fours, "across": fours, "further": wp.array(dtype=scalar)}
    return wp.struct(type(f"Bounds_{scalar.__name__}", (), {"__annotations__": annotations}))


@wp.func
def preconditioner_at(model: Any, i: int, bounds: Any, state: Any) -> None:
    """The compliance of a control point [unit^2 / erg]."""
    slots = model.point_segments[i]
    block = type(state.preconditioner[0])()
    level = bounds.further[i]
    for slot in range(4):
        s = slots[slot]
        if s >= 0:
            mean = state.segment_block[s]
            directed = type(block)(mean[0], mean[1], mean[2], mean[3], mean[4], mean[5])
            tight = wp.max(type(level)(1.0) - wp.sqrt(wp.sqrt(mean[6])), level - level)
            block += directed * (bounds.along[s][slot] * (type(level)(1.0) - tight))
            level += mean[6] * bounds.across[s][slot] + tight * bounds.along[s][slot]
            first = model.sample_start[s]
            count = model.sample_start[s + 1] - first
            row = weight_row(model, count, 0)
            for k in range(count):
                block += state.sample_block[first + k] * (type(level)(2.0) * model.sample_basis[row + k][slot])
    block += type(block)(level, level, level, level - level, level - level, level - level)
    state.preconditioner[i] = inverse_block(block)


@kernel
def find_preconditioner(
    # model
    model: Any,
    bounds: Any,
    # state in and out
    state: Any,
) -> None:
    """The compliance of each control point."""
    preconditioner_at(model, wp.tid(), bounds, state)
