# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Crossings of the polylines of a projection, as the rule of ``predicate`` decides them.

Each edge is tested against the edges that start in its cell and in half of the neighbouring cells, which finds each
pair once. Kernels write each crossing as one integer. With Y yarns, yarns i <= j, the image (a, b) of yarn j relative
to yarn i, and the sign +1 or -1, this is

    code = 2 (((i Y + j) A + a + (A - 1) / 2) B + b + (B - 1) / 2) + (1 + sign) / 2

where A and B are the numbers of possible images along the two periods. Kernels write the codes in any order, because
sums over crossings do not depend on the order in which the crossings are found.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import warp as wp

from stitchmesh.compute.kernel import kernel
from stitchmesh.compute.launch import launch
from stitchmesh.compute.slots import next_slot
from stitchmesh.errors import ParameterError
from stitchmesh.linking.predicate import crossing_is_positive, edges_cross, later_copy
from stitchmesh.linking.projection import Grid, ProjectedPolylines
from stitchmesh.mesh import IntArray


@wp.struct
class Crossings:
    """Found crossings, each one integer, in no particular order."""

    count: wp.array[wp.int32]
    """Number of crossings, which may exceed the capacity, shape (1,)."""
    code: wp.array[wp.int64]
    """Two yarns, the image of the second relative to the first, and the sign; see ``decoded``."""
    yarns: wp.int64
    """Number of yarns."""
    reach: wp.vec2i
    """Bound of the images."""


@wp.func
def note(crossings: Crossings, one: int, two: int, image: wp.vec2i, positive: bool) -> None:
    """Write a crossing of yarn one with the copy of yarn two in an image."""
    slot = next_slot(crossings.count)
    if slot < crossings.code.shape[0]:
        seen = wp.where(one <= two, image, -image)
        code = wp.int64(wp.min(one, two)) * crossings.yarns + wp.int64(wp.max(one, two))
        for axis in range(2):
            code = code * wp.int64(2 * crossings.reach[axis] + 1) + wp.int64(seen[axis] + crossings.reach[axis])
        crossings.code[slot] = wp.int64(2) * code + wp.where(positive, wp.int64(1), wp.int64(0))


def collected(projection: ProjectedPolylines, launch: Callable[[Any], None]) -> IntArray:
    """Return the codes that a launch writes; repeat the launch with more capacity if crossings outnumber edges.

    Raises:
        ParameterError: there are too many yarns over too many periods, so that a code does not fit 63 bits.
    """
    device = projection.vertices.device
    yarns = len(projection.yarn_edge) - 1
    if 2 * yarns**2 * int(np.prod(2 * projection.reach + 1, dtype=object)) >= 2**63:
        raise ParameterError(f"linking certificate: got {yarns} yarns; expected fewer, or nearer to one period")
    crossings = Crossings()
    crossings.yarns, crossings.reach = wp.int64(yarns), wp.vec2i(*projection.reach.tolist())
    room = projection.edge_yarn.shape[0]
    while True:
        crossings.count = wp.zeros(1, dtype=wp.int32, device=device)
        crossings.code = wp.empty(room, dtype=wp.int64, device=device)
        launch(crossings)
        found = int(crossings.count.numpy()[0])
        if found <= room:
            return crossings.code[:found].numpy()
        room = found


def encoded(projection: ProjectedPolylines, yarns: IntArray, sign: IntArray) -> IntArray:
    """Return the codes of crossings without a lattice, from their yarns i < j, shape (n, 2), and their signs."""
    code: IntArray = 2 * (yarns[:, 0] * (len(projection.yarn_edge) - 1) + yarns[:, 1]) + (sign > 0)
    return code


def decoded(projection: ProjectedPolylines, code: IntArray) -> tuple[IntArray, IntArray, IntArray]:
    """Return for each code the two yarns, the image of the second relative to the first, and the sign."""
    code, positive = np.divmod(code, 2)
    image = np.empty((len(code), 2), dtype=np.int64)
    for axis in (1, 0):
        code, image[:, axis] = np.divmod(code, 2 * projection.reach[axis] + 1)
    yarns = np.stack(np.divmod(code, len(projection.yarn_edge) - 1), axis=1)
    return yarns, image - projection.reach, 2 * positive - 1


@wp.struct
class Edges:
    """Edges in the order of their cells, moved into the first period."""

    key: wp.array[wp.int64]
    """Number of the cell, shape (2 E,); the second half is scratch space for sorting."""
    box: wp.array[wp.vec4d]
    """Least x and y, then largest x and y of the edge [units], shape (E,)."""
    tail: wp.array[wp.vec3d]
    """First vertex of the edge [units], shape (E,)."""
    head: wp.array[wp.vec3d]
    """Last vertex of the edge [units], shape (E,)."""
    yarn: wp.array[wp.int32]
    """Yarn of the edge, shape (E,)."""
    image: wp.array[wp.vec2i]
    """Image from which the edge was moved, shape (E,)."""


@wp.func
def box_of(tail: wp.vec3d, head: wp.vec3d) -> wp.vec4d:
    """Least x and y, then largest x and y of an edge."""
    low, high = wp.min(tail, head), wp.max(tail, head)
    return wp.vec4d(low[0], low[1], high[0], high[1])


@wp.func
def period_of(value: wp.float64, cell: wp.float64, cells: wp.int64) -> wp.int64:
    """Period that holds a coordinate."""
    return wp.int64(wp.floor(wp.floor(value / cell) / wp.float64(cells)))


@kernel
def place_edges(
    # model
    grids: wp.array[Grid],
    yarn_set: wp.array[wp.int32],
    # state in
    vertices: wp.array[wp.vec3d],
    edge_yarn: wp.array[wp.int32],
    # state out
    key: wp.array[wp.int64],
    edge: wp.array[wp.int32],
) -> None:
    """Number of the cell where each edge's box begins."""
    e = wp.tid()
    grid = grids[yarn_set[edge_yarn[e]]]
    low = box_of(vertices[e + edge_yarn[e]], vertices[e + edge_yarn[e] + 1])
    column = wp.int64(wp.floor(low[0] / grid.cell[0]))
    row = wp.int64(wp.floor(low[1] / grid.cell[1]))
    column -= period_of(low[0], grid.cell[0], grid.columns) * grid.columns
    row -= period_of(low[1], grid.cell[1], grid.rows) * grid.rows
    key[e] = grid.first + row * grid.columns + column
    edge[e] = e


@kernel
def order_edges(
    # model
    grids: wp.array[Grid],
    yarn_set: wp.array[wp.int32],
    # state in
    vertices: wp.array[wp.vec3d],
    edge_yarn: wp.array[wp.int32],
    edge: wp.array[wp.int32],
    # state out
    edges: Edges,
) -> None:
    """Copy edges in the order of their cells."""
    i = wp.tid()
    yarn = edge_yarn[edge[i]]
    grid = grids[yarn_set[yarn]]
    tail, head = vertices[edge[i] + yarn], vertices[edge[i] + yarn + 1]
    low = box_of(tail, head)
    x = period_of(low[0], grid.cell[0], grid.columns)
    y = period_of(low[1], grid.cell[1], grid.rows)
    back = wp.vec3d(wp.float64(x) * grid.period[0], wp.float64(y) * grid.period[1], wp.float64(0.0))
    edges.tail[i] = tail - back
    edges.head[i] = head - back
    edges.box[i] = box_of(tail - back, head - back)
    edges.yarn[i] = yarn
    edges.image[i] = wp.vec2i(wp.int32(x), wp.int32(y))


@wp.func
def periods_on(place: wp.int64, cells: wp.int64) -> int:
    """Period of a cell in the first period or next to it."""
    return wp.where(place < wp.int64(0), -1, wp.where(place == cells, 1, 0))


@wp.func
def boxes_meet(one: wp.vec4d, two: wp.vec4d) -> bool:
    """Whether two boxes have a point in common."""
    return one[0] <= two[2] and two[0] <= one[2] and one[1] <= two[3] and two[1] <= one[3]


@wp.func
def cross_pair(edges: Edges, grid: Grid, step: wp.array[wp.vec2i], i: int, j: int, wrap: wp.vec2i,
              crossings: Crossings) -> None:  # fmt: skip
    """Write the crossing of edge i with the copy of edge j displaced by ``wrap`` periods, if there is one."""
    one, two = edges.yarn[i], edges.yarn[j]
    image = edges.image[i] - edges.image[j] + wrap
    order = wp.where(one < two, 1, -1)
    if one == two:
        order = later_copy(image, step[one])
        if order == 0:
            return
    on = wp.vec3d(wp.float64(wrap[0]) * grid.period[0], wp.float64(wrap[1]) * grid.period[1], wp.float64(0.0))
    a, b, c, d = edges.tail[i], edges.head[i], edges.tail[j] + on, edges.head[j] + on
    later = wp.float64(order)
    if edges_cross(a, b, c, d, later):
        note(crossings, one, two, image, crossing_is_positive(a, b, c, d, later))


@kernel
def find_crossings(
    # model
    grids: wp.array[Grid],
    yarn_set: wp.array[wp.int32],
    step: wp.array[wp.vec2i],
    # state in
    edges: Edges,
    # state out
    crossings: Crossings,
) -> None:
    """Crossings of each edge with later ones of its cell, and with those of half of the neighbouring cells."""
    i = wp.tid()
    box, count = edges.box[i], edges.yarn.shape[0]
    grid = grids[yarn_set[edges.yarn[i]]]
    row = (edges.key[i] - grid.first) / grid.columns
    column = edges.key[i] - grid.first - row * grid.columns
    right = box[2] >= wp.float64(column + wp.int64(1)) * grid.cell[0]
    above = box[3] >= wp.float64(row + wp.int64(1)) * grid.cell[1]
    for neighbour in range(5):  # its own, to the right, and above from left to right
        if (neighbour > 1 and not above) or ((neighbour == 1 or neighbour == 4) and not right):
            continue
        x, y = column, row
        if neighbour > 0:
            x += wp.int64(wp.where(neighbour == 1, 1, neighbour - 3))
            y += wp.where(neighbour == 1, wp.int64(0), wp.int64(1))
        wrap = wp.vec2i(periods_on(x, grid.columns), periods_on(y, grid.rows))
        key = grid.first + (y - wp.int64(wrap[1]) * grid.rows) * grid.columns + x - wp.int64(wrap[0]) * grid.columns
        back_x, back_y = wp.float64(wrap[0]) * grid.period[0], wp.float64(wrap[1]) * grid.period[1]
        seen = wp.vec4d(box[0] - back_x, box[1] - back_y, box[2] - back_x, box[3] - back_y)
        j = i + 1
        if neighbour > 0:
            j = wp.lower_bound(edges.key, 0, count, key)
        while j < count and edges.key[j] == key:
            if boxes_meet(seen, edges.box[j]):
                cross_pair(edges, grid, step, i, j, wrap, crossings)
            j += 1


def edge_crossings(projection: ProjectedPolylines) -> IntArray:
    """Return the codes of the crossings of two yarns, or of two copies of one, in no particular order."""
    count, device = projection.edge_yarn.shape[0], projection.vertices.device
    edges = _sorted_edges(projection)

    def find(crossings: Any) -> None:
        inputs = [projection.grids, projection.yarn_set, projection.step, edges]
        launch(find_crossings, count, inputs, [crossings], device)

    return collected(projection, find)


def _sorted_edges(projection: ProjectedPolylines) -> Any:
    count, device = projection.edge_yarn.shape[0], projection.vertices.device
    polylines = [projection.grids, projection.yarn_set, projection.vertices, projection.edge_yarn]
    edges = Edges()
    edges.key = wp.empty(2 * count, dtype=wp.int64, device=device)
    order = wp.empty(2 * count, dtype=wp.int32, device=device)
    launch(place_edges, count, polylines, [edges.key, order], device)
    bits = projection.cell_count.bit_length()
    wp.utils.radix_sort_pairs(edges.key, order, count, end_bit=bits)
    edges.tail, edges.head = (wp.empty(count, dtype=wp.vec3d, device=device) for _ in range(2))
    edges.box = wp.empty(count, dtype=wp.vec4d, device=device)
    edges.yarn = wp.empty(count, dtype=wp.int32, device=device)
    edges.image = wp.empty(count, dtype=wp.vec2i, device=device)
    launch(order_edges, count, [*polylines, order], [edges], device)
    return edges
