# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Attachments: vertices and yarn nodes that are held, moved by keyframes, or pulled by springs.

What is attached is chosen by a box, by the border of a panel or by the numbers of vertices; each choice takes the yarn
nodes at the same place too, because a region of yarns has no vertices of its own. An attachment without stiffness
prescribes the motion (``prescribed_motion``), one with a stiffness pulls (``attachment_springs``).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.spatial import cKDTree

from stitchmesh.errors import ParameterError
from stitchmesh.mesh import FloatArray, IntArray, frozen_array
from stitchmesh.mixed.cloth.cloth import Cloth
from stitchmesh.mixed.contact.motion import RigidMotion

SIDES = ("all", "left", "right", "bottom", "top")
"""Sides of a panel: its whole border, or what of it lies at the smallest or largest x or y."""


def _none() -> IntArray:
    return np.zeros(0, dtype=np.int64)


@dataclass(frozen=True, eq=False)
class AttachmentNodes:
    """Where the yarn nodes of a layout are, as far as a choice of them needs it; N nodes."""

    panel: IntArray
    """Panel of each node; shape (N,)."""
    position: FloatArray
    """Place of each node in its panel [cm]; shape (N, 2)."""
    triangle: IntArray
    """Triangle of each node; shape (N,)."""
    place: FloatArray
    """Place of each node in the world at the start [cm]; shape (N, 3)."""

    @staticmethod
    def none() -> AttachmentNodes:
        """No nodes, for a cloth without yarns."""
        return AttachmentNodes(_none(), np.zeros((0, 2)), _none(), np.zeros((0, 3)))


@dataclass(frozen=True, eq=False)
class Attachment:
    """Vertices and nodes that are attached to something that does not move, or moves rigidly.

    Raises:
        ParameterError: nothing is attached, a number occurs twice or is negative, or a stiffness is not positive.
    """

    vertices: IntArray = field(default_factory=_none)
    """Numbers of vertices, ascending."""
    nodes: IntArray = field(default_factory=_none)
    """Numbers of yarn nodes, ascending."""
    motion: RigidMotion = field(default_factory=RigidMotion.at_rest)
    """How the attached points move, from where they are at the start."""
    stiffness: float | None = None
    """Stiffness of the spring at each vertex and node [dyn / cm]; None if they are held."""
    name: str = "attachment"
    """Name in messages."""

    def __post_init__(self) -> None:
        for kind in ("vertices", "nodes"):
            numbers = np.sort(np.asarray(getattr(self, kind), dtype=np.int64))
            if len(numbers) and (numbers[0] < 0 or (np.diff(numbers) == 0).any()):
                raise ParameterError(
                    f"{self.name}: {kind}: got a number below 0 or one twice; expected distinct numbers"
                )
            object.__setattr__(self, kind, frozen_array(numbers, np.int64))
        if not len(self.vertices) + len(self.nodes):
            raise ParameterError(f"{self.name}: got no vertex and no node; expected some: change what is chosen")
        if self.stiffness is not None and not (np.isfinite(self.stiffness) and self.stiffness > 0.0):
            raise ParameterError(f"{self.name}: got a stiffness of {self.stiffness} dyn / cm; expected a positive one")


def at_simulated_nodes(attachments: Sequence[Attachment], node_number: IntArray) -> list[Attachment]:
    """Attachments with the numbers that the simulated nodes have in a state; those that hold nothing are left out.

    Args:
        attachments: attachments whose nodes are numbered as in the layout.
        node_number: number of each node of the layout among the simulated ones, -1 for the others, shape (N,).
    """
    result = []
    for attachment in attachments:
        own = node_number[attachment.nodes]
        own = own[own >= 0]
        if len(own) + len(attachment.vertices):
            result.append(replace(attachment, nodes=own))
    return result


def chosen_in_box(low: ArrayLike, high: ArrayLike, cloth: Cloth, nodes: AttachmentNodes) -> tuple[IntArray, IntArray]:
    """Vertices and nodes whose place at the start is in a box, numbers of both.

    Args:
        low: least coordinates of the box [cm], shape (3,).
        high: largest coordinates [cm], shape (3,).
        cloth: the cloth.
        nodes: its yarn nodes.

    Raises:
        ParameterError: the box is empty.
    """
    least, most = np.asarray(low, dtype=np.float64), np.asarray(high, dtype=np.float64)
    if least.shape != (3,) or most.shape != (3,) or not (least <= most).all():
        raise ParameterError(f"attachment: got a box from {least} to {most} cm; expected three increasing coordinates")
    within = [((place >= least) & (place <= most)).all(axis=1) for place in (cloth.vertices, nodes.place)]
    return np.flatnonzero(within[0]), np.flatnonzero(within[1])


def chosen_with_vertices(vertices: ArrayLike, cloth: Cloth, nodes: AttachmentNodes) -> tuple[IntArray, IntArray]:
    """Some vertices, and the nodes on triangles all of whose vertices are among them.

    Args:
        vertices: numbers of vertices.
        cloth: the cloth.
        nodes: its yarn nodes.

    Raises:
        ParameterError: a vertex does not exist.
    """
    numbers = np.unique(np.asarray(vertices, dtype=np.int64))
    wrong = numbers[(numbers < 0) | (numbers >= len(cloth.vertices))]
    if len(wrong):
        found = f"got vertex {int(wrong[0])}"
        raise ParameterError(f"attachment: {found}; expected 0 to {len(cloth.vertices) - 1}")
    whole: NDArray[np.bool_] = np.isin(cloth.triangles, numbers).min(axis=1)
    return numbers, np.flatnonzero(whole[nodes.triangle])


def chosen_on_border(
    panel: str, side: str, cloth: Cloth, nodes: AttachmentNodes, *, width: float = 0.0
) -> tuple[IntArray, IntArray]:
    """Vertices on the border of a panel, and the nodes within a width of them.

    Args:
        panel: name of the panel.
        side: ``all`` for the whole border, or ``left``, ``right``, ``bottom`` or ``top``: what of it lies within the
            width of the smallest or largest x or y of the panel.
        cloth: the cloth.
        nodes: its yarn nodes.
        width: distance from the border, in the panel at rest, up to which nodes are chosen [cm].

    Raises:
        ParameterError: no panel or side of that name, or a width below 0.
    """
    if panel not in cloth.panel_names:
        raise ParameterError(f"attachment: got the panel {panel!r}; expected one of {', '.join(cloth.panel_names)}")
    if side not in SIDES:
        raise ParameterError(f"attachment: got the side {side!r}; expected one of {', '.join(SIDES)}")
    if not (np.isfinite(width) and width >= 0.0):
        raise ParameterError(f"attachment: got a width of {width} cm; expected at least 0")
    number = cloth.panel_names.index(panel)
    sides = cloth.border_sides[cloth.panel[cloth.border_sides // 3] == number]
    ends = cloth.side_rest[sides]
    kept = _at_side(ends, side, width)
    own = np.flatnonzero(nodes.panel == number)
    near = _within(nodes.position[own], ends[kept], width)
    return np.unique(cloth.side_vertices[sides[kept]]), own[near]


def _at_side(ends: FloatArray, side: str, width: float) -> IntArray:
    """Border edges both of whose ends lie at a side of the panel; shape (n, 2, 2) to (m,)."""
    if side == "all" or not len(ends):
        return np.arange(len(ends))
    coordinate = ends[:, :, 0 if side in ("left", "right") else 1]
    extreme = coordinate.min() if side in ("left", "bottom") else coordinate.max()
    rounding = 1e-9 * float(np.abs(ends).max())
    return np.flatnonzero((np.abs(coordinate - extreme) <= width + rounding).all(axis=1))


def _within(points: FloatArray, edges: FloatArray, width: float) -> NDArray[np.bool_]:
    """Whether each point is within a width of one of some straight edges, shapes (n, 2) and (m, 2, 2) to (n,)."""
    near: NDArray[np.bool_] = np.zeros(len(points), dtype=np.bool_)
    if not len(points) or not len(edges):
        return near
    middle, half = edges.mean(axis=1), 0.5 * np.linalg.norm(edges[:, 1] - edges[:, 0], axis=1)
    candidates = cKDTree(points).query_ball_point(middle, (half + width) * (1.0 + 1e-9))
    for (start, end), found in zip(edges, candidates, strict=True):
        along, apart = end - start, points[found] - start
        part = np.clip(apart @ along / (along @ along), 0.0, 1.0)
        near[found] |= np.linalg.norm(apart - part[:, None] * along, axis=1) <= width
    return near
