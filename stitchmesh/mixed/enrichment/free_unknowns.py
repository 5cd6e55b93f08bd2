# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Which coordinates of the mixed system are unknown, and which have prescribed velocities."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from stitchmesh.mixed.enrichment.region import Region, numbers_below


@dataclass(frozen=True, eq=False)
class FreeUnknowns:
    """Which coordinates move; what is fixed has a prescribed velocity instead."""

    vertices: NDArray[np.bool_]
    """Shape (V,); vertices without triangles of their own in the system are not free."""
    nodes: NDArray[np.bool_]
    """Of the simulated nodes, shape (n,)."""
    sliding: NDArray[np.bool_]
    """Eulerian coordinates (u, v) of the simulated nodes, shape (n, 2)."""

    @staticmethod
    def of(region: Region, *, fixed_vertices: ArrayLike = (), fixed_nodes: ArrayLike = ()) -> FreeUnknowns:
        """The unknowns of a region without the fixed ones.

        Args:
            region: the region of interest.
            fixed_vertices: numbers of vertices.
            fixed_nodes: numbers of nodes in the layout; nodes that are not simulated are left out. Their Eulerian
                coordinates are fixed too.

        Raises:
            ParameterError: a number does not exist.
        """
        vertices = region.unknown_vertices
        vertices[numbers_below("fixed vertices", fixed_vertices, len(vertices))] = False
        nodes = np.ones(len(region.nodes), dtype=bool)
        fixed = region.node_number[numbers_below("fixed nodes", fixed_nodes, len(region.node_triangle))]
        nodes[fixed[fixed >= 0]] = False
        return FreeUnknowns(vertices, nodes, np.repeat((nodes & region.sliding_nodes)[:, None], 2, axis=1))
