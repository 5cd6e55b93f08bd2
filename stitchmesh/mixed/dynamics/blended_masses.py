# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Masses of vertices and nodes from the masses of yarn segments (Casafranca et al. 2020, section 4.2).

Each segment gives half of its mass to each of its two nodes. In a full-yarn triangle the node keeps it. In a hybrid
triangle the node keeps the part alpha of it, alpha at the centroid of the segment, and the part 1 - alpha goes to the
vertices of the triangle by barycentric coordinates. A triangle without yarns, and a hybrid triangle that holds no node,
gets its mass from the density of the cloth, times 1 - alpha, a third for each vertex. Linear and angular momentum of a
motion of the triangles therefore are those of the yarns that they replace.

Masses are lumped: the mass matrix then is diagonal but for the Eulerian coordinates, the preconditioner inverts it
exactly, and a product with it reads no neighbours. The consistent matrix of a segment (Cirio et al. 2014) differs from
it by terms of the order of the square of the spacing of crossings over the length of a wave.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from stitchmesh.errors import ParameterError
from stitchmesh.mixed.enrichment.region import HYBRID, TRIANGLES, YARNS, Region, numbers_below

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
) -> BlendedMasses:
    """The masses of a region.

    Args:
        region: the region of interest.
        segments: numbers in the layout of both nodes of each yarn segment, shape (E, 2).
        segment_mass: mass of each segment [g], shape (E,).
        segment_coordinate: 0 where the segment is part of the u yarn of the node, 1 for the v yarn, shape (E, 2).
        triangle_mass: mass of each triangle of the cloth [g], shape (T,).

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
    half = np.repeat(mass / 2.0, 2)
    node, kind = ends.ravel(), region.node_kind[ends.ravel()]
    alpha = np.where(kind == YARNS, 1.0, np.repeat(_segment_alpha(region, ends), 2))
    yarns = np.zeros((len(region.nodes), 2))
    kept = kind != TRIANGLES
    np.add.at(yarns, (region.node_number[node[kept]], coordinate.ravel()[kept]), (half * alpha)[kept])
    vertices = _cloth_masses(region, of_triangles)
    shared = kind == HYBRID
    corners = region.triangles[region.node_triangle[node[shared]]]
    np.add.at(vertices, corners, region.node_weight[node[shared]] * (half * (1.0 - alpha))[shared, None])
    return BlendedMasses(vertices, yarns)


def _segment_alpha(region: Region, ends: NDArray[np.int64]) -> Numbers:
    """Alpha at the centroid of each segment, at least the smallest one, shape (E,)."""
    alpha: Numbers = np.maximum(region.node_alpha[ends].mean(axis=1), region.smallest_alpha)
    return alpha


def _cloth_masses(region: Region, triangle_mass: Numbers) -> Numbers:
    """Masses of the vertices by triangles whose mass is not that of their yarns, shape (V,)."""
    empty = np.ones(len(region.triangles), dtype=bool)
    empty[region.node_triangle] = False
    by_density = (region.triangle_kind == TRIANGLES) | ((region.triangle_kind == HYBRID) & empty)
    share = np.where(by_density, (1.0 - region.triangle_alpha) * triangle_mass / 3.0, 0.0)
    vertices = np.zeros(len(region.vertex_alpha))
    np.add.at(vertices, region.triangles, share[:, None])
    return vertices
