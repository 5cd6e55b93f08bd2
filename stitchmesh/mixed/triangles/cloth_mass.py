# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Masses of the triangles, which ``dynamics.blended_masses`` lumps at vertices, and of the rods along seams (C 4.2)."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike, NDArray

from stitchmesh.mixed.cloth.cloth import Cloth
from stitchmesh.mixed.triangles.cloth_material import ClothMaterial
from stitchmesh.mixed.triangles.seam_material import SeamMaterial
from stitchmesh.mixed.triangles.seam_shape import rest_lengths
from stitchmesh.mixed.triangles.weights import checked_weights, materials_of_panels


def triangle_masses(cloth: Cloth, materials: ClothMaterial | Sequence[ClothMaterial]) -> NDArray[np.float64]:
    """Mass of each triangle: area at rest times density [g], shape (T,).

    Args:
        cloth: T triangles in panels.
        materials: one material for all panels, or one for each panel.

    Raises:
        ParameterError: the number of materials is not that of the panels.
    """
    chosen = materials_of_panels(materials, len(cloth.panel_names))
    density = np.array([one.density for one in chosen])[cloth.panel if len(chosen) > 1 else 0]
    masses: NDArray[np.float64] = cloth.rest_area * density
    return masses


def rod_masses(cloth: Cloth, material: SeamMaterial, weight: ArrayLike | None = None) -> NDArray[np.float64]:
    """Lumped mass of each vertex from the rods along the seams, half of each edge at its ends [g], shape (V,).

    Args:
        cloth: a cloth with S edges on seams.
        material: density of the rods.
        weight: blending weight of each edge, shape (S,); by default 1.

    Raises:
        ParameterError: a weight is not in [0, 1].
    """
    mass = rest_lengths(cloth) * material.density * checked_weights(weight, len(cloth.seam_edges))
    lumped = np.bincount(cloth.seam_edges.ravel(), np.repeat(mass / 2.0, 2), len(cloth.vertices))
    return lumped.astype(np.float64)
