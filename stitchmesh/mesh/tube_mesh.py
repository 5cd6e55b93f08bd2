# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Triangle tubes around curves, with outward normals, in twist-free (parallel transport) frames.

Each point of a curve has a reference frame: any unit normal u of the tangent t, and v = t x u. The twist-free frame is
the reference frame rotated about t by an angle. The smallest rotation from a tangent t to the next tangent t' carries
u to ``u - (t + t') (t' . u) / (1 + t . t')``. The angle of this vector in the next reference frame is the turn of the
step. The angles of the frames are the cumulative sums of the turns, so that all curves are treated at once by array
operations. On a closed curve the frame does not return to its start; the remaining angle is distributed uniformly over
the points of the curve. A curve that continues in a shifted copy of itself is treated in the same way.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import ArrayLike, NDArray

from stitchmesh.mesh.polygon_mesh import FloatArray, IntArray

HIDDEN = 0.995
"""Radius of the outermost ring of a repeating tube over the radius of the tube: the next copy hides this ring."""


@dataclass(frozen=True)
class TubeMesh:
    """Triangles of one or more tubes."""

    vertices: FloatArray
    """Positions of the vertices [cm], ring by ring, shape (V, 3)."""
    normals: FloatArray
    """Outward unit normals of the tube, shape (V, 3)."""
    triangles: IntArray
    """Vertices of each triangle, counter-clockwise when seen from outside, shape (T, 3)."""
    ring: IntArray
    """Ring of each vertex, shape (V,): the number of the curve point around which the vertex lies."""


@dataclass(frozen=True)
class _Rings:
    """Points of all curves in one array, and the steps between consecutive points."""

    points: FloatArray
    """Points of all curves [cm], shape (P, 3)."""
    curve: IntArray
    """Curve of each point, shape (P,)."""
    step_from: IntArray
    """Point at which each step starts, shape (S,); a closed curve also has a step from its last point to its first."""
    step_to: IntArray
    """Point at which each step ends, shape (S,)."""
    step: FloatArray
    """Vector of each step [cm], shape (S, 3)."""
    starts: IntArray
    """First point of each curve, and the end of the last curve, shape (curves + 1,)."""
    closed: NDArray[np.bool_]
    """Whether each curve is closed, shape (curves,)."""


def tubes_around(curves: Sequence[FloatArray], closed: ArrayLike, radius: ArrayLike, *, sides: int) -> TubeMesh:
    """Make tubes around polylines; the ends of an open tube are closed by flat caps.

    Args:
        curves: points of each curve [cm], shape (n, 3) each, with n at least 2 (3 if closed); a closed curve does not
            repeat its first point.
        closed: whether each curve is closed.
        radius: radius of each point of all curves in turn [cm], of each tube, or of all tubes.
        sides: number of vertices around a ring, at least 3.
    """
    rings = _rings(curves, np.broadcast_to(np.asarray(closed, dtype=np.bool_), len(curves)))
    across, upward = _frames(rings)
    given = np.asarray(radius, dtype=np.float64)
    of_points = given.shape == (len(rings.points),)
    radii = given if of_points else np.broadcast_to(given, len(curves))[rings.curve]
    turn = 2 * np.pi * np.arange(sides) / sides
    normals = np.cos(turn)[:, None] * across[:, None] + np.sin(turn)[:, None] * upward[:, None]
    vertices = rings.points[:, None] + radii[:, None, None] * normals
    ring = np.repeat(np.arange(len(rings.points)), sides)
    return TubeMesh(vertices.reshape(-1, 3), normals.reshape(-1, 3), _triangles(rings, sides), ring)


def repeating_tubes(curves: Sequence[FloatArray], shift: FloatArray, radius: ArrayLike, *, sides: int) -> TubeMesh:
    """Make tubes around curves that continue in shifted copies of themselves, so that copies of the tubes join.

    The rings at both ends of a tube are equal up to the shift. Beyond each of them the tube has one more ring, which is
    hidden inside the next copy. Normals that a viewer computes from the triangles are therefore equal on both sides of
    a joint. Flat caps close the tube.

    Args:
        curves: points of each curve up to the point before the first one of its next copy [cm], shape (n, 3) each, with
            n at least 2.
        shift: translation from each curve to its next copy [cm], shape (curves, 3); 0 for a closed curve.
        radius: radius of each tube [cm], or one radius for all tubes.
        sides: number of vertices around a ring, at least 3.

    Returns:
        The tubes; ``ring`` numbers the points of all curves in turn.
    """
    rings = _rings(curves, np.ones(len(curves), dtype=np.bool_), shift)
    across, upward = _frames(rings)
    copied = [_with_joints(first, last) for first, last in pairwise(rings.starts.tolist())]
    point = np.concatenate([own for own, _, _ in copied])
    image, shrunk = (np.concatenate([each[place] for each in copied]) for place in (1, 2))
    centre = rings.points[point] + image[:, None] * shift[rings.curve[point]]
    radii = np.broadcast_to(np.asarray(radius, dtype=np.float64), len(curves))[rings.curve[point]] * shrunk
    turn = 2 * np.pi * np.arange(sides) / sides
    normals = np.cos(turn)[:, None] * across[point, None] + np.sin(turn)[:, None] * upward[point, None]
    vertices = centre[:, None] + radii[:, None, None] * normals
    counts = [len(own) for own, _, _ in copied]
    extended = _rings(np.split(centre, np.cumsum(counts)[:-1]), np.zeros(len(curves), dtype=np.bool_))
    triangles = _triangles(extended, sides)
    return TubeMesh(vertices.reshape(-1, 3), normals.reshape(-1, 3), triangles, np.repeat(point, sides))


def _with_joints(first: int, last: int) -> tuple[IntArray, FloatArray, FloatArray]:
    """Return the points of the rings of one repeating tube, the copy of each, and its part of the radius.

    Args:
        first: number of the first point of the curve.
        last: number of its last point, plus 1.
    """
    own = np.arange(first, last)
    point = np.concatenate([own[-1:], own, own[:2]])
    image = np.zeros(len(point))
    image[0], image[-2:] = -1.0, 1.0
    shrunk = np.ones(len(point))
    shrunk[[0, -1]] = HIDDEN
    return point, image, shrunk


def twist_free_frames(
    curves: Sequence[FloatArray], closed: ArrayLike, shift: FloatArray | None = None
) -> tuple[FloatArray, FloatArray]:
    """Return the two unit normals of the twist-free frame of each point of all curves, shape (P, 3) each.

    Args:
        curves: points of each curve [cm], as for ``tubes_around``.
        closed: whether each curve is closed.
        shift: translation from each closed curve to the copy in which it continues [cm], shape (curves, 3); 0 if None.
    """
    return _frames(_rings(curves, np.broadcast_to(np.asarray(closed, dtype=np.bool_), len(curves)), shift))


def _rings(curves: Sequence[FloatArray], closed: NDArray[np.bool_], shift: FloatArray | None = None) -> _Rings:
    """Concatenate the points of all curves and find the steps between consecutive points.

    Args:
        curves: points of each curve [cm], shape (n, 3) each.
        closed: whether each curve is closed, shape (curves,).
        shift: translation from each closed curve to the copy in which it continues [cm], shape (curves, 3).
    """
    counts = np.array([len(curve) for curve in curves])
    starts = np.concatenate([[0], np.cumsum(counts)])
    following = np.arange(1, starts[-1] + 1)
    following[starts[1:] - 1] = starts[:-1]
    has_step = np.ones(starts[-1], dtype=bool)
    has_step[starts[1:][~closed] - 1] = False
    step_from = np.flatnonzero(has_step)
    curve = np.repeat(np.arange(len(curves)), counts)
    points, step_to = np.concatenate(curves), following[step_from]
    step = points[step_to] - points[step_from]
    if shift is not None:
        returns = step_to <= step_from
        step[returns] += shift[curve[step_from[returns]]]
    return _Rings(points, curve, step_from, step_to, step, starts, closed)


def _frames(rings: _Rings) -> tuple[FloatArray, FloatArray]:
    """The two unit normals of the twist-free frame of each point, shape (P, 3) each."""
    tangent = _tangents(rings)
    across = _any_normal(tangent)
    upward = np.cross(tangent, across)
    angle = _angles(rings, tangent, across, upward)[:, None]
    return np.cos(angle) * across + np.sin(angle) * upward, np.cos(angle) * upward - np.sin(angle) * across


def _tangents(rings: _Rings) -> FloatArray:
    """Unit tangents, shape (P, 3): the mean of the steps before and after each point; at a cusp, the step after it."""
    step = rings.step
    after = np.zeros_like(rings.points)
    before = np.zeros_like(rings.points)
    after[rings.step_from] = step
    before[rings.step_to] = step
    total = after + before
    length = np.linalg.norm(total, axis=1, keepdims=True)
    scale = np.linalg.norm(after, axis=1, keepdims=True) + np.linalg.norm(before, axis=1, keepdims=True)
    is_cusp = (length <= 1e-9 * scale).ravel()  # Two steps cancel to rounding only where the curve reverses.
    total[is_cusp] = after[is_cusp]
    total[is_cusp & ~after.any(axis=1)] = [0.0, 0.0, 1.0]
    return total / np.linalg.norm(total, axis=1, keepdims=True)


def _any_normal(tangent: FloatArray) -> FloatArray:
    """A unit vector perpendicular to each tangent, shape (P, 3)."""
    axis = np.zeros_like(tangent)
    axis[np.arange(len(tangent)), np.abs(tangent).argmin(axis=1)] = 1.0
    normal = np.cross(tangent, axis)
    return normal / np.linalg.norm(normal, axis=1, keepdims=True)


def _angles(rings: _Rings, tangent: FloatArray, across: FloatArray, upward: FloatArray) -> FloatArray:
    """Angle of the twist-free frame relative to the reference frame of each point, shape (P,)."""
    here, there = rings.step_from, rings.step_to
    cosine = np.einsum("ij,ij->i", tangent[here], tangent[there])
    lean = np.einsum("ij,ij->i", tangent[there], across[here]) / np.maximum(1.0 + cosine, 1e-12)
    carried = across[here] - (tangent[here] + tangent[there]) * lean[:, None]
    turn = np.zeros(len(tangent))  # Turn of the step that starts at each point.
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
    """Triangles between consecutive rings, and of the caps of open curves, shape (T, 3)."""
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
