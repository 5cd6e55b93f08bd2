# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Masses of vertices and nodes from the masses of yarn segments (Casafranca et al. 2020, section 4.2).

Each segment gives the part alpha of its mass to its two nodes, half of it to each, with alpha at the centroid of the
segment. The part 1 - alpha goes to the vertices of the triangles of those ends whose alpha is between 0 and 1, by
barycentric coordinates. This is all of it where a segment leaves the hybrid region. Triangles without yarns, and hybrid
triangles that hold no node, get their mass from the density of the cloth, times 1 - alpha, a third for each vertex.

Masses are lumped: the mass matrix then is diagonal but for the Eulerian coordinates, the preconditioner inverts it
exactly, and a product with it reads no neighbours. The consistent matrix of a segment (Cirio et al. 2014) differs from
it by terms of the order of the square of the spacing of crossings over the length of a wave.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from stitchmesh.errors import ParameterError
from stitchmesh.mixed.enrichment.region import HYBRID, ROUNDING, TRIANGLES, Region, numbers_below

Numbers = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class BlendedMasses:
    """Lumped masses [g]; arrays are read-only."""

    vertices: Numbers
    """Mass of each triangle vertex, shape (V,)."""
    yarns: Numbers
    """Mass of the u yarn and of the v yarn at each simulated node, shape (n, 2)."""

    def __post_init__(self) -> None:
        for name, array in (("vertices", self.vertices), ("yarns", self.yarns)):
            if not np.isfinite(array).all() or (array < 0.0).any():
                raise ParameterError(
                    f"masses: {name}: got a mass that is negative or not finite; expected at least 0 g"
                )
            array.flags.writeable = False

    @property
    def nodes(self) -> Numbers:
        """Mass of each simulated node, shape (n,)."""
        return self.yarns.sum(axis=1)

    @property
    def total(self) -> float:
        """Mass of the whole system [g]."""
        return float(self.vertices.sum() + self.yarns.sum())


def blend_masses(
    region: Region,
    segments: ArrayLike,
    segment_mass: ArrayLike,
    segment_coordinate: ArrayLike,
    triangle_mass: ArrayLike,
    segment_alpha: ArrayLike | None = None,
) -> BlendedMasses:
    """The masses of a region.

    Args:
        region: the region of interest.
        segments: numbers in the layout of both nodes of each yarn segment, shape (E, 2).
        segment_mass: mass of each segment [g], shape (E,).
        segment_coordinate: 0 where the segment is part of the u yarn of the node, 1 for the v yarn, shape (E, 2).
        triangle_mass: mass of each triangle of the cloth [g], shape (T,).
        segment_alpha: weight of each segment, shape (E,); by default alpha at the centroid of its two nodes.

    Raises:
        ParameterError: shapes do not agree, or a mass is negative or not finite.
    """
    ends = numbers_below("nodes of the segments", segments, len(region.node_triangle)).reshape(-1, 2)
    mass, of_triangles = np.asarray(segment_mass, dtype=np.float64), np.asarray(triangle_mass, dtype=np.float64)
    coordinate = numbers_below("coordinates of the segments", segment_coordinate, 2).reshape(-1, 2)
    shapes = (mass.shape, coordinate.shape, of_triangles.shape)
    if shapes != ((len(ends),), ends.shape, (len(region.triangles),)):
        expected = ((len(ends),), ends.shape, (len(region.triangles),))
        raise ParameterError(f"masses: got segments and triangles of shapes {shapes}; expected {expected}")
    alpha = region.element_alpha(ends) if segment_alpha is None else np.asarray(segment_alpha, dtype=np.float64)
    kind = region.node_kind[ends]
    yarns = np.zeros((len(region.nodes), 2))
    kept = (alpha > 0.0)[:, None] & (kind != TRIANGLES)
    half = np.broadcast_to((mass * alpha / 2.0)[:, None], ends.shape)
    np.add.at(yarns, (region.node_number[ends[kept]], coordinate[kept]), half[kept])
    vertices = _cloth_masses(region, of_triangles)
    # Nodes at alpha = 1 lie on the border of the yarns, and keep their mass.
    hybrid = (kind == HYBRID) & (region.node_alpha[ends] < 1.0 - ROUNDING)
    # A segment that leaves the hybrid region for a triangle without yarns has half of its mass there already.
    inside = mass * (1.0 - alpha) * np.where((kind == TRIANGLES).any(axis=1), 0.5, 1.0)
    share = np.where(hybrid, (inside / np.maximum(hybrid.sum(axis=1), 1))[:, None], 0.0)
    node = ends[hybrid]
    corners = region.triangles[region.node_triangle[node]]
    # a control point beyond a border of the cloth has a negative coordinate there
    within = np.maximum(region.node_weight[node], 0.0)
    np.add.at(vertices, corners, within * (share[hybrid] / within.sum(axis=1))[:, None])
    return BlendedMasses(vertices, yarns)


def _cloth_masses(region: Region, triangle_mass: Numbers) -> Numbers:
    """Masses of the vertices by triangles whose mass is not that of their yarns, shape (V,)."""
    empty = np.ones(len(region.triangles), dtype=bool)
    empty[region.node_triangle] = False
    by_density = (region.triangle_kind == TRIANGLES) | ((region.triangle_kind == HYBRID) & empty)
    share = np.where(by_density, (1.0 - region.triangle_alpha) * triangle_mass / 3.0, 0.0)
    vertices = np.zeros(len(region.vertex_alpha))
    np.add.at(vertices, region.triangles, share[:, None])
    return vertices
