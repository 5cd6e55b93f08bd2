# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Division of a labeled mesh into stitch faces."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from stitchmesh.errors import ParameterError, TessellationError, check_kind
from stitchmesh.mesh import FloatArray, IntArray, StitchMesh
from stitchmesh.mesh.shaping_stitches import DEFAULT_INCREASE, Increase, with_increases
from stitchmesh.mesh.stitch import Stitch
from stitchmesh.tessellate.counts import EdgeName, edge_counts, edge_named
from stitchmesh.tessellate.courses import loops_per_course
from stitchmesh.tessellate.panel import DividedPanel, add_stitches, inner_points
from stitchmesh.tessellate.stitch_faces import StitchFaces

STITCH_WIDTH = 0.8
"""Wale spacing [cm] where a command is given none: bulky yarn by hand, 12.5 stitches in 10 cm."""
COURSE_OVER_WALE_SPACING = 0.77
"""Height of a relaxed plain stitch divided by its width, the inverse of Munden's ratio R = 1.3."""


def tessellate(
    labeled: StitchMesh,
    *,
    stitch_width: float,
    stitch_height: float | None = None,
    counts: Mapping[EdgeName, int] | None = None,
    marked: Sequence[EdgeName] = (),
    increase: Increase = DEFAULT_INCREASE,
) -> StitchMesh:
    """Divide each face of a labeled mesh into stitches.

    An edge shared by two faces is divided once, so that there are no T-junctions. If the numbers of stitches at the top
    and at the bottom of a face differ, its courses have increases or decreases at its wale edges.

    Args:
        labeled: a labeled mesh (``label``).
        stitch_width: wale spacing [cm].
        stitch_height: course spacing [cm]; by default 0.77 times the width.
        counts: number of stitches along single edges; the count of a wale edge applies to its whole row.
        marked: wale edges at which all increases and decreases of their faces are placed.
        increase: how increases are made: ``m1``, ``kfb``, ``lifted`` or ``yo`` (``with_increases``).

    Raises:
        ParameterError: a size or count is out of range, an edge does not exist, a marked edge is a course edge, there
            is no such form of increases, or the mesh has a lattice.
        TessellationError: the mesh already consists of stitches, counts of one row differ, a face has too few courses
            for its change of width, the stitches would not fit in memory, or the faces of the mesh are far too
            small for such stitches.

    Source: Yuksel et al. 2012, section 5.2.
    """
    check_kind("tessellate", labeled, StitchMesh, "sm.label(mesh)")
    if labeled.lattice is not None:
        raise ParameterError("tessellate: got a mesh on a lattice; make periodic stitch meshes from charts instead")
    stitches = np.flatnonzero(labeled.stitch != Stitch.PANEL)
    if len(stitches):
        raise TessellationError(f"face {stitches[0]}: is a stitch already; tessellate the result of `label`")
    height = COURSE_OVER_WALE_SPACING * stitch_width if stitch_height is None else stitch_height
    along = edge_counts(labeled, stitch_width, height, counts or {})
    marks = marked_sides(labeled, marked)
    return with_increases(_Tessellation(labeled, along, marks).stitch_mesh(), increase)


def marked_sides(labeled: StitchMesh, marked: Sequence[EdgeName]) -> NDArray[np.bool_]:
    """Return whether each side lies on a marked edge, shape (C,).

    Raises:
        ParameterError: an edge does not exist, or is a course edge.
    """
    edges = [edge_named(labeled, name) for name in marked]
    for name, edge in zip(marked, edges, strict=True):
        if not labeled.is_wale[labeled.edge_side[edge]]:
            raise ParameterError(f"marked edge {name}: is a course edge; increases are placed at wale edges")
    return np.isin(labeled.side_edge, edges)


class _Tessellation:
    """Numbers of the vertices and edges that panels share, and the points made so far."""

    def __init__(self, labeled: StitchMesh, along: IntArray, marked: np.ndarray) -> None:
        self.labeled, self.along, self.marked = labeled, along, marked
        vertex_start = len(labeled.vertices) + np.concatenate([[0], np.cumsum(along - 1)])
        self.edge_vertex, self.edge_base = vertex_start[:-1], np.concatenate([[0], np.cumsum(along)])
        self.points: list[FloatArray] = [labeled.vertices, self._points_on_edges()]
        self.next_vertex = int(vertex_start[-1])
        courses = along[labeled.side_edge[labeled.left_wale]]
        rows = np.zeros(labeled.row.max() + 1, dtype=np.int64)
        rows[labeled.row] = courses
        self.first_row = np.concatenate([[0], np.cumsum(rows)])[labeled.row]

    def _points_on_edges(self) -> FloatArray:
        """Points that divide each edge into equal parts, without the ends of the edge [cm], edge by edge."""
        mesh = self.labeled
        start = mesh.corner_position[mesh.edge_side]
        end = mesh.corner_position[mesh.side_next[mesh.edge_side]]
        edge = np.repeat(np.arange(len(self.along)), self.along - 1)
        place = np.arange(len(edge)) - np.repeat(np.cumsum(self.along - 1) - (self.along - 1), self.along - 1)
        share = ((place + 1) / self.along[edge])[:, None]
        return start[edge] * (1.0 - share) + end[edge] * share

    def _along_side(self, side: int) -> tuple[IntArray, IntArray]:
        """Vertices (both ends included) and edges along a side, in the direction of the side."""
        mesh, edge = self.labeled, self.labeled.side_edge[side]
        inner = self.edge_vertex[edge] + np.arange(self.along[edge] - 1)
        edges = self.edge_base[edge] + np.arange(self.along[edge])
        if mesh.edge_side[edge] != side:
            inner, edges = inner[::-1], edges[::-1]
        ends = mesh.face_vertex[side], mesh.face_vertex[mesh.side_next[side]]
        return np.concatenate([[ends[0]], inner, [ends[1]]]), edges

    def _chain(self, sides: Sequence[int], empty: int) -> tuple[IntArray, IntArray]:
        """Vertices and edges along consecutive sides; without sides, only the vertex ``empty``."""
        parts = [self._along_side(side) for side in sides]
        vertices = [part[0][1:] for part in parts]
        first = parts[0][0][:1] if parts else np.array([empty])
        edges = [part[1] for part in parts]
        return np.concatenate([first, *vertices]), np.concatenate([np.zeros(0, dtype=np.int64), *edges])

    def panel(self, face: int) -> DividedPanel:
        """Return the panel of a face, and make the points inside the panel."""
        mesh, start = self.labeled, int(self.labeled.face_start[face])
        right, left = int(mesh.right_wale[face]), int(mesh.left_wale[face])
        bottom_sides, top_sides = range(start, right), range(right + 1, left)
        low, bottom = self._chain(bottom_sides, int(mesh.face_vertex[right]))
        high, top = self._chain(top_sides, int(mesh.face_vertex[left]))
        right_vertices, right_edges = self._along_side(right)
        left_vertices, left_edges = (part[::-1] for part in self._along_side(left))
        loops = loops_per_course(len(bottom), len(top), len(left_edges), face)
        inner = inner_points(
            mesh.corner_position[start : left + 1],
            self.along[mesh.side_edge[list(bottom_sides)]],
            self.along[mesh.side_edge[list(top_sides)]][::-1],
            loops,
        )
        levels = [low]
        for level, points in enumerate(inner, start=1):
            own = self.next_vertex + np.arange(len(points))
            levels.append(np.concatenate([left_vertices[level : level + 1], own, right_vertices[level : level + 1]]))
            self.points.append(points)
            self.next_vertex += len(points)
        levels.append(high[::-1])
        marks = (self.marked[left], self.marked[right])
        mark = {(True, False): "left", (False, True): "right"}.get((bool(marks[0]), bool(marks[1])), "")
        return DividedPanel(levels, bottom, top[::-1], left_edges, right_edges, int(self.first_row[face]), mark)

    def stitch_mesh(self) -> StitchMesh:
        """Divide all panels and join their stitch faces to a stitch mesh."""
        faces, next_edge = StitchFaces(), int(self.edge_base[-1])
        for face in range(self.labeled.face_count):
            next_edge = add_stitches(self.panel(face), faces, next_edge)
        return faces.gathered().mesh(np.concatenate(self.points), palette=self.labeled.palette)
