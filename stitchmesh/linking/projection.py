# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Yarns and polygons as polylines with whole coordinates in a projection.

A point p has the coordinates (x, y, h): its place in the projection and its height towards the eye,

    p - origin = x e_0 + y e_1 + h e_2

with right-handed axes. Without a lattice the axes are orthonormal, and no mesh axis has the direction e_2 of the
projection. On a lattice e_0 and e_1 have the directions of the periods and e_2 is slightly inclined to the normal, so
that a copy of a yarn is the yarn displaced along x and y only.

Each segment becomes ``SAMPLES`` edges, or more if it is longer than the others. Vertices are rounded to whole units. A
unit is some millionths of the longest edge, and a period is a whole number of units. Every question about these
polylines can therefore be answered without rounding. Several sets of yarns are projected together, each in its own
units and cells, and no cell holds edges of two sets. The polylines lie a few hundredths of a yarn radius from the
curves; nearly all of this distance is the sag of the chords. The sides of polygons become edges in the same manner,
each side one edge, or more if it is longer than the others.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import warp as wp
from numpy.typing import NDArray

from stitchmesh.compute.launch import launch
from stitchmesh.compute.threads import each_block
from stitchmesh.lattice import Lattice
from stitchmesh.linking.predicate import EDGE
from stitchmesh.linking.yarn_samples import Curves, end_yarns, measure_segments, sample_segments
from stitchmesh.mesh import FloatArray, IntArray
from stitchmesh.yarn import YarnSet

SAMPLES = 4
"""Edges of a segment of usual length; the chords stay within a few hundredths of a radius of the curve."""
FINE = 64
"""Edges of a segment if yarns are nearly pressed together. A chord sags by at most 1 / (8 FINE^2) of the largest
difference of two legs between control points. If these differences are at most 16 radii, two chords stay apart at the
smallest clearance of a relaxation, a thousandth of a radius."""
LONG = 2.0
"""A segment longer than this, over the mean length, is divided into more edges, so that one grid suits all edges."""
SPAN = 2.0**48
"""Largest coordinate [units], so that the error of a sample before rounding is below half a unit."""
CELLS = 2.0**30
"""Largest number of cells along an axis, so that cell numbers fit 63 bits."""
DIRECTION = np.array([0.2911, 0.1727, 0.9410])
"""Direction of the projection in world axes; on a lattice in the axes of the fabric: courses, across them, normal."""


@wp.struct
class Grid:
    """Rectangular cells of the projection, which repeat with the period."""

    cell: wp.vec2d
    """Width and height of a cell, at least the extents of the longest edge [units]."""
    period: wp.vec2d
    """Periods of the projection [units]; without a lattice they are wider than the yarns."""
    columns: wp.int64
    """Number of cells along x in a period."""
    rows: wp.int64
    """Number of cells along y in a period."""
    first: wp.int64
    """Number of the first cell; each of several sets of yarns has its own numbers."""


@dataclass(frozen=True, eq=False)
class ProjectedPolylines:
    """Polylines on the device: edge ``e`` of yarn ``y`` runs from vertex ``e + y`` to vertex ``e + y + 1``."""

    vertices: wp.array[Any]
    """Coordinates [units], shape (E + Y,); the last vertex of a yarn closes it, or is the end of an open yarn."""
    edge_yarn: wp.array[Any]
    """Yarn of each edge, shape (E,)."""
    yarn_edge: IntArray
    """Where each yarn's edges start, shape (Y + 1,)."""
    step: wp.array[Any]
    """Lattice step of each yarn, shape (Y,)."""
    yarn_set: wp.array[Any]
    """The set of each yarn, shape (Y,)."""
    grids: wp.array[Any]
    """Cells and periods of each set."""
    cell_count: int
    """Number of cells of all sets."""
    middle: FloatArray
    """Middle of the yarns of the first set [units], shape (3,)."""
    reach: IntArray
    """Bound of the difference of the images of two edges, zero without a lattice, shape (2,)."""


@dataclass(frozen=True, eq=False)
class _Seen:
    """A set of yarns in its projection, before it is cut into edges."""

    yarns: YarnSet
    points: FloatArray
    """Control points [cm], shape (N, 3); the least coordinate along each axis is zero."""
    extent: FloatArray
    """Largest coordinate along each axis [cm], shape (3,)."""
    middle: FloatArray
    """Middle of the yarns [cm], shape (3,)."""
    periods: FloatArray | None
    """Lengths of the periods [cm], shape (2,); None without a lattice."""
    step: IntArray
    """Lattice step of each yarn, shape (Y, 2)."""
    shift: FloatArray
    """Lattice step of each yarn as a displacement [cm], shape (Y, 3)."""

    @classmethod
    def of(cls, yarns: YarnSet) -> _Seen:
        """Project the control points of yarns."""
        view = np.linalg.inv(_axes(yarns.lattice))
        seen = np.empty(yarns.points.shape)

        def see(some: slice) -> None:
            seen[some] = yarns.points[some] @ view

        each_block(see, len(seen))
        (low, high), (origin, farthest) = _bounds(yarns.points), _bounds(seen)
        middle = (low + high) / 2 @ view - origin
        seen -= origin
        periods = None if yarns.lattice is None else np.linalg.norm(yarns.lattice.periods, axis=1)
        return cls(yarns, seen, farthest - origin, middle, periods, *_steps(yarns, periods))

    @property
    def room(self) -> FloatArray:
        """Extent along each axis, with copies by the lattice steps [cm], shape (3,)."""
        room: FloatArray = self.extent + 2.0 * np.abs(self.shift).max(axis=0)
        return room

    @property
    def reach(self) -> FloatArray:
        """Bound of the difference of the images of two edges, shape (2,)."""
        return np.zeros(2) if self.periods is None else np.ceil(self.room[:2] / self.periods) + 2


def project_yarns(sets: Sequence[YarnSet], device: wp.Device, edges: int = SAMPLES) -> ProjectedPolylines:
    """Return the projections of sets of yarns as they lie, with ``edges`` edges in a segment of usual length."""
    seen = [_Seen.of(yarns) for yarns in sets]
    curves = _put_curves(seen, device)
    segment_start = _starts([len(yarns.rest_length) for yarns in sets])
    size = _measured(curves, int(segment_start[-1]), device)
    pieces, grids, scales, cells = [], list[Any](), [], 0
    for own, first, last in zip(seen, segment_start[:-1], segment_start[1:], strict=True):
        count, longest = _cut(size[first:last], own.periods, edges)
        grid, scale = _fit(longest, own.room, own.periods)
        grid.first = wp.int64(cells)
        cells += int(grid.columns) * int(grid.rows)
        pieces.append(count)
        grids.append(grid)
        scales.append(scale)
    segment_edge = _starts(np.concatenate(pieces))
    counts = [yarns.yarn_count for yarns in sets]
    yarn_edge = segment_edge[_starts(np.concatenate([np.diff(yarns.segment_start) for yarns in sets]))]
    curves.scale = wp.array(np.repeat(scales, counts, axis=0), dtype=wp.vec3d, device=device)
    projection = ProjectedPolylines(
        vertices=wp.empty(int(yarn_edge[-1]) + sum(counts), dtype=wp.vec3d, device=device),
        edge_yarn=wp.empty(int(yarn_edge[-1]), dtype=wp.int32, device=device),
        yarn_edge=yarn_edge,
        step=wp.array(np.concatenate([own.step for own in seen]), dtype=wp.vec2i, device=device),
        yarn_set=wp.array(np.repeat(np.arange(len(sets)), counts), dtype=wp.int32, device=device),
        grids=wp.array(grids, dtype=Grid, device=device),
        cell_count=cells,
        middle=np.rint(seen[0].middle * scales[0]),
        reach=np.max([own.reach for own in seen], axis=0).astype(np.int64),
    )
    closed = np.concatenate([yarns.closed for yarns in sets])
    periods = np.repeat([list(grid.period) for grid in grids], counts, axis=0)
    _sample(projection, curves, segment_edge, closed, periods)
    return projection


def project_polygons(points: FloatArray, polygons: Sequence[Sequence[int]], device: wp.Device) -> ProjectedPolylines:
    """Return the projection of closed polygons, which count as yarns without a lattice.

    Args:
        points: positions [cm], shape (n, 3).
        polygons: for each polygon the points through which it passes, in order; the last one is joined to the first.
        device: where the polylines are.
    """
    first = _starts([len(polygon) + 1 for polygon in polygons])
    corners = np.concatenate([[*polygon, polygon[0]] for polygon in polygons])
    places = (points @ np.linalg.inv(_axes(None)))[corners]
    places -= places.min(axis=0)
    is_side = np.ones(len(corners), dtype=bool)
    is_side[first[1:] - 1] = False  # the corner that closes a polygon is a vertex without an edge
    sides = np.diff(places, axis=0, append=places[:1])
    pieces, longest = _cut(np.abs(sides[is_side]).max(axis=1), None, 1)
    grid, scale = _fit(longest, places.max(axis=0), None)
    vertex_count = np.ones(len(corners), dtype=np.int64)
    vertex_count[is_side] = pieces
    corner = np.repeat(np.arange(len(corners)), vertex_count)
    along = (np.arange(len(corner)) - _starts(vertex_count)[corner]) / vertex_count[corner]
    vertices = np.rint((places[corner] + along[:, None] * sides[corner]) * scale)
    yarn_edge = _starts(np.add.reduceat(vertex_count, first[:-1]) - 1)
    return ProjectedPolylines(
        vertices=wp.array(vertices, dtype=wp.vec3d, device=device),
        edge_yarn=wp.array(np.repeat(np.arange(len(polygons)), np.diff(yarn_edge)), dtype=wp.int32, device=device),
        yarn_edge=yarn_edge,
        step=wp.zeros(len(polygons), dtype=wp.vec2i, device=device),
        yarn_set=wp.zeros(len(polygons), dtype=wp.int32, device=device),
        grids=wp.array([grid], dtype=Grid, device=device),
        cell_count=int(grid.columns) * int(grid.rows),
        middle=np.zeros(3),
        reach=np.zeros(2, dtype=np.int64),
    )


def _starts(counts: Sequence[int] | IntArray) -> IntArray:
    return np.concatenate([[0], np.cumsum(counts)]).astype(np.int64)


def _sample(
    projection: ProjectedPolylines, curves: Any, segment_edge: IntArray, closed: NDArray[np.bool_], periods: FloatArray
) -> None:
    """Fill in the vertices and the yarns of edges; ``periods``: the periods of each yarn in the projection [units]."""
    device = projection.vertices.device
    bounds = wp.array(segment_edge, dtype=wp.int32, device=device)
    outputs = [projection.vertices, projection.edge_yarn]
    launch(sample_segments, len(segment_edge) - 1, [bounds, curves], outputs, device)
    ends = wp.array(projection.yarn_edge, dtype=wp.int32, device=device)
    is_closed = wp.array(closed, dtype=wp.bool, device=device)
    inputs = [ends, is_closed, projection.step, wp.array(periods, dtype=wp.vec2d, device=device), curves]
    launch(end_yarns, len(closed), inputs, [projection.vertices], device)


def _bounds(points: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return the least and the largest coordinate along each axis."""
    blocks = each_block(lambda some: [(c.min(), c.max()) for c in points[some].T], len(points))
    bounds = np.array(blocks)
    return bounds[:, :, 0].min(axis=0), bounds[:, :, 1].max(axis=0)


def _steps(yarns: YarnSet, periods: FloatArray | None) -> tuple[IntArray, FloatArray]:
    """Return the lattice step of each yarn, zero for open ones, and its displacement in the projection [cm]."""
    step = np.zeros((yarns.yarn_count, 2), dtype=np.int64)
    shift = np.zeros((yarns.yarn_count, 3))
    if periods is not None and yarns.lattice_step is not None:
        step[yarns.closed] = yarns.lattice_step[yarns.closed]
        shift[:, :2] = step * periods
    return step, shift


def _axes(lattice: Lattice | None) -> FloatArray:
    """Return, as rows, the two axes of the projection and the direction towards the eye."""
    towards = DIRECTION / np.linalg.norm(DIRECTION)
    if lattice is None:
        right = np.cross([0.0, 1.0, 0.0], towards)
        right /= np.linalg.norm(right)
        return np.stack([right, np.cross(towards, right), towards])
    first, second = lattice.periods / np.linalg.norm(lattice.periods, axis=1, keepdims=True)
    normal = np.cross(first, second)
    normal /= np.linalg.norm(normal)
    return np.stack([first, second, towards @ np.stack([first, np.cross(normal, first), normal])])


def _put_curves(seen: Sequence[_Seen], device: wp.Device) -> Any:
    """Put the curves of all sets on the device, one after another; the scales of their projections follow later."""
    yarns = [own.yarns for own in seen]
    curves = Curves()
    curves.points = wp.array(np.concatenate([own.points for own in seen]), dtype=wp.vec3d, device=device)
    start = _starts(np.concatenate([np.diff(own.start) for own in yarns]))
    segment_start = _starts(np.concatenate([np.diff(own.segment_start) for own in yarns]))
    curves.start = wp.array(start, dtype=wp.int32, device=device)
    curves.segment_start = wp.array(segment_start, dtype=wp.int32, device=device)
    curves.shift = wp.array(np.concatenate([own.shift for own in seen]), dtype=wp.vec3d, device=device)
    return curves


def _measured(curves: Any, count: int, device: wp.Device) -> FloatArray:
    size = wp.empty(count, dtype=wp.float64, device=device)
    launch(measure_segments, count, [curves], [size], device)
    return size.numpy()


def _cut(size: FloatArray, periods: FloatArray | None, edges: int) -> tuple[IntArray, float]:
    """Return the number of edges of each segment, and a bound of their extent along an axis [cm]."""
    usual = LONG * float(size.mean())
    if periods is not None:
        usual = min(usual, edges / 2 * float(periods.min()))  # no edge longer than half a period
    pieces = edges * np.maximum(np.ceil(size / usual if usual > 0.0 else size), 1.0)
    return pieces.astype(np.int64), float((size / pieces).max())


def _fit(longest: float, room: FloatArray, periods: FloatArray | None) -> tuple[Any, FloatArray]:
    """Return cells just larger than the longest edge, and units per cm along each axis."""
    whole = room[:2] if periods is None else periods
    scale = min((EDGE - 2) / longest if longest > 0.0 else 1.0, SPAN / room.max() if room.max() > 0.0 else 1.0)
    least = max(np.ceil(longest * scale) + 2.0, np.ceil(whole.max() * scale / CELLS))  # rounding moves a vertex
    scales = np.full(3, scale)
    if periods is None:
        cells = np.floor(whole * scale / least) + 2.0  # one empty cell keeps the yarns from their own images
        cell = np.full(2, least)
    else:
        cells = np.maximum(np.floor(periods * scale / least), 1.0)
        cell = np.floor(periods * scale / cells)
        scales[:2] = cells * cell / periods
    grid = Grid()
    grid.cell, grid.period = wp.vec2d(*cell), wp.vec2d(*(cells * cell))
    grid.columns, grid.rows = wp.int64(int(cells[0])), wp.int64(int(cells[1]))
    return grid, scales
