# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The parts of a region that do not take a pattern: where they lie, and why."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from stitchmesh.mesh import BORDER, IntArray, StitchMesh
from stitchmesh.mesh.courses import course_through


@dataclass(frozen=True, eq=False)
class LeftOut:
    """Adjacent faces that do not take a pattern, all for one reason."""

    faces: IntArray
    """Faces of the fabric with the pattern, ascending, shape (n,)."""
    rows: tuple[int, int]
    """First and last row of these faces, as in ``StitchMesh.row``."""
    wales: tuple[int, int]
    """First and last place of these faces in their courses, counted from 0 at the left end, or at the face with the
    lowest number of a ring."""
    reason: str
    """Why the faces do not take the pattern."""

    def __str__(self) -> str:
        """Say how many stitches are left out, where, and why, in one line."""
        count = "1 stitch" if len(self.faces) == 1 else f"{len(self.faces)} stitches"
        return f"{count} ({_span('row', self.rows)}, {_span('wale', self.wales)}): {self.reason}"


def _span(what: str, ends: tuple[int, int]) -> str:
    return f"{what} {ends[0]}" if ends[0] == ends[1] else f"{what}s {ends[0]}-{ends[1]}"


def find_left_out(fabric: StitchMesh, reason: IntArray, reasons: list[str]) -> tuple[LeftOut, ...]:
    """Group faces by reason and by adjacency; the largest groups come first.

    Args:
        fabric: stitch mesh with the pattern.
        reason: index of the reason of each face, -1 for a face that is not left out, shape (F,).
        reasons: the reasons in words.
    """
    faces = np.flatnonzero(reason >= 0)
    if not len(faces):
        return ()
    group = _components(fabric, faces, reason)
    wale = _places(fabric, faces)
    found = []
    for number in range(group.max() + 1):
        own = faces[group == number]
        rows, wales = fabric.row[own], wale[group == number]
        ends = [(int(values.min()), int(values.max())) for values in (rows, wales)]
        found.append(LeftOut(own, ends[0], ends[1], reasons[int(reason[own[0]])]))
    return tuple(sorted(found, key=lambda part: (-len(part.faces), int(part.faces[0]))))


def _components(fabric: StitchMesh, faces: IntArray, reason: IntArray) -> IntArray:
    """Return the number of the group of each face: faces of one reason that are joined across sides, shape (n,)."""
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import connected_components

    place = np.full(fabric.face_count, BORDER)
    place[faces] = np.arange(len(faces))
    sides = fabric.sides_of(faces)
    other = fabric.side_face[fabric.twin[sides]]
    joined = (fabric.twin[sides] != BORDER) & (place[other] != BORDER)
    joined &= reason[other] == reason[fabric.side_face[sides]]
    one, two = place[fabric.side_face[sides[joined]]], place[other[joined]]
    graph = coo_array((np.ones(len(one)), (one, two)), shape=(len(faces), len(faces)))
    numbers: IntArray = connected_components(graph, directed=False)[1]
    return numbers


def _places(fabric: StitchMesh, faces: IntArray) -> IntArray:
    """Return the place of each face in its course, shape (n,)."""
    place: dict[int, int] = {}
    for face in faces.tolist():
        if face not in place:
            course = course_through(fabric, face)
            first = int(np.argmin(course.faces)) if course.closed else 0
            count = len(course.faces)
            place.update({other: (index - first) % count for index, other in enumerate(course.faces)})
    return np.array([place[face] for face in faces.tolist()])


def left_out_lines(left_out: tuple[LeftOut, ...]) -> list[str]:
    """Return one line of text for each reason: how many stitches it leaves out, in how many places, and where."""
    by_reason: dict[str, list[LeftOut]] = {}
    for part in left_out:
        by_reason.setdefault(part.reason, []).append(part)
    lines = []
    for reason, parts in by_reason.items():
        count = sum(len(part.faces) for part in parts)
        rows = min(part.rows[0] for part in parts), max(part.rows[1] for part in parts)
        if len(parts) == 1:
            lines.append(f"left out: {parts[0]}")
        else:
            where = f"{len(parts)} places of {_span('row', rows)}"
            most = f"{_span('row', parts[0].rows)} and {_span('wale', parts[0].wales)}"
            lines.append(f"left out: {count} stitches in {where}, most of them in {most}: {reason}")
    return lines
