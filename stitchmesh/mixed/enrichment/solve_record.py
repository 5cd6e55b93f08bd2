# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The record of an iteration of conjugate gradients on a device, and the coefficients that follow from it.

There are two records. One kernel reads the first one and writes the second one with a, and another kernel reads the
second one and writes the first one with b. All blocks of threads of a kernel can therefore find the coefficient by
themselves, and one of them writes it.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import warp as wp

from stitchmesh.mixed.mixed_vector import MixedVector

(RZ, FIRST_RZ, ALPHA, BETA, DONE, NEGATIVE, ITERATIONS, RATIO, MOST) = range(9)
RECORD = 9
"""Entries of the record: r . z, and the first one; a; b; whether the iteration has ended, and whether at a negative
curvature; iterations so far; square of the tolerance; largest number of iterations."""


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
    """What an iteration needs to move the solution along its direction, and to find the next one."""

    record: wp.array[Any]
    """The record before, and in the end that with b."""
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
