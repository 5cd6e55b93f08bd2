# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Stitch faces that are made row by row, and the stitch mesh that they become.

A row lies between two course lines. Wale edges divide it into faces. Faces are joined where they share an edge.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from stitchmesh.mesh import BORDER, FloatArray, IntArray, StitchMesh
from stitchmesh.mesh.palette import Palette, empty_palette
from stitchmesh.mesh.shaping_stitches import shaping_stitch
from stitchmesh.mesh.stitch import Stitch
from stitchmesh.tessellate.courses import MOST_LOOPS

Numbers = Sequence[int] | IntArray
"""Numbers of vertices, edges or places."""



@dataclass(frozen=True, eq=False)
class RowBoundary:
    """The course line below or above a row, from left to right."""

    vertices: Numbers
    """Its vertices."""
    edges: Numbers
    """Its edges."""
    ends: Numbers
    """The place, among the vertices, of the end of each wale edge of the row."""


@dataclass(frozen=True, eq=False)
class StitchFaces:
    """Stitch faces that have been made so far, as the lines around them; each list has an element for each row."""

    low: list[RowBoundary] = field(default_factory=list)
    """The course line below."""
    high: list[RowBoundary] = field(default_factory=list)
    """The course line above."""
    wales: list[Numbers] = field(default_factory=list)
    """The wale edges."""
    left: list[Sequence[bool] | NDArray[np.bool_]] = field(default_factory=list)
    """Whether each face, if it is an increase or a decrease, leans as in the left half of its row."""
    row: list[int] = field(default_factory=list)
    """The number of the row."""

    def add_row(
        self, low: RowBoundary, high: RowBoundary, wales: Numbers, left: Sequence[bool] | NDArray[np.bool_], row: int
    ) -> None:
        """Add the faces of a row, which lie between neighbouring wale edges.

        Args:
            low: the course line below.
            high: the course line above.
            wales: the wale edges from left to right; in a round the last one is the first one again.
            left: whether each face, if it is an increase or a decrease, leans as in the left half of its row.
            row: number of the row.
        """
        self.low.append(low)
        self.high.append(high)
        self.wales.append(wales)
        self.left.append(left)
        self.row.append(row)

    def gathered(self) -> GatheredFaces:
        """Return all faces as arrays."""
        low, high, (wales, first_wale) = _Lines.of(self.low), _Lines.of(self.high), _joined(self.wales)
        count = np.diff(first_wale) - 1
        row = np.repeat(np.arange(len(count)), count)
        wale = np.arange(len(row)) + row  # a row has one wale edge more than faces
        n_bottom, n_top = low.last - low.first, high.last - high.first
        start = np.concatenate([[0], np.cumsum(n_bottom + n_top + 2)])

        # Counter-clockwise from the lower left: along the course line below, then back along the one above
        face = np.repeat(np.arange(len(n_bottom)), n_bottom + n_top + 2)
        place = np.arange(start[-1]) - start[face]
        back = place - n_bottom[face] - 1
        is_low, is_right, is_left = back < 0, back == -1, back == n_top[face]
        low_place, high_place = low.first[face] + place, high.last[face] - back
        corner = np.empty(len(face), dtype=np.int64)
        at_low = is_low | is_right
        corner[at_low] = low.vertices[low_place[at_low]]
        corner[~at_low] = high.vertices[high_place[~at_low]]
        edge = np.where(is_right, wales[wale[face] + 1], wales[wale[face]])
        below, above = at_low & ~is_right, ~at_low & ~is_left
        edge[below] = low.edges[low_place[below] + low.edge_shift[face[below]]]
        edge[above] = high.edges[high_place[above] - 1 + high.edge_shift[face[above]]]
        return GatheredFaces(
            start=start,
            corner=corner,
            edge=edge,
            twin=twins_of_edges(edge),
            n_bottom=n_bottom,
            n_top=n_top,
            stitch=_stitches(n_bottom, n_top, np.concatenate(self.left).astype(bool)),
            row=np.array(self.row)[row],
        )


@dataclass(frozen=True, eq=False)
class _Lines:
    """The course lines on one side of all rows, one after another, and the part of a line along each face."""

    vertices: IntArray
    """The vertices of all lines."""
    edges: IntArray
    """The edges of all lines."""
    first: IntArray
    """The vertex, as a place in ``vertices``, at which the part of each face begins, shape (F,)."""
    last: IntArray
    """The vertex at which it ends, shape (F,)."""
    edge_shift: IntArray
    """Place in ``edges`` of the edge after a vertex of the part of each face, less the place of the vertex, (F,)."""

    @classmethod
    def of(cls, lines: Sequence[RowBoundary]) -> _Lines:
        """The lines of all rows."""
        vertices, first_vertex = _joined([line.vertices for line in lines])
        edges, first_edge = _joined([line.edges for line in lines])
        ends, first_end = _joined([line.ends for line in lines])
        row = np.repeat(np.arange(len(lines)), np.diff(first_end) - 1)
        end = np.arange(len(row)) + row  # a line has one end more than faces
        shift = first_vertex[row]
        return cls(vertices, edges, ends[end] + shift, ends[end + 1] + shift, first_edge[row] - shift)


def _joined(parts: Sequence[Numbers]) -> tuple[IntArray, IntArray]:
    """Numbers of several sequences as one array, and the place at which each begins, with the end of the last one."""
    joined = np.concatenate([np.asarray(part, dtype=np.int64) for part in parts])
    return joined, np.concatenate([[0], np.cumsum([len(part) for part in parts])])


def _stitches(n_bottom: IntArray, n_top: IntArray, left: NDArray[np.bool_]) -> IntArray:
    """The stitch of each face (``stitch_for``), shape (F,)."""
    sides = int(n_top.max()) + 1
    kinds, kind = np.unique((n_bottom * sides + n_top) * 2 + left, return_inverse=True)
    return np.array([stitch_for(*divmod(each // 2, sides), left_half=each % 2 == 1) for each in kinds.tolist()])[kind]
@dataclass(frozen=True, eq=False)
class GatheredFaces:
    """Stitch faces as arrays; F is their number and C the number of their corners."""

    start: IntArray
    """First corner of each face, and C at the end, shape (F + 1,)."""
    corner: IntArray
    """Vertex of each corner, shape (C,)."""
    edge: IntArray
    """Edge of each side, shape (C,)."""
    twin: IntArray
    """The other side of the edge of each side, shape (C,)."""
    n_bottom: IntArray
    """Number of bottom sides of each face, shape (F,)."""
    n_top: IntArray
    """Number of top sides of each face, shape (F,)."""
    stitch: IntArray
    """Stitch of each face, shape (F,)."""
    row: IntArray
    """Row of each face, shape (F,)."""

    def mesh(self, vertices: FloatArray, *, palette: Palette | None = None) -> StitchMesh:
        """Return the stitch mesh; faces whose bottom sides all lie on the border are cast on.

        Args:
            vertices: positions of the vertices [cm], shape (V, 3).
            palette: colours of the yarns; none if it is not given.
        """
        return StitchMesh(
            vertices=vertices,
            face_start=self.start,
            face_vertex=self.corner,
            twin=self.twin,
            n_bottom=self.n_bottom,
            n_top=self.n_top,
            stitch=_with_cast_on(self.stitch, self.start, self.n_bottom, self.twin),
            row=self.row,
            palette=empty_palette() if palette is None else palette,
        )


def stitch_for(n_bottom: int, n_top: int, *, left_half: bool) -> Stitch:
    """Return the stitch of a face by its numbers of sides; increases and decreases lean towards the middle.

    Args:
        n_bottom: number of bottom sides.
        n_top: number of top sides.
        left_half: whether the face is in the left half of its course.
    """
    if n_top == 0:
        return Stitch.DRAW_THROUGH
    if n_bottom == 0:
        return Stitch.CAST_ON
    triple = max(n_bottom, n_top) == MOST_LOOPS
    return shaping_stitch(n_bottom, n_top, keeps="middle" if triple else "left" if left_half else "right")


def twins_of_edges(edges: IntArray) -> IntArray:
    """Twin of each side: the other side with the same edge number, shape (C,)."""
    order = np.argsort(edges, kind="stable")
    pair = np.flatnonzero(np.diff(edges[order]) == 0)
    twin = np.full(len(edges), BORDER)
    twin[order[pair]], twin[order[pair + 1]] = order[pair + 1], order[pair]
    return twin


def _with_cast_on(stitch: IntArray, start: IntArray, n_bottom: IntArray, twin: IntArray) -> IntArray:
    """Replace stitches by cast-ons where all bottom sides of a face are on the border."""
    face = np.repeat(np.arange(len(n_bottom)), np.diff(start))
    bottom = np.arange(len(twin)) - start[:-1][face] < n_bottom[face]
    free = np.bincount(face[bottom & (twin == BORDER)], minlength=len(n_bottom))
    return np.where((free == n_bottom) & (stitch != Stitch.DRAW_THROUGH), Stitch.CAST_ON, stitch)
