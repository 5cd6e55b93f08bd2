# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Artificial closures of open yarns, so that open yarns have linking numbers too.

From each end of an open yarn a straight line runs outwards, away from the middle of all yarns. Outside of everything an
arc joins the two lines, from the last end to the first. The arc lies above all yarns, and above the lines of later
yarns, which continue outwards beyond it. All lines start from the same middle, and never cross each other. The
crossings of a line with yarns are found by angles around the middle. The order of the ends around the middle says
which arcs pass above which lines. As everywhere in the projection, signs of products are exact, and an infinitesimal
displacement of whole yarns breaks ties, so that closed-up yarns also cross an even number of times. Heights of the
lines are computed in float64: an error in a height changes the linking number of a closed-up yarn to another valid one.
"""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction
from typing import Any

import numpy as np
import warp as wp
from numpy.typing import NDArray

from stitchmesh.compute.kernel import kernel
from stitchmesh.compute.launch import launch
from stitchmesh.linking.crossings import Crossings, collected, encoded, note
from stitchmesh.linking.predicate import cross_product, is_left
from stitchmesh.linking.projection import ProjectedPolylines
from stitchmesh.mesh import FloatArray, IntArray


@wp.struct
class EndLines:
    """Lines from the ends of open yarns, in the order of their angles."""

    angle: wp.array[wp.float64]
    """Angle around the middle, -2 to 2 for a full turn; a 3 at the end marks the end; shape (L + 1,)."""
    end: wp.array[wp.vec3d]
    """End of the yarn, relative to the middle [units], shape (L,)."""
    direction: wp.array[wp.vec3d]
    """Direction of the line in the projection, shape (L,)."""
    distance: wp.array[wp.float64]
    """Square of the distance of the yarn's end from the middle, or slightly less [square units], shape (L,)."""
    yarn: wp.array[wp.int32]
    """Yarn of the line, shape (L,)."""
    outwards: wp.array[wp.int32]
    """1 if the yarn leaves along the line, -1 if it returns, shape (L,)."""


@wp.func
def angle_of(place: wp.vec3d) -> wp.float64:
    """A number that increases with the angle, from -2 to 2; equal directions give equal numbers."""
    size = wp.abs(place[0]) + wp.abs(place[1])
    if size == wp.float64(0.0):
        return size
    part = place[1] / size
    if place[0] >= wp.float64(0.0):
        return part
    return wp.where(place[1] >= wp.float64(0.0), wp.float64(2.0), wp.float64(-2.0)) - part


@wp.func
def cross_line(lines: EndLines, k: int, yarn: int, tail: wp.vec3d, head: wp.vec3d, crossings: Crossings) -> None:
    """Write the crossing of line k with an edge, if there is one; places are relative to the middle."""
    if lines.yarn[k] == yarn:
        return
    direction, end = lines.direction[k], lines.end[k]
    later = wp.where(lines.yarn[k] < yarn, wp.float64(1.0), wp.float64(-1.0))
    tail_side, head_side = cross_product(direction, tail), cross_product(direction, head)
    leftwards = is_left(direction, head_side, later)
    if is_left(direction, tail_side, later) == leftwards:
        return
    span = head - tail
    if is_left(span, cross_product(span, end - tail), -later) == (cross_product(span, direction) > wp.float64(0.0)):
        return  # the edge passes on the near side of the end
    place = tail + span * (tail_side / (tail_side - head_side))
    ratio = (place[0] * direction[0] + place[1] * direction[1]) / wp.length_sq(direction)
    above = end[2] * ratio > place[2]
    note(crossings, lines.yarn[k], yarn, wp.vec2i(0, 0), (above == leftwards) == (lines.outwards[k] > 0))


@kernel
def find_line_crossings(
    # model
    middle: wp.vec3d,
    # state in
    vertices: wp.array[wp.vec3d],
    edge_yarn: wp.array[wp.int32],
    lines: EndLines,
    # state out
    crossings: Crossings,
) -> None:
    """Crossings of each edge with the lines whose angles lie between the angles of its ends."""
    e = wp.tid()
    yarn = edge_yarn[e]
    tail, head = vertices[e + yarn] - middle, vertices[e + yarn + 1] - middle
    first, last = angle_of(tail), angle_of(head)
    low, high = wp.min(first, last), wp.max(first, last)
    turn = cross_product(tail, head)
    around = low < high and (turn > wp.float64(0.0)) != (first < last)  # the edge passes the angle pi
    if turn == wp.float64(0.0):  # in line with the middle
        if wp.dot(wp.vec2d(tail[0], tail[1]), wp.vec2d(head[0], head[1])) > wp.float64(0.0):
            return  # perhaps on a line, but entirely on one side of the line after the displacement
        low, high, around = wp.float64(-2.0), wp.float64(2.0), False
    farthest = wp.max(tail[0] * tail[0] + tail[1] * tail[1], head[0] * head[0] + head[1] * head[1])
    for part in range(2):
        begin, end = low, high
        if around:
            begin, end = wp.where(part == 0, wp.float64(-2.0), high), wp.where(part == 0, low, wp.float64(2.0))
        elif part == 1:
            return
        k = wp.lower_bound(lines.angle, begin)
        while lines.angle[k] <= end:
            if lines.distance[k] <= farthest:
                cross_line(lines, k, yarn, tail, head, crossings)
            k += 1


@dataclass(frozen=True, eq=False)
class OpenEnds:
    """Both ends of all open yarns, in the order of their angles around the middle."""

    place: FloatArray
    """Places of the ends, relative to the middle [units], shape (2 n, 3)."""
    yarn: IntArray
    """Yarn of each end, shape (2 n,)."""
    leaves: NDArray[np.bool_]
    """Whether the yarn leaves here, at its last end, shape (2 n,)."""

    @property
    def direction(self) -> FloatArray:
        """Direction away from the middle in the projection, or along x for an end seen at it, shape (2 n, 3)."""
        outwards = self.place * [1.0, 1.0, 0.0]
        outwards[~outwards.any(axis=1)] = [1.0, 0.0, 0.0]
        return outwards


def open_yarn_crossings(projection: ProjectedPolylines, closed: NDArray[np.bool_]) -> IntArray:
    """Return the codes of the crossings of lines with yarns, and of arcs with the lines that they pass above."""
    ends = _ends(projection, np.flatnonzero(~closed))
    lines = EndLines()
    device = projection.vertices.device
    lines.angle = wp.array(np.append(_angle(ends.direction), 3.0), dtype=wp.float64, device=device)
    lines.end = wp.array(ends.place, dtype=wp.vec3d, device=device)
    lines.direction = wp.array(ends.direction, dtype=wp.vec3d, device=device)
    square = (ends.place[:, :2] ** 2).sum(axis=1)
    lines.distance = wp.array(square * (1.0 - 1e-12), dtype=wp.float64, device=device)  # more than rounding removes
    lines.yarn = wp.array(ends.yarn, dtype=wp.int32, device=device)
    lines.outwards = wp.array(np.where(ends.leaves, 1, -1), dtype=wp.int32, device=device)

    def find(crossings: Any) -> None:
        inputs = [wp.vec3d(*projection.middle), projection.vertices, projection.edge_yarn, lines]
        launch(find_line_crossings, projection.edge_yarn.shape[0], inputs, [crossings], device)

    return np.concatenate([collected(projection, find), encoded(projection, *_arc_crossings(ends))])


def _ends(projection: ProjectedPolylines, yarn: IntArray) -> OpenEnds:
    index = np.concatenate([projection.yarn_edge[yarn], projection.yarn_edge[yarn + 1]]) + np.tile(yarn, 2)
    device = projection.vertices.device
    place = projection.vertices[wp.array(index, dtype=wp.int32, device=device)].numpy() - projection.middle
    ends = OpenEnds(place, np.tile(yarn, 2), np.arange(len(index)) >= len(yarn))
    order = _order_around(ends)
    return OpenEnds(place[order], ends.yarn[order], ends.leaves[order])


def _angle(direction: FloatArray) -> FloatArray:
    """``angle_of`` each direction."""
    x, y = direction[:, 0], direction[:, 1]
    part = y / (np.abs(x) + np.abs(y))
    return np.where(x >= 0.0, part, np.where(y >= 0.0, 2.0, -2.0) - part)


def _order_around(ends: OpenEnds) -> list[int]:
    """Return the exact order of the ends by angle; at equal angles a later line counts as moved (``is_left``)."""
    direction = ends.direction
    x, y = direction[:, 0], direction[:, 1]
    aside = np.where(y != 0.0, -np.sign(y), np.sign(x)) * ends.yarn
    exact = [Fraction(int(b), int(abs(a) + abs(b))) * (1 if a >= 0.0 else -1) for a, b in zip(x, y, strict=True)]
    keys = list(zip(_angle(direction).tolist(), exact, aside.tolist(), strict=True))
    return sorted(range(len(keys)), key=keys.__getitem__)


def _arc_crossings(ends: OpenEnds) -> tuple[IntArray, IntArray]:
    """Return the pairs of open yarns whose earlier arc passes above just one line of the later one, and the sign."""
    order = np.lexsort((ends.leaves, ends.yarn))  # of each yarn where it returns, then where it leaves
    returns, leaves = order[0::2], order[1::2]
    one, two = _interleaved(np.minimum(returns, leaves), np.maximum(returns, leaves))
    earlier, later = np.minimum(one, two), np.maximum(one, two)
    begin, end = leaves[earlier], returns[earlier]
    inside = (np.minimum(begin, end) < leaves[later]) & (leaves[later] < np.maximum(begin, end))
    # the arc turns counter-clockwise where it ends later: a line that leaves outwards passes it from left to right
    sign = np.where(end > begin, 1, -1) * np.where(inside, -1, 1)
    yarn = ends.yarn[order[0::2]]
    return np.stack([yarn[earlier], yarn[later]], axis=1), sign


def _interleaved(low: IntArray, high: IntArray) -> tuple[IntArray, IntArray]:
    """Return all pairs of intervals in which only the low end of the second lies in the first.

    The ends are the numbers from 0 to 2 n - 1. A descent in a tree of maxima finds the ends within an interval that
    begin an interval reaching beyond it, in time that grows with their number and n log n.
    """
    partner = np.full(1 << (2 * len(low) - 1).bit_length(), -1)
    partner[low] = high
    owner = np.zeros(len(partner), dtype=np.int64)
    owner[low] = np.arange(len(low))
    levels = [partner]
    while len(levels[-1]) > 1:
        levels.append(levels[-1].reshape(-1, 2).max(axis=1))
    interval: IntArray = np.arange(len(low))
    node: IntArray = np.zeros(len(low), dtype=np.int64)
    for depth in range(len(levels) - 2, -1, -1):
        interval = np.repeat(interval, 2)
        node = (2 * node[:, None] + np.array([0, 1])).ravel()
        keep = (node << depth < high[interval]) & ((node + 1) << depth > low[interval] + 1)
        keep &= levels[depth][node] > high[interval]
        interval, node = interval[keep], node[keep]
    return interval, owner[node]
