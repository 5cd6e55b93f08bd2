# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""A weave laid out on the panels of a cloth (Cirio et al. 2014, section 3).

Warps run along y and wefts along x of each panel, at equal distances. Warp k of a panel lies at x = (k + 1/2) / ends
and weft k at y = (k + 1/2) / picks, for all integers k, so that the matrix repeats in the coordinates of the panel. The
yarns are clipped at the border, and each crossing within it is a node.

A crossing is left out if it is nearer to the border, along one of its yarns, than ``MARGIN`` of the distance of two
crossings: on a seam the rest of the yarn would be a segment of nearly no length.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import ArrayLike, NDArray

from stitchmesh.errors import ParameterError
from stitchmesh.mesh import FloatArray, IntArray
from stitchmesh.mixed.cloth.cloth import Cloth
from stitchmesh.mixed.layout.clipped_lines import ClippedLines, clipped_lines
from stitchmesh.mixed.layout.crossing_yarns import WARP, WEFT, CrossingYarns
from stitchmesh.mixed.layout.embedding import embed_points
from stitchmesh.mixed.layout.passages import LaidNodes, Passages, assembled, joined
from stitchmesh.mixed.layout.rods import Joints, joined_joints, with_rods

MARGIN = 0.25
"""Smallest distance of a crossing to the border along its yarns, and of two nodes of a rod, in distances of yarns."""


def lay_weave(cloth: Cloth, over: ArrayLike, *, ends: float, picks: float) -> CrossingYarns:
    """Lay a weave out on all panels of a cloth.

    Args:
        cloth: the cloth.
        over: whether each weft passes over each warp in one repeat, seen from outside, wefts from the top and warps
            from the left, shape (wefts, warps); as the matrix of a weave file.
        ends: warps per cm.
        picks: wefts per cm.

    Raises:
        ParameterError: the matrix is empty, a density is not positive, or no yarn has two crossings on the cloth.
    """
    matrix = _checked_matrix(over)
    spacing = _checked_spacing("ends", ends), _checked_spacing("picks", picks)
    nodes, passages, family, joints = [], [], [np.zeros(0, dtype=np.int64)], []
    node_count = yarn_count = 0
    for panel in range(len(cloth.panel_names)):
        wefts = clipped_lines(cloth, panel, 0, spacing[1])
        warps = clipped_lines(cloth, panel, 1, spacing[0])
        crossings = _crossings(wefts, warps, spacing)
        laid = _nodes(panel, crossings, spacing, matrix)
        nodes.append(laid)
        passages += _passages(crossings, laid.position, node_count, yarn_count, len(wefts.line))
        joints += [_joints(wefts, yarn_count), _joints(warps, yarn_count + len(wefts.line))]
        family.append(np.repeat([WEFT, WARP], [len(wefts.line), len(warps.line)]))
        node_count, yarn_count = node_count + laid.count, yarn_count + len(family[-1])
    return _on_cloth(cloth, joined(nodes), joined(passages), np.concatenate(family), joined_joints(joints), spacing)


def _on_cloth(
    cloth: Cloth, nodes: LaidNodes, passages: Passages, family: IntArray, joints: Joints, spacing: tuple[float, float]
) -> CrossingYarns:
    """Find the triangles of the nodes, and join yarns to rods; ends of yarns without nodes are left out."""
    found = embed_points(cloth, nodes.panel, nodes.position)
    nodes = LaidNodes(nodes.panel, nodes.position, found.triangle, found.barycentric, nodes.side, nodes.seam_direction)
    has_nodes = np.bincount(passages.yarn, minlength=len(family)) > 0
    joints = joints.taken(has_nodes[joints.yarn])
    return assembled("weave", *with_rods(cloth, nodes, passages, family, joints, MARGIN * min(spacing)))


def _checked_matrix(over: ArrayLike) -> NDArray[np.bool_]:
    matrix = np.asarray(over)
    if matrix.ndim != 2 or not matrix.size:
        raise ParameterError(f"weave: got a matrix of shape {matrix.shape}; expected (wefts, warps)")
    if not np.isin(matrix, (0, 1)).all():
        raise ParameterError("weave: got numbers other than 0 and 1; expected 1 where the weft passes over the warp")
    return matrix.astype(np.bool_)


def _checked_spacing(name: str, density: float) -> float:
    """Return the distance of two yarns [cm]."""
    if not (math.isfinite(density) and density > 0.0):
        raise ParameterError(f"weave: {name}: got {density}; expected a positive number of yarns per cm")
    return 1.0 / density


def _crossings(wefts: ClippedLines, warps: ClippedLines, spacing: tuple[float, float]) -> IntArray:
    """Numbers of warp line, weft line, piece of the weft and piece of the warp of each crossing, shape (n, 4).

    They ascend along each weft, weft by weft.
    """
    margin = MARGIN * np.array(spacing)
    first = np.ceil((wefts.ends[:, 0] + margin[0]) / spacing[0] - 0.5).astype(np.int64)
    last = np.floor((wefts.ends[:, 1] - margin[0]) / spacing[0] - 0.5).astype(np.int64)
    count = np.maximum(last - first + 1, 0)
    piece = np.repeat(np.arange(len(count)), count)
    line = first[piece] + np.arange(len(piece)) - np.repeat(np.cumsum(count) - count, count)
    along: FloatArray = (wefts.line[piece] + 0.5) * np.float64(spacing[1])
    warp = warps.piece_at(line, along)
    clear = (warp >= 0) & (along >= warps.ends[warp, 0] + margin[1]) & (along <= warps.ends[warp, 1] - margin[1])
    return np.stack([line, wefts.line[piece], piece, warp], axis=1)[clear]


def _nodes(panel: int, crossings: IntArray, spacing: tuple[float, float], matrix: NDArray[np.bool_]) -> LaidNodes:
    """The nodes of a panel, without their triangles."""
    count = len(crossings)
    over = matrix[(-1 - crossings[:, 1]) % len(matrix), crossings[:, 0] % matrix.shape[1]]
    position: FloatArray = (crossings[:, :2] + 0.5) * np.array(spacing)
    empty = np.zeros((count, 2))
    return LaidNodes(
        np.full(count, panel), position, np.zeros(count, dtype=np.int64), empty, np.where(over, 1, -1), empty
    )


def _passages(
    crossings: IntArray, position: FloatArray, first_node: int, first_yarn: int, weft_count: int
) -> list[Passages]:
    """Passages of the wefts, and of the warps, both in order."""
    node = first_node + np.arange(len(crossings))
    up = np.argsort(crossings[:, 3], kind="stable")  # wefts ascend, and so does the place along each warp
    return [
        Passages(first_yarn + crossings[:, 2], position[:, 0], node, np.zeros_like(node), position),
        Passages(
            first_yarn + weft_count + crossings[up, 3], position[up, 1], node[up], np.ones_like(node), position[up]
        ),
    ]


def _joints(lines: ClippedLines, first_yarn: int) -> Joints:
    """Both ends of each piece."""
    piece = np.repeat(np.arange(len(lines.line)), 2)
    return Joints(first_yarn + piece, lines.ends.ravel(), lines.border.ravel(), lines.part.ravel())
