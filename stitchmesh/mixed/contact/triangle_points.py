# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Contact points on triangles, as dense as the thickness of the cloth demands.

A triangle whose longest side is longer than the spacing is divided into n x n equal parts, with n the power of two that
makes the sides of the parts no longer than the spacing. The contact points are the corners of the parts, and each part
gives a third of its area to each of its corners. Without division they are the vertices. Neighbouring triangles share
the points on their common side; because n is a power of two, the points of the coarser triangle are points of the finer
one too.

Between the points of a layer are holes, whose middles are half a diagonal from the points. A sphere of another layer
does not fit through them while the spacing is smaller than about the thickness; what is thinner than the spacing, such
as the point of a needle or the corner of another cloth, can pass between coarser points without any force.

A point where panels meet, or where a panel meets itself, has several places at rest. They form the links by which
neighbours across a seam are found (``rest_neighbours``).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from stitchmesh.errors import ParameterError
from stitchmesh.mesh import FloatArray, IntArray
from stitchmesh.mixed.contact.contact_points import ContactPoints, checked_thickness

MOST_PARTS = 1024
"""Largest number of parts of the side of a triangle."""


@dataclass(frozen=True, eq=False)
class SeamLinks:
    """Pairs of places at rest that are one place of the cloth."""

    panel: IntArray
    """The two panels of each link; shape (L, 2)."""
    rest: FloatArray
    """The two places in them [cm]; shape (L, 2, 2)."""


@dataclass(frozen=True, eq=False)
class _Corners:
    """Corners of all parts of all triangles; each occurs once for each of its triangles."""

    triangle: IntArray
    """Triangle of each corner; shape (K,)."""
    numerator: IntArray
    """Barycentric coordinates times the largest n; shape (K, 3)."""
    part: FloatArray
    """Part of the area of the triangle; shape (K,)."""
    most: int
    """The largest n."""


def points_on_triangles(
    triangles: ArrayLike,
    rest: ArrayLike,
    panel: ArrayLike,
    *,
    vertex_count: int,
    node_count: int = 0,
    weight: ArrayLike = 1.0,
    thickness: float,
    spacing: float | None = None,
) -> tuple[ContactPoints, SeamLinks]:
    """Contact points on the triangles of a cloth that have a weight, and the links of all its seams.

    Args:
        triangles: vertices of the triangles, shape (T, 3).
        rest: flat rest places of their corners [cm], shape (T, 3, 2).
        panel: panel of each triangle, shape (T,).
        vertex_count: number V of vertices.
        node_count: number N of simulated yarn nodes.
        weight: weight of blending of each triangle, 1 - alpha, shape (T,) or one number.
        thickness: thickness of the cloth [cm].
        spacing: largest distance between neighbouring points [cm]; the thickness where not given. Infinity means that
            triangles are not divided.

    Raises:
        ParameterError: a thickness or a spacing that is not positive, or a triangle that would have too many points.
    """
    corner, flat = np.asarray(triangles, dtype=np.int64), np.asarray(rest, dtype=np.float64)
    panels, radius = np.asarray(panel, dtype=np.int64), 0.5 * checked_thickness(thickness)
    weights = np.broadcast_to(np.asarray(weight, dtype=np.float64), len(corner))
    corners = _corners_of_parts(_divisions(flat, thickness if spacing is None else spacing))
    index, share, number = _merged(corner[corners.triangle], corners)
    place = np.einsum("kc,kcd->kd", corners.numerator / corners.most, flat[corners.triangle])
    area = corners.part * (_areas(flat) * weights)[corners.triangle]
    total = np.zeros(len(index))
    np.add.at(total, number, area)
    first = np.unique(number, return_index=True)[1]
    kept = np.flatnonzero(total > 0.0)
    points = ContactPoints(
        vertex_count, node_count, index[kept], share[kept], total[kept], np.full(len(kept), radius),
        panels[corners.triangle[first[kept]]], place[first[kept]],
    )  # fmt: skip
    return points, _links(number, panels[corners.triangle], place)


def _divisions(rest: FloatArray, spacing: float) -> IntArray:
    """Number n of parts of the sides of each triangle, shape (T,)."""
    if not spacing > 0.0:
        raise ParameterError(f"contact points: got a spacing of {spacing} cm; expected a positive number")
    longest = np.linalg.norm(rest - np.roll(rest, 1, axis=1), axis=2).max(axis=1, initial=0.0)
    times = np.ceil(np.log2(np.maximum(longest / spacing, 1.0)) - 1e-9).astype(np.int64)
    parts: IntArray = 2 ** np.maximum(times, 0)
    if parts.max(initial=1) > MOST_PARTS:
        worst = int(parts.argmax())
        found = f"triangle {worst} has a side of {longest[worst]:.3g} cm, over {MOST_PARTS} spacings of {spacing:.3g}"
        raise ParameterError(f"contact points: {found}; give a larger spacing")
    return parts


def _corners_of_parts(parts: IntArray) -> _Corners:
    most = int(parts.max(initial=1))
    triangle, numerator, part = [], [], []
    for n in np.unique(parts).tolist():
        chosen = np.flatnonzero(parts == n)
        i, j = (grid.ravel() for grid in np.mgrid[: n + 1, : n + 1])
        lattice = np.stack([i, j, n - i - j], axis=1)[i + j <= n]
        touching = np.array([6, 3, 1])[(lattice == 0).sum(axis=1)]  # parts inside, at a side, at a corner
        triangle.append(np.repeat(chosen, len(lattice)))
        numerator.append(np.tile(lattice * (most // n), (len(chosen), 1)))
        part.append(np.tile(touching / (3.0 * n * n), len(chosen)))
    if not triangle:
        return _Corners(np.zeros(0, dtype=np.int64), np.zeros((0, 3), dtype=np.int64), np.zeros(0), most)
    return _Corners(np.concatenate(triangle), np.concatenate(numerator), np.concatenate(part), most)


def _merged(vertex: IntArray, corners: _Corners) -> tuple[IntArray, FloatArray, IntArray]:
    """Distinct points (their vertices and shares), and the point of each corner, shape (K,)."""
    own = np.where(corners.numerator > 0, vertex, -1)  # a vertex without weight does not distinguish points
    order = np.argsort(own, axis=1)
    key = np.concatenate([np.take_along_axis(array, order, axis=1) for array in (own, corners.numerator)], axis=1)
    distinct, number = np.unique(key, axis=0, return_inverse=True)
    index = np.where(distinct[:, :3] < 0, distinct[:, 2:3], distinct[:, :3])
    return index, distinct[:, 3:] / corners.most, number.ravel()


def _areas(rest: FloatArray) -> FloatArray:
    one, other = rest[:, 1] - rest[:, 0], rest[:, 2] - rest[:, 0]
    return 0.5 * np.abs(one[:, 0] * other[:, 1] - one[:, 1] * other[:, 0])


def _links(number: IntArray, panel: IntArray, place: FloatArray) -> SeamLinks:
    """Links between the first rest place of each point and its other ones."""
    first = np.unique(number, return_index=True)[1][number]
    size = float(np.abs(place).max(initial=1.0))
    other = (panel != panel[first]) | (np.abs(place - place[first]).max(axis=1, initial=0.0) > 1e-9 * size)
    pairs = np.stack([first[other], np.flatnonzero(other)], axis=1)
    return SeamLinks(panel[pairs], place[pairs])
