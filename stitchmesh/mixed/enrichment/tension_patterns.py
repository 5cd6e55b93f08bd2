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

    r_c b_j,    r_c = w_after - w_before along the yarns of family c,    b_j the barycentric coordinate of vertex j

for each vertex j and both families c of a weave. Tension that changes linearly then passes like a uniform one. Energies
and momentum are kept: there are fewer motions, and the forces are the same. The yarns of a knit turn from node to node,
so that their tensions follow no such pattern.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike
from scipy.sparse import csr_array, diags_array, hstack

from stitchmesh.mixed.enrichment.region import HYBRID, Numbers, Region

SMALLEST = 1e-3
"""Smallest pattern that counts, over the largest one."""


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
    """The columns r_c b_j that are large enough to count, shape (H, K).

    Args:
        basis: B, shape (H, V).
        pattern: r, shape (H, 2).
    """
    columns = csr_array(hstack([diags_array(pattern[:, c]) @ basis for c in range(pattern.shape[1])]))
    square = np.asarray(columns.power(2).sum(axis=0)).ravel()
    return csr_array(columns[:, square > SMALLEST**2 * square.max(initial=0.0)])
