# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The part of a mixed system that B-spline yarns add: energy and masses of the yarns in and beside the region.

As for all elements of yarns (``term``), the weight of a segment comes from alpha at its control points. The triangles
carry the control points beside the region, whose alpha is zero, as far as yarns of the region touch them. Each weight
is at least the smallest weight of the region.

The mass m l of a segment goes to its four control points in the parts (1, 11, 11, 1) / 24, the row sums of its mass
matrix (Leaf et al. 2018, appendix B). In other words, the three legs between them have the masses (2, 20, 2) / 24, half
of which belongs to each end. With the weight of the segment, they blend with the masses of the triangles like the yarn
between crossings (``mass_matrix``). Carried control points have no mass of their own.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import warp as wp
from numpy.typing import NDArray

from stitchmesh.compute.precision import ScalarType
from stitchmesh.mixed.cloth.cloth import Cloth
from stitchmesh.mixed.dynamics.mass_matrix import BlendedMasses, blend_masses
from stitchmesh.mixed.enrichment.region import TRIANGLES, Region
from stitchmesh.mixed.layout.spline_yarns import SplineYarns
from stitchmesh.mixed.splines.carried_points import CarriedSplinePoints, Carrier
from stitchmesh.mixed.splines.spline_pieces import SplineMaterial, spline_pieces
from stitchmesh.mixed.splines.spline_term import SplineTerm
from stitchmesh.mixed.term import FULL, element_weight
from stitchmesh.yarn import YarnSet

REACH = 2
"""Rings of triangles around the region on which yarns are carried: a loop reaches through one stitch to the next."""
OF_LEGS = np.array([2.0, 20.0, 2.0]) / 24.0
"""Parts of the mass of a segment that belong to its three legs."""
Numbers = NDArray[np.float64]
Integers = NDArray[np.int64]


def spline_term(
    cloth: Cloth, yarns: SplineYarns, material: SplineMaterial, region: Region, scalar: ScalarType, device: wp.Device
) -> SplineTerm | None:
    """Return the energy of B-spline yarns in a region; None without yarns in it.

    Args:
        cloth: the cloth, in the shape in which the yarns were laid out.
        yarns: the yarns, everywhere on it.
        material: material of the yarns.
        region: the region of interest.
        scalar: Warp's floating-point type.
        device: where the term runs.
    """
    if len(region.nodes) == 0:
        return None
    near = np.flatnonzero(_near(region)[region.node_triangle])
    pieces = spline_pieces(yarns.curves, nodes=near, alpha=spline_weights(yarns, region, near))
    if pieces.curves is None:
        return None
    point = near[pieces.node]
    own = replace(pieces, node=region.node_number[point])
    carried = np.flatnonzero(own.node < 0)
    carrier = None
    if len(carried):
        triangle = yarns.triangle[point[carried]]
        places = CarriedSplinePoints(
            point=carried,
            corners=cloth.triangles[triangle],
            weight=yarns.barycentric[point[carried]],
            place=yarns.curves.points[point[carried]],
        )
        carrier = Carrier(places, cloth.vertices, scalar, device)
    return SplineTerm(own, material, scalar, device, carrier=carrier)


def weights_of(points: Integers, region: Region) -> Numbers:
    """Return the weight of segments, at least the smallest weight of the region, shape (S,).

    Args:
        points: control points of the segments, shape (S, 4).
        region: the region of interest.
    """
    alpha = region.node_alpha[points]
    weight = element_weight(alpha, np.ones_like(alpha, dtype=bool), alpha >= FULL)
    return np.maximum(weight, region.smallest_alpha)


def spline_weights(yarns: SplineYarns, region: Region, near: Integers) -> Numbers:
    """Return the weight of each segment, 0 where a control point is neither simulated nor carried, shape (S,).

    Args:
        yarns: the yarns.
        region: the region of interest.
        near: control points that are simulated or carried, ascending.
    """
    points = yarns.curves.segment_points
    present = np.zeros(yarns.node_count, dtype=bool)
    present[near] = True
    return np.where(present[points].all(axis=1), weights_of(points, region), 0.0)


def _near(region: Region) -> NDArray[np.bool_]:
    """Whether each triangle belongs to the region or lies within ``REACH`` rings around it, shape (T,)."""
    near = np.asarray(region.triangle_kind != TRIANGLES)
    for _ in range(REACH):
        reached = np.zeros(len(region.vertex_alpha), dtype=bool)
        reached[region.triangles[near]] = True
        near = np.asarray(reached[region.triangles].any(axis=1))
    return near


def spline_masses(curves: YarnSet, density: float, region: Region, triangle_mass: Numbers) -> BlendedMasses:
    """Return the masses of a cloth with B-spline yarns in a region.

    Args:
        curves: all yarns; their control points are the nodes of the region's layout.
        density: mass per length of yarn [g/cm].
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
