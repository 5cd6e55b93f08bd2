# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""How stiff each control point is held: the mass scaling of the relaxation.

Only the state of rest matters, so each control point is given the mass at which it is as fast as stability allows. For
an energy with Hessian H, the row sums D_i = sum_j |H_ij| bound H by the diagonal D (Gershgorin): steps F_i / D_i lower
the energy. Per segment, with B' and B'' the derivatives of the four basis functions at the rest shape:

    stretch  2 k_len / l^2    sum_j |int B'_i B'_j|          along the yarn
    length   2 k_length / l^2 sum_j |int B'_i int B'_j|      along the yarn
    bending  2 k_bend / l^3   sum_j |int B''_i B''_j|        across the yarn

Contact adds its own row sums as they change (``contact``).
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from stitchmesh.yarn import basis_derivative
from stitchmesh.yarnrelax.model import Model


def internal_stiffness(model: Model) -> NDArray[np.float64]:
    """Row sums of the stiffness of stretch, length and bending [dyn / cm], shape (N,)."""
    yarns, material = model.yarns, model.material
    length = yarns.rest_length[:, None]
    along = 2 * (material.k_len * _rows(_gram(1)) + material.k_length * _rows(_mean_gram())) / length**2
    rows = along + 2 * material.k_bend * _rows(_gram(2)) / length**3
    total = np.bincount(yarns.segment_points.ravel(), weights=rows.ravel(), minlength=model.point_count)
    return total.astype(np.float64)


def _rows(matrix: NDArray[np.float64]) -> NDArray[np.float64]:
    return np.abs(matrix).sum(axis=1)


def _gram(order: int) -> NDArray[np.float64]:
    """Integrals of products of the basis functions' first or second derivatives, shape (4, 4)."""
    s, weights = _gauss()
    second = np.stack([1 - s, 3 * s - 2, 1 - 3 * s, s], axis=1)
    values = basis_derivative(s) if order == 1 else second
    return np.einsum("g,gi,gj->ij", weights, values, values)


def _mean_gram() -> NDArray[np.float64]:
    """Products of the integrals of the first derivatives, shape (4, 4)."""
    s, weights = _gauss()
    mean = weights @ basis_derivative(s)
    return np.outer(mean, mean)


def _gauss() -> tuple[NDArray[np.float64], Any]:
    nodes, weights = np.polynomial.legendre.leggauss(4)  # exact for products of second-order polynomials
    return (nodes + 1) / 2, weights / 2
