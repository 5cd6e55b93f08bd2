# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Matrices of cells beside the processor and on a device."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import warp as wp
from scipy.sparse import csc_array

from stitchmesh.compute.device import device_named
from stitchmesh.yarnrelax.hessian.cell_matrices import CellMatrices, Owners
from stitchmesh.yarnrelax.hessian.couplings import CouplingRows
from stitchmesh.yarnrelax.hessian.matrices_on_gpu import MatricesOnGpu, PatternOnGpu
from stitchmesh.yarnrelax.hessian.matrices_on_host import MatricesOnHost

Place = Callable[[Owners, csc_array], CellMatrices]


def on_host(owners: Owners, matrix: csc_array) -> MatricesOnHost:
    return MatricesOnHost(matrix, owners)


def pattern_of(
    matrix: csc_array, device: wp.Device, group: np.ndarray, former: PatternOnGpu | None = None
) -> PatternOnGpu:
    parts = (wp.array(part, dtype=wp.int32, device=device) for part in (matrix.indptr, matrix.indices))
    return PatternOnGpu(*parts, group, CouplingRows([]), former)


def on_device(name: str, owners: Owners, matrix: csc_array) -> MatricesOnGpu:
    """The matrices as on a GPU; without factors, which are cuDSS's, also on the processor."""
    device = device_named(name)
    pattern = pattern_of(matrix, device, np.where(owners.cell == 2, 1, 0))  # a group of two cells, and one of one cell
    return MatricesOnGpu(pattern, wp.array(matrix.data, dtype=wp.float64, device=name), owners)
