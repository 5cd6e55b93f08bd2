# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Masses of B-spline yarns, as legs between control points.

The mass m l of a segment goes to its four control points in the parts (1, 11, 11, 1) / 24, the row sums of its mass
matrix (Leaf et al. 2018, appendix B). The three legs between them have the masses (2, 20, 2) / 24, half of which
belongs to each end. With the weight of the segment, they blend with the masses of the triangles as the yarn between
crossings does (``blended_masses``). Carried control points have no mass of their own.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from stitchmesh.mixed.dynamics.blended_masses import BlendedMasses, blend_masses
from stitchmesh.mixed.dynamics.spline_part import weights_of
from stitchmesh.mixed.enrichment.region import TRIANGLES, Region
from stitchmesh.yarn import YarnSet

OF_LEGS = np.array([2.0, 20.0, 2.0]) / 24.0
"""Parts of the mass of a segment that its three legs have."""


def spline_masses(curves: YarnSet, density: float, region: Region, triangle_mass: NDArray[np.float64]) -> BlendedMasses:
    """Return the masses of a cloth with B-spline yarns in a region.

    Args:
        curves: all yarns; their control points are the nodes of the region's layout.
        density: mass of a length of yarn [g/cm].
        region: the region of interest.
        triangle_mass: mass of each triangle of the cloth [g], shape (T,).

    Raises:
        ParameterError: shapes do not agree.
    """
    points = curves.segment_points
    legs = np.stack([points[:, :3], points[:, 1:]], axis=2).reshape(-1, 2)
    mass = (density * curves.rest_length[:, None] * OF_LEGS).reshape(-1)
    simulated = (region.node_kind[points] != TRIANGLES).any(axis=1)
    alpha = np.repeat(np.where(simulated, weights_of(points, region), 0.0), 3)
    return blend_masses(region, legs, mass, np.zeros_like(legs), triangle_mass, alpha)
