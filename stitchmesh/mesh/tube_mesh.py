# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Triangle tubes around curves, wound outward, in frames that do not twist.

The frame of a curve is its reference frame (any normal u of the tangent t, and v = t x u) turned by an angle.
Carrying u from one point to the next by the smallest rotation between the tangents,
``u - (t + t') (t' . u) / (1 + t . t')``, and reading off its angle in the next reference frame gives the turn of
that step; the angles are the running sums of these turns, so frames of any number of curves come without a loop. A
closed curve ends with a leftover turn, which is spread over its length.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from stitchmesh.mesh.polygon_mesh import FloatArray, IntArray


@dataclass(frozen=True)
class TubeMesh:
    """Triangles of many tubes."""

    vertices: FloatArray
    """Positions [cm], shape (V, 3): ring after ring."""
    normals: FloatArray
    """Outward unit normals of the tube, shape (V, 3)."""
    triangles: IntArray
    """Vertex numbers, counter-clockwise seen from outside, shape (T, 3)."""
    ring: IntArray
    """Ring of each vertex, which is the number of the point that it lies around, shape (V,)."""


@dataclass(frozen=True)
class _Rings:
    """Points of all curves in one row, and how they follow one another."""

    points: FloatArray
    curve: IntArray
    step_from: IntArray
    """Point at which each step between rings starts; a closed curve has one from its last point to its first."""
    step_to: IntArray
    starts: IntArray
    """First point of each curve, and the end of the last, shape (curves + 1,)."""
    closed: NDArray[np.bool_]


def tubes_around(curves: Sequence[FloatArray], closed: ArrayLike, radius: ArrayLike, *, sides: int) -> TubeMesh:
    """Tubes around polylines; open ones are closed with flat caps.

    Args:
        curves: points of each curve [cm], shape (n, 3) each, n at least 2 (3 if closed); the first is not repeated.
        closed: whether each curve is closed.
        radius: radius of each curve [cm], or one for all.
        sides: corners of a ring, at least 3.
    """
    rings = _rings(curves, np.broadcast_to(np.asarray(closed, dtype=np.bool_), len(curves)))
    across, upward = _frames(rings)
    radii = np.broadcast_to(np.asarray(radius, dtype=np.float64), len(curves))[rings.curve]
    turn = 2 * np.pi * np.arange(sides) / sides
    normals = np.cos(turn)[:, None] * across[:, None] + np.sin(turn)[:, None] * upward[:, None]
    vertices = rings.points[:, None] + radii[:, None, None] * normals
    ring = np.repeat(np.arange(len(rings.points)), sides)
    return TubeMesh(vertices.reshape(-1, 3), normals.reshape(-1, 3), _triangles(rings, sides), ring)


def _rings(curves: Sequence[FloatArray], closed: NDArray[np.bool_]) -> _Rings:
    counts = np.array([len(curve) for curve in curves])
    starts = np.concatenate([[0], np.cumsum(counts)])
    following = np.arange(1, starts[-1] + 1)
    following[starts[1:] - 1] = starts[:-1]
    has_step = np.ones(starts[-1], dtype=bool)
    has_step[starts[1:][~closed] - 1] = False
    step_from = np.flatnonzero(has_step)
    curve = np.repeat(np.arange(len(curves)), counts)
    return _Rings(np.concatenate(curves), curve, step_from, following[step_from], starts, closed)


def _frames(rings: _Rings) -> tuple[FloatArray, FloatArray]:
    tangent = _tangents(rings)
    across = _any_normal(tangent)
    upward = np.cross(tangent, across)
    angle = _angles(rings, tangent, across, upward)[:, None]
    return np.cos(angle) * across + np.sin(angle) * upward, np.cos(angle) * upward - np.sin(angle) * across


def _tangents(rings: _Rings) -> FloatArray:
    """Unit mean of the directions before and after each point; a cusp takes the direction after it."""
    step = rings.points[rings.step_to] - rings.points[rings.step_from]
    after = np.zeros_like(rings.points)
    before = np.zeros_like(rings.points)
    after[rings.step_from] = step
    before[rings.step_to] = step
    total = after + before
    length = np.linalg.norm(total, axis=1, keepdims=True)
    scale = np.linalg.norm(after, axis=1, keepdims=True) + np.linalg.norm(before, axis=1, keepdims=True)
    flat = (length <= 1e-9 * scale).ravel()  # only a turn on the spot cancels to rounding
    total[flat] = after[flat]
    total[flat & ~after.any(axis=1)] = [0.0, 0.0, 1.0]
    return total / np.linalg.norm(total, axis=1, keepdims=True)


def _any_normal(tangent: FloatArray) -> FloatArray:
    axis = np.zeros_like(tangent)
    axis[np.arange(len(tangent)), np.abs(tangent).argmin(axis=1)] = 1.0
    normal = np.cross(tangent, axis)
    return normal / np.linalg.norm(normal, axis=1, keepdims=True)


def _angles(rings: _Rings, tangent: FloatArray, across: FloatArray, upward: FloatArray) -> FloatArray:
    """Angle of the twist-free frame in the reference frame of each point."""
    here, there = rings.step_from, rings.step_to
    cosine = np.einsum("ij,ij->i", tangent[here], tangent[there])
    lean = np.einsum("ij,ij->i", tangent[there], across[here]) / np.maximum(1.0 + cosine, 1e-12)
    carried = across[here] - (tangent[here] + tangent[there]) * lean[:, None]
    turn = np.zeros(len(tangent))  # of the step that leaves each point
    turn[here] = np.arctan2(
        np.einsum("ij,ij->i", carried, upward[there]), np.einsum("ij,ij->i", carried, across[there])
    )
    total = np.concatenate([[0.0], np.cumsum(turn)])
    first, last = rings.starts[:-1], rings.starts[1:]
    leftover = total[last] - total[first]
    leftover -= 2 * np.pi * np.round(leftover / (2 * np.pi))
    spread = np.where(rings.closed, leftover, 0.0) / (last - first)
    place = np.arange(len(tangent)) - first[rings.curve]
    return total[:-1] - total[first][rings.curve] - spread[rings.curve] * place


def _triangles(rings: _Rings, sides: int) -> IntArray:
    corner = np.arange(sides)
    beside = (corner + 1) % sides
    here, there = rings.step_from[:, None] * sides, rings.step_to[:, None] * sides
    lower = np.stack([here + corner, here + beside, there + beside], axis=2)
    upper = np.stack([here + corner, there + beside, there + corner], axis=2)
    fan = np.stack([np.zeros(sides - 2, dtype=np.int64), corner[1:-1], corner[2:]], axis=1)
    first = rings.starts[:-1][~rings.closed, None, None] * sides
    last = (rings.starts[1:][~rings.closed, None, None] - 1) * sides
    parts = [lower, upper, first + fan[:, ::-1], last + fan]
    return np.concatenate([part.reshape(-1, 3) for part in parts])
