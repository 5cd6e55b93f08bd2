# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Weights of the stretch of hybrid triangles with which uniform tension balances at the vertices.

A triangle of area A resists a uniform stress along axis c with the forces -(1 - alpha) A g_c, with the gradients g of
its linear functions. The yarns of family c, at distances h, have the forces h B' r on the vertices, with the pattern r
of ``tension_patterns``. Both sums would vanish together if yarns filled the area evenly; but the yarns that cross a
triangle are a sample of it. The weights of the hybrid triangles are therefore changed by the d of least squares of

    sum over c and vertices of (h_c B' r_c - sum of (1 - alpha + d) A g_c)^2 + e sum of A d^2

by some hundredths. With two rings and more there are as many triangles as conditions and the balance is nearly exact.
Borders of panels, where tension does not end in the cloth, have no condition.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.sparse import csr_array, vstack
from scipy.sparse.linalg import lsqr

from stitchmesh.mixed.enrichment.embedding import basis_of
from stitchmesh.mixed.enrichment.region import HYBRID, Numbers, Region

DAMPING = 0.03
"""Square root of e, for columns of unit length."""

MOST_CHANGE = 0.5
"""Largest change over 1 - alpha and over alpha. Triangles of few yarns would change by more than they weigh."""


def balanced_weights(
    region: Region, gradients: Numbers, area: Numbers, border: NDArray[np.bool_], pattern: Numbers, spacing: ArrayLike
) -> Numbers:
    """The weights of the triangles, 1 - alpha with the change d, shape (T,).

    Args:
        region: the region of interest.
        gradients: gradients of the linear functions of the corners at rest [1/cm], shape (T, 3, 2); axis c is the
            direction of the yarns of family c.
        area: area of the triangles at rest [cm^2], shape (T,).
        border: whether vertices lie on the border of a panel, shape (V,).
        pattern: weights of the segments after less those before each hybrid node, also at ends, shape (H, 2).
        spacing: distances of the yarns of both families [cm].
    """
    weight: Numbers = 1.0 - region.triangle_alpha
    hybrid = np.flatnonzero((region.triangle_kind == HYBRID) & (weight > 0.0))
    node = np.flatnonzero(region.node_kind == HYBRID)
    held = np.setdiff1d(region.triangles[hybrid], np.flatnonzero(border))
    if len(held) == 0:
        return weight
    corners = region.triangles[region.node_triangle[node]]
    basis = basis_of(corners, region.node_weight[node], len(region.vertex_alpha))
    rows, wanted = [], []
    for c, distance in enumerate(np.asarray(spacing, dtype=np.float64)):
        pull = _pulls(region.triangles, gradients[:, :, c] * area[:, None], len(region.vertex_alpha))
        left = distance * (basis.T @ pattern[:, c]) - pull @ weight
        rows.append(pull[held][:, hybrid])
        wanted.append(left[held])
    scale = 1.0 / np.sqrt(area[hybrid])
    system = csr_array(vstack(rows)) * scale[None, :]
    length = np.sqrt(np.mean(np.asarray(system.power(2).sum(axis=0))))
    change = scale * lsqr(system, np.concatenate(wanted), damp=DAMPING * length, atol=1e-12, btol=1e-12)[0]
    most = MOST_CHANGE * np.minimum(weight[hybrid], 1.0 - weight[hybrid])
    weight[hybrid] += np.clip(change, -most, most)
    return weight


def _pulls(triangles: NDArray[np.int64], values: Numbers, vertices: int) -> csr_array:
    """Matrix of the forces of a unit stress in each triangle on the vertices, shape (V, T)."""
    column = np.repeat(np.arange(len(triangles)), 3)
    return csr_array((values.ravel(), (triangles.ravel(), column)), shape=(vertices, len(triangles)))
