# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Place the yarn of the templates on the faces of a stitch mesh.

A point of a template is mapped to its face by mean value coordinates. Its height moves it along the surface normal,
which is interpolated by the same coordinates (Yuksel et al. 2012, section 4).
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache, cached_property, lru_cache

import numpy as np
from numpy.typing import NDArray

from stitchmesh.mesh import FloatArray, IntArray, StitchMesh, frozen_array
from stitchmesh.mesh.arrays import distinct_rows
from stitchmesh.mesh.mean_value import mean_value_weights
from stitchmesh.yarn import FLOATING, YarnSet
from stitchmesh.yarngen.templates.edge_templates import Edge, edge_template
from stitchmesh.yarngen.templates.plain import knit
from stitchmesh.yarngen.templates.table import template
from stitchmesh.yarngen.templates.template import Template

FEWEST_POINTS = 2
"""Number of points of the shortest part. Two points are needed to define a direction."""


@dataclass(frozen=True, eq=False)
class PlacedParts:
    """The yarn parts on a stitch mesh, stored one after another."""

    points: FloatArray
    """Points through which the yarn passes [cm], shape (N, 3)."""
    start: IntArray
    """Index of the first point of each part, shape (P + 1,)."""
    face: IntArray
    """Stitch face of each part, shape (P,)."""
    row: IntArray
    """Row in which each part was knitted, shape (P,). The head of a loop below belongs to the row that made that
    loop."""
    index: IntArray
    """Number of each part within its template, shape (P,)."""
    end_side: IntArray
    """Sides that each part crosses at its start and at its end, shape (P, 2)."""
    end_slot: IntArray
    """Slots of these crossings, counted along the side, shape (P, 2)."""

    @cached_property
    def lengths(self) -> FloatArray:
        """Drawn length of each part between its first and its last point [cm], shape (P,)."""
        along = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(self.points, axis=0), axis=1))])
        drawn: FloatArray = along[self.start[1:] - 1] - along[self.start[:-1]]
        return drawn


def points_per_width(points_per_stitch: int) -> float:
    """Number of points along one stitch width of yarn, if a plain loop has ``points_per_stitch`` points."""
    return points_per_stitch / _plain_length()


@cache
def _plain_length() -> float:
    """Length of a plain loop [stitch widths]."""
    return sum(part.length for part in knit().parts)


def place_parts(
    fabric: StitchMesh, radius: float, points_per_stitch: int, *, corner_position: FloatArray | None = None,
    edge: IntArray | None = None,
) -> PlacedParts:  # fmt: skip
    """The yarn parts of all faces of a stitch mesh.

    Args:
        fabric: stitch faces.
        radius: yarn radius [cm].
        points_per_stitch: points along one plain loop; other parts have points in proportion to their length.
        corner_position: positions of the corners of the faces [cm], shape (C, 3); by default the corners of the fabric.
        edge: templates of the faces of first and last rows (``Edge``), shape (F,); the templates of their stitches if
            not given.

    Raises:
        YarnError: the stitch of a face has no yarn template.
    """
    edge = np.full(fabric.face_count, Edge.BY_STITCH) if edge is None else edge
    kinds = np.stack([edge, fabric.stitch, fabric.n_bottom, fabric.n_top, *_twists(fabric).T], axis=1)
    unique, kind = distinct_rows(kinds)
    position = fabric.corner_position if corner_position is None else corner_position
    density = points_per_width(points_per_stitch)
    groups = []
    for number, (edge_kind, stitch, n_bottom, n_top, *twists) in enumerate(unique.tolist()):
        faces = np.flatnonzero(kind == number)
        sides = n_bottom, n_top, tuple(twists[:n_top])
        shape = (
            template(fabric.stitch_type(stitch), *sides)
            if edge_kind == Edge.BY_STITCH
            else edge_template(Edge(edge_kind), *sides)
        )
        groups += _place_template(fabric, faces, shape, position, radius, density)
    return _concatenated(groups)


def _twists(fabric: StitchMesh) -> IntArray:
    """Half turns of the loops on top of each face from left to right, zero where there is no loop, shape (F, T).

    T is the largest number of top sides of a face.
    """
    loop = np.arange(fabric.n_top.max())
    side = (fabric.face_start[:-1] + fabric.n_bottom + fabric.n_top)[:, None] - loop  # top sides run from right to left
    return np.where(loop < fabric.n_top[:, None], fabric.twist[side], 0)


def _place_template(
    fabric: StitchMesh, faces: IntArray, shape: Template, corner_position: FloatArray, radius: float, density: float
) -> list[PlacedParts]:
    """The parts of all faces that share a template, one group for each part of the template."""
    first = fabric.face_start[:-1][faces]
    corners = first[:, None] + np.arange(len(shape.polygon))
    position, normal = _columns(corner_position[corners]), _columns(fabric.vertex_normal[fabric.face_vertex[corners]])
    groups = []
    for index, part in enumerate(shape.parts):
        weights, heights = _sampled_part(shape, index, max(FEWEST_POINTS, round(density * part.length)))
        points = (weights @ position).reshape(len(heights), 3, -1)
        out = (weights @ normal).reshape(points.shape)
        height = heights[:, None] * radius / np.maximum(np.sqrt((out**2).sum(axis=1)), 1e-12)
        points += np.multiply(out, height[:, None], out=out)
        sides = np.stack([first + part.start.place, first + part.end.place], axis=1)
        rows = _rows_below(fabric, sides[:, 0]) if part.is_head else fabric.row[faces]
        groups.append(
            PlacedParts(
                points=points.transpose(2, 0, 1).reshape(-1, 3),
                start=np.arange(len(faces) + 1) * len(heights),
                face=faces,
                row=rows,
                index=np.full(len(faces), index),
                end_side=sides,
                end_slot=np.tile([part.start.slot, part.end.slot], (len(faces), 1)),
            )
        )
    return groups


@lru_cache(maxsize=1024)
def _sampled_part(shape: Template, index: int, count: int) -> tuple[FloatArray, FloatArray]:
    """Mean value coordinates of ``count`` points of a part, shape (count, corners), and their heights [radii]."""
    flat = shape.parts[index].resampled(count)
    weights, heights = mean_value_weights(shape.polygon, flat[:, :2]), flat[:, 2]
    return frozen_array(weights, np.float64), frozen_array(heights, np.float64)


def _columns(vectors: FloatArray) -> FloatArray:
    """Vectors at the corners of faces, shape (F, C, 3), as one row for each corner, shape (C, 3 F)."""
    return np.ascontiguousarray(vectors.transpose(1, 2, 0)).reshape(vectors.shape[1], -1)


def _rows_below(fabric: StitchMesh, sides: IntArray) -> IntArray:
    """Row in which the loop on each bottom side was made, shape (n,).

    The search follows slipped loops down to the row that made them. At a border the result is the face's own row.
    """
    for _ in range(fabric.face_count):  # a loop that is slipped in every row of a closed ring of rows has no beginning
        across = np.where(fabric.twin[sides] < 0, sides, fabric.twin[sides])
        slipped = fabric.slipped_from[across] >= 0
        if not slipped.any():
            break
        sides = np.where(slipped, fabric.slipped_from[across], sides)
    return fabric.row[fabric.side_face[across]]


def _concatenated(groups: list[PlacedParts]) -> PlacedParts:
    """All groups of parts as one."""
    counts = np.concatenate([np.diff(group.start) for group in groups])
    return PlacedParts(
        points=np.concatenate([group.points for group in groups]),
        start=np.concatenate([[0], np.cumsum(counts)]),
        face=np.concatenate([group.face for group in groups]),
        row=np.concatenate([group.row for group in groups]),
        index=np.concatenate([group.index for group in groups]),
        end_side=np.concatenate([group.end_side for group in groups]),
        end_slot=np.concatenate([group.end_slot for group in groups]),
    )


def belongs_to_loop_below(yarns: YarnSet, fabric: StitchMesh) -> NDArray[np.bool_]:
    """Whether each control point belongs to a loop below its stitch (``TemplatePart.is_head``), shape (N,).

    Args:
        yarns: the yarns generated from the fabric.
        fabric: a stitch mesh without borders.
    """
    kinds = np.stack([fabric.stitch, fabric.n_bottom, fabric.n_top], axis=1)
    unique, kind = distinct_rows(kinds)
    shapes = [template(fabric.stitch_type(stitch), *sides).parts for stitch, *sides in unique.tolist()]
    heads = np.zeros((len(shapes), max(map(len, shapes))), dtype=bool)
    for number, parts in enumerate(shapes):
        heads[number, : len(parts)] = [part.is_head for part in parts]
    found: NDArray[np.bool_] = heads[kind[yarns.face], yarns.part] & (yarns.part != FLOATING)
    return found
