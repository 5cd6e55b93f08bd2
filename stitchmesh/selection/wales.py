# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Columns of stitches, rectangles and panels, which steps along rows and wales find.

A step up leads through a top side of a face to the face above. At an increase, the line of a left border takes the
leftmost loop and the line of a right border the rightmost loop, so that stitches that are increased between the lines
belong to the panel.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from stitchmesh.errors import ParameterError
from stitchmesh.mesh import BORDER, BOTTOM, TOP, FloatArray, IntArray, StitchMesh
from stitchmesh.mesh.courses import course_through
from stitchmesh.selection.parts import FORWARD, LEFT_HAND, UP, Parts, face_centres, perpendicular
from stitchmesh.selection.selection import Rectangle, RectangleBetween, Ring, Wale, WalePanel


def wale_faces(fabric: StitchMesh, wale: Wale) -> IntArray:
    """Return the faces of a column.

    Raises:
        ParameterError: the face or the side does not exist, or the side is not a course side.
    """
    start = _face_above_side(fabric, wale.start) if wale.from_side else _checked(fabric, wale.start)
    faces = [start]
    if wale.direction != "down":
        faces += _line(fabric, start, _above, 0.5, wale.count)[1:]
    if wale.direction != "up":
        faces += _line(fabric, start, _below, 0.5, wale.count)[1:]
    return np.array(faces, dtype=np.int64)


def ring_rows(parts: Parts, ring: Ring) -> IntArray:
    """Return the indices of the row of a face, and of the rows above or below it.

    Raises:
        ParameterError: the face does not exist.
    """
    fabric = parts.fabric
    first = int(parts.row_index[_checked(fabric, ring.face)])
    rows = {first}
    for direction, role in (("up", TOP), ("down", BOTTOM)):
        if ring.direction not in (direction, "both"):
            continue
        level = np.array([first])
        for _ in range(ring.count - 1):
            sides = np.flatnonzero(np.isin(parts.row_index, level)[fabric.side_face] & (fabric.side_role == role))
            across = fabric.twin[sides]
            level = np.setdiff1d(parts.row_index[fabric.side_face[across[across != BORDER]]], list(rows))
            rows |= set(level.tolist())
    return np.array(sorted(rows), dtype=np.int64)


def rectangle_faces(fabric: StitchMesh, rectangle: Rectangle) -> IntArray:
    """Return the faces of the rectangle above and to the right of a face.

    Raises:
        ParameterError: the face does not exist, or the rectangle is wider or higher than the fabric there.
    """
    face = _checked(fabric, rectangle.face)
    row = _rightwards(fabric, face, rectangle.width)
    if len(row) < rectangle.width:
        raise ParameterError(f"{rectangle}: the row ends {len(row)} stitches after face {face}; make it narrower")
    faces, height = _between(fabric, row, rectangle.height)
    if height < rectangle.height:
        raise ParameterError(f"{rectangle}: the wales have {height} rows from face {face} upwards; make it lower")
    return faces


def rectangle_between(fabric: StitchMesh, rectangle: RectangleBetween) -> IntArray:
    """Return the faces of the rectangle between two opposite corners.

    Raises:
        ParameterError: a face does not exist, or no row through one face meets the wale through the other face.
    """
    one, other = _checked(fabric, rectangle.corner), _checked(fabric, rectangle.opposite)
    for low, high in ((one, other), (other, one)):
        course = course_through(fabric, low)
        place = {face: k for k, face in enumerate(course.faces)}
        down = _line(fabric, high, _below, 0.5, None)
        foot = next((k for k, face in enumerate(down) if face in place), None)
        if foot is None:
            continue
        count = len(course.faces)
        steps = place[down[foot]] - place[low]
        if course.closed and abs(steps) * 2 > count:
            steps -= int(np.sign(steps)) * count
        left = low if steps >= 0 else down[foot]
        return _between(fabric, _rightwards(fabric, left, abs(steps) + 1), foot + 1)[0]
    raise ParameterError(f"{rectangle}: the wale through one face does not meet the row through the other face")


def panel_faces(parts: Parts, panel: WalePanel) -> IntArray:
    """Return the faces of the wales in the middle of the front, the back, the left or the right.

    The panel begins in the first row that runs around or faces the side. It is as wide as its wales; where stitches are
    decreased in it, it becomes narrower.

    Raises:
        ParameterError: the first row has fewer stitches than the panel has wales.
    """
    fabric = parts.fabric
    row = _middle_of_row(parts, panel)
    if len(row) < panel.width:
        raise ParameterError(f"{panel}: the row there has {len(row)} stitches; make the panel narrower")
    return _between(fabric, row, None)[0]


def _middle_of_row(parts: Parts, panel: WalePanel) -> list[int]:
    """Return the faces of the panel in the first row, from left to right."""
    fabric = parts.fabric
    course = course_through(fabric, int(fabric.row.argmin()))
    faces = np.array(course.faces)
    if panel.width > len(faces):
        return faces.tolist()
    if not parts.runs_around[0]:
        start = (len(faces) - panel.width) // 2
        return faces[start : start + panel.width].tolist()
    position = face_centres(fabric, faces)
    forward, leftward = _directions(position)
    towards, across = {
        "front": (forward, leftward), "back": (-forward, leftward), "left": (leftward, forward),
        "right": (-leftward, forward),
    }[panel.side]  # fmt: skip
    aside = np.abs(_window_sums(_from_middle(position @ across), panel.width))
    outside = _window_sums(_from_middle(position @ towards), panel.width) > 0.0
    aside = np.where(outside, aside, np.inf)
    if not course.closed:
        aside[len(faces) - panel.width + 1 :] = np.inf  # These windows would cross the ends of the row.
    best = int(np.flatnonzero(aside <= aside.min() + parts.fabric.rounding * panel.width)[0])
    return np.roll(faces, -best)[: panel.width].tolist()


def middle_of_front(row: FloatArray, closed: bool) -> float:
    """Return the place in the middle of the front of a row of points; the middle of the row if it is not a ring.

    Args:
        row: points from left to right, shape (n, 3).
        closed: whether the row is a ring.

    Returns:
        The number of points before the place, a multiple of one half: k + 0.5 is point k, and k lies midway between
        the points k - 1 and k.
    """
    if not closed:
        return len(row) / 2
    forward, leftward = _directions(row)
    across, depth = _from_middle(row @ leftward), _from_middle(row @ forward)
    following = np.roll(across, -1)
    passes = np.flatnonzero((across > 0.0) != (following > 0.0))
    foremost = int(passes[np.argmax((depth + np.roll(depth, -1))[passes])])
    share = across[foremost] / (across[foremost] - following[foremost])
    return float(np.round(2.0 * (foremost + share + 0.5)) / 2.0) % len(row)


def _directions(ring: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return the directions forward and to the left that are perpendicular to the axis of a ring of points."""
    offset = ring - ring.mean(axis=0)
    axis = np.cross(offset, np.roll(offset, -1, axis=0)).sum(axis=0)
    axis /= np.linalg.norm(axis)
    forward = perpendicular(FORWARD, axis, UP)
    leftward = np.cross(axis, forward)
    return forward, leftward if leftward @ LEFT_HAND >= 0.0 else -leftward  # A row knitted downwards points down.


def _from_middle(values: FloatArray) -> FloatArray:
    """Return coordinates relative to the middle between the smallest and the largest one."""
    return values - (values.min() + values.max()) / 2


def _window_sums(values: FloatArray, width: int) -> FloatArray:
    """Return the sum of the values of a ring over each window of neighbours, by the first place of the window."""
    return np.convolve(np.concatenate([values, values[: width - 1]]), np.ones(width), mode="valid")


def _checked(fabric: StitchMesh, face: int) -> int:
    if not 0 <= face < fabric.face_count:
        raise ParameterError(f"face {face}: does not exist; the mesh has faces 0 to {fabric.face_count - 1}")
    return face


def _face_above_side(fabric: StitchMesh, side: int) -> int:
    """Return the face above the course edge of a side; at a border, no face lies above a top side."""
    if not 0 <= side < fabric.side_count:
        raise ParameterError(f"side {side}: does not exist; the mesh has sides 0 to {fabric.side_count - 1}")
    role = fabric.role_of(side)
    if role not in (BOTTOM, TOP):
        raise ParameterError(f"{fabric.side_name(side)}: is a wale side; expected a course side")
    across = int(fabric.twin[side])
    above = side if role == BOTTOM else across
    if above == BORDER or fabric.role_of(above) != BOTTOM:
        raise ParameterError(f"{fabric.side_name(side)}: has no face above it")
    return int(fabric.side_face[above])


def _above(fabric: StitchMesh, face: int, share: float) -> int:
    """Return the face above a face, through its leftmost (share 0), rightmost (1) or middle loop (0.5)."""
    count = int(fabric.n_top[face])
    if count == 0:
        return BORDER
    return _across(fabric, int(fabric.left_wale[face]) - 1 - round(share * (count - 1)), BOTTOM)


def _below(fabric: StitchMesh, face: int, share: float) -> int:
    """Return the face below a face; ``share`` means the same as in ``_above``."""
    count = int(fabric.n_bottom[face])
    if count == 0:
        return BORDER
    return _across(fabric, int(fabric.face_start[face]) + round(share * (count - 1)), TOP)


def _across(fabric: StitchMesh, side: int, role: int) -> int:
    across = int(fabric.twin[side])
    return int(fabric.side_face[across]) if across != BORDER and fabric.role_of(across) == role else BORDER


def _line(
    fabric: StitchMesh, start: int, step: Callable[[StitchMesh, int, float], int], share: float, count: int | None
) -> list[int]:
    """Return the faces of a line of steps from a face; a line that returns to its start ends there."""
    faces = [start]
    while (count is None or len(faces) < count) and (following := step(fabric, faces[-1], share)) != BORDER:
        if following == start:
            break
        faces.append(following)
    return faces


def _rightwards(fabric: StitchMesh, face: int, count: int) -> list[int]:
    """Return a face and its right neighbours: at most the given number of faces, and at most one turn around."""
    faces = [face]
    while len(faces) < count:
        across = int(fabric.twin[fabric.right_wale[faces[-1]]])
        other = int(fabric.side_face[across]) if across != BORDER else face
        if across == BORDER or fabric.left_wale[other] != across or other == face:
            break
        faces.append(other)
    return faces


def _between(fabric: StitchMesh, row: list[int], height: int | None) -> tuple[IntArray, int]:
    """Return the faces between the two wale lines from the ends of a piece of a row, and the number of rows."""
    left = _line(fabric, row[0], _above, 0.0, height)
    right = _line(fabric, row[-1], _above, 1.0, height)
    faces: list[int] = []
    rows = 0
    widest = 4 * len(row) + 8
    for first, last in zip(left, right, strict=False):
        piece = _rightwards(fabric, first, widest)
        if last not in piece:
            break
        faces += piece[: piece.index(last) + 1]
        rows += 1
    return np.array(faces, dtype=np.int64), rows
