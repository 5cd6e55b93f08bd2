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
the smallest one over the slopes of the border sides.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from stitchmesh.mesh import BORDER
from stitchmesh.mixed.cloth.cloth import Cloth

FloatArray = NDArray[np.float64]
LEAST_SINGULAR = 1e-2
"""Part of the largest singular value below which a direction of curvature counts as one that five angles do not show,
as where eight vertices lie on one conic section. With a tenth of it some shares of irregular meshes are above 5, and a
hinge a hundred times stiffer than the others; with ten times as much cylinders are off by a thousandth."""


def hinge_stiffness(cloth: Cloth, rigidities: FloatArray, weight: FloatArray) -> Any:
    """The symmetric matrix K of the energy (theta - theta_0)^T K (theta - theta_0) / 2, never negative.

    Args:
        cloth: the cloth, with H hinges.
        rigidities: matrix of bending of each triangle in the axes of its panel [dyn cm], for kappa_11, kappa_22 and
            2 kappa_12, shape (T, 3, 3).
        weight: blending weight of each triangle, shape (T,).

    Returns:
        K [erg], a sparse matrix in compressed rows, shape (H, H).
    """
    from scipy.sparse import bsr_array, csr_array

    count = len(cloth.triangles)
    divided = slope_shares(cloth)
    hinges = np.repeat(np.arange(3 * count), 5)
    used = divided.hinge.ravel() != BORDER
    size = (3 * count, len(cloth.hinge_sides))
    shares = csr_array((divided.share.ravel()[used], (hinges[used], divided.hinge.ravel()[used])), shape=size)
    blocks = _side_stiffness(cloth, rigidities) * weight[:, None, None]
    diagonal = bsr_array((blocks, np.arange(count), np.arange(count + 1)), shape=(3 * count, 3 * count))
    stiffness = csr_array(shares.T @ (diagonal @ shares))
    stiffness.sum_duplicates()
    stiffness.sort_indices()
    return stiffness


class SlopeShares:
    """How the slope difference of each side follows from the angles of hinges: sums of ``share`` times angle."""

    def __init__(self, hinge: NDArray[np.int64], share: FloatArray) -> None:
        """Keep five hinges of each side, ``BORDER`` for none, and their shares, both of shape (3 T, 5)."""
        self.hinge = hinge
        self.share = share


def slope_shares(cloth: Cloth) -> SlopeShares:
    """The slope difference sigma of each side as a combination of angles; none on the border."""
    hinge_of = np.full(3 * len(cloth.triangles), BORDER)
    first, second = cloth.hinge_sides.T
    hinge_of[first] = hinge_of[second] = np.arange(len(first))
    tangent, height, length, own = _side_frames(cloth)
    whole = np.where((cloth.twin != BORDER)[:, None], own + own[cloth.twin], 0.0)
    others = [_next(first), _next(_next(first)), _next(second), _next(_next(second))]
    # the angle of each of the five hinges as a combination of k_tt, k_nn and k_tn in the frame of the hinge
    rows = [whole[first]] + [
        _turned(whole[side], tangent[base], tangent[side])
        for base, side in zip((first, first, second, second), others, strict=True)
    ]
    angles = np.stack(rows, axis=1) / length[first, None, None]
    share = np.zeros((len(first), 5))
    share[:, 0] = height[first] / (height[first] + height[second])
    wanted = own[first] / length[first, None] - share[:, :1] * angles[:, 0]
    share += _least_change(angles, wanted)
    five = np.column_stack([np.arange(len(first))] + [hinge_of[side] for side in others])
    hinges, shares = np.full((len(hinge_of), 5), BORDER), np.zeros((len(hinge_of), 5))
    hinges[first] = hinges[second] = five
    shares[first], shares[second] = share, -share
    shares[second, 0] += 1.0
    return SlopeShares(hinges, shares)


def _least_change(angles: FloatArray, wanted: FloatArray) -> FloatArray:
    """The smallest change of five shares that gives the wanted combination of curvatures, (H, 5, 3), (H, 3) to (H, 5).

    The sum over j of change_j angles_jk is to be wanted_k; directions that the angles hardly show are left out softly.
    """
    square = np.swapaxes(angles, 1, 2) @ angles
    softness = LEAST_SINGULAR**2 * np.trace(square, axis1=1, axis2=2)
    square += softness[:, None, None] * np.eye(3)
    change: FloatArray = (angles @ np.linalg.solve(square, wanted[:, :, None]))[:, :, 0]
    return change


def _next(side: NDArray[np.int64]) -> NDArray[np.int64]:
    """The next side of the same triangle."""
    return side - side % 3 + (side + 1) % 3


def _side_frames(cloth: Cloth) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
    """Direction (3 T, 2), height (3 T,), length (3 T,), and sigma for k_tt, k_nn, k_tn (3 T, 3), of each side."""
    ends = cloth.side_rest
    apex = np.roll(cloth.rest, -2, axis=1).reshape(-1, 2) - ends.mean(axis=1)
    length = np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1)
    tangent = (ends[:, 1] - ends[:, 0]) / length[:, None]
    x, h = (apex * tangent).sum(axis=1), (apex * _inward(tangent)).sum(axis=1)
    return tangent, h, length, np.column_stack([(x**2 - length**2 / 4.0) / (2.0 * h), h / 2.0, x])


def _inward(tangent: FloatArray) -> FloatArray:
    """The normal to the left of a direction, which points into an anticlockwise triangle."""
    return np.stack([-tangent[..., 1], tangent[..., 0]], axis=-1)


def _turned(row: FloatArray, base: FloatArray, tangent: FloatArray) -> FloatArray:
    """Coefficients of k_tt, k_nn, k_tn in the frame of a side as those in the frame of another side, ``base``."""
    c, s = (tangent * base).sum(axis=1), (tangent * _inward(base)).sum(axis=1)
    tt, nn, tn = row.T
    return np.column_stack(
        [
            tt * c * c + nn * s * s - tn * c * s,
            tt * s * s + nn * c * c + tn * c * s,
            2.0 * c * s * (tt - nn) + tn * (c * c - s * s),
        ]
    )


def _side_stiffness(cloth: Cloth, rigidities: FloatArray) -> FloatArray:
    """The energy of each triangle as a quadratic form in the slope differences of its sides [erg], shape (T, 3, 3)."""
    tangent, _height, length, _own = _side_frames(cloth)
    area = cloth.rest_area
    n = _inward(tangent)
    spread = np.stack([n[:, 0] ** 2, n[:, 1] ** 2, 2.0 * n[:, 0] * n[:, 1]], axis=1) * length[:, None]
    # column s: the curvature kappa_11, kappa_22, 2 kappa_12 that a slope difference of side s gives
    curvature = np.swapaxes(spread.reshape(-1, 3, 3), 1, 2) / area[:, None, None]
    moments = np.swapaxes(curvature, 1, 2) @ rigidities @ curvature * area[:, None, None]
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
