# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Places at which limbs join or part, and an added row where limbs would join and part within one row.

A row lies between two neighbouring level lines of the time. It joins several limbs to one, or parts one into several.
A band has several lines on both of its sides where a hole begins beside the end of another hole, or where the bar
between two holes is lower than a row. The time is then stretched around this band, so that one more level lies between
the joins and the parts. Joins and parts that are equally high are first moved apart by a part of a row.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from stitchmesh.mesh import FloatArray, IntArray
from stitchmesh.shaping.ends import Ends
from stitchmesh.shaping.level_lines import Band, LevelLines, level_lines, lines_between
from stitchmesh.shaping.triangle_surface import TriangleSurface

STRETCHED = 3
"""Rows below and above a band over which one more row is spread, as far as no row ends there."""
APART = 0.15
"""Least difference between the time of a join and the level that lies between it and the parts, in courses."""


@dataclass(frozen=True)
class Branchings:
    """Places at which limbs meet."""

    joins: IntArray
    """Vertices at which several lines become one above them, shape (n,)."""
    parts: IntArray
    """Vertices at which one line becomes several above them, shape (m,)."""


def with_joins_and_parts_apart(
    surface: TriangleSurface, time: FloatArray, ends: Ends, course_height: float
) -> tuple[LevelLines, FloatArray]:
    """Return the lines of a time, and the time with rows added where limbs would join and part within one row.

    Args:
        surface: a connected surface.
        time: time of each vertex in courses, shape (V,).
        ends: the ends, at whole numbers of courses.
        course_height: height of a course [cm].

    Returns:
        The lines and the bands, and the time, shape (V,). Bands that cannot be divided stay as they are.
    """
    levels = level_lines(surface, time, ends)
    # Number of rows that are added at most.
    for _ in range(12):
        mixed = [band for band in levels.bands if len(band.below) > 1 and len(band.above) > 1]
        stretched = next((t for band in mixed if (t := _divided(surface, time, ends, _level(levels, band),
                                                                course_height)) is not None), None)  # fmt: skip
        if stretched is None:
            break
        time = stretched
        levels = level_lines(surface, time, ends)
    return levels, time


def changes_around(surface: TriangleSurface, values: FloatArray) -> IntArray:
    """Return how often a function changes between higher and lower than at a vertex, around each vertex, shape (V,)."""
    changes = np.zeros(len(values), dtype=np.int64)
    for corner in range(3):
        vertex, one, other = (surface.triangles[:, (corner + turn) % 3] for turn in range(3))
        crossed = (values[one] > values[vertex]) != (values[other] > values[vertex])
        changes += np.bincount(vertex[crossed], minlength=len(values))
    return changes


def branchings(surface: TriangleSurface, time: FloatArray, ends: Ends, level: int) -> Branchings:
    """Find the places from a level to below the next one at which limbs join or part.

    Limbs also part at a piece of a border where loops are bound off while the rows beside it go on, such as the foot of
    a hole. The whole piece has one time, and one of its vertices stands for it.
    """
    inside = (time >= level) & (time < level + 1)
    inside[np.concatenate([end.vertices for end in ends.all])] = False
    borders = np.concatenate([*surface.borders, np.zeros(0, dtype=np.int64)])
    on_border = np.isin(np.arange(len(time)), borders)
    off = [end.vertices[0] for end in ends.lines if on_border[end.vertices].all() and time[end.vertices[0]] == level]
    found = np.flatnonzero(inside & (changes_around(surface, time) >= np.where(on_border, 2, 4)))
    below, above = (
        [_lines_beside(surface, time >= time[v] if up == 0 else time > time[v], int(v)) for v in found] for up in (0, 1)
    )
    return Branchings(
        found[[one > other for one, other in zip(below, above, strict=True)]],
        np.append(found[[one < other for one, other in zip(below, above, strict=True)]], off).astype(np.int64),
    )


def _lines_beside(surface: TriangleSurface, high: NDArray[np.bool_], vertex: int) -> int:
    """Number of lines between the high and the low vertices that cross edges of a vertex."""
    edge, line = lines_between(surface, high)
    return len(np.unique(line[(surface.edges[edge] == vertex).any(axis=1)]))


def _level(levels: LevelLines, band: Band) -> int:
    """The level below a band."""
    return levels.lines[band.below[0]].level


def _divided(
    surface: TriangleSurface, time: FloatArray, ends: Ends, level: int, course_height: float
) -> FloatArray | None:
    """Stretch a time by one course, so that a level lies between the joins and the parts between two levels.

    Returns:
        The time; None if there are no joins and parts between which a level could lie.
    """
    found = branchings(surface, time, ends, level)
    if not len(found.joins) or not len(found.parts):
        return None
    first, then = found.joins, found.parts
    if time[first].mean() > time[then].mean():
        first, then = then, first
    middle = 0.5 * (time[first].max() + time[then].min())
    if time[first].max() + 2.0 * APART > time[then].min():
        middle = min(max(float(time[np.append(first, then)].mean()), level + 2.0 * APART), level + 1.0 - 2.0 * APART)
        moved = time.copy()
        for vertices, sign in ((first, -1.0), (then, 1.0)):
            for vertex in vertices:
                lacking = APART - sign * (time[vertex] - middle)
                # Distance from a join or a part, in courses, at which the motion around it has fallen to 1 / e.
                away = np.linalg.norm(surface.vertices - surface.vertices[vertex], axis=1) / (2.0 * course_height)
                moved += sign * max(lacking, 0.0) * np.exp(-(away**2))
        for end in ends.all:
            moved[end.vertices] = time[end.vertices]
        time = moved
    at_ends = np.array([time[end.vertices[0]] for end in ends.all])
    low = max([level - STRETCHED, *np.ceil(at_ends[at_ends <= level])])
    high = min([level + 1 + STRETCHED, *np.floor(at_ends[at_ends >= level + 1])])
    whole = float(np.clip(np.rint(low + (middle - low) * (high + 1 - low) / (high - low)), low + 1, high))
    return np.asarray(np.interp(time, [low, middle, high], [low, whole, high + 1.0])
                      + np.minimum(time - low, 0.0) + np.maximum(time - high, 0.0))  # fmt: skip
