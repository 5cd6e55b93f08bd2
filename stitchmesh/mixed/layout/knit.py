# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""A knit laid out on the panels of a cloth, with four nodes for each loop.

The loop. Cirio et al. 2017 give a knit two nodes for each stitch contact and about four nodes for each loop. A loop has
four stitch contacts: two with the loop through which it is drawn, and two with the loop that is drawn through it. We
chose the places of the two nodes of a contact: they are the two crossings of the yarns as seen from the front, at the
left and at the right of the loop. On each side of a knit stitch

* at P the new loop comes from the link to its neighbour and passes behind the leg of the old loop, and
* at Q the leg of the new loop passes in front of the head of the old loop.

A purl stitch is the same with front and back exchanged. Both yarns run directly from P to Q, up on the left side and
down on the right side. Along its yarn a loop has the nodes

    P Q of the old loop at the left, P Q Q P of the new loop, Q P of the old loop at the right

with the head of the loop between Q and Q in the middle. The places follow from the closed curve of Crane 2023 for a
plain loop,

    x = t + 3/2 sin 2t,  y = 4 cos t  [wale spacing 2 pi, course spacing 9/2]

This curve crosses its copy one course higher at the points ``P`` and ``Q`` below, which are given in wale and course
spacings. The four nodes are then nearly evenly spaced along the yarn. Rest lengths are the lengths of the polygon
through the nodes, so a knit is laid out without tension.

The panels. Loop (i, j) of a panel lies in the cell from (j, i) to (j + 1, i + 1), in units of wale and course spacing.
The line through the middle of a course is clipped at the border of the panel. Each piece of it is one yarn, with the
loops of which it passes at least half of the cell. The lines through the nodes P and Q are clipped too, and the
outermost cells end at the border there. These cells are narrower or wider than the others, from half a wale spacing to
less than two, so that the loops leave no opening beside the border. A stitch contact exists where both of its loops
exist. On a seam, the yarn of a course is joined to the rod where it ends, at the head of each loop through which no
loop is drawn, and between the feet of two loops that are drawn through no loop.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from stitchmesh.errors import ParameterError
from stitchmesh.mesh import FloatArray, IntArray
from stitchmesh.mixed.cloth.cloth import Cloth
from stitchmesh.mixed.layout.crossing_yarns import WEFT, CrossingYarns, Joints, LaidNodes, Passages, joined
from stitchmesh.mixed.layout.embedding import NO_TRIANGLE, embed_points
from stitchmesh.mixed.layout.panel_yarns import ClippedLines, PanelYarns, clipped_lines, yarns_on_cloth

P = (0.3047882717353637, -0.3428759934355383)
"""Distance of the node P from the middle of the loop, in wale spacings, and its height above the border between the new
and the old loop, in course spacings."""
Q = (0.1952117282646363, 0.3428759934355383)
"""The same numbers for the node Q."""
NODES = np.array([[-P[0], P[1]], [-Q[0], Q[1]], [Q[0], Q[1]], [P[0], P[1]]])
"""The four nodes of the contacts of a new loop with its old loop: P and Q at the left, Q and P at the right."""
SLOTS = 8
"""Nodes of a loop along its yarn."""
HEAD, FOOT = 3.5, -0.5
"""Places along the yarn at which a loop is joined to a rod: at its head, and before its left foot."""
NARROWEST = 0.5
"""Smallest width of a loop beside a border, in wale spacings."""


@dataclass(frozen=True, eq=False)
class _Loops:
    """The loops of a panel, course by course and from left to right."""

    course: IntArray
    wale: IntArray
    yarn: IntArray
    """Piece of a course to which each loop belongs."""
    below: IntArray
    """The loop below each loop, -1 if there is none."""


def lay_knit(cloth: Cloth, knit: ArrayLike, *, wale_spacing: float, course_spacing: float) -> CrossingYarns:
    """Lay a chart of knit and purl stitches out on all panels of a cloth; courses run along x, wales along y.

    Args:
        cloth: the cloth.
        knit: whether each stitch of one repeat of the chart is a knit stitch, not a purl stitch, seen from outside,
            shape (rows, columns); the last row is knitted first, as charts are written.
        wale_spacing: distance of two wales [cm].
        course_spacing: distance of two courses [cm].

    Raises:
        ParameterError: the chart is empty, a spacing is not positive, or no loop is drawn through another one.
    """
    chart = _checked_chart(knit)
    spacing = np.array([checked_spacing("wale", wale_spacing), checked_spacing("course", course_spacing)])
    panels = [_panel_yarns(cloth, panel, spacing, chart) for panel in range(len(cloth.panel_names))]
    return yarns_on_cloth("knit", cloth, panels, 0.25 * float(spacing.min()))  # nodes of a rod keep this distance


def _panel_yarns(cloth: Cloth, panel: int, spacing: FloatArray, chart: NDArray[np.bool_]) -> PanelYarns:
    """The courses of a panel."""
    courses = clipped_lines(cloth, panel, 0, float(spacing[1]))
    loops = _loops(courses, float(spacing[0]))
    nodes, linked = _nodes(cloth, panel, loops, spacing, chart)
    joints = joined(_joints(cloth, panel, courses, loops, linked, spacing))
    family = np.full(len(courses.line), WEFT)
    return PanelYarns(nodes, _passages(loops, linked, nodes), family, joints, contacts_of_links(nodes.count))


def contacts_of_links(node_count: int) -> IntArray:
    """Return the nodes of stitch contacts, from nodes in the order of ``NODES``; left and right in turn, (C, 2)."""
    return np.arange(node_count).reshape(-1, 4)[:, [[0, 1], [3, 2]]].reshape(-1, 2)


def _checked_chart(knit: ArrayLike) -> NDArray[np.bool_]:
    chart = np.asarray(knit)
    if chart.ndim != 2 or not chart.size:
        raise ParameterError(f"knit: got a chart of shape {chart.shape}; expected (rows, columns)")
    if not np.isin(chart, (0, 1)).all():
        raise ParameterError("knit: got numbers other than 0 and 1; expected 1 for a knit and 0 for a purl stitch")
    return chart.astype(np.bool_)


def checked_spacing(name: str, spacing: float) -> float:
    """Return a spacing.

    Raises:
        ParameterError: it is not a positive number of cm.
    """
    if not (math.isfinite(spacing) and spacing > 0.0):
        raise ParameterError(f"knit: {name} spacing: got {spacing}; expected a positive number of cm")
    return spacing


def _loops(courses: ClippedLines, width: float) -> _Loops:
    """The loops that have at least half of their cell within the pieces of the courses."""
    ends = courses.ends / width
    first = np.ceil(ends[:, 0] - 0.5 - 1e-9).astype(np.int64)
    last = np.floor(ends[:, 1] + 0.5 + 1e-9).astype(np.int64)
    count = np.where(ends[:, 1] - ends[:, 0] > NARROWEST - 1e-9, np.maximum(last - first, 0), 0)
    yarn = np.repeat(np.arange(len(count)), count)
    wale = first[yarn] + np.arange(len(yarn)) - np.repeat(np.cumsum(count) - count, count)
    course = courses.line[yarn]
    return _Loops(course, wale, yarn, _loop_at(course, wale, course - 1, wale))


def _loop_at(course: IntArray, wale: IntArray, wanted_course: IntArray, wanted_wale: IntArray) -> IntArray:
    """Return the loop at each wanted place, -1 if there is none; loops ascend by course and wale."""
    if not len(course):
        return np.zeros(len(wanted_course), dtype=np.int64)
    low, stride = wale.min() - 1, int(np.ptp(wale)) + 3
    key, wanted = course * stride + wale - low, wanted_course * stride + wanted_wale - low
    place = np.minimum(np.searchsorted(key, wanted), len(key) - 1)
    return np.where(key[place] == wanted, place, -1)


def _nodes(
    cloth: Cloth, panel: int, loops: _Loops, spacing: FloatArray, chart: NDArray[np.bool_]
) -> tuple[LaidNodes, IntArray]:
    """The nodes of all stitch contacts of a panel, four for each loop drawn through another one; and these loops."""
    linked = np.flatnonzero(loops.below >= 0)
    cells = {height: _cells(cloth, panel, loops, linked, spacing, height) for height in (P[1], Q[1])}
    low, high = (np.stack([cells[height][end] for height in NODES[:, 1]], axis=1) for end in (0, 1))
    wide = (high - low > NARROWEST - 1e-9).all(axis=1)
    linked, low, high = linked[wide], low[wide], high[wide]
    along = low + (0.5 + NODES[:, 0]) * (high - low)
    position = (np.stack([along, loops.course[linked, None] + NODES[:, 1]], axis=-1) * spacing).reshape(-1, 2)
    found = embed_points(cloth, np.full(len(position), panel), position)
    held = (found.triangle != NO_TRIANGLE).reshape(-1, 4).all(axis=1)
    kept = np.repeat(held, 4)
    linked = linked[held]
    is_knit = chart[(-1 - loops.course[linked]) % len(chart), loops.wale[linked] % chart.shape[1]]
    side = np.where(is_knit, 1, -1)[:, None] * np.array([-1, 1, 1, -1])
    count = 4 * len(linked)
    laid = LaidNodes(
        np.full(count, panel), position[kept], found.triangle[kept], found.barycentric[kept], side.ravel(),
        np.zeros((count, 2)),
    )  # fmt: skip
    return laid, linked


def _cells(
    cloth: Cloth, panel: int, loops: _Loops, some: IntArray, spacing: FloatArray, height: float
) -> tuple[FloatArray, FloatArray]:
    """Where the cells of loops begin and end along the line at a height over their courses, in wale spacings.

    The outermost cells end at the border of the panel if it is less than one wale spacing beyond them. Cells whose
    middle lies outside have no width.
    """
    course, wale = loops.course[some], loops.wale[some]
    lines = clipped_lines(cloth, panel, 0, float(spacing[1]), height)
    piece = lines.piece_at(course, (wale + 0.5) * spacing[0])
    border = lines.ends[piece] / spacing[0] if len(lines.line) else np.zeros((len(some), 2))
    beside = (course[1:] == course[:-1]) & (wale[1:] == wale[:-1] + 1)
    first, last = ~np.concatenate([[False], beside])[: len(some)], ~np.append(beside, False)[: len(some)]
    low = np.where(first & (wale - border[:, 0] < 1.0), border[:, 0], np.maximum(wale, border[:, 0]))
    high = np.where(last & (border[:, 1] - wale < 2.0), border[:, 1], np.minimum(wale + 1.0, border[:, 1]))
    return low, np.where(piece >= 0, high, low)


def _passages(loops: _Loops, linked: IntArray, laid: LaidNodes) -> Passages:
    """Each node as u along the yarn of its new loop, and as v along the yarn of its old loop."""
    place = SLOTS * loops.wale
    as_new = place[linked, None] + np.array([0, 1, 6, 7])  # of the slots of a loop
    as_old = place[loops.below[linked], None] + np.array([2, 3, 4, 5])
    order = np.concatenate([as_new.ravel(), as_old.ravel()])
    yarn = np.concatenate([loops.yarn[linked], loops.yarn[loops.below[linked]]])
    node = np.tile(np.arange(laid.count), 2)
    return Passages(
        np.repeat(yarn, 4),
        order.astype(np.float64),
        node,
        np.repeat([0, 1], laid.count),
        laid.position[node],
    )


def _joints(
    cloth: Cloth, panel: int, courses: ClippedLines, loops: _Loops, linked: IntArray, spacing: FloatArray
) -> list[Joints]:
    """Places where the yarns of a panel reach its border: at both ends, at open heads, and between open feet."""
    piece = np.repeat(np.arange(len(courses.line)), 2)
    order = np.tile([-1e15, 1e15], len(courses.line))  # before and after all loops
    ends = Joints(piece, order, courses.border.ravel(), courses.part.ravel())
    drawn, holds = np.zeros((2, len(loops.wale)), dtype=np.bool_)
    drawn[linked] = True
    holds[loops.below[linked]] = True
    heads = np.flatnonzero(~holds)
    feet = np.flatnonzero(~drawn)
    feet = feet[(feet > 0) & (loops.yarn[feet - 1] == loops.yarn[feet])]
    above = _reached(clipped_lines(cloth, panel, 1, float(spacing[0])), loops, heads, spacing, HEAD)
    below = _reached(clipped_lines(cloth, panel, 1, float(spacing[0]), 0.0), loops, feet, spacing, FOOT)
    return [ends, above, below]


def _reached(lines: ClippedLines, loops: _Loops, some: IntArray, spacing: FloatArray, slot: float) -> Joints:
    """Places where lines up from the middle of loops, or down from their left feet, reach a border that is near."""
    end = 1 if slot == HEAD else 0
    level = (loops.course[some] + 0.5) * spacing[1]
    piece = lines.piece_at(loops.wale[some], level)
    some, level, piece = some[piece >= 0], level[piece >= 0], piece[piece >= 0]
    near = np.abs(lines.ends[piece, end] - level) <= 1.5 * spacing[1]  # farther loops are not joined to the seam
    some, piece = some[near], piece[near]
    order: FloatArray = SLOTS * loops.wale[some] + np.float64(slot)
    return Joints(loops.yarn[some], order, lines.border[piece, end], lines.part[piece, end])
