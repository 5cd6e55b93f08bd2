# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The coarse part of the preconditioner of Newton's method: rigid motions of pieces of yarn, strains of the cell.

The blocks at the control points are stiff, because yarn hardly stretches, and conjugate gradients need many products
until a motion of one of them has reached a whole stitch. The soft motions of a fabric move and turn pieces of yarn
almost rigidly. With the matrix P of such motions (``coarse_motions``), the preconditioner is

    C = blocks at the control points  +  P (P^T H P)^-1 P^T

with H the matrix of Gauss and Newton (two-level additive Schwarz; Toselli and Widlund 2005, section 3). The small
matrices of all cells are assembled (``coarse_matrix``) and inverted (``coarse_inverse``) on the device once in each
Newton step, in a fixed order.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import warp as wp
from numpy.typing import NDArray

from stitchmesh.compute.captured import CapturedLaunches, Launcher
from stitchmesh.yarnrelax.hessian.hessian_product import Hessian
from stitchmesh.yarnrelax.model.constants import Model
from stitchmesh.yarnrelax.solvers.coarse_inverse import Inverses
from stitchmesh.yarnrelax.solvers.coarse_matrix import (
    assemble_rows,
    put_strain_row,
    raise_diagonal,
    sum_lengths,
    sum_scales,
)
from stitchmesh.yarnrelax.solvers.coarse_motions import (
    add_coarse_motions,
    place_groups,
    put_groups,
    restrict_vectors,
)

THREADS = 64
"""Threads of a block on a GPU."""


class CoarseSpace:
    """The coarse motions of cells on a device."""

    def __init__(self, model: Model, strains: int) -> None:
        """Divide the yarns into groups; ``strains`` is the number of cells that relax."""
        self.model, self.strains, device = model, strains, model.device
        self.groups = groups = put_groups(model, strains)
        counts = np.diff(groups.of_cell.numpy())
        self.count, self.threads = len(groups.cell), THREADS if device.is_cuda else 1
        self.matrix = wp.zeros(int(((6 * counts) ** 2).sum()), dtype=wp.float64, device=device)
        """The matrices of the cells, one after the other, and after ``invert`` their inverses."""
        self.coarse, self.motion = (self._sums(self.count) for _ in range(2))
        self.scales, self.lengths = (self._sums(model.cell_count) for _ in range(2))

    def prepare(self, hessian: Hessian, points: wp.array[Any], level: wp.array[Any], damping: wp.array[Any]) -> None:
        """Capture the launches of ``invert``; ``level`` and ``damping`` of the entries, shape (E,)."""
        model, launcher = self.model, self.model.prepare
        launches = self.matrix_launches(hessian, points, level, damping, launcher)
        self._assemble = CapturedLaunches(launches, model.device)
        self._inverses = Inverses(model, self.groups, self.matrix)

    def invert(self, cells: NDArray[np.bool_]) -> None:
        """Assemble the matrices of some cells in the current state, shape (C,), and invert them.

        All other cells are marked as resting (``Model.resting``) and keep their inverses.
        """
        self._assemble.launch()
        self._inverses.invert(cells)

    def apply_launches(
        self, points: wp.array[Any], residual: wp.array[Any], vectors: wp.array[Any], launcher: Launcher
    ) -> list[Any]:
        """The launches that add the coarse part of the preconditioned ``residual`` to ``vectors``, both (E, 3)."""
        inputs = [self.model.constants, self.groups, points, self.matrix, self.coarse, self.motion, vectors]
        add = launcher(add_coarse_motions, self.count, inputs, [], tile=self.threads)
        return [self._restrict(points, residual, launcher), add]

    def matrix_launches(
        self, hessian: Hessian, points: wp.array[Any], level: wp.array[Any], damping: wp.array[Any], launcher: Launcher
    ) -> list[Any]:
        """The launches that assemble the matrices."""
        pairs, model = hessian.touching, self.model
        inputs = [model.constants, points, hessian.leg_hessian, pairs.count, pairs.entries, pairs.stiffness,
                  level, damping, self.groups]  # fmt: skip
        launches = [
            launcher(place_groups, self.count, [points, self.groups], []),
            launcher(assemble_rows, 6 * self.count, inputs, [self.matrix]),
        ]
        if hessian.strain is not None:
            launches += self._strain_launches(hessian, points, launcher)
        return launches + self._regular_launches(launcher)

    def _strain_launches(self, hessian: Hessian, points: wp.array[Any], launcher: Launcher) -> list[Any]:
        """The rows of the strains, from products with a unit of each."""
        model, launches = self.model, list[Any]()
        product = model.empty(model.point_count + self.strains, 3)
        for k in range(3):
            unit = np.zeros((len(product), 3))
            unit[model.point_count :, k] = 1.0
            motion = model.upload(unit, 3)
            inputs = [model.constants, self.groups, k, model.point_count, hessian.strain.free, product, self.coarse]
            launches += [
                *hessian.product_launches(motion, product, launcher),
                self._restrict(points, product, launcher),
                launcher(put_strain_row, self.count, inputs, [self.matrix]),
            ]
        return launches

    def _regular_launches(self, launcher: Launcher) -> list[Any]:
        """What keeps the matrices regular; a cell on a lattice cannot turn."""
        model, groups = self.model, self.groups
        cells, lanes = model.cell_count, self.threads
        turns = 0 if model.on_lattice else 1
        launches = [launcher(sum_scales, cells, [model.constants, groups, self.matrix], [self.scales], tile=lanes)]
        if turns:
            launches.append(launcher(sum_lengths, cells, [groups, self.scales], [self.lengths], tile=lanes))
        inputs = [model.constants, groups, turns, self.scales, self.lengths, self.matrix]
        return [*launches, launcher(raise_diagonal, self.count, inputs, [], tile=lanes)]

    def _restrict(self, points: wp.array[Any], vectors: wp.array[Any], launcher: Launcher) -> Any:
        inputs = [self.model.constants, self.groups, points, vectors]
        return launcher(restrict_vectors, self.count, inputs, [self.coarse], tile=self.threads)

    def _sums(self, count: int) -> wp.array[Any]:
        """Sums of blocks of threads."""
        return wp.zeros((count, 7), dtype=wp.float64, device=self.model.device)
