# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The yarns of single panels, and their union on a cloth with the rods of its seams."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from typing import Literal

import numpy as np

from stitchmesh.mesh import IntArray
from stitchmesh.mixed.cloth.cloth import Cloth
from stitchmesh.mixed.layout.crossing_yarns import CrossingYarns
from stitchmesh.mixed.layout.passages import LaidNodes, Passages, assembled, joined
from stitchmesh.mixed.layout.rods import Joints, joined_joints, with_rods


def _no_contacts() -> IntArray:
    return np.zeros((0, 2), dtype=np.int64)


@dataclass(frozen=True, eq=False)
class PanelYarns:
    """The yarns of a panel; nodes and yarns are numbered from 0 in the panel."""

    nodes: LaidNodes
    passages: Passages
    family: IntArray
    """Family of each yarn, shape (yarns,)."""
    joints: Joints
    """Where yarns reach the border of the panel; those of yarns without nodes are left out later."""
    contacts: IntArray = field(default_factory=_no_contacts)
    """The two nodes of each stitch contact, shape (C, 2), in turn at the left and at the right foot of a loop."""


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
    """The yarns of a panel, numbered after those of the panels before it."""
    passages, joints = part.passages, part.joints
    return replace(
        part,
        passages=replace(passages, node=passages.node + first_node, yarn=passages.yarn + first_yarn),
        joints=replace(joints, yarn=joints.yarn + first_yarn),
        contacts=part.contacts + first_node,
    )
