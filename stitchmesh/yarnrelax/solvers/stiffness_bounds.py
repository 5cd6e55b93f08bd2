# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Upper bounds of the stiffness at each control point: row sums of the Hessian.

The quasistatic solver needs no true masses; it scales its steps by bounds of stiffness. For an energy with Hessian H,
the row sums D_i = sum_j |H_ij| bound H by the diagonal D (Gershgorin), so steps F_i / D_i lower the energy. For each
segment, with B' and B'' the derivatives of the four basis functions at the rest shape:

    stretch, length   2 (k_len + k_length) / l^2  int |B'_i| sum_j |B'_j|      along the yarn
    bending           2 k_bend / l^3              int |B''_i| sum_j |B''_j|    across the yarn

The sums of both hold in all directions, even with the dependence of bending on y', because stretch is much stiffer
(``preconditioner``). Contact adds its own row sums, which change (``contact``).
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from stitchmesh.yarn import basis_derivative
from stitchmesh.yarnrelax.model.constants import Model


def stiffness_row_sums(model: Model) -> NDArray[np.float64]:
    """Row sums of the stiffness of stretch, length and bending at each control point [erg / unit^2], shape (N,)."""
    return _at_points(model, stretch_row_sums(model) + bend_row_sums(model))


def bend_stiffness(model: Model) -> NDArray[np.float64]:
    """Row sums of the stiffness of bending at each control point [erg / unit^2], shape (N,)."""
    return _at_points(model, bend_row_sums(model))


def _at_points(model: Model, rows: NDArray[np.float64]) -> NDArray[np.float64]:
    points = model.yarns.segment_points.ravel()
    return np.bincount(points, weights=rows.ravel(), minlength=model.point_count).astype(np.float64)


def stretch_row_sums(model: Model) -> NDArray[np.float64]:
    """Row sums along the yarn, for each of a segment's four control points [erg / unit^2], shape (S, 4)."""
    stiffness = model.segment_stiffness[:, :2].sum(axis=1, keepdims=True)
    return 2 * stiffness * _swept_rows(1) / model.rest_length[:, None] ** 2


def bend_row_sums(model: Model) -> NDArray[np.float64]:
    """Row sums across the yarn, for each of a segment's four control points [erg / unit^2], shape (S, 4)."""
    return 2 * model.segment_stiffness[:, 2:] * _swept_rows(2) / model.rest_length[:, None] ** 3


def _swept_rows(order: int) -> NDArray[np.float64]:
    """Return the integrals of |B_i| sum_j |B_j| with first or second derivatives of the basis functions, shape (4,).

    The magnitudes are inside the integral, because the direction of the yarn turns along a segment.
    """
    nodes, weights = np.polynomial.legendre.leggauss(8)  # the kinks of the magnitudes leave an error of 0.1 %
    s = (nodes + 1) / 2
    second = np.stack([1 - s, 3 * s - 2, 1 - 3 * s, s], axis=1)
    size = np.abs(basis_derivative(s) if order == 1 else second)
    return np.asarray((weights / 2) @ (size * size.sum(axis=1, keepdims=True)))
