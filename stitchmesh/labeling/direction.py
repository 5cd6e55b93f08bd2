# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The wale direction of each row.

Two neighbouring rows match at a common edge if the edge is a top side of one row and a bottom side of the other. For
each pair of rows the common course length counts as positive where the rows match and as negative where they do not.
Pairs are joined to a spanning forest in descending order of the absolute value, and each join fixes the relative
direction of two rows. Mismatches therefore remain at the shortest seams. Seeded rows keep the direction in which they
grew.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from stitchmesh.labeling.growth import RowGrowth
from stitchmesh.mesh import BORDER, Mesh

ROOT = -1
"""Additional node of the forest, to which all seeded rows are joined."""
DIGITS = 9
"""Decimal digits to which lengths [cm] are rounded before comparison; equally long seams may differ by rounding."""


def turned_rows(mesh: Mesh, growth: RowGrowth, seeded: list[int]) -> NDArray[np.bool_]:
    """Return whether the direction of each row must be reversed, shape (rows,).

    Args:
        mesh: the surface.
        growth: rows and edge labels of the surface, with the directions in which the rows grew.
        seeded: rows that keep their direction.
    """
    forest = _ParityForest(growth.row_count + 1)
    for row in seeded:
        forest.join(ROOT, row, 0)
    for first, second, differ in _neighbours(mesh, growth):
        forest.join(first, second, differ)
    return np.array([forest.parity(row) ^ forest.parity_of_root(row) for row in range(growth.row_count)], dtype=bool)


def _neighbours(mesh: Mesh, growth: RowGrowth) -> list[tuple[int, int, int]]:
    """Pairs of rows, and whether one of them must be reversed to match, in descending order of the matched length."""
    sides = np.flatnonzero((mesh.twin != BORDER) & (np.arange(mesh.side_count) < mesh.twin))
    sides = sides[growth.edge_label[mesh.side_edge[sides]] == 0]
    top = _is_top(mesh, growth)
    rows = growth.row[mesh.side_face[sides]], growth.row[mesh.side_face[mesh.twin[sides]]]
    sign = np.where(top[sides] == top[mesh.twin[sides]], -1.0, 1.0)
    gain: dict[tuple[int, int], float] = {}
    for first, second, amount in zip(*rows, sign * mesh.side_length[sides], strict=True):
        if first != second:
            pair = (min(int(first), int(second)), max(int(first), int(second)))
            gain[pair] = gain.get(pair, 0.0) + float(amount)
    gain = {pair: round(amount, DIGITS) for pair, amount in gain.items()}
    order = sorted(gain, key=lambda pair: (-abs(gain[pair]), pair))
    return [(first, second, int(gain[first, second] < 0)) for first, second in order]


def _is_top(mesh: Mesh, growth: RowGrowth) -> NDArray[np.bool_]:
    """Whether each side is a top side in the direction of growth: it comes after the right wale side of its face."""
    sizes = np.diff(mesh.face_start)[mesh.side_face]
    left = growth.left_wale[mesh.side_face]
    place = (np.arange(mesh.side_count) - left) % sizes
    right = (growth.right_wale[mesh.side_face] - left) % sizes
    return place > right


class _ParityForest:
    """Union-find structure whose links store the parity of two nodes: 0 for the same direction, 1 for the opposite."""

    def __init__(self, count: int) -> None:
        self._parent = list(range(count))
        self._flip = [0] * count

    def find(self, node: int) -> tuple[int, int]:
        """Return the root of a node and the parity of the node relative to the root."""
        node, parity = node % len(self._parent), 0
        while self._parent[node] != node:
            parity ^= self._flip[node]
            node = self._parent[node]
        return node, parity

    def join(self, first: int, second: int, differ: int) -> None:
        """Join the components of two nodes with a parity, unless both nodes are in one component already."""
        (a, parity_a), (b, parity_b) = self.find(first), self.find(second)
        if a == b:
            return
        self._parent[b], self._flip[b] = a, parity_a ^ parity_b ^ differ

    def parity(self, node: int) -> int:
        """Return the parity of a node relative to the root of its component."""
        return self.find(node)[1]

    def parity_of_root(self, node: int) -> int:
        """Return the parity of the node ``ROOT`` if it is in the component of this node, else 0."""
        (root, _), (own, parity) = self.find(node), self.find(ROOT)
        return parity if own == root else 0
