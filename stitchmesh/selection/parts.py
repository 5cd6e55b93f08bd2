# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The parts of a garment: front and back, sleeves and body, and where rows meet.

Front and back are defined for each row. A row that runs around the body or around a limb has an axis, the normal of its
ring, and a *forward* direction perpendicular to the axis. The forward direction of the first row is +z. From row to row
it turns no more than the axis turns (parallel transport), so that the instep of a sock, which continues the front of
the leg, is front. A face is in front if it lies in the forward half of its row: at least halfway from the rearmost face
of the row to the foremost one. A row that does not run around, such as a row above an armhole, is in front as a whole
if its mean normal points forward.
"""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from stitchmesh.mesh import BORDER, FloatArray, IntArray, StitchMesh
from stitchmesh.mesh.arrays import unit_vectors
from stitchmesh.mesh.courses import right_neighbours
from stitchmesh.selection.borders import Border, borders, named_borders

LEFT_HAND, UP, FORWARD = np.eye(3)
"""Directions of the axes, as the wearer sees them."""


@dataclass(frozen=True, eq=False)
class Parts:
    """The rows and the borders of a fabric, with their places. All values are computed when they are first used."""

    fabric: StitchMesh
    """The stitch mesh."""

    @cached_property
    def borders(self) -> list[Border]:
        """Borders with their names."""
        return borders(self.fabric)

    @cached_property
    def face_centre(self) -> FloatArray:
        """Mean of the corners of each face [cm], shape (F, 3)."""
        return face_centres(self.fabric, np.arange(self.fabric.face_count))

    @cached_property
    def row_numbers(self) -> IntArray:
        """Numbers of the rows that have faces, ascending, shape (R,)."""
        return np.unique(self.fabric.row)

    @cached_property
    def row_index(self) -> IntArray:
        """Index into ``row_numbers`` of the row of each face, shape (F,)."""
        return np.searchsorted(self.row_numbers, self.fabric.row)

    def _row_sum(self, values: FloatArray) -> FloatArray:
        """Sum of vectors of faces over the faces of each row, shape (R, 3)."""
        return np.stack([np.bincount(self.row_index, values[:, k], len(self.row_numbers)) for k in range(3)], axis=1)

    @cached_property
    def row_centre(self) -> FloatArray:
        """Mean of the face centres of each row [cm], shape (R, 3)."""
        return self._row_sum(self.face_centre) / np.bincount(self.row_index)[:, None]

    @cached_property
    def row_axis(self) -> FloatArray:
        """Vector area of the ring through the face centres of each row [cm^2], shape (R, 3)."""
        after = self.right_neighbour
        inner = np.flatnonzero(after != BORDER)
        offset = self.face_centre - self.row_centre[self.row_index]
        spans = np.zeros_like(offset)
        spans[inner] = np.cross(offset[inner], self.face_centre[after[inner]] - self.row_centre[self.row_index[inner]])
        return 0.5 * self._row_sum(spans)

    @cached_property
    def right_neighbour(self) -> IntArray:
        """Right neighbour of each face, ``BORDER`` where its row ends, shape (F,)."""
        return right_neighbours(self.fabric)

    @cached_property
    def row_normal(self) -> FloatArray:
        """Mean unit normal of the faces of each open row, shape (R, 3); 0 for a closed row, which faces all ways."""
        fabric, count = self.fabric, len(self.row_numbers)
        is_open = np.zeros(count, dtype=bool)
        is_open[self.row_index[self.right_neighbour == BORDER]] = True
        faces = np.flatnonzero(is_open[self.row_index])
        sizes = np.diff(fabric.face_start)[faces]
        sides = fabric.sides_of(faces)
        start, end = (fabric.vertices[fabric.face_vertex[corners]] for corners in (sides, fabric.side_next[sides]))
        normal = np.zeros((len(faces), 3))
        if len(faces):
            normal = np.add.reduceat(np.cross(start, end), np.cumsum(sizes) - sizes, axis=0)
            normal /= np.linalg.norm(normal, axis=1, keepdims=True)
        row = self.row_index[faces]
        total = np.stack([np.bincount(row, normal[:, k], count) for k in range(3)], axis=1)
        return total / np.bincount(self.row_index)[:, None]

    @cached_property
    def runs_around(self) -> NDArray[np.bool_]:
        """Whether each row runs around the body or a limb, shape (R,).

        A closed ring and a turn of a spiral run around. An open row does if its normals point in most directions.
        """
        # An open row is flat if the mean unit normal of its faces is at least this long; an arc of 217 degrees has this
        # value.
        return np.linalg.norm(self.row_normal, axis=1) < 0.5

    @cached_property
    def rows_beside(self) -> list[list[int]]:
        """Rows that share course edges with each row, by index, in ascending order."""
        fabric, count = self.fabric, len(self.row_numbers)
        sides = np.flatnonzero((fabric.twin > np.arange(fabric.side_count)) & ~fabric.is_wale)
        one, other = self.row_index[fabric.side_face[sides]], self.row_index[fabric.side_face[fabric.twin[sides]]]
        joined = np.zeros((count, count), dtype=bool)
        joined[one, other] = joined[other, one] = True
        np.fill_diagonal(joined, False)
        beside: list[list[int]] = [[] for _ in range(count)]
        for row, neighbour in np.argwhere(joined).tolist():
            beside[row].append(neighbour)
        return beside

    @cached_property
    def row_forward(self) -> FloatArray:
        """Forward direction of each row, a unit vector, shape (R, 3)."""
        axis = self.row_axis
        axis = np.where(self.runs_around[:, None], unit_vectors(axis), 0.0)
        forward = np.zeros_like(axis)
        reached = np.zeros(len(axis), dtype=bool)
        for root in range(len(axis)):
            if reached[root]:
                continue
            forward[root], reached[root] = perpendicular(FORWARD, axis[root], UP), True
            waiting = deque([root])
            while waiting:
                row = waiting.popleft()
                for other in self.rows_beside[row]:
                    if not reached[other]:
                        forward[other] = perpendicular(forward[row], axis[other], forward[row])
                        reached[other] = True
                        waiting.append(other)
        return forward

    @cached_property
    def in_front(self) -> NDArray[np.bool_]:
        """Whether each face is in front (module docstring), shape (F,); a face exactly at the side counts as front."""
        forward = self.row_forward
        depth = np.einsum("fk,fk->f", self.face_centre, forward[self.row_index])
        foremost, rearmost = np.full(len(forward), -np.inf), np.full(len(forward), np.inf)
        np.maximum.at(foremost, self.row_index, depth)
        np.minimum.at(rearmost, self.row_index, depth)
        halfway = ((foremost + rearmost) / 2)[self.row_index]
        faces_forward = np.einsum("rk,rk->r", self.row_normal, forward) >= 0.0
        around = self.runs_around[self.row_index]
        return np.where(around, depth >= halfway - self.fabric.rounding, faces_forward[self.row_index])

    @cached_property
    def on_left(self) -> NDArray[np.bool_]:
        """Whether each face is on the wearer's left of the middle plane, shape (F,); a face on the plane counts."""
        across = self.fabric.vertices[:, 0]
        return self.face_centre[:, 0] >= (across.min() + across.max()) / 2 - self.fabric.rounding

    def sleeve_rows(self, hand: str | None) -> IntArray:
        """Return the indices of the rows of the sleeves, which are the tubes from the cuffs to the body.

        From each cuff, row follows row while all loops of a row lead to exactly one further row, which runs around. The
        last row of a sleeve is the row below the one that also meets rows of the body. A tube that meets no body is no
        sleeve.

        Args:
            hand: ``left`` or ``right``; None for all.
        """
        tubes = [self.tube_from(border) for border in named_borders(self.borders, "cuffs", hand)]
        return np.array(sorted({row for rows, meets_body in tubes if meets_body for row in rows}), dtype=np.int64)

    def tube_from(self, border: Border) -> tuple[list[int], bool]:
        """Return the rows of the tube that begins at a border, and whether it meets rows of a body at its other end."""
        touching = self.row_index[self.fabric.side_face[border.sides]]
        rows = [int(np.bincount(touching).argmax())]
        while True:
            further = [row for row in self.rows_beside[rows[-1]] if row not in rows[-3:]]
            if not further:
                return rows, False
            if len(further) > 1 or not self._continues(rows, further[0]):
                return rows, True
            rows.append(further[0])

    def _continues(self, rows: list[int], row: int) -> bool:
        """Return whether a row continues a tube: it runs around, and at most one row beside it is outside the tube."""
        further = [other for other in self.rows_beside[row] if other not in rows[-3:]]
        return bool(self.runs_around[row]) and len(further) <= 1


def perpendicular(vector: FloatArray, axis: FloatArray, otherwise: FloatArray) -> FloatArray:
    """Return the unit vector along the part of a unit vector perpendicular to a unit axis; the axis may be 0.

    If the vector is nearly parallel to the axis, ``otherwise`` takes its place.
    """
    for candidate in (vector, otherwise, UP, FORWARD):
        part = candidate - (candidate @ axis) * axis
        length = float(np.linalg.norm(part))
        # The part of a unit vector perpendicular to an axis gives a direction only if it is at least this long
        if length >= 0.1:
            return part / length
    return vector


def face_centres(fabric: StitchMesh, faces: IntArray) -> FloatArray:
    """Return the mean of the corners of some faces [cm], shape (n, 3)."""
    sizes = np.diff(fabric.face_start)[faces]
    position = fabric.vertices[fabric.face_vertex[fabric.sides_of(faces)]]
    return np.add.reduceat(position, np.cumsum(sizes) - sizes, axis=0) / sizes[:, None]
