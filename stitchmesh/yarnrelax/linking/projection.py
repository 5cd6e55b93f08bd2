# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Yarns as polylines with integer coordinates in a projection.

A point p has the coordinates (x, y, h): its place in the projection and its height towards the eye,

    p - origin = x e_0 + y e_1 + h e_2

with right-handed axes. Without a lattice the axes are orthonormal, and no mesh axis has the direction e_2 of the
projection. On a lattice e_0 and e_1 have the directions of the periods and e_2 is slightly inclined to the normal, so
that a copy of a yarn is the yarn displaced along x and y only.

Each segment becomes SAMPLES edges, and more where the segment is longer than the others. Vertices are rounded to whole
units, a unit being some millionths of the longest edge, and a period is a whole number of units. Every question about
these polylines can therefore be answered without rounding. The polylines lie a few hundredths of a yarn radius from the
curves; nearly all of this distance is the sag of the chords.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import warp as wp

from stitchmesh.compute.launch import launch
from stitchmesh.mesh import FloatArray, IntArray
from stitchmesh.yarn import YarnSet
from stitchmesh.yarnrelax.linking.polylines import Curves, end_yarns, measure_segments, sample_segments

SAMPLES = 4
"""Edges of a segment of usual length; their chords stay within a few hundredths of a radius of the curve."""
LONG = 2.0
"""Size over the mean size above which a segment is divided into more edges, so that one grid suits all edges."""
EDGE = 2**19
"""Longest edge along each axis [units]; the volume of two edges and their distance then fits 63 bits."""
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
    """Width and height of a cell, no less than an edge's [units]."""
    period: wp.vec2d
    """Periods of the projection; without a lattice wider than the yarns [units]."""
    columns: wp.int64
    """Cells along x in a period."""
    rows: wp.int64
    """Cells along y in a period."""


@dataclass(frozen=True, eq=False)
class Projection:
    """Polylines on the device: edge ``e`` of yarn ``y`` runs from vertex ``e + y`` to vertex ``e + y + 1``."""

    vertices: wp.array[Any]
    """Coordinates [units]; the last of each yarn closes it, or is the end of an open one, shape (E + Y,)."""
    edge_yarn: wp.array[Any]
    """Yarn of each edge, shape (E,)."""
    yarn_edge: IntArray
    """Where each yarn's edges start, shape (Y + 1,)."""
    step: wp.array[Any]
    """Lattice step of each yarn, shape (Y,)."""
    grid: Any
    """Cells and periods."""
    middle: FloatArray
    """Middle of all yarns [units], shape (3,)."""
    reach: IntArray
    """Bound of the difference of the images of two edges, zero without a lattice, shape (2,)."""


def project_yarns(yarns: YarnSet, device: wp.Device) -> Projection:
    """The projection of yarns in their current positions."""
    view = np.linalg.inv(_axes(yarns))
    seen = yarns.points @ view
    origin = seen.min(axis=0)
    seen -= origin
    periods = None if yarns.lattice is None else np.linalg.norm(yarns.lattice.periods, axis=1)
    step, shift = _steps(yarns, periods)
    curves = _put_curves(yarns, seen, shift, device)
    segment_edge, longest = _cut(_measured(curves, int(yarns.segment_start[-1]), device), periods)
    room = seen.max(axis=0) + 2.0 * np.abs(shift).max(axis=0)
    grid, scale = _fit(longest, room, periods)
    middle = (yarns.points.min(axis=0) + yarns.points.max(axis=0)) / 2 @ view - origin
    reach = np.zeros(2) if periods is None else np.ceil(room[:2] / periods) + 2
    yarn_edge = segment_edge[yarns.segment_start]
    projection = Projection(
        vertices=wp.empty(int(yarn_edge[-1]) + yarns.yarn_count, dtype=wp.vec3d, device=device),
        edge_yarn=wp.empty(int(yarn_edge[-1]), dtype=wp.int32, device=device),
        yarn_edge=yarn_edge,
        step=wp.array(step, dtype=wp.vec2i, device=device),
        grid=grid,
        middle=np.rint(middle * scale),
        reach=reach.astype(np.int64),
    )
    _sample(projection, curves, segment_edge, yarns, scale)
    return projection


def _sample(projection: Projection, curves: Any, segment_edge: IntArray, yarns: YarnSet, scale: FloatArray) -> None:
    """Fill in vertices and yarns of edges."""
    device, units = projection.vertices.device, wp.vec3d(*scale)
    bounds = wp.array(segment_edge, dtype=wp.int32, device=device)
    outputs = [projection.vertices, projection.edge_yarn]
    launch(sample_segments, len(segment_edge) - 1, [bounds, units, curves], outputs, device)
    ends = wp.array(projection.yarn_edge, dtype=wp.int32, device=device)
    closed = wp.array(yarns.closed, dtype=wp.bool, device=device)
    inputs = [ends, closed, projection.step, projection.grid.period, units, curves]
    launch(end_yarns, yarns.yarn_count, inputs, [projection.vertices], device)


def _steps(yarns: YarnSet, periods: FloatArray | None) -> tuple[IntArray, FloatArray]:
    """Lattice step of each yarn, zero for open ones, and the same as a displacement in the projection [cm]."""
    step = np.zeros((yarns.yarn_count, 2), dtype=np.int64)
    shift = np.zeros((yarns.yarn_count, 3))
    if periods is not None and yarns.lattice_step is not None:
        step[yarns.closed] = yarns.lattice_step[yarns.closed]
        shift[:, :2] = step * periods
    return step, shift


def _axes(yarns: YarnSet) -> FloatArray:
    """Rows: the two axes of the projection and the direction towards the eye."""
    towards = DIRECTION / np.linalg.norm(DIRECTION)
    if yarns.lattice is None:
        right = np.cross([0.0, 1.0, 0.0], towards)
        right /= np.linalg.norm(right)
        return np.stack([right, np.cross(towards, right), towards])
    first, second = yarns.lattice.periods / np.linalg.norm(yarns.lattice.periods, axis=1, keepdims=True)
    normal = np.cross(first, second)
    normal /= np.linalg.norm(normal)
    return np.stack([first, second, towards @ np.stack([first, np.cross(normal, first), normal])])


def _put_curves(yarns: YarnSet, seen: FloatArray, shift: FloatArray, device: wp.Device) -> Any:
    curves = Curves()
    curves.points = wp.array(seen, dtype=wp.vec3d, device=device)
    curves.start = wp.array(yarns.start, dtype=wp.int32, device=device)
    curves.segment_start = wp.array(yarns.segment_start, dtype=wp.int32, device=device)
    curves.shift = wp.array(shift, dtype=wp.vec3d, device=device)
    return curves


def _measured(curves: Any, count: int, device: wp.Device) -> FloatArray:
    size = wp.empty(count, dtype=wp.float64, device=device)
    launch(measure_segments, count, [curves], [size], device)
    return size.numpy()


def _cut(size: FloatArray, periods: FloatArray | None) -> tuple[IntArray, float]:
    """Where each segment's edges start, and a bound of their extent along an axis [cm]."""
    usual = LONG * float(size.mean())
    if periods is not None:
        usual = min(usual, SAMPLES / 2 * float(periods.min()))  # no edge longer than half a period
    pieces = SAMPLES * np.maximum(np.ceil(size / usual if usual > 0.0 else size), 1.0)
    return np.concatenate([[0], np.cumsum(pieces.astype(np.int64))]), float((size / pieces).max())


def _fit(longest: float, room: FloatArray, periods: FloatArray | None) -> tuple[Any, FloatArray]:
    """Cells just larger than the longest edge, and units per cm along each axis."""
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
