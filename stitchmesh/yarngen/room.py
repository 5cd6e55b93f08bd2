# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Room for the yarns where a surface is folded more sharply than a stitch.

At the corners of a mouth or between toes, two parts of a surface come closer to each other than the centre lines of two
yarns may start. A fabric spans such places. Stitches around them are therefore smoothed: each vertex moves by half of
the way to the mean of its neighbours, and the yarns are generated again, until they have room. All other stitches stay
where they are. Borders stay too at first. If the yarns get no room in this way, the vertices of borders also move,
towards their neighbours on the border, and only the corners stay: mesh relaxation can press the vertices of a border
together. A ring that is moved all around, as at a tip, keeps its length; otherwise it would shrink to a point.

A row can end where a border is straight, for example where the front of a cardigan passes smoothly into its neck. The
last stitch of the row then has two sides along one line, between which its yarns have little room or none. If they have
none, or if its loops do not hold, the corner between these sides is first moved away from the stitch, by a fifth of a
stitch.

Two layers of a fabric that lie too close, such as a brim that is folded up, get no room by smoothing. They are then
moved apart (``layers_apart``). Beside a sewn seam, as at a shoulder, the loops at the borders of two layers can hang in
each other although their yarns have room (``check_loops``); layers are then moved apart further.

A vertex has another layer beside it if another vertex lies across from it, in the direction of its normal, and no edge
joins the two. Both move apart along their normals, each by half of the distance that is missing. The moves are smoothed
over the fabric, so that they end gently where the layers part or join.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import TYPE_CHECKING

import numpy as np

from stitchmesh.errors import YarnError, check_kind
from stitchmesh.mesh import BORDER, FloatArray, IntArray, StitchMesh
from stitchmesh.quality import DEFAULT_QUALITY, Quality, quality_named
from stitchmesh.yarn.yarn_set import YarnSet
from stitchmesh.yarngen.finish import DEFAULT_FINISH, YarnFinish
from stitchmesh.yarngen.generate import (
    SMALLEST_DISTANCE_OVER_RADIUS,
    checked_radius,
    trace_yarn_routes,
    yarns_along_routes,
)
from stitchmesh.yarngen.loop_check.loop_linking import check_loops

if TYPE_CHECKING:
    from scipy.sparse import csr_array

THICKNESS_OVER_RADIUS = 5.0
"""Distance that layers get, over the yarn radius. Yarns of two flat layers start 1.5 radii apart at this distance and
0.5 at 3 radii; beside a fold, where the layers meet, a smaller distance leaves them too close."""
RINGS = 4
"""Vertices are smoothed up to this number of edges from a crowded stitch. With a smaller number, the stitches of a deep
fold are pressed together in its middle."""
STRAIGHT = np.radians(150.0)
"""The corner of a stitch on a border is moved away if the angle of the border there is at least this."""
CORNER_HEIGHT = 0.3
"""How far the corner is moved, over half the distance of its two neighbours. The angle is then below ``STRAIGHT``,
because the value is above tan((180 degrees - ``STRAIGHT``) / 2)."""
APART = (THICKNESS_OVER_RADIUS, 2.0 * THICKNESS_OVER_RADIUS)
"""Distances to which layers are moved apart, one after the other, over the radius: the thickness of a fabric, and a
distance at which the loops at two borders hang beside each other."""
MOST_ROUNDS = 18
"""If the yarns have no room after this number of checks, the stitches stay as they were."""


def layers_apart(fabric: StitchMesh, distance: float) -> StitchMesh:
    """Move the layers of a fabric apart where they are closer than a distance.

    Args:
        fabric: the stitches.
        distance: smallest distance of two layers [cm].

    Returns:
        The fabric; the same one if no two layers are closer.
    """
    ends = np.stack([fabric.face_vertex, fabric.face_vertex[fabric.side_next]])
    beside = _links(np.concatenate([ends, ends[::-1]], axis=1), len(fabric.vertices))
    reach = 0.75 * float(np.median(fabric.side_length))
    moved = fabric
    # Largest number of searches for layers that are too close.
    for _ in range(10):
        move = _moves(moved, beside, distance, reach)
        if move is None:
            break
        # How often a move is smoothed over the neighbours of its vertex.
        for _ in range(2):
            move = 0.5 * (move + (beside @ move) / np.maximum(beside.sum(axis=1), 1.0)[:, None])
        moved = replace(moved, vertices=moved.vertices + move)
    return moved


def _moves(fabric: StitchMesh, beside: csr_array, distance: float, reach: float) -> FloatArray | None:
    """Return how far each vertex moves [cm], shape (V, 3); None if no layers are too close.

    Args:
        fabric: the stitches.
        beside: a matrix that is 1 for the ends of an edge, shape (V, V).
        distance: smallest distance of two layers [cm].
        reach: how far from the normal of a vertex the vertex across may lie [cm].
    """
    from scipy.spatial import cKDTree

    points, normal = fabric.vertices, fabric.vertex_normal
    pairs = cKDTree(points).query_pairs(float(np.hypot(distance, reach)), output_type="ndarray")
    pairs = np.concatenate([pairs, pairs[:, ::-1]])
    one, other = pairs[np.asarray(beside[pairs[:, 0], pairs[:, 1]]).reshape(-1) == 0.0].T
    offset = points[other] - points[one]
    height = np.einsum("nk,nk->n", offset, normal[one])
    aside = np.sqrt(np.maximum(np.einsum("nk,nk->n", offset, offset) - height**2, 0.0))
    # Two layers lie beside each other if the cosine of the angle between their normals is at least this.
    parallel = np.abs(np.einsum("nk,nk->n", normal[one], normal[other])) > 0.5
    # Part of the wanted distance that may be missing.
    close = parallel & (aside <= reach) & (np.abs(height) < (1.0 - 1e-3) * distance)
    if not close.any():
        return None
    one, height, aside = one[close], height[close], aside[close]
    order = np.lexsort((aside, one))
    vertex, first = np.unique(one[order], return_index=True)
    across = height[order][first]
    move = np.zeros_like(points)
    away = -np.where(across < 0.0, -1.0, 1.0) * 0.5 * (distance - np.abs(across))
    move[vertex] = away[:, None] * normal[vertex]
    return move


@dataclass(frozen=True, eq=False)
class RoomyFabric:
    """A fabric whose yarns have room, and where stitches were moved to make it."""

    fabric: StitchMesh
    """The fabric; the given one if its yarns have room, or cannot be given any."""
    faces: tuple[int, ...]
    """Stitches whose yarns were crowded."""
    farthest: float
    """Largest distance by which a vertex was moved [cm]."""


def make_room(
    fabric: StitchMesh, *, yarn_radius: float | None = None, quality: str | Quality = DEFAULT_QUALITY,
    finish: YarnFinish = DEFAULT_FINISH,
) -> RoomyFabric:  # fmt: skip
    """Smooth stitches where the yarns of a fabric would start too close, until the yarns have room.

    Args:
        fabric: stitch faces after mesh relaxation.
        yarn_radius: contact radius of the yarn [cm]; an eighth of the mean stitch width if not given.
        quality: the quality with which the yarns will be generated.
        finish: how rows are cast on and bound off, and which floats are cut.

    Returns:
        The fabric, and what was moved; the given fabric and no faces if the yarns are still crowded after
        ``MOST_ROUNDS``.

    Raises:
        ParameterError, YarnError: as for ``generate_yarns``; a fabric on a lattice is a ``YarnError`` too.
    """
    check_kind("make_room", fabric, StitchMesh)
    if fabric.lattice is not None:
        raise YarnError("make_room: got a fabric on a lattice, which lies on no surface; relax its swatch instead")
    radius = checked_radius(fabric, yarn_radius)
    points_per_stitch = quality_named(quality).control_points_per_stitch
    yarns_of = partial(_yarns, radius=radius, points_per_stitch=points_per_stitch, finish=finish)
    crowded: set[int] = set()
    roomy: StitchMesh | None = None
    distances = [thickness * radius for thickness in APART]
    for begun in _starts(fabric, distances):
        for along_borders in (False, True):
            smoothed, found, tangled = _with_room(begun, radius, yarns_of, finish, along_borders=along_borders)
            crowded |= found | tangled
            if smoothed is None:
                continue
            roomy = smoothed if roomy is None or not tangled else roomy
            if not tangled:
                return _with_figures(fabric, roomy, crowded) if crowded else RoomyFabric(fabric, (), 0.0)
            break
    if roomy is None or roomy is fabric:
        return RoomyFabric(fabric, (), 0.0)
    return _with_figures(fabric, roomy, crowded)


def _yarns(fabric: StitchMesh, radius: float, points_per_stitch: int, finish: YarnFinish) -> YarnSet:
    return yarns_along_routes(trace_yarn_routes(fabric, radius, points_per_stitch, finish), radius)


def _starts(fabric: StitchMesh, distances: Sequence[float]) -> Iterator[StitchMesh]:
    """Yield the fabric, and for each distance [cm] the fabric with layers moved apart, if any are closer."""
    yield fabric
    for distance in distances:
        apart = layers_apart(fabric, distance)
        if apart is not fabric:
            yield apart


def _tangled(fabric: StitchMesh, yarns: YarnSet, finish: YarnFinish) -> set[int]:
    """Return the first stitch whose loops do not hold as they should, or nothing."""
    try:
        check_loops(fabric, yarns, finish=finish)
    except YarnError as error:
        return set() if error.face is None else {error.face}
    return set()


def _with_room(
    fabric: StitchMesh, radius: float, yarns_of: Callable[[StitchMesh], YarnSet], finish: YarnFinish, *,
    along_borders: bool,
) -> tuple[StitchMesh | None, set[int], set[int]]:  # fmt: skip
    """Smooth around crowded stitches until the yarns have room.

    Args:
        fabric: the stitches.
        radius: radius of the yarns [cm].
        yarns_of: function that generates the yarns of stitches.
        finish: the finish of these yarns.
        along_borders: whether vertices of borders are moved too.

    Returns:
        The fabric, None if its yarns are still crowded after ``MOST_ROUNDS``; the stitches that were crowded; and a
        stitch whose loops do not hold as they should, if there is one.
    """
    from stitchmesh.yarngen.clearance import crowded_points

    found: set[int] = set()
    smooth = None
    for number in range(MOST_ROUNDS):
        yarns = yarns_of(fabric)
        # Distance that yarns get, over the smallest permitted distance, so that rounding does not decide what is
        # permitted.
        crowded = crowded_points(yarns, 1.1 * SMALLEST_DISTANCE_OVER_RADIUS * radius)
        tangled = set() if len(crowded) else _tangled(fabric, yarns, finish)
        faces = np.unique(np.append(yarns.face[crowded], np.array(sorted(tangled), dtype=np.int64)))
        raised = _with_raised_corners(fabric, faces)
        if raised is fabric and not len(crowded):
            return fabric, found, tangled
        found.update(faces.tolist())
        if raised is not fabric:
            fabric = raised
            continue
        smooth = _Smoothing.of(fabric, along_borders=along_borders) if smooth is None else smooth
        # After this number of checks of the yarns, one more ring of vertices is smoothed: stitches that do not get
        # room by themselves take some from their neighbours.
        fabric = replace(fabric, vertices=smooth.moved(fabric, faces, RINGS + number // 3))
    return None, found, set()


def _with_raised_corners(fabric: StitchMesh, near: IntArray) -> StitchMesh:
    """Move the corners that lie on a straight border away from their stitches, beside some stitches.

    Returns:
        The fabric; the given one if none of its corners there is straight.
    """
    at_border, following, points = fabric.twin == BORDER, fabric.side_next, fabric.vertices
    # The corner lies between two successive sides: the row ends at one, and the other is cast on or bound off.
    side = np.flatnonzero(at_border & at_border[following] & (fabric.is_wale != fabric.is_wale[following]))
    before, corner, after = fabric.face_vertex[np.stack([side, following[side], following[following[side]]])]
    beside = np.isin(np.stack([before, corner, after]), fabric.face_vertex[fabric.sides_of(near)]).any(axis=0)
    straight = beside & (_angle(points[before] - points[corner], points[after] - points[corner]) > STRAIGHT)
    if not straight.any():
        return fabric
    faces, corner = fabric.side_face[side[straight]], corner[straight]
    along = points[after[straight]] - points[before[straight]]
    length = np.linalg.norm(along, axis=1, keepdims=True)
    middle = np.add.reduceat(points[fabric.face_vertex], fabric.face_start[:-1]) / np.diff(fabric.face_start)[:, None]
    away = points[corner] - middle[faces]
    away -= np.einsum("ni,ni->n", away, along)[:, None] * along / length**2
    vertices = points.copy()
    vertices[corner] += 0.5 * CORNER_HEIGHT * length * away / np.linalg.norm(away, axis=1, keepdims=True)
    return replace(fabric, vertices=vertices)


def _angle(one: FloatArray, other: FloatArray) -> FloatArray:
    """Angle between vectors [rad], shape (n, 3) to (n,)."""
    across = np.linalg.norm(np.cross(one, other), axis=1)
    return np.asarray(np.arctan2(across, np.einsum("ni,ni->n", one, other)))


def _with_figures(fabric: StitchMesh, smoothed: StitchMesh, faces: set[int]) -> RoomyFabric:
    """The fabric with the vertices of a smoothed one; the stretch of its edges changes with their lengths."""
    farthest = np.linalg.norm(smoothed.vertices - fabric.vertices, axis=1).max(initial=0.0)
    moved = replace(fabric, vertices=smoothed.vertices)
    if fabric.stretch is not None:
        sides = fabric.edge_side
        moved = replace(moved, stretch=fabric.stretch * moved.side_length[sides] / fabric.side_length[sides])
    return RoomyFabric(moved, tuple(sorted(faces)), float(farthest))


@dataclass(frozen=True, eq=False)
class _Smoothing:
    """The vertices towards which smoothing moves each vertex, as matrices that are 1 there, shape (V, V)."""

    beside: csr_array
    """The vertices at the other ends of its edges."""
    towards: csr_array
    """The same for inner vertices; a vertex of a border has none, or the vertices beside it on the border."""
    rings: tuple[IntArray, ...]
    """Vertices of the borders along which vertices are moved."""

    @classmethod
    def of(cls, fabric: StitchMesh, *, along_borders: bool) -> _Smoothing:
        """Find the vertices. The corners of a border, at which one stitch or at least three meet, do not move."""
        ends = np.stack([fabric.face_vertex, fabric.face_vertex[fabric.side_next]])
        on_border = fabric.twin == BORDER
        stitches = np.bincount(fabric.face_vertex, minlength=len(fabric.vertices))
        edges, borders = (np.concatenate([pairs, pairs[::-1]], axis=1) for pairs in (ends, ends[:, on_border]))
        inner = edges[:, ~np.isin(edges[0], borders[0])]
        along = borders[:, (stitches[borders[0]] == 2) & along_borders]
        towards = _links(np.concatenate([inner, along], axis=1), len(stitches))
        rings = tuple(fabric.face_vertex[loop] for loop in fabric.boundary_loops) if along_borders else ()
        return cls(_links(edges, len(stitches)), towards, rings)

    def moved(self, fabric: StitchMesh, faces: IntArray, rings: int) -> FloatArray:
        """Positions after smoothing of the vertices up to ``rings`` edges from some faces [cm]."""
        near = np.zeros(len(fabric.vertices))
        near[fabric.face_vertex[fabric.sides_of(faces)]] = 1.0
        for _ in range(rings):
            near = np.maximum(near, self.beside @ near > 0.0)
        count = np.asarray(self.towards.sum(axis=1))
        free = np.flatnonzero(near * count)
        vertices, own, count = fabric.vertices.copy(), self.towards[free], count[free, None]
        closed = [ring for ring in self.rings if np.isin(ring, free).all()]
        # Number of smoothing steps between two checks of the yarns.
        for _ in range(6):
            vertices[free] = 0.5 * (vertices[free] + (own @ vertices) / count)
            for ring in closed:
                vertices[ring] = _with_length(vertices[ring], _length(fabric.vertices[ring]))
        return vertices


def _with_length(ring: FloatArray, length: float) -> FloatArray:
    """Scale a closed line about its middle to a length [cm], shape (n, 3)."""
    middle = ring.mean(axis=0)
    return middle + (ring - middle) * (length / _length(ring))


def _length(ring: FloatArray) -> float:
    """Length of a closed line [cm]."""
    return float(np.linalg.norm(np.roll(ring, -1, axis=0) - ring, axis=1).sum())


def _links(pairs: IntArray, size: int) -> csr_array:
    """Matrix that is 1 for each pair of numbers, shape (size, size)."""
    from scipy.sparse import coo_array

    pairs = np.unique(pairs, axis=1)
    return coo_array((np.ones(pairs.shape[1]), (pairs[0], pairs[1])), shape=(size, size)).tocsr()
