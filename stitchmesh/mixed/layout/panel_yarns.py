# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The yarns of single panels, and their union on a cloth with the rods of its seams.

Wefts, warps and courses are parallel lines at equal distances, clipped at the border of a panel. Line k has the level
(k + phase) d across its direction. A line crosses sides of the border; in order along the line, it enters the panel at
the first, leaves it at the second, and so on in turn. This holds for panels with bays, and with holes too.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from typing import Literal

import numpy as np

from stitchmesh.mesh import FloatArray, IntArray
from stitchmesh.mixed.cloth.cloth import Cloth
from stitchmesh.mixed.layout.crossing_yarns import CrossingYarns
from stitchmesh.mixed.layout.passages import LaidNodes, Passages, assembled, joined
from stitchmesh.mixed.layout.rods import Joints, joined_joints, with_rods


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
    passages, joints = joined([part.passages for part in parts]), joined_joints([part.joints for part in parts])
    has_nodes = np.bincount(passages.yarn, minlength=first_yarn[-1]) > 0
    joints = joints.taken(has_nodes[joints.yarn])
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
