# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The sides of polygons that run along each edge, whatever their number and direction."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from stitchmesh.mesh.polygon_mesh import IntArray
from stitchmesh.mesh.repair.soup import Soup


@dataclass(frozen=True, eq=False)
class EdgeSides:
    """Sides by edge; E is the number of edges and C the number of sides."""

    sides: IntArray
    """Sides, edge by edge, and ascending for each edge, shape (C,)."""
    first: IntArray
    """Place of the first side of each edge in ``sides``, shape (E,)."""
    count: IntArray
    """Number of sides of each edge, shape (E,)."""

    def with_count(self, count: int) -> IntArray:
        """Return the sides of the edges with a number of sides, shape (n, count)."""
        return self.sides[self.first[self.count == count][:, None] + np.arange(count)]

    def crowded_counts(self) -> list[int]:
        """Return the numbers of sides above two that occur."""
        return [int(count) for count in np.unique(self.count) if count > 2]


def edge_sides(tail: IntArray, head: IntArray) -> EdgeSides:
    """Group sides by their two ends.

    Args:
        tail: number of the vertex at which each side starts, shape (C,).
        head: number of the vertex at which each side ends, shape (C,).
    """
    key = edge_keys(tail, head, int(tail.max(initial=0)) + 1)
    sides = np.argsort(key, kind="stable")
    is_first = np.concatenate([[True], np.diff(key[sides]) != 0])
    first = np.flatnonzero(is_first[: len(key)])
    return EdgeSides(sides, first, np.diff(np.append(first, len(key))))


def edge_keys(tail: IntArray, head: IntArray, vertex_count: int) -> IntArray:
    """Return a number for each pair of ends, the same for both directions, shape (n,)."""
    return np.minimum(tail, head) * vertex_count + np.maximum(tail, head)


def edges_of(soup: Soup) -> EdgeSides:
    """Group the sides of polygons by edge."""
    return edge_sides(soup.vertex, soup.head)


def open_sides(soup: Soup) -> NDArray[np.bool_]:
    """Return whether each side is alone on its edge, shape (C,)."""
    alone = np.zeros(len(soup.vertex), dtype=bool)
    alone[edges_of(soup).with_count(1)[:, 0]] = True
    return alone
