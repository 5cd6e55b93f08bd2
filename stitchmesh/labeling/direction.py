# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The wale direction of each row.

Two neighbouring rows match where one calls their common edge top and the other bottom. Rows are joined to a tree by
the course length over which they would match or mismatch, longest first, so that what cannot match is left to the
shortest seams. Seeded rows keep the direction in which they grew.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from stitchmesh.labeling.growth import RowGrowth
from stitchmesh.mesh import BORDER, Mesh

ROOT = -1
"""The tree's own node, which all seeded rows hang on."""
DIGITS = 9
"""Digits after the point of lengths [cm] that are compared: seams that are equally long differ in their last bits."""


def turned_rows(mesh: Mesh, growth: RowGrowth, seeded: list[int]) -> NDArray[np.bool_]:
    """Rows to turn over relative to the way they grew, shape (rows,)."""
    tree = _ParityForest(growth.row_count + 1)
    for row in seeded:
        tree.join(ROOT, row, 0)
    for first, second, differ in _neighbours(mesh, growth):
        tree.join(first, second, differ)
    return np.array([tree.parity(row) ^ tree.parity_of_root(row) for row in range(growth.row_count)], dtype=bool)


def _neighbours(mesh: Mesh, growth: RowGrowth) -> list[tuple[int, int, int]]:
    """Pairs of rows and whether one must turn over to match, longest common seam first."""
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
    """Whether each side comes after its face's right wale side, as the row grew."""
    sizes = np.diff(mesh.face_start)[mesh.side_face]
    left = growth.left_wale[mesh.side_face]
    place = (np.arange(mesh.side_count) - left) % sizes
    right = (growth.right_wale[mesh.side_face] - left) % sizes
    return place > right


class _ParityForest:
    """Union-find whose links say whether two nodes point the same way."""

    def __init__(self, count: int) -> None:
        self._parent = list(range(count))
        self._flip = [0] * count

    def find(self, node: int) -> tuple[int, int]:
        """Root of a node and the parity between them."""
        node, parity = node % len(self._parent), 0
        while self._parent[node] != node:
            parity ^= self._flip[node]
            node = self._parent[node]
        return node, parity

    def join(self, first: int, second: int, differ: int) -> None:
        """Tie two nodes, unless they are tied already; the root keeps the component it is in."""
        (a, parity_a), (b, parity_b) = self.find(first), self.find(second)
        if a == b:
            return
        self._parent[b], self._flip[b] = a, parity_a ^ parity_b ^ differ

    def parity(self, node: int) -> int:
        """Parity of a node to the root of its component."""
        return self.find(node)[1]

    def parity_of_root(self, node: int) -> int:
        """Parity of the tree's own node, where it is in the component of this one."""
        (root, _), (own, parity) = self.find(node), self.find(ROOT)
        return parity if own == root else 0
