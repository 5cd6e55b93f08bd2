# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Growth of rows from course edges, one row after the other.

A row starts at a course edge of an unlabeled face. The course edges of this face that are already known become its
bottom sides. The edges at the two ends of the bottom become wale edges, and all other edges become course edges. The
row continues into the neighbouring faces across the wale edges. In a quad, the second wale edge is opposite to the wale
edge through which the row enters. In any other polygon, the second wale edge is the first edge after the known bottom.
Edges that the user has labeled have precedence over these rules, so that the two wale edges of a quad can also be
neighbours.

If the labels that a face needs contradict the labels of its edges, the face stays unlabeled, and the row ends before
it.
"""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from stitchmesh.mesh import BORDER, IntArray, Mesh

UNKNOWN, COURSE, WALE = -1, 0, 1
UNLABELED = -1
"""Row and wale sides of a face without a row."""
SHORTEST_RUN = 12
"""Smallest number of quads that are labeled together; for fewer, the general rule is faster."""


@dataclass(frozen=True, eq=False, kw_only=True)
class EdgeLabels:
    """Labels of the edges of a mesh, and the rows of its faces; F and E are the numbers of faces and edges."""

    edge_label: IntArray
    """``COURSE``, ``WALE`` or ``UNKNOWN`` of each edge, shape (E,)."""
    by_hand: NDArray[np.bool_]
    """Whether the user has set the label of each edge, shape (E,)."""
    row: IntArray
    """Row of each face in the order of growth, ``UNLABELED`` for a face without a row, shape (F,)."""
    left_wale: IntArray
    """Left wale side of each face in the direction of growth, ``UNLABELED`` for a face without a row, shape (F,)."""
    right_wale: IntArray
    """Right wale side of each face, as ``left_wale``, shape (F,)."""
    fault_side: IntArray
    """Side at which the labels of a face contradict each other, ``UNLABELED`` where there is none, shape (F,)."""
    waiting: IntArray
    """Sides of unlabeled faces from which rows start or continue, in this order, shape (n,)."""

    @property
    def row_count(self) -> int:
        """Number of rows."""
        return int(self.row.max()) + 1


def no_labels(mesh: Mesh) -> EdgeLabels:
    """Return the labels of a mesh on which nothing is labeled."""
    edges, faces = len(mesh.edge_side), mesh.face_count
    return EdgeLabels(
        edge_label=np.full(edges, UNKNOWN),
        by_hand=np.zeros(edges, dtype=bool),
        row=np.full(faces, UNLABELED),
        left_wale=np.full(faces, UNLABELED),
        right_wale=np.full(faces, UNLABELED),
        fault_side=np.full(faces, UNLABELED),
        waiting=np.zeros(0, dtype=np.int64),
    )


class RowGrowth:
    """Labels of edges, and rows and wale sides of faces, while rows grow.

    The loops over the faces of a row read and write single numbers. They use memory views of the arrays, which are
    several times faster than arrays for single numbers.
    """

    def __init__(self, mesh: Mesh, labels: EdgeLabels) -> None:
        """Start with a copy of labels."""
        self.mesh = mesh
        self.edge_label = np.array(labels.edge_label)
        self.by_hand = np.array(labels.by_hand)
        self.row = np.array(labels.row)
        self.left_wale = np.array(labels.left_wale)
        self.right_wale = np.array(labels.right_wale)
        self.fault_side = np.array(labels.fault_side)
        self.row_count = labels.row_count
        self.waiting: deque[int] = deque(labels.waiting.tolist())
        self.rows_met = False  # Whether a row has reached the open end of another row.
        self._any_by_hand = bool(self.by_hand.any())
        has_hand = np.zeros(mesh.face_count, dtype=bool)
        if self._any_by_hand:
            sides = np.flatnonzero(self.by_hand[mesh.side_edge])
            has_hand[mesh.side_face[sides]] = True
        self._has_hand = has_hand.data  # Whether the user has labeled an edge of each face.
        self._label, self._hand, self._fault = self.edge_label.data, self.by_hand.data, self.fault_side.data
        self._row, self._left, self._right = self.row.data, self.left_wale.data, self.right_wale.data
        self._twin, self._face, self._edge = mesh.twin.data, mesh.side_face.data, mesh.side_edge.data
        self._beyond = mesh.side_beyond.data
        self._next, self._previous, self._start = mesh.side_next.data, mesh.side_previous.data, mesh.face_start.data

    def labels(self) -> EdgeLabels:
        """Return the present labels; the growth must not continue afterwards, because the arrays are not copied."""
        waiting = [side for side in self.waiting if self._row[self._face[side]] < 0]
        return EdgeLabels(
            edge_label=self.edge_label,
            by_hand=self.by_hand,
            row=self.row,
            left_wale=self.left_wale,
            right_wale=self.right_wale,
            fault_side=self.fault_side,
            waiting=np.array(waiting, dtype=np.int64),
        )

    def start(self, sides: list[int]) -> int | None:
        """Label the edges of a chain of sides as course edges, and grow a row from the first side.

        Returns:
            The row, or None if the first side has no unlabeled face.
        """
        for side in sides:
            self._label[self._edge[side]] = COURSE
        before = self.row_count
        self.grow(sides[0])
        self.waiting.extend(sides)
        self.waiting.extend(int(twin) for twin in self.mesh.twin[sides] if twin != BORDER)
        return before if self.row_count > before else None

    def grow_rows(self, count: int | None = None) -> int:
        """Grow rows from the waiting sides.

        Args:
            count: largest number of rows; None for all.

        Returns:
            The number of rows that were started or continued.
        """
        grown = 0
        while self.waiting and (count is None or grown < count):
            grown += self.grow(self.waiting.popleft())
        return grown

    def grow(self, side: int) -> bool:
        """Start a row at a course side, or continue a row across a wale side; return whether a face was labeled."""
        face = self._face[side]
        if self._row[face] >= 0 or self._fault[face] >= 0:
            return False
        label = self._label[self._edge[side]]
        if label == WALE:
            return self._continue_row(side)
        return label == COURSE and self._start_row(side)

    def _start_row(self, side: int) -> bool:
        face, row = self._face[side], self.row_count
        wales = self._wales_around(side)
        if wales is None or not self._take(face, *wales, row):
            return False
        self.row_count += 1
        left, right = wales
        self._walk(right, self._next, row)
        self._walk(left, self._previous, row)
        return True

    def _continue_row(self, side: int) -> bool:
        """Continue the row of the face across a wale side into the unlabeled face of the side."""
        across = self._twin[side]
        row = UNLABELED if across == BORDER else self._row[self._face[across]]
        if row == UNLABELED:
            return False
        rightwards = across == self._right[self._face[across]]
        self._walk(across, self._next if rightwards else self._previous, row)
        return self._row[self._face[side]] >= 0

    def _wales_around(self, side: int) -> tuple[int, int] | None:
        """Return the left and the right wale side of a face whose row starts at its bottom side ``side``.

        The bottom consists of the known course sides that contain ``side``; in a quad it is only this side, unless the
        user has labeled others. The result is None if the labels of the user leave no or more than one choice.
        """
        face = self._face[side]
        by_hand = bool(self._has_hand[face])
        first, last = self._bottom_around(side, by_hand)
        left, right = self._previous[first], self._next[last]
        if not by_hand:
            return left, right
        wales = [s for s in self._around(last) if self._is_by_hand(s, WALE)]
        if len(wales) == 1:
            free = [s for s in self._around(last) if self._label[self._edge[s]] != COURSE and s != wales[0]]
            if len(free) == 1:
                wales = sorted([*wales, *free], key=self._around(last).index)
            elif wales[0] not in (left, right):
                self._fault[face] = wales[0]
                return None
        return (wales[1], wales[0]) if len(wales) == 2 else (left, right)

    def _bottom_around(self, side: int, by_hand: bool) -> tuple[int, int]:
        """First and last side of the run of known course sides that contains this side."""
        face = self._face[side]
        count = self._start[face + 1] - self._start[face]
        room = 0 if count == 4 and not by_hand else count - 3
        first = last = side
        while room > 0 and self._is_bottom(self._next[last], count):
            last, room = self._next[last], room - 1
        while room > 0 and self._is_bottom(self._previous[first], count):
            first, room = self._previous[first], room - 1
        return first, last

    def _is_bottom(self, side: int, count: int) -> bool:
        """Whether a side beside a bottom side belongs to the bottom too; in a quad only if the user has labeled it."""
        if count == 4:
            return self._is_by_hand(side, COURSE)
        return self._label[self._edge[side]] == COURSE

    def _walk(self, wale: int, forward: memoryview, row: int) -> None:
        """Extend a row across this wale side, face by face.

        Args:
            wale: wale side of a face of the row.
            forward: next side of each side in the direction of the bottoms of the faces that follow, shape (C,).
            row: number of the row.
        """
        rightwards = forward is self._next
        while True:
            wale = self._take_quads(wale, rightwards, row)
            entry = self._twin[wale]
            if entry == BORDER:
                return
            if self._row[self._face[entry]] >= 0:
                self.rows_met |= self._row[self._face[entry]] != row
                return
            face = self._face[entry]
            wale = self._exit(entry, forward)
            left, right = (entry, wale) if rightwards else (wale, entry)
            if not self._take(face, left, right, row):
                return

    def _take_quads(self, wale: int, rightwards: bool, row: int) -> int:
        """Extend a row across this wale side by a run of quads; return the wale side at which the run ends.

        The quads of the run are labeled together, which is several times faster than one after the other. They are
        labeled one by one if the run is short or if a label contradicts another one; the run then ends at the fault.
        A face with an edge that the user has labeled does not belong to the run.
        """
        run, faces, side = [], [], self._beyond[wale]
        while side != BORDER:
            face = self._face[side]
            if self._row[face] >= 0 or self._has_hand[face]:
                break
            self._row[face] = row
            run.append(side)
            faces.append(face)
            side = self._beyond[side]
        if len(run) >= SHORTEST_RUN and self._label_quads(np.array(run), rightwards):
            return run[-1]
        for face in faces:
            self._row[face] = UNLABELED
        for face, leaving in zip(faces, run, strict=True):
            entry = self._twin[wale]
            if not self._take(face, *((entry, leaving) if rightwards else (leaving, entry)), row):
                break
            wale = leaving
        return wale

    def _label_quads(self, exits: IntArray, rightwards: bool) -> bool:
        """Label a run of quads that a row leaves through these sides; return False if a label contradicts another one.

        All changes are undone in the latter case.
        """
        mesh, faces = self.mesh, self.mesh.side_face[exits]
        entries = mesh.side_next[mesh.side_next[exits]]
        courses = np.sort([mesh.side_next[exits], mesh.side_previous[exits]], axis=0)
        wale_edges, course_edges = mesh.side_edge[exits], mesh.side_edge[courses]
        former = self.edge_label[wale_edges], self.edge_label[course_edges]
        self.edge_label[wale_edges] = WALE
        if (former[0] == COURSE).any() or (self.edge_label[course_edges] == WALE).any():
            self.edge_label[wale_edges] = former[0]
            return False
        self.edge_label[course_edges] = COURSE
        self.left_wale[faces], self.right_wale[faces] = (entries, exits) if rightwards else (exits, entries)
        self.fault_side[faces] = UNLABELED
        twins = mesh.twin[courses].ravel(order="F")
        twins = twins[twins != BORDER]
        self.waiting.extend(twins[self.row[mesh.side_face[twins]] < 0].tolist())
        return True

    def _exit(self, entry: int, forward: memoryview) -> int:
        """The second wale side of a face that a row enters through the wale side ``entry``."""
        face = self._face[entry]
        if self._has_hand[face]:
            chosen = self._exit_by_hand(entry)
            if chosen is not None:
                return chosen
        count = self._start[face + 1] - self._start[face]
        if count == 4:
            return forward[forward[entry]]
        side, passed = forward[entry], 0
        while passed < count - 2 and self._label[self._edge[side]] == COURSE:
            side, passed = forward[side], passed + 1
        if passed == 0 and count > 4 and self._label[self._edge[side]] == UNKNOWN:
            side = forward[side]  # No bottom side is known, so the face gets one, as a quad does.
        return side

    def _exit_by_hand(self, entry: int) -> int | None:
        """The exit that the labels of the user determine; None if the rule for other faces applies."""
        others = self._around(entry)
        wales = [side for side in others if self._is_by_hand(side, WALE)]
        if wales:
            return wales[0]
        free = [side for side in others if self._label[self._edge[side]] != COURSE]
        return free[0] if len(free) == 1 else None

    def _take(self, face: int, left: int, right: int, row: int) -> bool:
        """Add a face to a row, label its sides, and queue its course sides as starts of the neighbouring rows.

        If a side already has the other label, the face stays unlabeled and the side is recorded as its fault.
        """
        sides = range(self._start[face], self._start[face + 1])
        for side in sides:
            known = self._label[self._edge[side]]
            if known != UNKNOWN and known != (side in (left, right)):
                self._fault[face] = side
                return False
        for side in sides:
            is_wale = side in (left, right)
            self._label[self._edge[side]] = WALE if is_wale else COURSE
            if not is_wale and self._twin[side] != BORDER:
                self.waiting.append(self._twin[side])
        self._row[face], self._left[face], self._right[face] = row, left, right
        self._fault[face] = UNLABELED
        return True

    def _around(self, side: int) -> list[int]:
        """The other sides of the face of a side, counter-clockwise."""
        found = [self._next[side]]
        while self._next[found[-1]] != side:
            found.append(self._next[found[-1]])
        return found

    def _is_by_hand(self, side: int, label: int) -> bool:
        """Whether the user has given the edge of a side this label."""
        edge = self._edge[side]
        return bool(self._hand[edge]) and self._label[edge] == label
