# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The yarns of single panels, and their union on a cloth with the rods of its seams.

Wefts, warps and courses are parallel lines at equal distances, clipped at the border of a panel. Line k has the level
(k + phase) d across its direction. A line crosses sides of the border; in order along the line, it enters the panel at
the first, leaves it at the second, and so on in turn. This holds for panels with bays, and with holes too.

*Rods* (Casafranca et al. 2020, section 6.1). A rod is a yarn that runs along a seam. Each yarn that reaches the seam
from either panel has a node in common with the rod; the rod is the v yarn of the node. The rest length of the rod
between two nodes is the mean of the lengths of both borders. Nodes of yarns from both panels may lie at nearly the same
place; their distance would be a segment of nearly no length, whose stiffness has no bound. The nodes are therefore
moved along the rod until all distances are at least a given distance, with the least sum of squares of the moves
(isotonic regression).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from typing import Literal

import numpy as np

from stitchmesh.mesh import FloatArray, IntArray
from stitchmesh.mixed.cloth.cloth import Cloth
from stitchmesh.mixed.layout.crossing_yarns import (
    ROD,
    CrossingYarns,
    Joints,
    LaidNodes,
    Passages,
    assembled,
    joined,
    taken,
)
from stitchmesh.mixed.layout.embedding import rest_positions


@dataclass(frozen=True, eq=False)
class ClippedLines:
    """Pieces of lines within a panel, ascending by line and along the line."""

    line: IntArray
    """Number of the line of each piece, shape (n,)."""
    ends: FloatArray
    """Where each piece begins and ends along its line [cm], shape (n, 2)."""
    border: IntArray
    """Side of the cloth that the line crosses at both ends, shape (n, 2)."""
    part: FloatArray
    """Place of the crossing on this side, from 0 at its start to 1 at its end, shape (n, 2)."""

    def piece_at(self, line: IntArray, along: FloatArray) -> IntArray:
        """Return the piece that holds each point, -1 if there is none, shape (m,).

        Args:
            line: line of each point, shape (m,).
            along: place along the line [cm], shape (m,).
        """
        if not len(self.line):
            return np.full(len(line), -1)
        low, size = self.ends.min(), max(2.0 * np.ptp(self.ends), 1e-300)
        key = self.line + (self.ends[:, 0] - low) / size
        piece = np.searchsorted(key, line + np.clip((along - low) / size, 0.0, 0.75), side="right") - 1
        held = (
            (piece >= 0) & (self.line[piece] == line) & (along >= self.ends[piece, 0]) & (along <= self.ends[piece, 1])
        )
        return np.where(held, piece, -1)


def clipped_lines(cloth: Cloth, panel: int, axis: int, distance: float, phase: float = 0.5) -> ClippedLines:
    """Clip lines at the border of a panel.

    Args:
        cloth: the cloth.
        panel: number of the panel.
        axis: direction of the lines, 0 along x and 1 along y.
        distance: distance between two lines [cm].
        phase: level of line 0, in distances.
    """
    sides = cloth.border_sides[cloth.panel[cloth.border_sides // 3] == panel]
    start, end = cloth.side_rest[sides, 0], cloth.side_rest[sides, 1]
    levels = [np.ceil(points[:, 1 - axis] / distance - phase).astype(np.int64) for points in (start, end)]
    count = np.abs(levels[1] - levels[0])  # lines k with low < level <= high, so that a common corner counts once
    side = np.repeat(np.arange(len(sides)), count)
    line = np.minimum(*levels)[side] + np.arange(len(side)) - np.repeat(np.cumsum(count) - count, count)
    rise = (end - start)[side, 1 - axis]
    part = np.clip(((line + phase) * distance - start[side, 1 - axis]) / rise, 0.0, 1.0)
    along = start[side, axis] + part * (end - start)[side, axis]
    order = np.lexsort((along, line))
    pairs = order[: len(order) // 2 * 2].reshape(-1, 2)
    return ClippedLines(line[pairs[:, 0]], along[pairs], sides[side[pairs]], part[pairs])


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
    joints = taken(joints, edge_of_side[joints.border] >= 0)
    if not len(joints.yarn):
        return nodes, passages, family
    edge = edge_of_side[joints.border]
    backwards = (cloth.seam_sides[edge, 1] == joints.border).astype(np.int64)
    seam = np.searchsorted(cloth.seam_start, edge, side="right") - 1
    along = _along(cloth, edge, np.where(backwards == 1, 1.0 - joints.part, joints.part))
    order = np.lexsort((along, seam))
    joints, seam, backwards, along = taken(joints, order), seam[order], backwards[order], along[order]
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


@dataclass(frozen=True, eq=False)
class PanelYarns:
    """The yarns of a panel; nodes and yarns are numbered from 0 in the panel."""

    nodes: LaidNodes
    passages: Passages
    family: IntArray
    """Family of each yarn, shape (yarns,)."""
    joints: Joints
    """Where yarns reach the border of the panel; joints of yarns without nodes are left out later."""
    contacts: IntArray = field(default_factory=lambda: np.zeros((0, 2), dtype=np.int64))
    """The two nodes of each stitch contact, shape (C, 2), in turn for the left and for the right foot of a loop."""


def yarns_on_cloth(
    kind: Literal["weave", "knit"], cloth: Cloth, panels: Sequence[PanelYarns], smallest: float
) -> CrossingYarns:
    """Return the yarns of all panels, joined to rods along the seams.

    Args:
        kind: weave or knit.
        cloth: the cloth.
        panels: the yarns of each panel.
        smallest: smallest distance of two nodes of a rod [cm].

    Raises:
        ParameterError: no yarn has two nodes.
    """
    first_node = np.concatenate([[0], np.cumsum([part.nodes.count for part in panels])])
    first_yarn = np.concatenate([[0], np.cumsum([len(part.family) for part in panels])])
    parts = [_numbered(part, *firsts) for part, *firsts in zip(panels, first_node, first_yarn, strict=False)]
    passages, joints = joined([part.passages for part in parts]), joined([part.joints for part in parts])
    has_nodes = np.bincount(passages.yarn, minlength=first_yarn[-1]) > 0
    joints = taken(joints, has_nodes[joints.yarn])
    family = np.concatenate([part.family for part in parts])
    laid = with_rods(cloth, joined([part.nodes for part in parts]), passages, family, joints, smallest)
    return assembled(kind, *laid, np.concatenate([part.contacts for part in parts]))


def _numbered(part: PanelYarns, first_node: int, first_yarn: int) -> PanelYarns:
    """The yarns of a panel, with nodes and yarns numbered after those of the panels before it."""
    passages, joints = part.passages, part.joints
    return replace(
        part,
        passages=replace(passages, node=passages.node + first_node, yarn=passages.yarn + first_yarn),
        joints=replace(joints, yarn=joints.yarn + first_yarn),
        contacts=part.contacts + first_node,
    )
