# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Masses of the vertices: a third of each triangle at rest, and half of each edge of the rods along seams (C 4.2)."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike, NDArray

from stitchmesh.mixed.cloth.cloth import Cloth
from stitchmesh.mixed.triangles.cloth_material import ClothMaterial
from stitchmesh.mixed.triangles.weights import checked_weights, materials_of_panels


def triangle_masses(
    cloth: Cloth, materials: ClothMaterial | Sequence[ClothMaterial], weight: ArrayLike | None = None
) -> NDArray[np.float64]:
    """Lumped mass of each vertex from the triangles [g], shape (V,).

    Args:
        cloth: T triangles in panels.
        materials: one material for all panels, or one for each panel.
        weight: blending weight 1 - alpha of each triangle, shape (T,); by default 1.

    Raises:
        ParameterError: the number of materials is not that of the panels, or a weight is not in [0, 1].
    """
    chosen = materials_of_panels(materials, len(cloth.panel_names))
    density = np.array([one.density for one in chosen])[cloth.panel if len(chosen) > 1 else 0]
    mass = cloth.rest_area * density * checked_weights(weight, len(cloth.triangles))
    return _lumped(cloth.triangles, mass, len(cloth.vertices))


def rod_masses(
    cloth: Cloth, density: float, lengths: NDArray[np.float64], weight: ArrayLike | None = None
) -> NDArray[np.float64]:
    """Lumped mass of each vertex from the rods along the seams [g], shape (V,).

    Args:
        cloth: a cloth with S edges on seams.
        density: mass per length [g / cm] (``SeamMaterial.density``).
        lengths: rest length of each edge [cm], shape (S,) (``seam_rod.rest_lengths``).
        weight: blending weight of each edge, shape (S,); by default 1.

    Raises:
        ParameterError: a weight is not in [0, 1].
    """
    mass = lengths * density * checked_weights(weight, len(cloth.seam_edges))
    return _lumped(cloth.seam_edges, mass, len(cloth.vertices))


def _lumped(corners: NDArray[np.int64], mass: NDArray[np.float64], count: int) -> NDArray[np.float64]:
    """Equal parts of the mass of each element at its corners, shape (count,)."""
    parts = corners.shape[1]
    return np.bincount(corners.ravel(), np.repeat(mass / parts, parts), count).astype(np.float64)
