# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""A cloth from a stitch mesh: each stitch is a trapezoid at rest, divided into triangles.

A stitch with b bottom sides and t top sides has a bottom of b stitch widths, a top of t stitch widths, and two wale
sides of one course height, so its edges at rest are as long as the edges of its neighbours. Where bottom and top differ
too much for such wale sides, the trapezoid is ``LOWEST`` course heights high.

Each course is a panel. The stitches of a course stand side by side along x, from left to right; y runs from 0 at the
bottom sides upwards. A square stitch is divided along one or the other diagonal in turn, as on a draughtboard, because
diagonals of one direction only would make the cloth stiffer along them.

The triangles of a face stand together: they are numbered face by face, with b + t triangles each.
"""

from __future__ import annotations

import math
from functools import cache

import numpy as np

from stitchmesh.errors import ParameterError, check_kind, first_few
from stitchmesh.mesh import FloatArray, IntArray, StitchMesh
from stitchmesh.mesh.arrays import distinct_rows
from stitchmesh.mesh.courses import Course, find_courses
from stitchmesh.mesh.stitch import Stitch
from stitchmesh.mixed.cloth.cloth import Cloth

LOWEST = 0.5
"""Smallest height of a trapezoid, in course heights."""


def cloth_from_stitches(fabric: StitchMesh, *, stitch_width: float, course_height: float) -> Cloth:
    """Return the cloth of a stitch mesh, with its vertices where they are.

    Args:
        fabric: stitch mesh whose panels are divided into stitches.
        stitch_width: wale spacing at rest [cm].
        course_height: course spacing at rest [cm].

    Raises:
        ParameterError: a length is not positive, the fabric is periodic, or it has faces that are not stitches.
    """
    check_kind("cloth_from_stitches", fabric, StitchMesh)
    for name, length in (("stitch width", stitch_width), ("course height", course_height)):
        if not (math.isfinite(length) and length > 0.0):
            raise ParameterError(f"{name}: got {length}; expected a positive number of cm")
    if fabric.lattice is not None:
        raise ParameterError("cloth_from_stitches: got a periodic fabric; expected one with borders or a closed one")
    panels = np.flatnonzero(fabric.stitch == Stitch.PANEL)
    if len(panels):
        raise ParameterError(f"face {first_few(panels)}: is no stitch; expected stitches; tessellate the mesh first")
    courses = find_courses(fabric)
    course, x = _places_in_courses(fabric, courses, stitch_width)
    corners = stitch_triangles(fabric)
    rest = _corner_rest(fabric, x, stitch_width, course_height)
    return Cloth(
        vertices=fabric.vertices,
        triangles=fabric.face_vertex[corners],
        rest=rest[corners],
        panel=course[fabric.side_face[corners[:, 0]]],
        panel_names=_names(fabric, courses),
    )


def triangle_start(fabric: StitchMesh) -> IntArray:
    """Return the number of the first triangle of each face, and their number at the end, shape (F + 1,)."""
    return np.concatenate([[0], np.cumsum(fabric.n_bottom + fabric.n_top)])


def stitch_triangles(fabric: StitchMesh) -> IntArray:
    """Return the corners of the fabric at the corners of each triangle, face by face, shape (T, 3)."""
    place = _places_in_courses(fabric, find_courses(fabric), 2.0)[1]
    turned = (np.floor(place).astype(np.int64) // 2 + fabric.row) % 2
    kinds, kind = distinct_rows(np.stack([fabric.n_bottom, fabric.n_top, turned], axis=1))
    start = triangle_start(fabric)
    corners = np.empty((start[-1], 3), dtype=np.int64)
    for number, (bottom, top, parity) in enumerate(kinds.tolist()):
        faces = np.flatnonzero(kind == number)
        template = np.array(_template(bottom, top, parity))
        rows = start[faces][:, None] + np.arange(len(template))
        corners[rows] = fabric.face_start[faces][:, None, None] + template
    return corners


@cache
def _template(bottom: int, top: int, parity: int) -> tuple[tuple[int, int, int], ...]:
    """Triangles of a face, as places of its corners; bottom corners come first, and top corners from right to left.

    Args:
        bottom: number of bottom sides.
        top: number of top sides.
        parity: 1 where the first triangle has its long side at the top, if the next places on both chains are equally
            far.
    """
    low, high, made = 0, 0, []
    while low < bottom or high < top:
        along, across = (low + 1) * top, (high + 1) * bottom  # next place on each chain, in parts of its length
        use_bottom = low < bottom and (high == top or along < across or (along == across and not parity))
        upper = bottom + 1 + top - high
        if use_bottom:
            made.append((low, low + 1, upper))
            low += 1
        else:
            made.append((low, upper - 1, upper))
            high += 1
    return tuple(made)


def _places_in_courses(fabric: StitchMesh, courses: list[Course], width: float) -> tuple[IntArray, FloatArray]:
    """Course of each face, and the x of the middle of each face in its course [cm], shapes (F,)."""
    course, x = np.empty(fabric.face_count, dtype=np.int64), np.empty(fabric.face_count)
    mean = width * (fabric.n_bottom + fabric.n_top) / 2
    for number, one in enumerate(courses):
        faces = np.array(one.faces)
        course[faces] = number
        x[faces] = np.cumsum(mean[faces]) - mean[faces] / 2
    return course, x


def _corner_rest(fabric: StitchMesh, x: FloatArray, width: float, height: float) -> FloatArray:
    """Flat position of each corner at rest [cm], shape (C, 2)."""
    lean = (fabric.n_bottom - fabric.n_top) * width / 2
    tall = np.sqrt(np.maximum(height**2 - lean**2, (LOWEST * height) ** 2))
    face, place = fabric.side_face, fabric.side_place
    bottom, top = fabric.n_bottom[face], fabric.n_top[face]
    at_top = place > bottom
    from_left = np.where(at_top, bottom + 1 + top - place, place)
    sides = np.where(at_top, top, bottom)
    return np.stack([x[face] + (from_left - sides / 2) * width, at_top * tall[face]], axis=1)


def _names(fabric: StitchMesh, courses: list[Course]) -> tuple[str, ...]:
    """Names of the courses: the row of each, and the number of its part if the row has several."""
    rows = fabric.row[[course.faces[0] for course in courses]]
    parts: dict[int, int] = {}
    names = []
    for row in rows.tolist():
        parts[row] = parts.get(row, 0) + 1
        names.append(f"row {row}" if parts[row] == 1 else f"row {row}, part {parts[row]}")
    return tuple(names)
