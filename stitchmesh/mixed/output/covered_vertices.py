# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Positions of the vertices in the full-yarn region, where only yarns are simulated.

A vertex all of whose triangles are full-yarn triangles has no position of its own. For display, for normals and for a
run that goes on with another region, it is placed so that the triangles follow the yarn nodes: the positions v of these
vertices minimize

    sum over the nodes in their triangles of |p_i - (B v)_i|^2 + e sum over their triangles of |D v - D r|^2

where D v are the differences between the corners of a triangle and D r those of the initial shape, by which vertices
are placed where triangles hold too few nodes.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from scipy.sparse import csr_array

from stitchmesh.mesh import FloatArray, IntArray
from stitchmesh.mixed.cloth.cloth import Cloth
from stitchmesh.mixed.enrichment.embedding import basis_of
from stitchmesh.mixed.enrichment.region import Region

SOFTNESS = 1e-4
"""The number e: small, so that it decides only what the nodes leave open."""


class CoveredVertices:
    """The vertices without a position of their own; the matrix of their positions is factored once."""

    def __init__(self, cloth: Cloth, region: Region) -> None:
        """Factor the matrix.

        Args:
            cloth: the cloth, whose initial shape decides what the nodes leave open.
            region: the region of interest.
        """
        self.covered: IntArray = np.flatnonzero(~region.unknown_vertices)
        """Vertices that are placed, ascending, shape (n,)."""
        self._known = np.flatnonzero(region.unknown_vertices)
        if not len(self.covered):
            return
        basis = basis_of(region.triangles[region.node_triangle], region.node_weight, len(cloth.vertices))
        near = np.flatnonzero(abs(basis[:, self.covered]).sum(axis=1) > 0.0)
        self._nodes, self._basis = near, csr_array(basis[near])
        self._sides = _side_differences(cloth, self.covered)
        self._initial = self._sides @ cloth.vertices
        self._solve = self._factored()

    def placed(self, vertices: FloatArray, nodes: FloatArray) -> FloatArray:
        """Return the positions of all vertices, with those of the covered ones from the nodes, shape (V, 3).

        Args:
            vertices: positions of the vertices [cm], shape (V, 3).
            nodes: positions of all nodes of the layout [cm], shape (N, 3); only those near covered vertices are used.
        """
        if not len(self.covered):
            return vertices
        known = np.zeros_like(vertices)
        known[self._known] = vertices[self._known]
        right = self._basis[:, self.covered].T @ (nodes[self._nodes] - self._basis @ known)
        right += SOFTNESS * (self._sides[:, self.covered].T @ (self._initial - self._sides @ known))
        known[self.covered] = self._solve(right)
        return known

    def _factored(self) -> Any:
        from scipy.sparse.linalg import splu

        of_nodes, of_sides = self._basis[:, self.covered], self._sides[:, self.covered]
        square = of_nodes.T @ of_nodes + SOFTNESS * (of_sides.T @ of_sides)
        return splu(square.tocsc()).solve


def _side_differences(cloth: Cloth, covered: IntArray) -> csr_array:
    """Differences between the ends of all sides of triangles with a covered vertex, shape (sides, V)."""
    touched = np.isin(cloth.side_vertices, covered).any(axis=1)
    ends = cloth.side_vertices[touched]
    rows, values = np.repeat(np.arange(len(ends)), 2), np.tile([-1.0, 1.0], len(ends))
    return csr_array((values, (rows, ends.ravel())), shape=(len(ends), len(cloth.vertices)))
