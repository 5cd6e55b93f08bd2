# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Triangles of about one size: split, collapse and flip edges, and spread the points over the surface.

These are the steps of Botsch and Kobbelt, A Remeshing Approach to Multiresolution Modeling, 2004. All edges of a step
that do not touch one another are changed at the same time.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array

from stitchmesh.mesh import FloatArray, IntArray

BoolArray = NDArray[np.bool_]
Points = Callable[[FloatArray], FloatArray]
ROUNDS, SWEEPS, MOST_STEPS = 3, 3, 12
"""Rounds of all steps, sweeps of smoothing in a round, and repetitions of one step for edges that touch."""
SEED = 3
"""Seed of the order in which edges are collapsed: an order by length alone would choose few edges in a step."""
LONG, SHORT = 1.45, 0.72
"""Lengths of edges that are split and that are collapsed, in parts of the wanted length."""
LEAST_GAIN = 1e-6
"""Edges are flipped where the sum of the cotangents of the two angles opposite to them is below minus this number."""
LEAST_COSINE = 0.3
"""A changed triangle is refused if the cosine between its normal and that of the surface is smaller."""


@dataclass(frozen=True)
class Edges:
    """The edges of triangles; side ``3 t + k`` runs from corner k of triangle t to the next corner."""

    ends: IntArray
    """Vertices of each edge, the smaller number first, shape (E, 2)."""
    of_side: IntArray
    """Edge of each side, shape (3 T,)."""
    faces: IntArray
    """Number of triangles at each edge: 1 on the border, shape (E,)."""

    @classmethod
    def of(cls, corners: IntArray) -> Edges:
        """Find the edges of triangles, shape (T, 3)."""
        sides = np.sort(corners[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), axis=1)
        count = int(corners.max()) + 1
        keys, of_side, faces = np.unique(sides[:, 0] * count + sides[:, 1], return_inverse=True, return_counts=True)
        return cls(np.column_stack([keys // count, keys % count]), of_side, faces)

    def pairs_of_sides(self) -> IntArray:
        """The two sides at each inner edge, shape (n, 2)."""
        order = np.argsort(self.of_side, kind="stable")
        first = (np.cumsum(self.faces) - self.faces)[self.faces == 2]
        return np.column_stack([order[first], order[first + 1]])

    def border(self, count: int) -> BoolArray:
        """Whether each of some vertices is on the border, shape (count,)."""
        result = np.zeros(count, dtype=bool)
        result[self.ends[self.faces == 1]] = True
        return result

    def lengths(self, points: FloatArray) -> FloatArray:
        """Length of each edge, shape (E,)."""
        return np.linalg.norm(points[self.ends[:, 1]] - points[self.ends[:, 0]], axis=1)


@dataclass(frozen=True)
class Surface:
    """What is needed of a surface to move points over it."""

    normals: Points
    """Unit normals of the surface at points, shape (n, 3) to (n, 3)."""
    inner: Points
    """Points moved to the surface."""
    border: Points
    """Points moved to the border of the surface."""


def evened(points: FloatArray, corners: IntArray, edge: float, onto: Surface) -> tuple[FloatArray, IntArray]:
    """Return triangles with edges of about one length on the same surface.

    Args:
        points: positions, shape (n, 3).
        corners: vertices of the triangles, shape (m, 3).
        edge: wanted length.
        onto: the surface.
    """
    for _ in range(ROUNDS):
        points, corners = split_edges(points, corners, LONG * edge, rounds=1)
        points, corners = collapsed(points, corners, SHORT * edge, onto.normals)
        corners = flipped(points, corners, onto.normals)
        for _ in range(SWEEPS):
            points = spread(points, corners, onto)
    return points, flipped(points, corners, onto.normals)


def split_edges(points: FloatArray, corners: IntArray, longest: float, rounds: int = 30) -> tuple[FloatArray, IntArray]:
    """Split edges that are longer than a length at their midpoints, and the triangles beside them."""
    for _ in range(rounds):
        edges = Edges.of(corners)
        split = edges.lengths(points) > longest
        if not split.any():
            break
        middle = np.where(split, len(points) + np.cumsum(split) - 1, -1)
        points = np.concatenate([points, points[edges.ends[split]].mean(axis=1)])
        corners = _with_midpoints(points, corners, middle[edges.of_side].reshape(-1, 3))
    return points, corners


def _with_midpoints(points: FloatArray, corners: IntArray, middle: IntArray) -> IntArray:
    """Return triangles in place of those whose sides have a new vertex, or -1, shape (m, 3)."""
    split = middle >= 0
    halved = split.sum(axis=1)
    # Triangles are turned so that one new vertex is on side 0, and two are on sides 0 and 1.
    turn = np.where(halved == 1, split.argmax(axis=1), np.where(halved == 2, split.argmin(axis=1) + 1, 0))
    order = (np.arange(3) + turn[:, None]) % 3
    corners, middle = np.take_along_axis(corners, order, 1), np.take_along_axis(middle, order, 1)
    (a, b, c), (p, q, r) = corners.T, middle.T
    straight = np.linalg.norm(points[a] - points[q], axis=1) < np.linalg.norm(points[p] - points[c], axis=1)
    one, three = halved == 1, halved == 3
    parts = [
        (halved == 0, (a, b, c)),
        *((one, part) for part in ((a, p, c), (p, b, c))),
        (halved == 2, (p, b, q)),
        *(((halved == 2) & straight, part) for part in ((a, p, q), (a, q, c))),
        *(((halved == 2) & ~straight, part) for part in ((a, p, c), (p, q, c))),
        *((three, part) for part in ((a, p, r), (p, b, q), (r, q, c), (p, q, r))),
    ]
    return np.concatenate([np.column_stack(part)[chosen] for chosen, part in parts])


def collapsed(points: FloatArray, corners: IntArray, shortest: float, normals: Points) -> tuple[FloatArray, IntArray]:
    """Collapse edges that are shorter than a length, without a change of the topology."""
    random = np.random.default_rng(SEED)
    for _ in range(MOST_STEPS):
        edges = Edges.of(corners)
        short = _collapsible(points, edges, shortest)
        preferred = np.argsort(edges.lengths(points)[short] * random.uniform(0.5, 1.5, len(short)))
        chosen = apart(edges, short[preferred], len(points))
        kept, gone = edges.ends[chosen].T
        moved, joined = _joined(points, corners, kept, gone, edges.border(len(points)))
        good = ~np.isin(kept, _folded(moved, joined, kept, normals))
        if not good.any():
            break
        points, corners = _joined(points, corners, kept[good], gone[good], edges.border(len(points)))
        points, corners = _compact(points, corners)
    return points, corners


def _collapsible(points: FloatArray, edges: Edges, shortest: float) -> IntArray:
    """Short edges whose collapse leaves a surface with the same topology."""
    length, border = edges.lengths(points), edges.border(len(points))
    first, second = edges.ends.T
    chosen = np.flatnonzero((length < shortest) & ((edges.faces == 1) | ~(border[first] & border[second])))
    ones = np.ones(len(first), dtype=np.int64)
    beside = coo_array((ones, (first, second)), shape=(len(points), len(points))).tocsr()
    beside = beside + beside.T
    shared = (beside[first[chosen]] * beside[second[chosen]]).sum(axis=1)
    return chosen[shared == edges.faces[chosen]]


def apart(edges: Edges, ordered: IntArray, count: int) -> IntArray:
    """Of edges in order of preference, those that have no better one within two edges of their ends."""
    best = np.full(count, len(ordered))
    ranks = np.arange(len(ordered))
    for end in edges.ends[ordered].T:
        np.minimum.at(best, end, ranks)
    for _ in range(2):
        around = best.copy()
        for one, other in (edges.ends.T, edges.ends.T[::-1]):
            np.minimum.at(around, one, best[other])
        best = around
    return ordered[(best[edges.ends[ordered]] == ranks[:, None]).all(axis=1)]


def _joined(
    points: FloatArray, corners: IntArray, kept: IntArray, gone: IntArray, border: BoolArray
) -> tuple[FloatArray, IntArray]:
    """Move pairs of vertices into one: to their middle, or to the one that is on the border."""
    points, target = points.copy(), np.arange(len(points))
    weight = np.where(border[kept] == border[gone], 0.5, border[kept])[:, None]
    points[kept] = weight * points[kept] + (1.0 - weight) * points[gone]
    target[gone] = kept
    return points, target[corners]


def _folded(points: FloatArray, corners: IntArray, moved: IntArray, normals: Points) -> IntArray:
    """Vertices of the triangles around moved vertices that have an area and do not face outwards."""
    changed = corners[np.isin(corners, moved).any(axis=1)]
    changed = changed[_has_area(changed)]
    return changed[~_faces_outwards(points, changed, normals)]


def _has_area(corners: IntArray) -> BoolArray:
    """Whether triangles have three different vertices, shape (m,)."""
    return (corners != corners[:, [1, 2, 0]]).all(axis=1)


def _compact(points: FloatArray, corners: IntArray) -> tuple[FloatArray, IntArray]:
    """Drop triangles without an area and points without a triangle."""
    corners = corners[_has_area(corners)]
    used, corners = np.unique(corners, return_inverse=True)
    return points[used], corners.reshape(-1, 3)


def _faces_outwards(points: FloatArray, corners: IntArray, normals: Points) -> BoolArray:
    """Whether the normals of triangles are near those of the surface, shape (m,)."""
    a, b, c = (points[column] for column in corners.T)
    normal = np.cross(b - a, c - a)
    size = np.linalg.norm(normal, axis=1)
    return (normal * normals((a + b + c) / 3.0)).sum(axis=1) > LEAST_COSINE * size


def flipped(points: FloatArray, corners: IntArray, normals: Points) -> IntArray:
    """Flip edges until the angles opposite to each of them sum to at most two right angles (Delaunay)."""
    corners = corners.copy()
    for _ in range(MOST_STEPS):
        edges = Edges.of(corners)
        sides = edges.pairs_of_sides()
        gain, quads = _flips(points, corners, sides)
        wanted = np.flatnonzero(gain > LEAST_GAIN)
        wanted = wanted[~_are_edges(edges, quads[wanted, 2], quads[wanted, 3])]
        new = quads[:, [[2, 0, 3], [3, 1, 2]]]
        wanted = wanted[_faces_outwards(points, new[wanted].reshape(-1, 3), normals).reshape(-1, 2).all(axis=1)]
        wanted = _without_shared_faces(wanted[np.argsort(-gain[wanted], kind="stable")], sides // 3, quads[:, 2:])
        if not len(wanted):
            break
        corners[sides[wanted] // 3] = new[wanted]
    return corners


def _flips(points: FloatArray, corners: IntArray, sides: IntArray) -> tuple[FloatArray, IntArray]:
    """Return what flips of inner edges gain, and for each its two ends and the two corners opposite to it."""
    flat = corners.ravel()
    a, b, c = (flat[3 * (sides[:, 0] // 3) + (sides[:, 0] + k) % 3] for k in range(3))
    d = flat[3 * (sides[:, 1] // 3) + (sides[:, 1] + 2) % 3]
    return -_cotangent(points, c, a, b) - _cotangent(points, d, a, b), np.column_stack([a, b, c, d])


def _cotangent(points: FloatArray, top: IntArray, left: IntArray, right: IntArray) -> FloatArray:
    """Cotangent of the angle at ``top``."""
    one, other = points[left] - points[top], points[right] - points[top]
    return (one * other).sum(axis=1) / np.maximum(np.linalg.norm(np.cross(one, other), axis=1), 1e-12)


def _are_edges(edges: Edges, one: IntArray, other: IntArray) -> BoolArray:
    """Whether vertices are joined by an edge."""
    count = int(edges.ends.max()) + 1
    keys = edges.ends[:, 0] * count + edges.ends[:, 1]  # In order, as the edges are.
    wanted = np.minimum(one, other) * count + np.maximum(one, other)
    return keys[np.minimum(np.searchsorted(keys, wanted), len(keys) - 1)] == wanted


def _without_shared_faces(ordered: IntArray, faces: IntArray, made: IntArray) -> IntArray:
    """Of flips in order of preference, those that share no triangle with a better one and make no edge twice.

    Args:
        ordered: numbers of flips.
        faces: the two triangles of each flip, shape (n, 2).
        made: ends of the edge that each flip makes, shape (n, 2).
    """
    best, ranks = np.full(int(faces.max(initial=0)) + 1, len(ordered)), np.arange(len(ordered))
    for face in faces[ordered].T:
        np.minimum.at(best, face, ranks)
    ordered = ordered[(best[faces[ordered]] == ranks[:, None]).all(axis=1)]
    _, first = np.unique(np.sort(made[ordered], axis=1), axis=0, return_index=True)
    return ordered[np.sort(first)]


def spread(points: FloatArray, corners: IntArray, onto: Surface) -> FloatArray:
    """Move points half-way to the mean of their neighbours and back to the surface, those of the border along it."""
    edges = Edges.of(corners)
    border = edges.border(len(points))
    ends = np.concatenate([edges.ends, edges.ends[:, ::-1]])
    ends = ends[~border[ends[:, 0]] | np.tile(edges.faces == 1, 2)]
    total = np.column_stack([np.bincount(ends[:, 0], points[ends[:, 1], k], len(points)) for k in range(3)])
    moved = 0.5 * points + 0.5 * total / np.bincount(ends[:, 0], minlength=len(points))[:, None]
    moved[~border] = onto.inner(moved[~border])
    moved[border] = onto.border(moved[border])
    return moved
