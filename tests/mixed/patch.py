# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""A square patch of triangles with yarn nodes on a grid, for the tests of the mixed system."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from stitchmesh.mixed.enrichment.region import HYBRID, Region


@dataclass(frozen=True, eq=False)
class Patch:
    """Vertices on a grid of squares, two triangles a square, nodes on a finer grid."""

    vertices: np.ndarray
    triangles: np.ndarray
    nodes: np.ndarray
    node_triangle: np.ndarray
    node_weight: np.ndarray
    nodes_a_side: int

    @property
    def layout(self) -> tuple[np.ndarray, int, np.ndarray, np.ndarray]:
        """What a region is made from."""
        return self.triangles, len(self.vertices), self.node_triangle, self.node_weight

    def segments(self) -> np.ndarray:
        """Neighbouring nodes along both families of yarns, shape (S, 2)."""
        number = np.arange(self.nodes_a_side**2).reshape(self.nodes_a_side, -1)
        pairs = [(number[:, :-1], number[:, 1:]), (number[:-1], number[1:])]
        return np.concatenate([np.stack([a.ravel(), b.ravel()], axis=1) for a, b in pairs])

    def edges(self) -> np.ndarray:
        """Edges of the triangles, shape (E, 2)."""
        pairs = np.concatenate([self.triangles[:, [k, (k + 1) % 3]] for k in range(3)])
        return np.unique(np.sort(pairs, axis=1), axis=0)

    def near(self, centre: tuple[float, float], radius: float) -> np.ndarray:
        """Triangles whose centroid is within a square of half the side ``radius``."""
        centroid = self.vertices[self.triangles].mean(axis=1)[:, :2]
        return np.flatnonzero((np.abs(centroid - np.array(centre)) < radius).all(axis=1))


def square_patch(squares: int, nodes_a_square: int, side: float = 1.0) -> Patch:
    """A patch in the plane z = 0 with ``squares`` squares and ``squares * nodes_a_square`` nodes a side."""
    x, y = np.meshgrid(np.linspace(0, side, squares + 1), np.linspace(0, side, squares + 1), indexing="ij")
    vertices = np.stack([x.ravel(), y.ravel(), np.zeros(x.size)], axis=1)
    corner = np.arange((squares + 1) ** 2).reshape(squares + 1, -1)
    a, b, c, d = (part.ravel() for part in (corner[:-1, :-1], corner[1:, :-1], corner[1:, 1:], corner[:-1, 1:]))
    triangles = np.concatenate([np.stack([a, b, c], axis=1), np.stack([a, c, d], axis=1)])
    count = squares * nodes_a_square
    place = (np.arange(count) + 0.5) / nodes_a_square
    u, v = (part.ravel() for part in np.meshgrid(place, place, indexing="ij"))
    square = np.floor(u).astype(int) * squares + np.floor(v).astype(int)
    s, t = u - np.floor(u), v - np.floor(v)
    lower = s >= t
    weight = np.where(lower[:, None], np.stack([1 - s, s - t, t], axis=1), np.stack([1 - t, s, t - s], axis=1))
    triangle = np.where(lower, square, square + squares**2)
    nodes = np.einsum("nk,nkd->nd", weight, vertices[triangles[triangle]])
    return Patch(vertices, triangles, nodes, triangle, weight, count)


def enriched_everywhere(
    triangles: np.ndarray, vertex_count: int, node_triangle: np.ndarray, node_weight: np.ndarray
) -> Region:
    """All triangles hybrid with alpha = 1: the triangle mesh moves along, and the yarns behave as a full-yarn model."""
    everywhere = np.full(len(triangles), HYBRID)
    return Region(triangles, node_triangle, node_weight, everywhere, np.ones(vertex_count))
