# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Stitch faces that are made row by row, and the stitch mesh that they become.

A row lies between two course lines. Wale edges divide it into faces. Faces are joined where they share an edge.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from itertools import pairwise

import numpy as np

from stitchmesh.mesh import BORDER, FloatArray, IntArray, StitchMesh
from stitchmesh.mesh.palette import Palette, empty_palette
from stitchmesh.mesh.shaping_stitches import shaping_stitch
from stitchmesh.mesh.stitch import Stitch
from stitchmesh.tessellate.courses import MOST_LOOPS


@dataclass(frozen=True)
class RowBoundary:
    """The course line below or above a row, from left to right."""

    vertices: Sequence[int]
    """Its vertices."""
    edges: Sequence[int]
    """Its edges."""
    ends: Sequence[int]
    """The place, among the vertices, of the end of each wale edge of the row."""


@dataclass
class StitchFaces:
    """Stitch faces that have been made so far."""

    corners: list[list[int]] = field(default_factory=list)
    """Vertices of each face, counter-clockwise from the lower left."""
    edges: list[list[int]] = field(default_factory=list)
    """Edges of each face, in the order of its sides."""
    n_bottom: list[int] = field(default_factory=list)
    """Number of bottom sides of each face."""
    n_top: list[int] = field(default_factory=list)
    """Number of top sides of each face."""
    stitch: list[Stitch] = field(default_factory=list)
    """Stitch of each face."""
    row: list[int] = field(default_factory=list)
    """Row of each face."""

    def add_row(
        self, low: RowBoundary, high: RowBoundary, wales: Sequence[int], left: Sequence[bool], row: int
    ) -> None:
        """Add the faces of a row, which lie between neighbouring wale edges.

        Args:
            low: the course line below.
            high: the course line above.
            wales: the wale edges from left to right; in a round the last one is the first one again.
            left: whether each face, if it is an increase or a decrease, leans as in the left half of its row.
            row: number of the row.
        """
        for place, ((b, b_end), (t, t_end)) in enumerate(zip(pairwise(low.ends), pairwise(high.ends), strict=True)):
            bottom, top = low.edges[b:b_end], high.edges[t:t_end]
            self.corners.append([*low.vertices[b : b_end + 1], *high.vertices[t : t_end + 1][::-1]])
            self.edges.append([*bottom, wales[place + 1], *top[::-1], wales[place]])
            self.n_bottom.append(len(bottom))
            self.n_top.append(len(top))
            self.stitch.append(stitch_for(len(bottom), len(top), bool(left[place])))
            self.row.append(row)

    def gathered(self) -> GatheredFaces:
        """Return all faces as arrays."""
        edge = np.concatenate(self.edges)
        return GatheredFaces(
            start=np.concatenate([[0], np.cumsum([len(corners) for corners in self.corners])]),
            corner=np.concatenate(self.corners),
            edge=edge,
            twin=twins_of_edges(edge),
            n_bottom=np.array(self.n_bottom),
            n_top=np.array(self.n_top),
            stitch=np.array(self.stitch),
            row=np.array(self.row),
        )


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


def stitch_for(n_bottom: int, n_top: int, left_half: bool) -> Stitch:
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
