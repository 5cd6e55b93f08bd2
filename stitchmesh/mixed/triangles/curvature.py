# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The bending energy of a triangulated cloth as a quadratic form in the angles of its hinges.

Discrete shells (Grinspun et al. 2003) give each hinge an energy of its own, a multiple of l^2 theta^2 / A. On the same
grid of right triangles, a cylinder then costs from 0.75 to 3 times the energy per area D kappa^2 / 2, depending on the
direction of its axis, and refinement does not help. We take the angles of discrete shells and couple neighbouring
angles so that the energy is the energy of the Morley element (Morley 1968). This plate element converges on all meshes;
its unknowns are the heights of the vertices and the slopes across the middles of the edges.

A triangle of rest area A whose sides have the lengths l_s and the inward normals n_s has the constant curvature

    kappa = sum over its sides of  (l_s / A) sigma_s n_s n_s^T

where sigma_s is the difference between the slopes of the flat triangle and of the surface at the middle of side s, both
along n_s. At each hinge, sigma_1 + sigma_2 = theta. The division of an angle is not an unknown here. We write sigma_1
as a combination of the five angles of the two triangles (the hinge and its four neighbours) that is exact for every
surface of constant curvature. Among these combinations we take the nearest to the division by the heights h of both
triangles, sigma_1 = theta h_1 / (h_1 + h_2). For a surface of curvature k in the frame (t, n) of a side with the third
vertex at (x, h) from the middle of the side

    sigma = k_tt (x^2 - l^2 / 4) / (2 h) + k_nn h / 2 + k_tn x

A cylinder therefore costs D kappa^2 / 2 per area on every mesh. Plates converge, because the element is the Morley
element on a part of its functions that still contains all quadratic functions. There is no moment at a border: the
energy is the smallest energy over the slopes of the border sides. ``slope_shares`` also finds the slopes where the
triangles end and the cloth goes on as yarns alone.

``slope_shares`` expresses the slope difference sigma of a side by the angles of nearby hinges, with a combination that
is exact for every surface of constant curvature. Of all such combinations it takes the one nearest to a first guess. At
a hinge they contain the five angles of its two triangles, and the guess is its own angle times h_1 / (h_1 + h_2). A
side behind which the cloth goes on as yarns alone has no angle, because the vertices behind it are not unknowns. Its
slope follows from six angles, of the two other sides of its triangle and of the triangles behind them, and the guess is
0.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from stitchmesh.mesh import BORDER
from stitchmesh.mixed.cloth.cloth import Cloth

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]
LEAST_SINGULAR = 1e-2
"""Part of the largest singular value below which the angles do not count as showing a direction of curvature, as where
eight vertices lie on one conic section. With a tenth of this value, some shares of irregular meshes are above 5, and a
hinge is a hundred times stiffer than the others; with ten times the value, cylinders are off by a thousandth."""


@dataclass(frozen=True, eq=False)
class SideFrames:
    """The sides of a cloth at rest, each in the coordinates of the panel of its triangle."""

    cloth: Cloth

    @cached_property
    def length(self) -> FloatArray:
        """Length of each side [cm], shape (3 T,)."""
        lengths: FloatArray = np.linalg.norm(np.diff(self.cloth.side_rest, axis=1)[:, 0], axis=1)
        return lengths

    @cached_property
    def tangent(self) -> FloatArray:
        """Direction t of each side, shape (3 T, 2)."""
        directions: FloatArray = np.diff(self.cloth.side_rest, axis=1)[:, 0] / self.length[:, None]
        return directions

    @cached_property
    def normal(self) -> FloatArray:
        """The normal n of each side that points into its triangle, to the left of t, shape (3 T, 2)."""
        return np.stack([-self.tangent[:, 1], self.tangent[:, 0]], axis=1)

    @cached_property
    def apex(self) -> FloatArray:
        """Place (x, h) of the third vertex from the middle of each side, along t and n [cm], shape (3 T, 2)."""
        across = np.roll(self.cloth.rest, -2, axis=1).reshape(-1, 2) - self.cloth.side_rest.mean(axis=1)
        return np.column_stack([(across * self.tangent).sum(axis=1), (across * self.normal).sum(axis=1)])

    @cached_property
    def sigma(self) -> FloatArray:
        """Slope difference of each side for k_tt = 1, for k_nn = 1 and for k_tn = 1 [cm], shape (3 T, 3)."""
        x, h = self.apex.T
        return np.column_stack([(x**2 - self.length**2 / 4.0) / (2.0 * h), h / 2.0, x])

    def turned(self, row: FloatArray, base: IntArray, side: IntArray) -> FloatArray:
        """Convert coefficients of k_tt, k_nn and k_tn from the frames of sides to the frames of the sides ``base``.

        Both sides belong to the same triangle; all arrays have the shape (n, 3) or (n,).
        """
        c = (self.tangent[side] * self.tangent[base]).sum(axis=1)
        s = (self.tangent[side] * self.normal[base]).sum(axis=1)
        tt, nn, tn = row.T
        return np.column_stack(
            [
                tt * c * c + nn * s * s - tn * c * s,
                tt * s * s + nn * c * c + tn * c * s,
                2.0 * c * s * (tt - nn) + tn * (c * c - s * s),
            ]
        )


@dataclass(frozen=True, eq=False)
class SlopeShares:
    """The slope difference of each side: the sum over six hinges of a share times the angle of the hinge."""

    hinge: IntArray
    """Six hinges of each side, ``BORDER`` where there is none, shape (3 T, 6)."""
    share: FloatArray
    """Shares of these hinges, shape (3 T, 6)."""


def slope_shares(frames: SideFrames, active: NDArray[np.bool_]) -> SlopeShares:
    """The shares of all sides of active triangles; sides on the border of the cloth have none.

    Args:
        frames: the sides of the cloth.
        active: whether each triangle has a weight; hinges of other triangles have no angle, shape (T,).
    """
    cloth = frames.cloth
    first, second = cloth.hinge_sides.T
    bends = active[first // 3] & active[second // 3]
    patch = _Patch(frames, np.flatnonzero(bends), first[bends], second[bends])
    hinge = np.full((len(cloth.twin), 6), BORDER)
    share = np.zeros(hinge.shape)
    at = first[bends]
    hinge[at], share[at] = patch.of_hinges(at)
    hinge[second[bends]], share[second[bends]] = hinge[at], -share[at]
    share[second[bends], 0] += 1.0
    ends = np.flatnonzero(np.repeat(active, 3) & (cloth.twin != BORDER))
    ends = ends[~active[cloth.twin[ends] // 3]]
    hinge[ends], share[ends] = patch.of_ends(ends)
    return SlopeShares(hinge, share)


class _Patch:
    """The angles of hinges as combinations of curvatures."""

    def __init__(self, frames: SideFrames, number: IntArray, first: IntArray, second: IntArray) -> None:
        """Take the hinges with an angle: their numbers and their two sides."""
        self.frames = frames
        self.hinge_of = np.full(len(frames.length), BORDER)
        self.hinge_of[first] = self.hinge_of[second] = number
        self.angle = np.zeros((len(frames.length), 3))
        self.angle[first] = self.angle[second] = frames.sigma[first] + frames.sigma[second]
        self.twin = np.where(self.hinge_of == BORDER, np.arange(len(self.hinge_of)), frames.cloth.twin)

    def of_hinges(self, side: IntArray) -> tuple[IntArray, FloatArray]:
        """Hinges and shares of sides with a hinge, shapes (n, 6)."""
        height = self.frames.apex[:, 1]
        guess = np.zeros((len(side), 6))
        guess[:, 0] = height[side] / (height[side] + height[self.twin[side]])
        both = [self._of_side(side, each) for each in (side, _next(side), _next(_next(side)))]
        behind = self._behind(side)
        return self._nearest(side, [*both, *behind], guess)

    def of_ends(self, side: IntArray) -> tuple[IntArray, FloatArray]:
        """Hinges and shares of sides without a hinge, shapes (n, 6)."""
        columns = []
        for other in (_next(side), _next(_next(side))):
            columns.append(self._of_side(side, other))
            for hinge, angle in self._behind(other):
                columns.append((hinge, self.frames.turned(angle, side, other)))
        return self._nearest(side, columns, np.zeros((len(side), 6)))

    def _of_side(self, base: IntArray, side: IntArray) -> tuple[IntArray, FloatArray]:
        """The hinge of another side of the same triangle, and its angle in the frame of ``base``."""
        return self.hinge_of[side], self.frames.turned(self.angle[side], base, side)

    def _behind(self, side: IntArray) -> list[tuple[IntArray, FloatArray]]:
        """The two other hinges of the triangle behind each side, none on a border, in the frames of the sides."""
        twin = self.twin[side]
        found = []
        for other in (_next(twin), _next(_next(twin))):
            hinge, angle = self._of_side(twin, other)
            none = twin == side
            found.append((np.where(none, BORDER, hinge), np.where(none[:, None], 0.0, angle)))
        return found

    def _nearest(
        self, side: IntArray, columns: list[tuple[IntArray, FloatArray]], guess: FloatArray
    ) -> tuple[IntArray, FloatArray]:
        """Hinges, and the shares nearest to a guess that give the right slope differences for all curvatures."""
        hinge, angles = np.full((len(side), 6), BORDER), np.zeros((len(side), 6, 3))
        for k, (number, angle) in enumerate(columns):
            hinge[:, k], angles[:, k] = number, angle / self.frames.length[side, None]
        wanted = self.frames.sigma[side] / self.frames.length[side, None] - (guess[:, None] @ angles)[:, 0]
        return hinge, guess + _least_change(angles, wanted)


def _least_change(angles: FloatArray, wanted: FloatArray) -> FloatArray:
    """The smallest change of six shares that gives the wanted combination of curvatures, (n, 6, 3), (n, 3) to (n, 6).

    The sum over j of change_j angles_jk must be wanted_k; directions that the angles hardly show are damped.
    """
    square = np.swapaxes(angles, 1, 2) @ angles
    softness = LEAST_SINGULAR**2 * np.trace(square, axis1=1, axis2=2) + np.finfo(np.float64).tiny
    square += softness[:, None, None] * np.eye(3)
    change: FloatArray = (angles @ np.linalg.solve(square, wanted[:, :, None]))[:, :, 0]
    return change


def _next(side: IntArray) -> IntArray:
    """The next side of the same triangle."""
    return side - side % 3 + (side + 1) % 3


def hinge_stiffness(cloth: Cloth, rigidities: FloatArray, weight: FloatArray) -> Any:
    """The symmetric matrix K of the energy (theta - theta_0)^T K (theta - theta_0) / 2, never negative.

    Args:
        cloth: the cloth, with H hinges.
        rigidities: matrix of bending of each triangle in the axes of its panel [dyn cm], for kappa_11, kappa_22 and
            2 kappa_12, shape (T, 3, 3).
        weight: blending weight of each triangle, shape (T,). Triangles of weight 0 do not exist: vertices that belong
            only to such triangles are not read.

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
