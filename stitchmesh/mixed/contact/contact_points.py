# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Contact points: the spheres that represent a cloth in contact (Casafranca et al. 2020, section 6.1).

A contact point lies on a triangle, where its position is a weighted mean of three vertices, or at a yarn node:

    c = sum over k of  share_k x_k,    x = (vertices v, nodes p)

It stands for an area of cloth. The area is multiplied by the blending weight, 1 - alpha on triangles and alpha at
nodes. A hybrid region, which has points of both kinds, then counts once.

Contact points on triangles are as dense as the thickness of the cloth demands and the size of the triangles allows. A
triangle whose longest side is longer than the spacing is divided into n x n equal parts. n is the smallest power of two
that makes the sides of the parts no longer than the spacing, but at most ``MOST_PARTS``. The contact points are the
corners of the parts, and each part gives a third of its area to each of its corners. Without division they are the
vertices. Neighbouring triangles share the points on their common side; because n is a power of two, the points of the
coarser triangle are points of the finer one too.

A layer of coarse triangles, whose points are farther apart than the thickness, would have holes. Its spheres are
therefore as large as the distance of the points: another layer of the same kind cannot pass, but stays that far away.
An object that is thinner than the distance of the points, such as the corner of another cloth or a needle, can pass
between them.

A point where panels meet, or where a panel meets itself, has several rest places. They form the links by which
``pair_lists`` finds neighbours across a seam.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from stitchmesh.errors import ParameterError
from stitchmesh.mesh import FloatArray, IntArray, frozen_array
from stitchmesh.mixed.cloth.cloth import Cloth, signed_areas

MOST_PARTS = 4
"""Default of the largest number of parts of the side of a triangle."""


@dataclass(frozen=True, eq=False)
class ContactPoints:
    """M contact points of a cloth with V vertices and N simulated nodes.

    Raises:
        ParameterError: an array has the wrong shape, an index is out of range, an area or a radius is not positive, or
            a number is not finite.
    """

    vertex_count: int
    """Number V of triangle vertices."""
    node_count: int
    """Number N of yarn nodes."""
    index: IntArray
    """Numbers of the three positions whose mean a point is: vertex j has number j, node i has V + i; shape (M, 3)."""
    share: FloatArray
    """Weights of the three positions, which sum to 1; shape (M, 3)."""
    area: FloatArray
    """Area of cloth that each point stands for, times its blending weight [cm^2]; shape (M,)."""
    radius: FloatArray
    """Distance that each point keeps from a body, half the thickness of the cloth [cm]; shape (M,)."""
    layer_radius: FloatArray
    """Radius of the sphere at each point in contact with other layers [cm], shape (M,). It is half the thickness, or
    half the distance of neighbouring points if that is larger, so that no layer fits through the holes of another."""
    panel: IntArray
    """Panel of each point; shape (M,)."""
    rest: FloatArray
    """Place of each point in its panel at rest [cm]; shape (M, 2)."""

    def __post_init__(self) -> None:
        for name in ("index", "panel"):
            object.__setattr__(self, name, frozen_array(getattr(self, name), np.int64))
        for name in ("share", "area", "radius", "layer_radius", "rest"):
            object.__setattr__(self, name, frozen_array(getattr(self, name), np.float64))
        self._check_shapes()
        self._check_numbers()

    def _check_shapes(self) -> None:
        count = len(self.area)
        flat = dict.fromkeys(("radius", "layer_radius", "panel"), (count,))
        expected = {"index": (count, 3), "share": (count, 3), "rest": (count, 2), **flat}
        for name, shape in expected.items():
            found = getattr(self, name).shape
            if found != shape:
                raise ParameterError(f"contact points: {name}: got shape {found}; expected {shape}")

    def _check_numbers(self) -> None:
        most = self.vertex_count + self.node_count
        wrong = np.flatnonzero(((self.index < 0) | (self.index >= most)).any(axis=1))
        if len(wrong):
            found = f"got the positions {self.index[wrong[0]].tolist()}"
            raise ParameterError(f"contact points: point {int(wrong[0])}: {found}; expected 0 to {most - 1}")
        for name in ("area", "radius", "layer_radius"):
            values = getattr(self, name)
            wrong = np.flatnonzero(~((values > 0.0) & np.isfinite(values)))
            if len(wrong):
                found = f"point {int(wrong[0])}: got {float(values[wrong[0]])}"
                raise ParameterError(f"contact points: {name} of {found}; expected a positive number")
        if not (np.isfinite(self.share).all() and np.isfinite(self.rest).all()):
            raise ParameterError("contact points: got shares or rest places that are not finite; expected numbers")

    def __len__(self) -> int:
        return len(self.area)

    def places(self, vertices: FloatArray, nodes: FloatArray) -> FloatArray:
        """Positions of the points [cm], shape (M, 3), from the positions of vertices, (V, 3), and nodes, (N, 3)."""
        positions = np.concatenate([np.reshape(vertices, (-1, 3)), np.reshape(nodes, (-1, 3))])
        return np.einsum("mk,mkd->md", self.share, positions[self.index])


def points_at_nodes(
    vertex_count: int,
    *,
    panel: ArrayLike,
    rest: ArrayLike,
    area: ArrayLike,
    weight: ArrayLike,
    thickness: float,
) -> ContactPoints:
    """One contact point at each yarn node whose weight is not zero.

    Args:
        vertex_count: number V of triangle vertices, after which nodes are numbered.
        panel: panel of each node, shape (N,).
        rest: place of each node in its panel [cm], shape (N, 2).
        area: area of cloth that each node stands for [cm^2], shape (N,) or one number.
        weight: blending weight of each node, alpha, shape (N,) or one number.
        thickness: thickness of the cloth [cm].

    Raises:
        ParameterError: as ``ContactPoints``, or the thickness is not positive.
    """
    panels = np.asarray(panel, dtype=np.int64)
    count = len(panels)
    areas = np.broadcast_to(np.asarray(area, dtype=np.float64) * np.asarray(weight, dtype=np.float64), count)
    kept = np.flatnonzero(areas != 0.0)
    return ContactPoints(
        vertex_count,
        count,
        np.repeat(vertex_count + kept, 3).reshape(-1, 3),
        np.tile([1.0, 0.0, 0.0], (len(kept), 1)),
        areas[kept],
        np.full(len(kept), 0.5 * checked_thickness(thickness)),
        np.full(len(kept), 0.5 * thickness),
        panels[kept],
        np.reshape(rest, (-1, 2))[kept],
    )


def join_points(parts: Sequence[ContactPoints]) -> ContactPoints:
    """All points of several sets that belong to the same vertices and nodes, in the given order.

    Raises:
        ParameterError: there is no set, or the sets are for different numbers of vertices.
    """
    if len({part.vertex_count for part in parts}) != 1:
        found = [part.vertex_count for part in parts]
        raise ParameterError(f"contact points: got sets for {found} vertices; expected sets for one cloth")
    arrays = {
        name: np.concatenate([getattr(part, name) for part in parts])
        for name in ("index", "share", "area", "radius", "layer_radius", "panel", "rest")
    }
    return ContactPoints(parts[0].vertex_count, max(part.node_count for part in parts), **arrays)


def checked_thickness(thickness: float) -> float:
    """A thickness, if it is a positive number.

    Raises:
        ParameterError: the thickness is not a positive number.
    """
    if not (np.isfinite(thickness) and thickness > 0.0):
        raise ParameterError(f"contact: got a thickness of {thickness} cm; expected a positive number")
    return float(thickness)


@dataclass(frozen=True, eq=False)
class SeamLinks:
    """Pairs of rest places that are the same place of the cloth."""

    panel: IntArray
    """The two panels of each link; shape (L, 2)."""
    rest: FloatArray
    """Places of each link in its two panels [cm]; shape (L, 2, 2)."""


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
    cloth: Cloth,
    *,
    node_count: int = 0,
    weight: ArrayLike = 1.0,
    thickness: float,
    spacing: float | None = None,
    most_parts: int = MOST_PARTS,
) -> tuple[ContactPoints, SeamLinks]:
    """Contact points on the triangles of a cloth whose weight is not zero, and the links of all its seams.

    Args:
        cloth: T triangles in panels.
        node_count: number N of simulated yarn nodes.
        weight: blending weight of each triangle, 1 - alpha, shape (T,) or one number.
        thickness: thickness of the cloth [cm].
        spacing: wanted distance between neighbouring points [cm]; the thickness if it is None. With infinity, triangles
            are not divided.
        most_parts: largest number of parts of the side of a triangle, a power of two.

    Raises:
        ParameterError: the thickness or the spacing is not positive, or the number of parts is not a power of two.
    """
    flat, radius = cloth.rest, 0.5 * checked_thickness(thickness)
    weights = np.broadcast_to(np.asarray(weight, dtype=np.float64), len(flat))
    longest = np.linalg.norm(flat - np.roll(flat, 1, axis=1), axis=2).max(axis=1, initial=0.0)
    corners = _corners_of_parts(_divisions(longest, thickness if spacing is None else spacing, most_parts), longest)
    index, share, number = _merged(cloth.triangles[corners.triangle], corners)
    place = np.einsum("kc,kcd->kd", corners.numerator / corners.most, flat[corners.triangle])
    area = corners.part * (np.abs(signed_areas(flat)) * weights)[corners.triangle]
    total = np.zeros(len(index))
    np.add.at(total, number, area)
    first = np.unique(number, return_index=True)[1]
    layer_radius = np.full(len(index), radius)
    np.maximum.at(layer_radius, number, 0.5 * corners.apart)
    kept = np.flatnonzero(total > 0.0)
    points = ContactPoints(
        len(cloth.vertices), node_count, index[kept], share[kept], total[kept], np.full(len(kept), radius),
        layer_radius[kept], cloth.panel[corners.triangle[first[kept]]], place[first[kept]],
    )  # fmt: skip
    return points, _links(number, cloth.panel[corners.triangle], place)


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


def _links(number: IntArray, panel: IntArray, place: FloatArray) -> SeamLinks:
    """Links between the first rest place of each point and its other rest places."""
    first = np.unique(number, return_index=True)[1][number]
    size = float(np.abs(place).max(initial=1.0))
    other = (panel != panel[first]) | (np.abs(place - place[first]).max(axis=1, initial=0.0) > 1e-9 * size)
    pairs = np.stack([first[other], np.flatnonzero(other)], axis=1)
    return SeamLinks(panel[pairs], place[pairs])
