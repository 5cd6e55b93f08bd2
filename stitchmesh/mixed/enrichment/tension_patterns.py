# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""What the gradient of alpha leaves unbalanced at hybrid nodes when a cloth is stretched evenly.

Under uniform stretch all yarns of a family have one tension T, and the energy of a segment has the weight w of its
element. The forces of the segments after and before a node, T (w_after - w_before) along the yarn, do not balance where
alpha changes. The triangles have the opposite forces, so that the sum of both models balances at the vertices; but the
part of these forces that triangles cannot represent would move the nodes, because the gradient of a piecewise linear
alpha jumps from triangle to triangle. It is a force of the blending alone, like the ghost forces where atoms and finite
elements meet.

No blend of two energies is without such forces, and a force that takes them away has no energy. The filter therefore
takes the motions that they would cause: beside what triangles represent, displacements x of the nodes have no part
along

    r_c b_K,    r_c = w_after - w_before along the yarns of family c,    b_K the sum of barycentric coordinates of K

for both families c of a weave and parts K of the vertices, each with some thousand nodes. The b_K add up to 1, so that
uniform tension passes; there are few parts, because each pattern takes a motion from the yarns too: with one for each
vertex, yarns in the ring could not evade the triangles where these are too coarse for shear. Energies and momentum are
kept: there are fewer motions, and the forces are the same. The yarns of a knit turn from node to node, so that their
tensions follow no such pattern.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike
from scipy.sparse import csr_array, diags_array, hstack
from scipy.sparse.csgraph import reverse_cuthill_mckee

from stitchmesh.mixed.enrichment.region import HYBRID, Numbers, Region

SMALLEST = 1e-3
"""Smallest pattern that counts, over the largest one."""
NODES_OF_PART = 2000
"""Nodes of a pattern. A sum over many more would be slow on a GPU."""


def tension_left(region: Region, segments: ArrayLike, family: ArrayLike, *, at_ends: bool = False) -> Numbers:
    """Weight of the segment after each hybrid node less that of the segment before it, for two families of yarns.

    Yarns that end at a node have no pattern: their end has no tension, unless it is held.

    Args:
        region: the region of interest.
        segments: numbers in the layout of the nodes before and after each segment, shape (E, 2).
        family: family of each segment, 0 or 1, shape (E,).
        at_ends: whether the ends of yarns have the tension of their last segment.

    Returns:
        The patterns r, shape (H, 2) for H hybrid nodes.
    """
    ends, column = np.asarray(segments, dtype=np.int64).reshape(-1, 2), np.asarray(family, dtype=np.int64)
    weight = region.element_alpha(ends)
    sides = np.zeros((2, len(region.node_triangle), 2))
    there = np.zeros(sides.shape, dtype=bool)
    for side in range(2):  # the segment begins at its first node, and ends at its second one
        sides[side, ends[:, side], column] = weight
        there[side, ends[:, side], column] = True
    hybrid = region.node_kind == HYBRID
    pattern: Numbers = np.where(at_ends | there.all(axis=0), sides[0] - sides[1], 0.0)[hybrid]
    return pattern


def pattern_columns(basis: csr_array, pattern: Numbers) -> csr_array:
    """The columns r_c b_K that are large enough to count, shape (H, P).

    Args:
        basis: B, shape (H, V).
        pattern: r, shape (H, 2).
    """
    parts = csr_array(basis @ _parts(basis))
    columns = csr_array(hstack([diags_array(pattern[:, c]) @ parts for c in range(pattern.shape[1])]))
    square = np.asarray(columns.power(2).sum(axis=0)).ravel()
    return csr_array(columns[:, square > SMALLEST**2 * square.max(initial=0.0)])


def _parts(basis: csr_array) -> csr_array:
    """Which part each vertex belongs to, shape (V, K): parts of neighbours with about ``NODES_OF_PART`` nodes each."""
    links = csr_array(basis.T @ basis)
    order = reverse_cuthill_mckee(links, symmetric_mode=True)
    before = np.concatenate([[0.0], np.cumsum(np.asarray(basis.sum(axis=0)).ravel()[order])[:-1]])
    part = np.zeros(len(order), dtype=np.int64)
    part[order] = (before / NODES_OF_PART).astype(np.int64)
    shape = (len(part), int(part.max(initial=0)) + 1)
    return csr_array((np.ones(len(part)), (np.arange(len(part)), part)), shape=shape)
