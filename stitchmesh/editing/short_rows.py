# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Two short rows over a run of stitches: back, and out again.

The yarn works the run, turns, works back over the new loops, turns, works the run a third time, and goes on in its row.
All three passes belong to the row: the lower one continues the stitches before the run, the upper one leads to the
stitches after it. Where an end of the run lies inside the fabric, the ends of two of the three rows form a slit, a
border of two sides, which narrows the short rows to a point. Where the end lies at a border, all three rows end there.

A round is worked from right to left. With the first run, the round begins and ends at the left end of that run, and the
two short rows have the next row number, so that the rows can still be knitted one after another. A flat row is worked
from the end at which it is joined to the row below, so that its yarn stays whole, and all its stitches keep its number.
"""

from __future__ import annotations

from collections.abc import Hashable, Sequence
from dataclasses import dataclass

import numpy as np

from stitchmesh.editing.fitting import plain_stitch_named
from stitchmesh.editing.row_edits import renumber_rows
from stitchmesh.editing.sides import check_face
from stitchmesh.editing.sketch import Sketch, SketchFace, face_like
from stitchmesh.errors import ParameterError
from stitchmesh.mesh import BORDER, FloatArray, StitchMesh
from stitchmesh.mesh.change import Change, apply_change
from stitchmesh.mesh.courses import Course, course_through
from stitchmesh.mesh.stitch import Stitch
from stitchmesh.mesh.turns import tip_beside

LOWER_LINE, UPPER_LINE = 1 / 3, 2 / 3
"""Heights of the two new course lines, as fractions of the height of the row."""


@dataclass(frozen=True)
class ShortRowRun:
    """Neighbouring stitches of a row that get short rows."""

    faces: tuple[int, ...]
    """Faces from left to right."""
    left_border: bool
    """Whether the row ends at the left end of the run."""
    right_border: bool
    """Whether the row ends at the right end of the run."""
    from_left: bool
    """Whether the row is worked from left to right."""
    in_rounds: bool
    """Whether the row is a closed round."""


def short_rows(fabric: StitchMesh, faces: Sequence[int], stitch: str = "k") -> list[Change]:
    """Add two short rows above each run of neighbouring stitches.

    Twists and cables stay with the loops of the old stitches. In a flat row the new stitches have the row number of the
    old ones. In a round they have the next number, and the numbers of the rows above increase by one.

    Args:
        fabric: a mesh of stitches.
        faces: the stitches; neighbours in a row form a run.
        stitch: code of the new stitches; the stitch must have one loop below and one above.

    Raises:
        ParameterError: there is no face, a face does not exist, the stitch does not fit, or a run is a whole row, has
            fewer than two loops, has a stitch without a loop, or would have a slit that meets a border.
    """
    if len(faces) == 0:
        raise ParameterError("faces: got none; expected the stitches that short rows are worked over")
    for face in faces:
        check_face(fabric, face)
    made = plain_stitch_named(stitch, "a short row")
    changes: list[Change] = []
    left = set(faces)
    while left:
        run = _run(fabric, course_through(fabric, min(left)), left)
        left -= set(run.faces)
        more, fabric = _add_short_rows(fabric, run, made)
        changes += more
    return changes


def _add_short_rows(fabric: StitchMesh, run: ShortRowRun, stitch: Stitch) -> tuple[list[Change], StitchMesh]:
    """Add the short rows of one run; return the changes, and the mesh after them."""
    row = int(fabric.row[run.faces[0]])
    changes, fabric = renumber_rows(fabric, (fabric.row > row) & run.in_rounds, 1)
    sketch = Sketch(fabric)
    _check_run(sketch, run)
    _knit_short_rows(sketch, run, stitch, row + run.in_rounds)
    changes.append(sketch.patch())
    return changes, apply_change(fabric, changes[-1])


def _run(fabric: StitchMesh, course: Course, chosen: set[int]) -> ShortRowRun:
    """The first run of neighbours among the chosen faces of a course.

    Raises:
        ParameterError: all faces of the course are chosen.
    """
    faces = course.faces
    inside = np.array([face in chosen for face in faces])
    if inside.all():
        raise ParameterError(
            f"face {faces[0]}: its whole row is chosen; expected a part of it (insert_row adds whole rows)"
        )
    first = int(np.flatnonzero(inside & ~np.roll(inside, 1))[0]) if course.closed else int(np.flatnonzero(inside)[0])
    following = np.roll(inside, -first)[: len(faces) if course.closed else len(faces) - first]
    count = len(following) if following.all() else int(np.argmin(following))
    return ShortRowRun(
        faces=tuple(faces[(first + place) % len(faces)] for place in range(count)),
        left_border=not course.closed and _ends_at_border(fabric, course, first, 0),
        right_border=not course.closed and _ends_at_border(fabric, course, first + count - 1, -1),
        from_left=not course.closed and not _is_joined_at_right(fabric, course),
        in_rounds=course.closed,
    )


def _ends_at_border(fabric: StitchMesh, course: Course, place: int, end: int) -> bool:
    """Return whether the left end (0) or the right end (-1) of a row is at a place of its course, and at a border."""
    face = course.faces[place]
    side = fabric.left_wale[face] if end == 0 else fabric.right_wale[face]
    return face == course.faces[end] and bool(fabric.twin[side] == BORDER)


def _is_joined_at_right(fabric: StitchMesh, course: Course) -> bool:
    """Return whether the yarn of a flat row comes from the row below at the right end (``yarngen.row_ends``).

    Rows that end above each other at a right border are joined in pairs there, the first to the second.
    """
    side = start = int(fabric.right_wale[course.faces[-1]])
    if fabric.twin[start] != BORDER:
        return True
    below = 0
    while (lower := _row_end_below(fabric, side)) not in (BORDER, start):
        side, below = lower, below + 1
    return below % 2 == 1


def _row_end_below(fabric: StitchMesh, side: int) -> int:
    """Return the right end of the row below a row that ends at a border; ``BORDER`` if there is none."""
    lower = fabric.previous_border_side(side)
    stacked = fabric.twin[fabric.side_next[lower]] == fabric.side_previous[side]
    return lower if stacked else BORDER


def _check_run(sketch: Sketch, run: ShortRowRun) -> None:
    """Check that a run has loops to work, and room for its slits.

    Raises:
        ParameterError: the run has no loops to work, or no room for its slits.
    """
    fabric = sketch.fabric
    tops = fabric.n_top[list(run.faces)]
    for face, count in zip(run.faces, tops.tolist(), strict=True):
        if count == 0:
            raise ParameterError(f"face {face}: makes no loop that a short row could take; leave it out")
    if tops.sum() < 2:
        raise ParameterError(f"face {run.faces[0]}: a run of one loop; expected two or more (or the edit bobble)")
    first, last = sketch.face(run.faces[0]), sketch.face(run.faces[-1])
    slits = [] if run.left_border else [first.high[0] if run.from_left else first.low[0]]
    slits += [] if run.right_border else [last.low[-1] if run.from_left else last.high[-1]]
    for vertex in slits:
        if sketch.corners.is_on_border(vertex):
            raise ParameterError(
                f"{first.name}: an end of its short rows meets a border in vertex {vertex}; move that end by a stitch"
            )


def _knit_short_rows(sketch: Sketch, run: ShortRowRun, stitch: Stitch, row: int) -> None:
    """Shorten the faces of a run to the lower course line, and add two rows of stitches above the line."""
    faces = [sketch.face(number) for number in run.faces]
    low, high = _course_line(sketch, faces), [faces[0].high[0], *(v for face in faces for v in face.high[1:])]
    lower, upper = _lines(sketch, run, low, high)
    tops = [edge for face in faces for edge in face.above]
    owners = [face for face in faces for _ in face.above]
    name = faces[0].name
    first: list[Hashable] = [(name, "first line", place) for place in range(len(tops))]
    second: list[Hashable] = [(name, "second line", place) for place in range(len(tops))]
    wales = _wales(run, faces, len(tops))
    for place, (top, owner) in enumerate(zip(tops, owners, strict=True)):
        for level, line, next_line, below, above in (
            (1, lower, upper, first[place], second[place]), (2, upper, high, second[place], top),
        ):  # fmt: skip
            sketch.add(
                face_like(
                    owner, low=line[place : place + 2], high=next_line[place : place + 2], below=[below], above=[above],
                    left=wales[level][place], right=wales[level][place + 1], stitch=stitch,
                    row=row,
                )
            )  # fmt: skip
    start = 0
    for face in faces:
        count = len(face.above)
        face.high, face.above = lower[start : start + count + 1], first[start : start + count]
        start += count
    faces[0].left, faces[-1].right = wales[0][0], wales[0][-1]


def _wales(run: ShortRowRun, faces: list[SketchFace], count: int) -> list[list[Hashable]]:
    """Return names of the wale edges of the lower, the middle and the upper row, from left to right.

    Only the ends of the lower row are used. The old edge beside the run goes to the lower row at the end where the yarn
    comes in, and to the upper row at the other end.
    """
    name = faces[0].name
    wales: list[list[Hashable]] = [[(name, level, place) for place in range(count + 1)] for level in range(3)]
    wales[0 if run.from_left or run.left_border else 2][0] = faces[0].left
    wales[2 if run.from_left and not run.right_border else 0][-1] = faces[-1].right
    return wales


def _course_line(sketch: Sketch, faces: list[SketchFace]) -> FloatArray:
    """Return a point at the bottom for each vertex along the tops of faces [cm], shape (loops + 1, 3)."""
    points = [sketch.position(faces[0].low[0])]
    for face in faces:
        ends = sketch.position(face.low[0]), sketch.position(face.low[-1])
        count = len(face.above)
        points += [ends[0] + (ends[1] - ends[0]) * place / count for place in range(1, count + 1)]
    return np.array(points)


def _lines(sketch: Sketch, run: ShortRowRun, low: FloatArray, high: list[int]) -> tuple[list[int], list[int]]:
    """Add the vertices of the two new course lines, from left to right.

    At the end where the yarn comes in, the lower line begins at the top of the row and the upper line at the tip of the
    slit. At the other end the upper line ends at the bottom of the row and the lower line at the tip.
    """
    tops = np.array([sketch.position(vertex) for vertex in high])
    lines = [[sketch.vertex(point) for point in low[1:-1] + share * (tops - low)[1:-1]]
             for share in (LOWER_LINE, UPPER_LINE)]  # fmt: skip
    for end, inner, at_border, comes_in in (
        (0, 1, run.left_border, run.from_left), (-1, -2, run.right_border, not run.from_left),
    ):  # fmt: skip
        beside = [low[inner] + share * (tops - low)[inner] for share in (LOWER_LINE, UPPER_LINE)]
        if at_border:
            ends = [sketch.vertex(low[end] + share * (tops - low)[end]) for share in (LOWER_LINE, UPPER_LINE)]
        elif comes_in:
            ends = [high[end], sketch.vertex(tip_beside(tops[end], beside[1]))]
        else:
            ends = [sketch.vertex(tip_beside(low[end], beside[0])), _bottom_vertex(sketch, run, end)]
        for line, vertex in zip(lines, ends, strict=True):
            line.insert(0 if end == 0 else len(line), vertex)
    return lines[0], lines[1]


def _bottom_vertex(sketch: Sketch, run: ShortRowRun, end: int) -> int:
    """The lower left (``end`` 0) or the lower right vertex (-1) of a run."""
    return sketch.face(run.faces[end]).low[end]
