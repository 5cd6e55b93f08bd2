# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The number of loops in each course of a panel, and the places of increases and decreases.

A stitch takes at most three loops and makes at most three loops, so that the number of loops changes by at most a
factor of three from course to course. Increases and decreases are placed at the wale edges of the panel, or all at the
marked wale edge (Yuksel et al. 2012, section 5.2).
"""

from __future__ import annotations

import numpy as np

from stitchmesh.errors import TessellationError
from stitchmesh.mesh import IntArray

MOST_LOOPS = 3
"""Largest number of loops that one stitch takes or makes."""


def loops_per_course(bottom: int, top: int, courses: int, face: int) -> IntArray:
    """Return the number of loops below each course of a panel and above the last course, shape (courses + 1,).

    Args:
        bottom: number of loops below the first course.
        top: number of loops above the last course.
        courses: number of courses.
        face: number of the panel, for the error message.

    Raises:
        TessellationError: the panel has too few courses for its change of width.
    """
    loops = np.rint(np.linspace(bottom, top, courses + 1)).astype(np.int64)
    loops[1:-1] = np.maximum(loops[1:-1], 1)
    for course in range(1, courses):
        loops[course] = min(loops[course], MOST_LOOPS * loops[course - 1]) if loops[course - 1] else loops[course]
    for course in range(courses - 1, 0, -1):
        loops[course] = min(loops[course], MOST_LOOPS * loops[course + 1]) if loops[course + 1] else loops[course]
    wide, narrow = np.maximum(loops[1:], loops[:-1]), np.minimum(loops[1:], loops[:-1])
    if ((narrow > 0) & (wide > MOST_LOOPS * narrow)).any():
        raise TessellationError(
            f"face {face}: {bottom} stitches at the bottom and {top} at the top within {courses} courses; a stitch "
            f"changes the number of loops by at most a factor of {MOST_LOOPS}: give its edges other counts"
        )
    return loops


def stitch_widths(narrow: int, wide: int, course: int, marked: str) -> IntArray:
    """Return the number of loops of each stitch on the wide side of a course, from left to right, shape (narrow,).

    Args:
        narrow: number of loops on the narrow side of the course, which is the number of stitches.
        wide: number of loops on the wide side, the sum of the result.
        course: number of the course; single increases or decreases alternate between the two ends.
        marked: wale edge at which all increases and decreases are placed, ``"left"`` or ``"right"``; ``""`` for both.
    """
    widths = np.ones(narrow, dtype=np.int64)
    places = _places(narrow, course, marked)
    for change in range(wide - narrow):
        widths[places[change % narrow]] += 1
    return widths


def _places(count: int, course: int, marked: str) -> IntArray:
    """Stitches of a course in the order in which they become increases or decreases."""
    order = np.arange(count)
    if marked == "left":
        return order
    if marked == "right":
        return order[::-1]
    ends = np.empty(count, dtype=np.int64)
    ends[0::2] = order[: (count + 1) // 2]
    ends[1::2] = order[::-1][: count // 2]
    return ends if course % 2 == 0 else count - 1 - ends
