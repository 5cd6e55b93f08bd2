# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""How much energy triangles alone are wrong by, for each triangle of a cloth: where yarns are worth their time.

Yarns and triangles of one fabric store different energies in three cases. The indicator is the area of a triangle times
the sum of these differences of energy density [erg/cm^2].

*Wrinkles are missing.* Triangles of size h have no waves of half length h or less. A strip of the fabric of that length
buckles at the compression (Euler)

    e_c = B (pi / h)^2 / Y

and carries the tension Y e_c from there on, while the triangle goes on to 1/2 Y e^2. The difference is
1/2 Y (e - e_c)^2 for a compression e > e_c. Y, B and h are taken along the direction of the smallest principal strain.

*Curves are polygons.* Along a curvature kappa, an arc of length h is replaced by its chord, which is shorter by
(kappa h)^2 / 24 of it, and chords turn more than arcs: 2 asin(kappa h / 2) = kappa h (1 + (kappa h)^2 / 24). Yarns on
the triangles therefore store too much by

    1/2 Y ((kappa h)^2 / 24)^2 + 1/2 B kappa^2 (kappa h)^2 / 12,

along the direction of the largest principal curvature.

*Strains are constant.* A triangle has one strain E, where the strain of a fabric varies. A better one is linear: at
each corner the mean of the triangles of the panel around it, by area (Zienkiewicz and Zhu 1987). With the differences
D_k at the corners, the moduli C and D_0 = D_1 + D_2 + D_3, the mean energy density of the difference is

    1/24 (D_0 : C : D_0 + D_1 : C : D_1 + D_2 : C : D_2 + D_3 : C : D_3).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from stitchmesh.errors import ParameterError
from stitchmesh.mixed.cloth.cloth import Cloth
from stitchmesh.mixed.placement.triangle_deformation import TriangleDeformation, deformation_of
from stitchmesh.mixed.triangles.cloth_material import ClothMaterial
from stitchmesh.mixed.triangles.slope_shares import SlopeShares
from stitchmesh.mixed.triangles.weights import materials_of_panels

Numbers = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class ErrorIndicator:
    """Energies by which T triangles alone are wrong [erg]; arrays are read-only and of shape (T,)."""

    wrinkles: Numbers
    """Because triangles cannot wrinkle."""
    curves: Numbers
    """Because triangles are flat."""
    strains: Numbers
    """Because the strain of a triangle is constant."""

    def __post_init__(self) -> None:
        for array in (self.wrinkles, self.curves, self.strains):
            array.flags.writeable = False

    @property
    def total(self) -> Numbers:
        """The sum."""
        return self.wrinkles + self.curves + self.strains


def indicate_errors(
    cloth: Cloth,
    vertices: Numbers,
    materials: ClothMaterial | Sequence[ClothMaterial],
    *,
    shares: SlopeShares | None = None,
) -> ErrorIndicator:
    """The indicator of a run with triangles alone.

    Args:
        cloth: the cloth.
        vertices: positions of the vertices [cm], shape (V, 3).
        materials: one material for all panels, or one for each panel.
        shares: ``shares_of(cloth)``, which are the same for all positions; computed if it is None.

    Raises:
        ParameterError: positions are not finite or of another shape, or the number of materials is wrong.
    """
    places = np.asarray(vertices, dtype=np.float64)
    if places.shape != cloth.vertices.shape or not np.isfinite(places).all():
        found = f"got positions of shape {places.shape}, or some that are not finite"
        raise ParameterError(f"error indicator: {found}; expected finite ones of shape {cloth.vertices.shape}")
    deformation = deformation_of(cloth, places, shares)
    chosen = materials_of_panels(materials, len(cloth.panel_names))
    which = cloth.panel if len(chosen) > 1 else np.zeros(len(cloth.panel), dtype=np.int64)
    moduli = np.array([material.moduli() for material in chosen])[which]
    rigidities = np.array([material.rigidities() for material in chosen])[which]
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
    """Energy density of chords in the place of arcs [erg/cm^2]."""
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
