# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The error of energy of each triangle in a cloth of triangles alone, which shows where yarns are worth their time.

Yarns and triangles of one fabric store different energies in three cases. The indicator is the area of a triangle times
the sum of these differences of energy density [erg/cm^2].

*Wrinkles are missing.* Triangles of size h have no waves of half length h or less. A strip of the fabric with the
length h buckles at the compression (Euler)

    e_c = B (pi / h)^2 / Y

and carries the tension Y e_c from there on, while the triangle goes on to 1/2 Y e^2. The difference is
1/2 Y (e - e_c)^2 for a compression e > e_c. Y, B and h are taken along the direction of the smallest principal strain.

*Curves are polygons.* Along a curvature kappa, a chord replaces each arc of length h. The chord is shorter
by (kappa h)^2 / 24 of the arc, and chords turn more than arcs: 2 asin(kappa h / 2) = kappa h (1 + (kappa h)^2 / 24).
Yarns on the triangles therefore store an excess of

    1/2 Y ((kappa h)^2 / 24)^2 + 1/2 B kappa^2 (kappa h)^2 / 12,

along the direction of the largest principal curvature.

*Strains are constant.* A triangle has one strain E, where the strain of a fabric varies. A better strain is linear: at
each corner it is the mean, by area, of the triangles of the panel around this corner (Zienkiewicz and Zhu 1987). With
the differences D_k at the corners, the moduli C and D_0 = D_1 + D_2 + D_3, the mean energy density of the difference is

    1/24 (D_0 : C : D_0 + D_1 : C : D_1 + D_2 : C : D_2 + D_3 : C : D_3).

``deformation_of`` computes strain and curvature of each triangle in the axes of its panel. The strain is the membrane
strain E = (F^T F - 1) / 2. The curvature is the one in the bending energy: the angle of a hinge is divided among both
of its triangles (``triangles.curvature``), and with sigma_s the part at side s

    kappa = sum over the sides of (l_s / A) sigma_s n_s n_s^T.

Border sides have no angle of their own; they get the angle with which the curvature is smallest.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from stitchmesh.errors import ParameterError
from stitchmesh.mesh import BORDER
from stitchmesh.mixed.cloth.cloth import Cloth
from stitchmesh.mixed.triangles.cloth_material import ClothMaterial
from stitchmesh.mixed.triangles.curvature import SideFrames, SlopeShares, slope_shares

Numbers = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class TriangleDeformation:
    """Symmetric tensors of T triangles in the axes of their panels; arrays are read-only."""

    strain: Numbers
    """Green strain, shape (T, 2, 2)."""
    curvature: Numbers
    """Curvature beyond the curvature at rest [1/cm], shape (T, 2, 2); positive where a ridge is seen from outside."""

    def __post_init__(self) -> None:
        self.strain.flags.writeable = False
        self.curvature.flags.writeable = False


def deformation_of(cloth: Cloth, vertices: Numbers, shares: SlopeShares | None = None) -> TriangleDeformation:
    """Strain and curvature of a cloth.

    Args:
        cloth: the cloth, with its rest shape.
        vertices: positions of the vertices [cm], shape (V, 3).
        shares: ``shares_of(cloth)``, which is the same for all positions; computed if it is None.
    """
    places = np.asarray(vertices, dtype=np.float64)
    gradient = cloth.deformation_gradients(places)
    strain = (np.swapaxes(gradient, 1, 2) @ gradient - np.eye(2)) / 2.0
    known = shares_of(cloth) if shares is None else shares
    return TriangleDeformation(strain, _curvatures(cloth, places[cloth.triangles], known))


def shares_of(cloth: Cloth) -> SlopeShares:
    """The shares with which the slopes across the sides of all triangles follow from the angles of hinges."""
    return slope_shares(SideFrames(cloth), np.ones(len(cloth.triangles), dtype=bool))


def _curvatures(cloth: Cloth, corners: Numbers, shares: SlopeShares) -> Numbers:
    """Curvature of each triangle, shape (T, 2, 2)."""
    angle = np.append(_hinge_angles(cloth, corners) - cloth.hinge_angle, 0.0)  # the zero at the end is for BORDER
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


@dataclass(frozen=True, eq=False)
class ErrorIndicator:
    """Errors of energy of T triangles alone [erg]; arrays are read-only and of shape (T,)."""

    wrinkles: Numbers
    """Error because triangles cannot wrinkle."""
    curves: Numbers
    """Error because triangles are flat."""
    strains: Numbers
    """Error because the strain of a triangle is constant."""

    def __post_init__(self) -> None:
        for array in (self.wrinkles, self.curves, self.strains):
            array.flags.writeable = False

    @property
    def total(self) -> Numbers:
        """The sum of the three errors."""
        return self.wrinkles + self.curves + self.strains


def indicate_errors(
    cloth: Cloth,
    vertices: Numbers,
    material: ClothMaterial,
    *,
    shares: SlopeShares | None = None,
) -> ErrorIndicator:
    """The indicator of a run with triangles alone.

    Args:
        cloth: the cloth.
        vertices: positions of the vertices [cm], shape (V, 3).
        material: material of the triangles.
        shares: ``shares_of(cloth)``, which is the same for all positions; computed if it is None.

    Raises:
        ParameterError: positions are not finite or of the wrong shape.
    """
    places = np.asarray(vertices, dtype=np.float64)
    if places.shape != cloth.vertices.shape or not np.isfinite(places).all():
        found = f"got positions of shape {places.shape}, or some that are not finite"
        raise ParameterError(f"error indicator: {found}; expected finite ones of shape {cloth.vertices.shape}")
    deformation = deformation_of(cloth, places, shares)
    moduli, rigidities = (
        np.repeat(each[None], len(cloth.triangles), axis=0) for each in (material.moduli(), material.rigidities())
    )
    return ErrorIndicator(
        cloth.rest_area * _of_wrinkles(cloth, deformation, moduli, rigidities),
        cloth.rest_area * _of_curves(cloth, deformation, moduli, rigidities),
        cloth.rest_area * _of_strains(cloth, deformation, moduli),
    )


def _of_wrinkles(cloth: Cloth, deformation: TriangleDeformation, moduli: Numbers, rigidities: Numbers) -> Numbers:
    """Energy density of compression that wrinkles would release [erg/cm^2]."""
    values, vectors = np.linalg.eigh(deformation.strain)
    direction = vectors[:, :, 0]
    stiffness, rigidity = _along(moduli, direction), _along(rigidities, direction)
    buckling = rigidity * (np.pi / _extent(cloth, direction)) ** 2 / stiffness
    excess = np.maximum(-values[:, 0] - buckling, 0.0)
    result: Numbers = stiffness * excess**2 / 2.0
    return result


def _of_curves(cloth: Cloth, deformation: TriangleDeformation, moduli: Numbers, rigidities: Numbers) -> Numbers:
    """Energy density of chords that replace arcs [erg/cm^2]."""
    values, vectors = np.linalg.eigh(deformation.curvature)
    most = np.abs(values).argmax(axis=1)
    row = np.arange(len(values))
    direction, curvature = vectors[row, :, most], values[row, most]
    turn = (curvature * _extent(cloth, direction)) ** 2
    stiffness, rigidity = _along(moduli, direction), _along(rigidities, direction)
    result: Numbers = stiffness * (turn / 24.0) ** 2 / 2.0 + rigidity * curvature**2 * turn / 24.0
    return result


def _of_strains(cloth: Cloth, deformation: TriangleDeformation, moduli: Numbers) -> Numbers:
    """Energy density of the difference from strains that vary linearly [erg/cm^2]."""
    strain = deformation.strain
    voigt = np.stack([strain[:, 0, 0], strain[:, 1, 1], 2.0 * strain[:, 0, 1]], axis=1)
    corner = cloth.panel[:, None] * len(cloth.vertices) + cloth.triangles
    _, place = np.unique(corner, return_inverse=True)
    place, area = place.reshape(-1), np.repeat(cloth.rest_area, 3)
    weighted = area[:, None] * np.repeat(voigt, 3, axis=0)
    sums = np.stack([np.bincount(place, part) for part in (*weighted.T, area)], axis=1)
    apart = (sums[:, :3] / sums[:, 3:])[place].reshape(-1, 3, 3) - voigt[:, None]
    apart = np.concatenate([apart, apart.sum(axis=1, keepdims=True)], axis=1)
    result: Numbers = np.einsum("tka,tab,tkb->t", apart, moduli, apart) / 24.0
    return result


def _along(matrix: Numbers, direction: Numbers) -> Numbers:
    """Stiffness against a unit strain or curvature along a direction, shape (T,)."""
    c, s = direction.T
    unit = np.stack([c * c, s * s, 2.0 * c * s], axis=1)
    result: Numbers = np.einsum("ta,tab,tb->t", unit, matrix, unit)
    return result


def _extent(cloth: Cloth, direction: Numbers) -> Numbers:
    """Size of each triangle at rest along a direction [cm], shape (T,)."""
    result: Numbers = np.ptp(np.einsum("tka,ta->tk", cloth.rest, direction), axis=1)
    return result
