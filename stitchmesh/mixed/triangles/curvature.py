# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The bending energy of a triangulated cloth as a quadratic form in the angles of its hinges.

Discrete shells (Grinspun et al. 2003) give each hinge an energy of its own, a multiple of l^2 theta^2 / A. On one and
the same grid of right triangles a cylinder then costs from 0.75 to 3 times the energy per area D kappa^2 / 2, as the
direction of its axis changes, and refinement does not help. We take the angles of discrete shells, and couple the
neighbouring ones so that the energy is that of the Morley element (Morley 1968), a plate element that converges on all
meshes and whose unknowns are the heights of the vertices and the slopes across the middles of the edges.

A triangle of rest area A whose sides have the lengths l_s and the inward normals n_s has the constant curvature

    kappa = sum over its sides of  (l_s / A) sigma_s n_s n_s^T

where sigma_s is the difference between the slope of the flat triangle and that of the surface at the middle of side s,
both along n_s. At each hinge, sigma_1 + sigma_2 = theta. How an angle is divided is not an unknown here: we write
sigma_1 as that combination of the five angles of the two triangles (the hinge and its four neighbours) that is exact
for every surface of constant curvature, and among those the one nearest to the division by the heights h of both
triangles, sigma_1 = theta h_1 / (h_1 + h_2). For a surface of curvature k in the frame (t, n) of a side with the third
vertex at (x, h) from the middle of the side

    sigma = k_tt (x^2 - l^2 / 4) / (2 h) + k_nn h / 2 + k_tn x

A cylinder therefore costs D kappa^2 / 2 per area on every mesh, and plates converge, because the element is that of
Morley on a part of its functions that still contains all quadratic ones. There is no moment at a border: the energy is
the smallest one over the slopes of the border sides. ``slope_shares`` also finds the slopes where the triangles end and
the cloth goes on as yarns alone.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from stitchmesh.mesh import BORDER
from stitchmesh.mixed.cloth.cloth import Cloth
from stitchmesh.mixed.triangles.slope_shares import SideFrames, slope_shares

FloatArray = NDArray[np.float64]


def hinge_stiffness(cloth: Cloth, rigidities: FloatArray, weight: FloatArray) -> Any:
    """The symmetric matrix K of the energy (theta - theta_0)^T K (theta - theta_0) / 2, never negative.

    Args:
        cloth: the cloth, with H hinges.
        rigidities: matrix of bending of each triangle in the axes of its panel [dyn cm], for kappa_11, kappa_22 and
            2 kappa_12, shape (T, 3, 3).
        weight: blending weight of each triangle, shape (T,). Triangles of weight 0 do not exist: the vertices that only
            they have are not read.

    Returns:
        K [erg], a sparse matrix in compressed rows, shape (H, H).
    """
    from scipy.sparse import bsr_array, csr_array

    count, frames = len(cloth.triangles), SideFrames(cloth)
    divided = slope_shares(frames, weight > 0.0)
    sides, used = np.repeat(np.arange(3 * count), divided.hinge.shape[1]), divided.hinge.ravel() != BORDER
    size = (3 * count, len(cloth.hinge_sides))
    shares = csr_array((divided.share.ravel()[used], (sides[used], divided.hinge.ravel()[used])), shape=size)
    blocks = _side_stiffness(frames, rigidities) * weight[:, None, None]
    diagonal = bsr_array((blocks, np.arange(count), np.arange(count + 1)), shape=(3 * count, 3 * count))
    stiffness = csr_array(shares.T @ (diagonal @ shares))
    stiffness.sum_duplicates()
    stiffness.sort_indices()
    return stiffness


def hinge_angles_of(cloth: Cloth, curvature: FloatArray) -> FloatArray:
    """The angles of the hinges of a cloth with constant curvatures: -(sigma_1 + sigma_2) [rad], shape (H,).

    Args:
        cloth: the cloth.
        curvature: kappa_11, kappa_22 and 2 kappa_12 of each triangle in the axes of its panel [1/cm], positive towards
            the normals, where a hinge is a valley; shape (T, 3).
    """
    frames = SideFrames(cloth)
    course, wale, shear = np.repeat(curvature, 3, axis=0).T
    x, y = frames.tangent.T
    across = course * y**2 + wale * x**2 - shear * x * y
    twist = (wale - course) * x * y + 0.5 * shear * (x**2 - y**2)
    along = course * x**2 + wale * y**2 + shear * x * y
    slope = (frames.sigma * np.column_stack([along, across, twist])).sum(axis=1)
    angles: FloatArray = -slope[cloth.hinge_sides].sum(axis=1)
    return angles


def _side_stiffness(frames: SideFrames, rigidities: FloatArray) -> FloatArray:
    """The energy of each triangle as a quadratic form in the slope differences of its sides [erg], shape (T, 3, 3)."""
    cloth, n = frames.cloth, frames.normal
    spread = np.stack([n[:, 0] ** 2, n[:, 1] ** 2, 2.0 * n[:, 0] * n[:, 1]], axis=1) * frames.length[:, None]
    area = cloth.rest_area[:, None, None]
    # column s: the curvature kappa_11, kappa_22, 2 kappa_12 that a slope difference of side s gives
    curvature = np.swapaxes(spread.reshape(-1, 3, 3), 1, 2) / area
    moments: FloatArray = np.swapaxes(curvature, 1, 2) @ rigidities @ curvature * area
    border = (cloth.twin == BORDER).reshape(-1, 3)
    some = np.flatnonzero(border.any(axis=1))
    moments[some] = [_without(moments[t], border[t]) for t in some]
    return moments


def _without(moments: FloatArray, free: NDArray[np.bool_]) -> FloatArray:
    """A quadratic form at its smallest value over the free unknowns, with zero rows for these."""
    kept = ~free
    least = np.zeros_like(moments)
    across = moments[np.ix_(free, kept)]
    least[np.ix_(kept, kept)] = moments[np.ix_(kept, kept)] - across.T @ np.linalg.solve(
        moments[np.ix_(free, free)], across
    )
    return least
