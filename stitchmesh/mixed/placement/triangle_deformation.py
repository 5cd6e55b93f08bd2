# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Strain and curvature of each triangle of a cloth, in the axes of its panel.

The strain is that of the membrane, E = (F^T F - 1) / 2. The curvature is that of the bending energy: with the angle of
a hinge divided among both of its triangles (``triangles.slope_shares``), sigma_s the part at side s,

    kappa = sum over the sides of (l_s / A) sigma_s n_s n_s^T.

Border sides have no angle. Theirs is the one with which the curvature is smallest.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from stitchmesh.mesh import BORDER
from stitchmesh.mixed.cloth.cloth import Cloth
from stitchmesh.mixed.triangles.slope_shares import SideFrames, SlopeShares, slope_shares

Numbers = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class TriangleDeformation:
    """Symmetric tensors of T triangles in the axes of their panels; arrays are read-only."""

    strain: Numbers
    """Green strain, shape (T, 2, 2)."""
    curvature: Numbers
    """Curvature beyond that at rest [1/cm], shape (T, 2, 2); positive where a ridge is seen from outside."""

    def __post_init__(self) -> None:
        self.strain.flags.writeable = False
        self.curvature.flags.writeable = False


def deformation_of(cloth: Cloth, vertices: Numbers, shares: SlopeShares | None = None) -> TriangleDeformation:
    """Strain and curvature of a cloth.

    Args:
        cloth: the cloth, with its rest shape.
        vertices: positions of the vertices [cm], shape (V, 3).
        shares: ``shares_of(cloth)``, which are the same for all positions; computed if it is None.
    """
    corners = np.asarray(vertices, dtype=np.float64)[cloth.triangles]
    edges = np.swapaxes(corners[:, 1:] - corners[:, :1], 1, 2)
    rest = np.swapaxes(cloth.rest[:, 1:] - cloth.rest[:, :1], 1, 2)
    gradient = edges @ np.linalg.inv(rest)
    strain = (np.swapaxes(gradient, 1, 2) @ gradient - np.eye(2)) / 2.0
    return TriangleDeformation(strain, _curvatures(cloth, corners, shares_of(cloth) if shares is None else shares))


def shares_of(cloth: Cloth) -> SlopeShares:
    """How the slopes across the sides of all triangles follow from the angles of hinges."""
    return slope_shares(SideFrames(cloth), np.ones(len(cloth.triangles), dtype=bool))


def _curvatures(cloth: Cloth, corners: Numbers, shares: SlopeShares) -> Numbers:
    """Curvature of each triangle, shape (T, 2, 2)."""
    angle = np.append(_hinge_angles(cloth, corners) - cloth.hinge_angle, 0.0)  # BORDER reads the zero at the end
    hinge = np.where(shares.hinge == BORDER, len(angle) - 1, shares.hinge)
    slope = (shares.share * angle[hinge]).sum(axis=1).reshape(-1, 3)
    ends = cloth.side_rest
    along = ends[:, 1] - ends[:, 0]
    across = np.stack([-along[:, 1], along[:, 0]], axis=1)
    # l n n^T / A, with n of unit length
    of_side = across[:, :, None] * across[:, None, :] / np.linalg.norm(along, axis=1)[:, None, None]
    of_side = of_side.reshape(-1, 3, 2, 2) / cloth.rest_area[:, None, None, None]
    border = (cloth.twin == BORDER).reshape(-1, 3)
    curvature = np.einsum("ts,tsab->tab", np.where(border, 0.0, slope), of_side)
    for t in np.flatnonzero(border.any(axis=1)):
        free = of_side[t, border[t]].reshape(-1, 4).T
        amount = np.linalg.lstsq(free, -curvature[t].ravel(), rcond=None)[0]
        curvature[t] += (free @ amount).reshape(2, 2)
    result: Numbers = curvature
    return result


def _hinge_angles(cloth: Cloth, corners: Numbers) -> Numbers:
    """Angle of each hinge as ``Cloth`` defines it, shape (H,)."""
    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    normal /= np.maximum(np.linalg.norm(normal, axis=1), np.finfo(np.float64).tiny)[:, None]
    first, second = cloth.hinge_sides.T
    start, end = corners[first // 3, first % 3], corners[first // 3, (first + 1) % 3]
    edge = end - start
    edge /= np.maximum(np.linalg.norm(edge, axis=1), np.finfo(np.float64).tiny)[:, None]
    one, other = normal[first // 3], normal[second // 3]
    sine, cosine = np.einsum("ij,ij->i", edge, np.cross(one, other)), np.einsum("ij,ij->i", one, other)
    angles: Numbers = np.arctan2(sine, cosine)
    return angles
