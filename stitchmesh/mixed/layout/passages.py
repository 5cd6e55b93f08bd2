# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Makes ``CrossingYarns`` from nodes and the passages of yarns through them, in any order."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, fields, replace
from typing import Literal, TypeVar

import numpy as np
from numpy.typing import NDArray

from stitchmesh.errors import ParameterError
from stitchmesh.mesh import FloatArray, IntArray
from stitchmesh.mixed.layout.crossing_yarns import CrossingYarns

Table = TypeVar("Table", "LaidNodes", "Passages", "Joints")


@dataclass(frozen=True, eq=False)
class LaidNodes:
    """Nodes on a cloth; fields that ``CrossingYarns`` has too have the same meaning."""

    panel: IntArray
    position: FloatArray
    triangle: IntArray
    barycentric: FloatArray
    side: IntArray
    seam_direction: FloatArray
    """Direction of a rod in the panel of the node, zero at a node without a rod, shape (N, 2)."""

    @property
    def count(self) -> int:
        """Number of nodes."""
        return len(self.panel)


@dataclass(frozen=True, eq=False)
class Passages:
    """Passages of yarns through nodes."""

    yarn: IntArray
    """Yarn of each passage, shape (M,)."""
    order: FloatArray
    """A number that increases along each yarn, shape (M,)."""
    node: IntArray
    """Node of each passage, shape (M,)."""
    coordinate: IntArray
    """0 where the yarn is the u yarn of the node and 1 where it is its v yarn, shape (M,)."""
    place: FloatArray
    """Flat place of each passage in a frame of its yarn [cm], shape (M, 2); distances along a yarn are rest lengths.
    The frames of the two yarns of a node differ only by a shift."""


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


def taken(table: Table, rows: IntArray | NDArray[np.bool_]) -> Table:
    """Return some of the nodes, passages or joints, in the given order."""
    return type(table)(*(getattr(table, one.name)[rows] for one in fields(table)))


def joined(parts: Sequence[Table]) -> Table:
    """Return nodes, passages or joints of several parts one after the other; numbers stay as they are."""
    first = parts[0]
    return type(first)(*(np.concatenate([getattr(part, one.name) for part in parts]) for one in fields(first)))


def assembled(
    kind: Literal["weave", "knit"], nodes: LaidNodes, passages: Passages, family: IntArray,
    contacts: IntArray | None = None,
) -> CrossingYarns:  # fmt: skip
    """Return the yarns.

    A yarn with fewer than two nodes has no segment; it is left out with its node, until no such yarn is left.

    Args:
        kind: weave or knit.
        nodes: the nodes.
        passages: the passages, in any order.
        family: family of each yarn that a passage names, shape (yarns,).
        contacts: the two nodes of each stitch contact of a knit, shape (C, 2), in turn for the left and for the right
            foot of a loop.

    Raises:
        ParameterError: no yarn is left.
    """
    kept = _kept_nodes(passages, nodes.count)
    if not kept.any():
        raise ParameterError(f"{kind}: no yarn has two nodes on the cloth; take a denser fabric or larger panels")
    number = np.cumsum(kept) - 1
    passages = taken(passages, kept[passages.node])
    passages = _in_order(replace(passages, node=number[passages.node]))
    used, start = np.unique(passages.yarn, return_index=True)
    nodes = taken(nodes, kept)
    length, turn, direction = _measures(passages)
    code = 2 * passages.node + passages.coordinate
    yarns = CrossingYarns(
        kind=kind,
        panel=nodes.panel,
        position=nodes.position,
        triangle=nodes.triangle,
        barycentric=nodes.barycentric,
        side=nodes.side,
        yarn_start=np.append(start, len(passages.node)),
        yarn_node=passages.node,
        yarn_coordinate=passages.coordinate,
        yarn_family=family[used],
        rest_sliding=_by_coordinate(code, length, nodes.count),
        rest_turn=_by_coordinate(code, turn, nodes.count),
        rest_shear=_angles_between(code, direction, nodes),
    )
    if contacts is None or not len(contacts):
        return yarns
    whole = kept[contacts].all(axis=1)
    is_left = np.arange(len(contacts)) % 2 == 0
    contacts = number[contacts[whole]]
    return replace(yarns, stitch_contacts=contacts, stitch_left=is_left[whole])


def _kept_nodes(passages: Passages, count: int) -> NDArray[np.bool_]:
    """Whether each node lies only on yarns with at least two nodes."""
    kept = np.ones(count, dtype=np.bool_)
    while True:
        nodes = np.bincount(passages.yarn[kept[passages.node]], minlength=int(passages.yarn.max(initial=-1)) + 1)
        lost = kept[passages.node] & (nodes[passages.yarn] < 2)
        if not lost.any():
            return kept
        kept[passages.node[lost]] = False


def _in_order(passages: Passages) -> Passages:
    step = np.diff(passages.yarn)
    if ((step > 0) | ((step == 0) & (np.diff(passages.order) > 0))).all():
        return passages
    return taken(passages, np.lexsort((passages.order, passages.yarn)))


def _measures(passages: Passages) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Length along the yarn, angle of turning, and direction at each passage, shapes (M,), (M,) and (M, 2)."""
    count = len(passages.yarn)
    inner = np.flatnonzero(passages.yarn[1:] == passages.yarn[:-1])
    leg = np.zeros((count + 1, 2))  # leg k leads to passage k; zero at the beginning of a yarn
    leg[inner + 1] = passages.place[inner + 1] - passages.place[inner]
    before, after = leg[:-1], leg[1:]
    total = np.cumsum(np.hypot(before[:, 0], before[:, 1]))
    first = np.concatenate([[True], passages.yarn[1:] != passages.yarn[:-1]]) if count else np.zeros(0, dtype=np.bool_)
    length = total - total[first][np.cumsum(first) - 1] if count else total
    turn = np.arctan2(np.abs(_cross(before, after)), (before * after).sum(axis=1))
    return length, turn, before + after


def _cross(one: FloatArray, other: FloatArray) -> FloatArray:
    return one[:, 0] * other[:, 1] - one[:, 1] * other[:, 0]


def _by_coordinate(code: IntArray, values: FloatArray, count: int) -> FloatArray:
    """Values of passages at their nodes, shape (count, 2); zero where a node has no second yarn."""
    result = np.zeros(2 * count)
    result[code] = values
    return result.reshape(count, 2)


def _angles_between(code: IntArray, direction: FloatArray, nodes: LaidNodes) -> FloatArray:
    """Angle between the two yarns of each node in [0, pi], a right angle where there is no second yarn."""
    at_node = np.zeros((2 * nodes.count, 2))
    at_node[code] = direction
    one, other = at_node[0::2], np.where(nodes.side[:, None] == 0, nodes.seam_direction, at_node[1::2])
    angle = np.arctan2(np.abs(_cross(one, other)), (one * other).sum(axis=1))
    return np.where((one == 0.0).all(axis=1) | (other == 0.0).all(axis=1), np.pi / 2, angle)
