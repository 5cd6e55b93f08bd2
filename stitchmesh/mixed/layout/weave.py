# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""A weave laid out on the panels of a cloth (Cirio et al. 2014, section 3).

Warps run along y and wefts along x of each panel, at equal distances. Warp k of a panel lies at x = (k + 1/2) / ends
and weft k at y = (k + 1/2) / picks, for all integers k, so the matrix of the weave repeats in the coordinates of the
panel. The yarns are clipped at the border, and each crossing inside is a node.

A crossing that is too near to the border along one of its yarns is left out: nearer than ``MARGIN`` times the distance
of two crossings. On a seam the rest of the yarn would be a segment of nearly no length.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import ArrayLike, NDArray

from stitchmesh.errors import ParameterError
from stitchmesh.mesh import FloatArray, IntArray
from stitchmesh.mixed.cloth.cloth import Cloth
from stitchmesh.mixed.layout.crossing_yarns import WARP, WEFT, CrossingYarns, Joints, LaidNodes, Passages, joined
from stitchmesh.mixed.layout.embedding import embed_points
from stitchmesh.mixed.layout.panel_yarns import ClippedLines, PanelYarns, clipped_lines, yarns_on_cloth

MARGIN = 0.25
"""Smallest distance of a crossing from the border along its yarns, and of two nodes of a rod, in distances of yarns."""


def lay_weave(cloth: Cloth, over: ArrayLike, *, ends: float, picks: float) -> CrossingYarns:
    """Lay a weave out on all panels of a cloth.

    Args:
        cloth: the cloth.
        over: whether each weft passes over each warp in one repeat, seen from outside, shape (wefts, warps). Wefts are
            listed from the top and warps from the left, as in the matrix of a weave file.
        ends: warps per cm.
        picks: wefts per cm.

    Raises:
        ParameterError: the matrix is empty, a density is not positive, or no yarn has two crossings on the cloth.
    """
    matrix = _checked_matrix(over)
    spacing = yarn_distance("ends", ends), yarn_distance("picks", picks)
    panels = [_panel_yarns(cloth, panel, spacing, matrix) for panel in range(len(cloth.panel_names))]
    return yarns_on_cloth("weave", cloth, panels, MARGIN * min(spacing))


def _panel_yarns(cloth: Cloth, panel: int, spacing: tuple[float, float], matrix: NDArray[np.bool_]) -> PanelYarns:
    """The wefts of a panel, followed by its warps."""
    wefts, warps = clipped_lines(cloth, panel, 0, spacing[1]), clipped_lines(cloth, panel, 1, spacing[0])
    crossings = _crossings(wefts, warps, spacing)
    nodes = _nodes(cloth, panel, crossings, spacing, matrix)
    return PanelYarns(
        nodes,
        _passages(crossings, nodes.position, len(wefts.line)),
        np.repeat([WEFT, WARP], [len(wefts.line), len(warps.line)]),
        joined([_joints(wefts, 0), _joints(warps, len(wefts.line))]),
    )


def _checked_matrix(over: ArrayLike) -> NDArray[np.bool_]:
    matrix = np.asarray(over)
    if matrix.ndim != 2 or not matrix.size:
        raise ParameterError(f"weave: got a matrix of shape {matrix.shape}; expected (wefts, warps)")
    if not np.isin(matrix, (0, 1)).all():
        raise ParameterError("weave: got numbers other than 0 and 1; expected 1 where the weft passes over the warp")
    return matrix.astype(np.bool_)


def yarn_distance(name: str, density: float) -> float:
    """Return the distance of two yarns [cm].

    Raises:
        ParameterError: the density is not a positive number of yarns per cm.
    """
    if not (math.isfinite(density) and density > 0.0):
        raise ParameterError(f"weave: {name}: got {density}; expected a positive number of yarns per cm")
    return 1.0 / density


def _crossings(wefts: ClippedLines, warps: ClippedLines, spacing: tuple[float, float]) -> IntArray:
    """Numbers of warp line, weft line, piece of the weft and piece of the warp of each crossing, shape (n, 4).

    Crossings ascend along each weft, weft by weft.
    """
    if not len(warps.line):
        return np.zeros((0, 4), dtype=np.int64)
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


def _nodes(
    cloth: Cloth, panel: int, crossings: IntArray, spacing: tuple[float, float], matrix: NDArray[np.bool_]
) -> LaidNodes:
    """The nodes of a panel."""
    position: FloatArray = (crossings[:, :2] + 0.5) * np.array(spacing)
    of_panel = np.full(len(crossings), panel)
    found = embed_points(cloth, of_panel, position)
    over = matrix[(-1 - crossings[:, 1]) % len(matrix), crossings[:, 0] % matrix.shape[1]]
    side, no_seam = np.where(over, 1, -1), np.zeros_like(position)
    return LaidNodes(of_panel, position, found.triangle, found.barycentric, side, no_seam)


def _passages(crossings: IntArray, position: FloatArray, first_warp: int) -> Passages:
    """Passages of the wefts, followed by passages of the warps, both in order."""
    node = np.arange(len(crossings))
    up = np.argsort(crossings[:, 3], kind="stable")  # wefts ascend, and so does the place along each warp
    wefts = Passages(crossings[:, 2], position[:, 0], node, np.zeros_like(node), position)
    warps = Passages(first_warp + crossings[up, 3], position[up, 1], up, np.ones_like(node), position[up])
    return joined([wefts, warps])


def _joints(lines: ClippedLines, first_yarn: int) -> Joints:
    """Both ends of each piece."""
    piece = np.repeat(np.arange(len(lines.line)), 2)
    return Joints(first_yarn + piece, lines.ends.ravel(), lines.border.ravel(), lines.part.ravel())
