# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Changes of a list of marks; each returns another list."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

from stitchmesh.app.pages.rows.mesh_borders import AUTOMATIC, MeshBorders, role_after
from stitchmesh.app.project.shaping import Point, plain_mark
from stitchmesh.errors import ParameterError
from stitchmesh.shaping.marks import UNTIMED, TimeMark

Marks = tuple[TimeMark, ...]
"""Marks in the order in which they were made."""


def with_next_role(marks: Marks, borders: MeshBorders, number: int) -> Marks:
    """Return the marks after a click at a border."""
    return with_border_role(marks, borders, number, role_after(borders.role_of(marks, number)))


def with_border_role(marks: Marks, borders: MeshBorders, number: int, role: Any) -> Marks:
    """Return the marks with another role of a border; an automatic one has no mark."""
    mark = borders.mark_of(marks, number)
    if role == AUTOMATIC:
        return marks if mark is None else without_mark(marks, mark)
    if mark is not None:
        return with_role(marks, mark, role)
    return (*marks, TimeMark("border", (borders.point(number),), role))


def with_tip(marks: Marks, point: Point) -> Marks:
    """Return the marks with a tip at which knitting ends."""
    return (*marks, TimeMark("point", (point,), "end"))


def with_line(marks: Marks, points: tuple[Point, ...]) -> Marks:
    """Return the marks with a line along which a row runs.

    Raises:
        ParameterError: the line has a single point.
    """
    if len(points) < 2:
        raise ParameterError("line: has one point; click where it goes on, or put a tip instead")
    return (*marks, TimeMark("stroke", points, "row"))


def with_role(marks: Marks, number: int, role: Any) -> Marks:
    """Return the marks with another role of one; only some roles have a time, and only plain places a radius.

    Raises:
        ParameterError: the mark cannot have the role.
    """
    mark = marks[number]
    time, radius = None if role in UNTIMED else mark.time, mark.radius if role == "plain" else None
    return _with(marks, number, replace(mark, role=role, time=time, radius=radius))


def with_radius(marks: Marks, number: int, radius: float) -> Marks:
    """Return the marks with another radius of a plain one [cm]; 0 for the usual radius.

    Raises:
        ParameterError: the mark is not plain.
    """
    return _with(marks, number, replace(marks[number], radius=radius or None))


def with_time(marks: Marks, number: int, time: float | None) -> Marks:
    """Return the marks with another time of one [cm]; None for the time that follows from the surface.

    Raises:
        ParameterError: the mark is a side or plain.
    """
    role = marks[number].role
    if role in UNTIMED and time is not None:
        raise ParameterError(f"time: a mark whose role is {role} has none, because many rows pass it")
    return _with(marks, number, replace(marks[number], time=time))


def with_point(marks: Marks, number: int, place: int, point: Point) -> Marks:
    """Return the marks with a point of one at another place.

    Raises:
        ParameterError: the mark is a border.
    """
    mark = marks[number]
    if mark.kind == "border":
        raise ParameterError("move: a border has no points; choose a tip or a line")
    points = [*mark.points[:place], point, *mark.points[place + 1 :]]
    return _with(marks, number, plain_mark(replace(mark, points=points)))


def without_point(marks: Marks, number: int, place: int) -> Marks:
    """Return the marks without a point of one; a line with a single point left goes too."""
    points = [*marks[number].points[:place], *marks[number].points[place + 1 :]]
    if len(points) < 2:
        return without_mark(marks, number)
    return _with(marks, number, plain_mark(replace(marks[number], points=points)))


def without_mark(marks: Marks, number: int) -> Marks:
    """Return the marks without one."""
    return (*marks[:number], *marks[number + 1 :])


def _with(marks: Marks, number: int, mark: TimeMark) -> Marks:
    return (*marks[:number], mark, *marks[number + 1 :])
