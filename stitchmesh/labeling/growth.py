# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Growth of rows from course edges, one row after the other, until all faces are labeled.

A row starts at a course edge of an unlabeled face. The course edges of this face that are already known become its
bottom sides. The edges at the two ends of the bottom become wale edges, and all other edges become course edges. The
row continues into the neighbouring faces across the wale edges. In a quad, the second wale edge is opposite to the wale
edge through which the row enters. In any other polygon, the second wale edge is the first edge after the known bottom.
"""

from __future__ import annotations

from collections import deque

import numpy as np

from stitchmesh.errors import LabelError
from stitchmesh.mesh import BORDER, Mesh

UNKNOWN, COURSE, WALE = -1, 0, 1


class Conflict(LabelError):
    """Two rows require different labels of one edge."""


class RowGrowth:
    """Labels of edges, and rows and wale sides of faces, while rows grow."""

    def __init__(self, mesh: Mesh) -> None:
        """Start with all edges and faces unlabeled."""
        self.mesh = mesh
        self.edge_label = np.full(len(mesh.edge_side), UNKNOWN)
        self.row = np.full(mesh.face_count, -1)
        self.left_wale = np.full(mesh.face_count, -1)
        self.right_wale = np.full(mesh.face_count, -1)
        self.row_count = 0
        self._waiting: deque[int] = deque()

    def mark_courses(self, sides: list[int]) -> None:
        """Label the edges of these sides as course edges."""
        for side in sides:
            self._set(side, COURSE)

    def queue(self, sides: list[int]) -> None:
        """Queue both sides of these course edges as starts of rows, in this order."""
        self._waiting.extend(sides)
        self._waiting.extend(int(t) for t in self.mesh.twin[sides] if t != BORDER)

    def grow_all(self) -> None:
        """Grow a row from each queued course side until the queue is empty."""
        while self._waiting:
            self.grow_row(self._waiting.popleft())

    def unlabeled_face(self) -> int | None:
        """Return the first face without a row, None if all faces have rows."""
        rest = np.flatnonzero(self.row < 0)
        return int(rest[0]) if len(rest) else None

    def grow_row(self, side: int) -> int | None:
        """Grow a row with this course side at its bottom.

        Returns:
            The number of the row, or None if the face of the side already has a row.

        Raises:
            Conflict: an edge would get two labels.
        """
        face = int(self.mesh.side_face[side])
        if self.row[face] >= 0:
            return None
        row = self.row_count
        self.row_count += 1
        first, last = self._bottom_around(side)
        left, right = int(self.mesh.side_previous[first]), int(self.mesh.side_next[last])
        self._take(face, left, right, row)
        self._walk(right, self.mesh.side_next, row)
        self._walk(left, self.mesh.side_previous, row)
        return row

    def _bottom_around(self, side: int) -> tuple[int, int]:
        """First and last side of the run of known course sides that contains this side; in a quad only this side."""
        mesh, face = self.mesh, self.mesh.side_face[side]
        count = int(mesh.face_start[face + 1] - mesh.face_start[face])
        room = 0 if count == 4 else count - 3
        first = last = side
        while room > 0 and self._label(mesh.side_next[last]) == COURSE:
            last, room = int(mesh.side_next[last]), room - 1
        while room > 0 and self._label(mesh.side_previous[first]) == COURSE:
            first, room = int(mesh.side_previous[first]), room - 1
        return first, last

    def _walk(self, wale: int, forward: np.ndarray, row: int) -> None:
        """Extend a row across this wale side, face by face.

        Args:
            wale: wale side of a face of the row.
            forward: next side of each side in the direction of the bottoms of the faces that follow, shape (C,).
            row: number of the row.
        """
        rightwards = forward is self.mesh.side_next
        while True:
            entry = int(self.mesh.twin[wale])
            if entry == BORDER:
                return
            face = int(self.mesh.side_face[entry])
            if self.row[face] >= 0:
                if entry not in (self.left_wale[face], self.right_wale[face]):
                    raise self._conflict(entry, WALE)
                return
            wale = self._exit(entry, forward)
            self._take(face, *((entry, wale) if rightwards else (wale, entry)), row)

    def _exit(self, entry: int, forward: np.ndarray) -> int:
        """The second wale side of a face that a row enters through the wale side ``entry``."""
        mesh, face = self.mesh, self.mesh.side_face[entry]
        count = int(mesh.face_start[face + 1] - mesh.face_start[face])
        if count == 4:
            return int(forward[forward[entry]])
        side, passed = int(forward[entry]), 0
        while passed < count - 2 and self._label(side) == COURSE:
            side, passed = int(forward[side]), passed + 1
        if passed == 0 and count > 4 and self._label(side) == UNKNOWN:
            side = int(forward[side])  # No bottom side is known, so that the face gets one, as a quad does.
        return side

    def _take(self, face: int, left: int, right: int, row: int) -> None:
        """Add a face to a row, label its sides, and queue its course sides as starts of the neighbouring rows."""
        mesh = self.mesh
        for side in range(int(mesh.face_start[face]), int(mesh.face_start[face + 1])):
            self._set(side, WALE if side in (left, right) else COURSE)
            if side not in (left, right) and mesh.twin[side] != BORDER:
                self._waiting.append(int(mesh.twin[side]))
        self.row[face], self.left_wale[face], self.right_wale[face] = row, left, right

    def _label(self, side: int) -> int:
        return int(self.edge_label[self.mesh.side_edge[side]])

    def _set(self, side: int, value: int) -> None:
        known = self._label(side)
        if known not in (UNKNOWN, value):
            raise self._conflict(side, value)
        self.edge_label[self.mesh.side_edge[side]] = value

    def _conflict(self, side: int, new_label: int) -> Conflict:
        """The error for an edge that already has the label opposite to ``new_label``."""
        mesh = self.mesh
        faces = [int(mesh.side_face[side])] + [int(mesh.side_face[t]) for t in [mesh.twin[side]] if t != BORDER]
        start, end = mesh.face_vertex[side], mesh.face_vertex[mesh.side_next[side]]
        names = {WALE: "wale", COURSE: "course"}
        return Conflict(
            f"face {' and '.join(map(str, faces))}: edge {start}-{end} would be both {names[new_label]} and "
            f"{names[1 - new_label]}, but a face needs exactly 2 wale edges and rows must not cross; remodel the "
            "faces around this edge, or start elsewhere with seeds=[(vertex, vertex)]"
        )
