# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Yarns with a node at each crossing, laid out on the panels of a cloth (Cirio et al. 2014 and 2017).

Two yarns cross in a node. One is the u yarn of the node, coordinate 0, the other its v yarn, coordinate 1. In a weave u
is the weft and v is the warp. In a knit u belongs to the new loop and v to the loop through which it is drawn; both may
be parts of one yarn. On a rod, the yarn along a seam, u is the yarn that reaches the seam and v is the rod.

A yarn passes through its nodes in order. Each passage names the node, and the coordinate of the node along this yarn.
The passages are stored yarn by yarn. All yarns are open: knitted rounds are joined to a spiral.

Each node stores its own rest shape of its two yarns, because the panels at both sides of a seam, or the rows of a
stitch mesh, have different coordinates: the rest lengths between nodes (``rest_sliding``), the angle by which a yarn
turns at a node (``rest_turn``), and the angle between the two yarns (``rest_shear``).

``assembled`` makes the yarns from nodes and the passages of yarns through them, in any order. Layouts state them as
``LaidNodes``, ``Passages``, and ``Joints`` with the rods of seams.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, fields, replace
from functools import cached_property
from typing import Literal, TypeVar

import numpy as np
from numpy.typing import NDArray

from stitchmesh.errors import ParameterError, first_few
from stitchmesh.mesh import FloatArray, IntArray, frozen_array
from stitchmesh.mixed.cloth.cloth import Cloth
from stitchmesh.mixed.layout.embedding import world_positions

WEFT, WARP, ROD = 0, 1, 2
"""Families of yarns: wefts or courses, warps, and the rods along seams."""
NO_NODE = -1
"""Neighbour or link where a yarn ends."""


@dataclass(frozen=True, eq=False, kw_only=True)
class CrossingYarns:
    """Y yarns with N nodes and M passages.

    Raises:
        ParameterError: an array has the wrong shape, a number does not exist, a node is not passed exactly once as u
            and at most once as v, a yarn has fewer than two nodes, or coordinates do not increase along a yarn.
    """

    kind: Literal["weave", "knit"]
    """Whether shear acts at crossings (a weave), or wrapping and stitch length at stitch contacts (a knit)."""
    panel: IntArray
    """Panel of each node, shape (N,)."""
    position: FloatArray
    """Position of each node in its panel [cm], shape (N, 2)."""
    triangle: IntArray
    """Triangle of the cloth in which each node lies, shape (N,)."""
    barycentric: FloatArray
    """Barycentric coordinates of each node in its triangle, shape (N, 3)."""
    side: IntArray
    """Side of the u yarn at each node, shape (N,): 1 where it lies above the v yarn, towards the outside of the cloth,
    -1 where it lies below, and 0 on a rod, where both are joined."""
    yarn_start: IntArray
    """First passage of each yarn, and M at the end, shape (Y + 1,)."""
    yarn_node: IntArray
    """Node of each passage, shape (M,)."""
    yarn_coordinate: IntArray
    """Coordinate of each passage, 0 for u and 1 for v, shape (M,)."""
    yarn_family: IntArray
    """``WEFT``, ``WARP`` or ``ROD`` for each yarn, shape (Y,)."""
    rest_sliding: FloatArray
    """Rest length of yarn from its beginning to the node, along the u yarn and along the v yarn [cm], (N, 2)."""
    rest_turn: FloatArray
    """Angle by which the u yarn and the v yarn turn at the node at rest, in the plane of the panel [rad], (N, 2)."""
    rest_shear: FloatArray
    """Angle between the directions of the u yarn and of the v yarn at rest, in [0, pi], shape (N,)."""
    stitch_contacts: IntArray = field(default_factory=lambda: np.zeros((0, 2), dtype=np.int64))
    """The two nodes of each stitch contact, shape (C, 2): P, where the new loop enters beside the leg of the old loop,
    and Q, where it leaves over the head of the old loop (``knit`` describes the loop). Both yarns run directly from P
    to Q. The stitch length energy of a knit acts on the distance of P and Q."""
    stitch_left: NDArray[np.bool_] = field(default_factory=lambda: np.zeros(0, dtype=np.bool_))
    """Whether each stitch contact is at the left foot of its new loop, seen from outside, shape (C,). The neighbours
    outside of the contact lie to the left of the line from P to Q at a left foot, and to the right of it at a right
    foot. The positions do not tell this, because P and Q may lie in different panels."""

    def __post_init__(self) -> None:
        for name in ("position", "barycentric", "rest_sliding", "rest_turn", "rest_shear"):
            object.__setattr__(self, name, frozen_array(getattr(self, name), np.float64))
        for name in ("panel", "triangle", "side", "yarn_start", "yarn_node", "yarn_coordinate", "yarn_family",
                     "stitch_contacts"):  # fmt: skip
            object.__setattr__(self, name, frozen_array(getattr(self, name), np.int64))
        object.__setattr__(self, "stitch_left", frozen_array(self.stitch_left, np.bool_))
        if self.kind not in ("weave", "knit"):
            raise ParameterError(f"crossing yarns: kind: got {self.kind!r}; expected 'weave' or 'knit'")
        self._check_shapes()
        self._check_passages()
        self._check_rest()

    def __repr__(self) -> str:
        """Return one line: the kind, and the numbers of yarns and nodes."""
        rods = int((self.yarn_family == ROD).sum())
        return f"CrossingYarns({self.kind}, {self.yarn_count - rods} yarns, {rods} rods, {self.node_count} nodes)"

    @property
    def node_count(self) -> int:
        """Number N of nodes."""
        return len(self.panel)

    @property
    def yarn_count(self) -> int:
        """Number Y of yarns."""
        return len(self.yarn_start) - 1

    @cached_property
    def passage_yarn(self) -> IntArray:
        """Yarn of each passage, shape (M,)."""
        return np.repeat(np.arange(self.yarn_count), np.diff(self.yarn_start))

    @cached_property
    def node_passage(self) -> IntArray:
        """Passage of each node as u and as v, ``NO_NODE`` where there is no second yarn, shape (N, 2)."""
        passage = np.full(2 * self.node_count, NO_NODE)
        passage[2 * self.yarn_node + self.yarn_coordinate] = np.arange(len(self.yarn_node))
        return passage.reshape(-1, 2)

    @cached_property
    def node_yarn(self) -> IntArray:
        """The u yarn and the v yarn of each node, ``NO_NODE`` where there is none, shape (N, 2)."""
        passage = self.node_passage
        return np.where(passage < 0, NO_NODE, self.passage_yarn[passage])

    @cached_property
    def links(self) -> IntArray:
        """Neighbours after and before each node along its u yarn, then after and before along its v yarn, shape (N, 4).

        A neighbour is 2 j + c, if the yarn passes node j with coordinate c, or ``NO_NODE`` at the end of a yarn.
        """
        code = 2 * self.yarn_node + self.yarn_coordinate
        after, before = np.full((2, len(code)), NO_NODE)
        inner = np.flatnonzero(self.passage_yarn[1:] == self.passage_yarn[:-1])
        after[inner], before[inner + 1] = code[inner + 1], code[inner]
        passage = self.node_passage
        both = np.stack([after[passage], before[passage]], axis=2)
        both[passage < 0] = NO_NODE
        return both.reshape(-1, 4)

    @cached_property
    def neighbours(self) -> IntArray:
        """Nodes after and before each node along its u yarn, then after and before along its v yarn, shape (N, 4)."""
        return np.where(self.links < 0, NO_NODE, self.links // 2)

    def world(self, cloth: Cloth, vertices: FloatArray | None = None) -> FloatArray:
        """Return the places of the nodes on the triangles in space [cm], shape (N, 3).

        Args:
            cloth: the cloth on which the yarns are laid out.
            vertices: positions of the vertices [cm], shape (V, 3); by default the positions of the cloth.
        """
        return world_positions(cloth, self.triangle, self.barycentric, vertices)

    def _check_shapes(self) -> None:
        nodes, passages, yarns = len(self.panel), len(self.yarn_node), len(self.yarn_start) - 1
        expected = {"panel": (nodes,), "position": (nodes, 2), "triangle": (nodes,), "barycentric": (nodes, 3),
                    "side": (nodes,), "rest_sliding": (nodes, 2), "rest_turn": (nodes, 2), "rest_shear": (nodes,),
                    "yarn_coordinate": (passages,), "yarn_family": (yarns,),
                    "stitch_contacts": (len(self.stitch_contacts), 2),
                    "stitch_left": (len(self.stitch_contacts),)}  # fmt: skip
        for name, shape in expected.items():
            found = getattr(self, name).shape
            if found != shape:
                raise ParameterError(f"crossing yarns: {name}: got shape {found}; expected {shape}")
        if yarns < 0 or self.yarn_start[0] != 0 or self.yarn_start[-1] != passages:
            raise ParameterError(f"crossing yarns: yarn_start: expected 0 to {passages}, the number of passages")

    def _check_passages(self) -> None:
        for name in ("yarn_node", "stitch_contacts"):
            values = getattr(self, name)
            if values.size and (values.min() < 0 or values.max() >= self.node_count):
                found = f"got nodes {values.min()} to {values.max()}"
                raise ParameterError(f"crossing yarns: {name}: {found}; expected 0 to {self.node_count - 1}")
        if self.yarn_coordinate.size and not np.isin(self.yarn_coordinate, (0, 1)).all():
            raise ParameterError("crossing yarns: yarn_coordinate: expected 0 for u and 1 for v")
        count = np.bincount(2 * self.yarn_node + self.yarn_coordinate, minlength=2 * self.node_count).reshape(-1, 2)
        bad = np.flatnonzero((count[:, 0] != 1) | (count[:, 1] > 1))
        if len(bad):
            found = f"{count[bad[0], 0]} passages as u and {count[bad[0], 1]} as v"
            raise ParameterError(f"crossing yarns: node {first_few(bad)}: got {found}; expected 1 and at most 1")
        bad = np.flatnonzero(np.diff(self.yarn_start) < 2)
        if len(bad):
            found = f"got {self.yarn_start[bad[0] + 1] - self.yarn_start[bad[0]]} nodes"
            raise ParameterError(f"crossing yarns: yarn {first_few(bad)}: {found}; expected at least 2")

    def _check_rest(self) -> None:
        along = self.rest_sliding[self.yarn_node, self.yarn_coordinate]
        if not np.isfinite(along).all():
            raise ParameterError("crossing yarns: rest_sliding: got numbers that are not finite; expected cm")
        inner = self.passage_yarn[1:] == self.passage_yarn[:-1]
        bad = np.flatnonzero(inner & ~(np.diff(along) > 0.0))
        if len(bad):
            where = f"yarn {self.passage_yarn[bad[0]]}, nodes {self.yarn_node[bad[0]]} and {self.yarn_node[bad[0] + 1]}"
            found = f"got {along[bad[0]]:g} and {along[bad[0] + 1]:g} cm"
            raise ParameterError(f"crossing yarns: rest_sliding: {where}: {found}; expected lengths that increase")


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
