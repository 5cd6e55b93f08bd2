# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Contact points on triangles, as dense as the thickness of the cloth demands and the size of the triangles allows.

A triangle whose longest side is longer than the spacing is divided into n x n equal parts, with n the power of two that
makes the sides of the parts no longer than the spacing, but at most ``MOST_PARTS``. The contact points are the corners
of the parts, and each part gives a third of its area to each of its corners. Without division they are the vertices.
Neighbouring triangles share the points on their common side; because n is a power of two, the points of the coarser
triangle are points of the finer one too.

A layer of coarse triangles, whose points are farther apart than the thickness, would have holes. Its spheres are as
large as the distance of the points, so that other layers of the same kind do not pass, but stay that far away. What is
thinner than the distance of the points, such as the corner of another cloth or a needle, can pass between them.

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

MOST_PARTS = 4
"""Default of the largest number of parts of the side of a triangle."""


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
    apart: FloatArray
    """Longest side of the parts [cm]; shape (K,)."""
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
    most_parts: int = MOST_PARTS,
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
        spacing: wanted distance between neighbouring points [cm]; the thickness where not given. Infinity means that
            triangles are not divided.
        most_parts: largest number of parts of the side of a triangle, a power of two.

    Raises:
        ParameterError: a thickness or a spacing that is not positive, or a number of parts that is no power of two.
    """
    corner, flat = np.asarray(triangles, dtype=np.int64), np.asarray(rest, dtype=np.float64)
    panels, radius = np.asarray(panel, dtype=np.int64), 0.5 * checked_thickness(thickness)
    weights = np.broadcast_to(np.asarray(weight, dtype=np.float64), len(corner))
    longest = np.linalg.norm(flat - np.roll(flat, 1, axis=1), axis=2).max(axis=1, initial=0.0)
    corners = _corners_of_parts(_divisions(longest, thickness if spacing is None else spacing, most_parts), longest)
    index, share, number = _merged(corner[corners.triangle], corners)
    place = np.einsum("kc,kcd->kd", corners.numerator / corners.most, flat[corners.triangle])
    area = corners.part * (_areas(flat) * weights)[corners.triangle]
    total = np.zeros(len(index))
    np.add.at(total, number, area)
    first = np.unique(number, return_index=True)[1]
    layer_radius = np.full(len(index), radius)
    np.maximum.at(layer_radius, number, 0.5 * corners.apart)
    kept = np.flatnonzero(total > 0.0)
    points = ContactPoints(
        vertex_count, node_count, index[kept], share[kept], total[kept], np.full(len(kept), radius), layer_radius[kept],
        panels[corners.triangle[first[kept]]], place[first[kept]],
    )  # fmt: skip
    return points, _links(number, panels[corners.triangle], place)


def _divisions(longest: FloatArray, spacing: float, most_parts: int) -> IntArray:
    """Number n of parts of the sides of each triangle, from its longest side, shape (T,)."""
    if not spacing > 0.0:
        raise ParameterError(f"contact points: got a spacing of {spacing} cm; expected a positive number")
    if most_parts < 1 or most_parts & (most_parts - 1):
        raise ParameterError(f"contact points: got {most_parts} parts of a side; expected a power of two: 1, 2, 4, 8")
    times = np.ceil(np.log2(np.maximum(longest / spacing, 1.0)) - 1e-9)
    return np.minimum(2 ** np.clip(times, 0, 30).astype(np.int64), most_parts)


def _corners_of_parts(parts: IntArray, longest: FloatArray) -> _Corners:
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
        return _Corners(np.zeros(0, dtype=np.int64), np.zeros((0, 3), dtype=np.int64), np.zeros(0), np.zeros(0), most)
    of = np.concatenate(triangle)
    return _Corners(of, np.concatenate(numerator), np.concatenate(part), (longest / parts)[of], most)


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
