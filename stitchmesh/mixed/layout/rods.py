# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Rods along seams, and the yarns that are joined to them (Casafranca et al. 2020, section 6.1).

A rod is a yarn that runs along a seam. Each yarn that reaches the seam from either panel has a node in common with the
rod; the rod is the v yarn of the node. The rest length of the rod between two nodes is the mean of the lengths of both
borders. Nodes of yarns from both panels may lie at nearly the same place; their distance would be a segment of nearly
no length, whose stiffness has no bound. The nodes are therefore moved along the rod until all distances are at least a
given distance, with the least sum of squares of the moves (isotonic regression).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, fields

import numpy as np

from stitchmesh.mesh import FloatArray, IntArray
from stitchmesh.mixed.cloth.cloth import Cloth
from stitchmesh.mixed.layout.crossing_yarns import ROD
from stitchmesh.mixed.layout.embedding import rest_positions
from stitchmesh.mixed.layout.passages import LaidNodes, Passages, joined


@dataclass(frozen=True, eq=False)
class Joints:
    """Places where yarns reach the border of their panel."""

    yarn: IntArray
    """Yarn of each joint, shape (n,)."""
    order: FloatArray
    """Order of the passage along the yarn, shape (n,)."""
    border: IntArray
    """Side of the cloth that the yarn reaches, shape (n,)."""
    part: FloatArray
    """Place on this side, from 0 to 1, shape (n,)."""

    def taken(self, joints: IntArray | np.ndarray) -> Joints:
        """Return some of the joints, in the given order."""
        return Joints(self.yarn[joints], self.order[joints], self.border[joints], self.part[joints])


def joined_joints(parts: Sequence[Joints]) -> Joints:
    """Return joints of several parts one after the other."""
    return Joints(*(np.concatenate([getattr(part, name.name) for part in parts]) for name in fields(Joints)))


def with_rods(
    cloth: Cloth, nodes: LaidNodes, passages: Passages, family: IntArray, joints: Joints, smallest: float
) -> tuple[LaidNodes, Passages, IntArray]:
    """Add the rods of all seams, with a node for each joint on a seam.

    Args:
        cloth: the cloth.
        nodes: the nodes of the yarns.
        passages: the passages of the yarns.
        family: family of each yarn.
        joints: where yarns reach borders; joints that lie on no seam are left out.
        smallest: smallest distance of two nodes of a rod [cm].

    Returns:
        Nodes, passages and families; those of the rods follow the given ones.
    """
    edge_of_side = np.full(len(cloth.twin), -1)
    edge_of_side[cloth.seam_sides] = np.arange(len(cloth.seam_edges))[:, None]
    joints = joints.taken(edge_of_side[joints.border] >= 0)
    if not len(joints.yarn):
        return nodes, passages, family
    edge = edge_of_side[joints.border]
    backwards = (cloth.seam_sides[edge, 1] == joints.border).astype(np.int64)
    seam = np.searchsorted(cloth.seam_start, edge, side="right") - 1
    along = _along(cloth, edge, np.where(backwards == 1, 1.0 - joints.part, joints.part))
    order = np.lexsort((along, seam))
    joints, seam, backwards, along = joints.taken(order), seam[order], backwards[order], along[order]
    along = _spread(cloth, seam, along, smallest)
    made = _seam_nodes(cloth, along, seam, backwards)
    node = nodes.count + np.arange(len(seam))
    straight = np.stack([along, np.zeros(len(along))], axis=1)
    rods = Passages(len(family) + seam, along, node, np.ones_like(node), straight)
    ends = Passages(joints.yarn, joints.order, node, np.zeros_like(node), made.position)
    return (
        joined([nodes, made]),
        joined([passages, ends, rods]),
        np.concatenate([family, np.full(cloth.seam_count, ROD)]),
    )


def _edge_lengths(cloth: Cloth) -> FloatArray:
    """Mean of the rest lengths of both sides of each seam edge [cm], shape (S,)."""
    ends = cloth.side_rest[cloth.seam_sides]
    lengths: FloatArray = np.linalg.norm(ends[:, :, 1] - ends[:, :, 0], axis=2).mean(axis=1)
    return lengths


def _along(cloth: Cloth, edge: IntArray, part: FloatArray) -> FloatArray:
    """Length of the rod from the beginning of its seam to a place on an edge [cm]."""
    length = _edge_lengths(cloth)
    begin = np.concatenate([[0.0], np.cumsum(length)])
    seam = np.searchsorted(cloth.seam_start, edge, side="right") - 1
    return begin[edge] - begin[cloth.seam_start[seam]] + part * length[edge]


def _spread(cloth: Cloth, seam: IntArray, along: FloatArray, smallest: float) -> FloatArray:
    """Move places along each rod so that they are at least ``smallest`` apart; both arrays are sorted."""
    from scipy.optimize import isotonic_regression

    total = np.add.reduceat(_edge_lengths(cloth), cloth.seam_start[:-1])
    result = np.empty_like(along)
    for number in np.unique(seam).tolist():
        own = np.flatnonzero(seam == number)
        gap = min(smallest, 0.9 * float(total[number]) / len(own))  # all gaps take at most this part of the seam
        steps = gap * np.arange(len(own))
        free = total[number] - gap * (len(own) - 1)
        result[own] = np.clip(isotonic_regression(along[own] - steps).x, 0.0, free) + steps
    return result


def _seam_nodes(cloth: Cloth, along: FloatArray, seam: IntArray, backwards: IntArray) -> LaidNodes:
    """Nodes at places along seams, each in the panel at one side of the seam."""
    length = _edge_lengths(cloth)
    begin = np.concatenate([[0.0], np.cumsum(length)])
    total = begin[cloth.seam_start[seam]] + along
    edge = np.searchsorted(begin, total, side="right") - 1
    edge = np.clip(edge, cloth.seam_start[seam], cloth.seam_start[seam + 1] - 1)
    part = np.clip((total - begin[edge]) / length[edge], 0.0, 1.0)
    part = np.where(backwards == 1, 1.0 - part, part)
    side = cloth.seam_sides[edge, backwards]
    triangle, corner = np.divmod(side, 3)
    barycentric = np.zeros((len(side), 3))
    barycentric[np.arange(len(side)), corner] = 1.0 - part
    barycentric[np.arange(len(side)), (corner + 1) % 3] = part
    position = rest_positions(cloth, triangle, barycentric)
    direction = (cloth.side_rest[side, 1] - cloth.side_rest[side, 0]) * (1 - 2 * backwards)[:, None]
    return LaidNodes(cloth.panel[triangle], position, triangle, barycentric, np.zeros_like(side), direction)
