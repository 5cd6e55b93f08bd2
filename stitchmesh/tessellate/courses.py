# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""How a panel's stitches change from its bottom to its top, and where increases and decreases go.

A stitch takes at most three loops together and makes at most three of one, so the number of loops changes by a
factor of at most three from course to course. Increases and decreases stand at the panel's wale edges, or all at
the marked one (Yuksel et al. 2012, section 5.2).
"""

from __future__ import annotations

import numpy as np

from stitchmesh.errors import TessellationError
from stitchmesh.mesh import IntArray

MOST_LOOPS = 3
"""Loops that one stitch takes together or makes."""


def loops_per_course(bottom: int, top: int, courses: int, face: int) -> IntArray:
    """Loops below each course of a panel and above the last, shape (courses + 1,).

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
    """Loops on the wide side of each of ``narrow`` stitches, left to right, in sum ``wide``.

    Args:
        narrow: loops on the narrow side of the course.
        wide: loops on the wide side.
        course: number of the course; single changes alternate between the two ends.
        marked: ``"left"`` or ``"right"`` wale edge that takes all changes, ``""`` for both.
    """
    widths = np.ones(narrow, dtype=np.int64)
    places = _places(narrow, course, marked)
    for change in range(wide - narrow):
        widths[places[change % narrow]] += 1
    return widths


def _places(count: int, course: int, marked: str) -> IntArray:
    """Stitches of a course in the order in which they take changes."""
    order = np.arange(count)
    if marked == "left":
        return order
    if marked == "right":
        return order[::-1]
    ends = np.empty(count, dtype=np.int64)
    ends[0::2] = order[: (count + 1) // 2]
    ends[1::2] = order[::-1][: count // 2]
    return ends if course % 2 == 0 else count - 1 - ends
