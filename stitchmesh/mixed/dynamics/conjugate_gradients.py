# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Modified preconditioned conjugate gradients (Ascher and Boxerman 2003), as captured launches.

For A x = b with a preconditioner C that returns only motions p = B v + F x, the iteration starts from x = 0 and r = b,
z = C r, d = z:

    a = r . z / d . A d,    x + a d,    r - a A d,    z = C r,    b = new r . z / old r . z,    d = z + b d

Every direction is a sum of results of C, so the iteration stays in the filtered motions. C also replaces r by the part
of r that the filter keeps. The norm is r . z, the square of a velocity error in the metric of C. The iteration ends
where the norm has fallen to ``tolerance``^2 times its first value. It also ends at a direction of negative curvature;
if this is the first direction, it is the result.

All coefficients stay on the device in a record (``solve_record``). Dot products have a fixed order: the kernels that
make the vectors also compute parts of the sums, and the kernels that need a coefficient add up the parts. On a GPU a
graph repeats itself and the host reads the record at the end. Elsewhere the host looks at the record after each batch
of iterations. Iterations after the end change neither x nor r.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np
import warp as wp

from stitchmesh.compute.captured import CapturedLoop, CopyArray, Launcher, ZeroArray
from stitchmesh.compute.host_copy import HostCopy
from stitchmesh.compute.kernel import kernel
from stitchmesh.compute.launch import prepare
from stitchmesh.compute.partial_sums import add_parts, chunk_of, dot_parts, part_count, parts_for
from stitchmesh.compute.thread_block import THREADS
from stitchmesh.mixed.enrichment.preconditioner import Preconditioner
from stitchmesh.mixed.enrichment.solve_record import (
    ALPHA,
    BETA,
    DONE,
    FIRST_RZ,
    ITERATIONS,
    MOST,
    NEGATIVE,
    RATIO,
    RECORD,
    RZ,
    Advance,
)
from stitchmesh.mixed.mixed_vector import MixedVector

BATCH = {"cuda": 8, "cpu": 1}
"""Iterations between two looks at the record, where the host decides whether the solve has ended."""
Products = Callable[[MixedVector, MixedVector, wp.array[Any], Launcher], list[Any]]
"""From d to the launches that compute A d and the parts of d . A d."""


@kernel(tile=THREADS)
def begin(
    # state in
    parts: wp.array2d[wp.float64],
    # state in and out
    sums: wp.array2d[wp.float64],
    record: wp.array[wp.float64],
    # state out
    active: wp.array[wp.int32],
) -> None:
    """The first r . z, a record for a new solve, and whether it begins."""
    _block, lane = wp.tid()
    rz = add_parts(parts, 0, parts.shape[0], lane, sums[0])
    zero, one = wp.float64(0.0), wp.float64(1.0)
    if lane == 0:
        record[RZ] = rz
        record[FIRST_RZ] = rz
        record[ALPHA] = zero
        record[BETA] = zero
        record[DONE] = wp.where(rz > zero, zero, one)
        active[0] = wp.where(rz > zero, 1, 0)
        record[NEGATIVE] = zero
        record[ITERATIONS] = zero


@dataclass(frozen=True)
class SolveReport:
    """How a solve ended."""

    iterations: int
    """Number of products with A."""
    first_norm: float
    """Square root of the first r . z."""
    norm: float
    """Square root of the last r . z."""
    negative: bool
    """Whether a direction had negative curvature."""


class ConjugateGradients:
    """A solver whose iterations are captured once and repeated."""

    def __init__(self, shape: MixedVector, products: Products, preconditioner: Preconditioner) -> None:
        """Capture the iteration.

        Args:
            shape: a vector of the shape, precision and device of the unknowns.
            products: from a vector d and a vector to set, the launches that set the latter to A d.
            preconditioner: C.
        """
        self.solution, self.residual = shape.like(), shape.like()
        self._preconditioned, self._direction, self._product = shape.like(), shape.like(), shape.like()
        self._device = device = shape.device
        entities = shape.vertex_count + shape.node_count
        self._parts = parts_for(len(shape.values), device)
        self._of_curvature, self._of_residual = parts_for(entities, device), parts_for(entities, device)
        self._sums = wp.zeros_like(self._parts)
        self._record, self._between = (wp.zeros(RECORD, dtype=wp.float64, device=device) for _ in range(2))
        self._read, self._ends_at = HostCopy(self._record), (0.0, 0)
        self._launcher: Launcher = partial(prepare, device=device)
        self._active = wp.zeros(1, dtype=wp.int32, device=device)
        launches = self._start_launches(preconditioner), self._iteration_launches(products, preconditioner)
        batch = BATCH["cuda" if device.is_cuda else "cpu"]
        self._solve = CapturedLoop(*launches, self._active, device, batch=batch)

    def solve(self, right: MixedVector, *, tolerance: float, most_iterations: int) -> SolveReport:
        """Solve A x = b for the current A and C, and wait for the end, with the arguments of ``begin_solve``."""
        self.begin_solve(right, tolerance=tolerance, most_iterations=most_iterations)
        return self.report()

    def begin_solve(self, right: MixedVector, *, tolerance: float, most_iterations: int) -> None:
        """Begin to solve A x = b for the current A and C; later launches find the result in ``solution``.

        Args:
            right: b.
            tolerance: part of the first norm to which the norm must fall.
            most_iterations: largest number of products with A, up to a batch.
        """
        if (tolerance, most_iterations) != self._ends_at:  # a solve keeps both
            record = np.zeros(RECORD)
            record[[RATIO, MOST]] = tolerance**2, most_iterations
            self._record.assign(record)
            self._ends_at = tolerance, most_iterations
        self.residual.assign(right)
        self._solve.launch()

    def report(self) -> SolveReport:
        """Wait for the end of the last solve, and return its report."""
        record = self._read.read()
        norms = np.sqrt(np.maximum(record[[FIRST_RZ, RZ]], 0.0))
        return SolveReport(int(record[ITERATIONS]), float(norms[0]), float(norms[1]), bool(record[NEGATIVE]))

    def _start_launches(self, preconditioner: Preconditioner) -> list[Any]:
        """The launches before the first iteration."""
        z, run, count = self._preconditioned, self._launcher, len(self.residual.values)
        chunk = chunk_of(count, self._device)
        inputs = [chunk, self.residual.values, z.values]
        return [
            ZeroArray(self.solution.values),
            *preconditioner.launches(self.residual, z, run),
            CopyArray(z.values, self._direction.values),
            run(dot_parts, part_count(count, self._device), inputs, [self._parts]),
            run(begin, 1, [self._parts], [self._sums, self._record, self._active]),
        ]

    def _iteration_launches(self, products: Products, preconditioner: Preconditioner) -> list[Any]:
        """The launches of one iteration."""
        z, direction, product, run = self._preconditioned, self._direction, self._product, self._launcher
        memory = self._of_curvature, self._of_residual, self._sums, self._active
        advance = Advance(self._record, self._between, *memory, direction, product, self.solution)
        return [
            *products(direction, product, self._of_curvature, run),
            *preconditioner.advance_launches(advance, self.residual, z, run),
        ]
