# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Place the templates' yarn on the faces of a stitch mesh.

A template point is carried to its face by mean value coordinates and moved along the surface normal, interpolated
with the same coordinates, by its height (Yuksel et al. 2012, section 4).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from stitchmesh.mesh import FloatArray, IntArray, StitchMesh
from stitchmesh.mesh.mean_value import mean_value_weights
from stitchmesh.mesh.stitch import VOCABULARY, Stitch
from stitchmesh.yarngen.templates.edge_templates import Edge, edge_template
from stitchmesh.yarngen.templates.plain import knit
from stitchmesh.yarngen.templates.table import template
from stitchmesh.yarngen.templates.template import Template

FEWEST_POINTS = 2
"""Points of the shortest part, so that its direction is known."""


@dataclass(frozen=True, eq=False)
class PlacedParts:
    """Yarn parts on a stitch mesh, in compressed rows."""

    points: FloatArray
    """Points that the yarn passes through [cm], shape (N, 3)."""
    start: IntArray
    """Where each part's points start, shape (P + 1,)."""
    face: IntArray
    """Stitch face of each part, shape (P,)."""
    row: IntArray
    """Knitting row of each part: a head's is the row below, shape (P,)."""
    index: IntArray
    """Number of each part within its template, shape (P,)."""
    end_side: IntArray
    """Side at the start and at the end of each part, shape (P, 2)."""
    end_slot: IntArray
    """Which crossing of that side, counted along it, shape (P, 2)."""


def points_per_width(points_per_stitch: int) -> float:
    """Points along a stitch width of yarn, where a plain loop has so many."""
    return points_per_stitch / sum(part.length for part in knit().parts)


def place_parts(
    fabric: StitchMesh, radius: float, points_per_stitch: int, *, corner_position: FloatArray | None = None,
    edge: IntArray | None = None,
) -> PlacedParts:  # fmt: skip
    """The yarn parts of all faces.

    Args:
        fabric: stitch faces.
        radius: yarn radius [cm].
        points_per_stitch: points along one plain loop; other parts get their share by length.
        corner_position: where the corners of the faces are [cm], shape (C, 3), if not where the fabric has them.
        edge: how faces of the first and last rows are drawn (``Edge``), shape (F,); as their stitch says if not given.

    Raises:
        YarnError: a face's stitch has no yarn template.
    """
    edge = np.full(fabric.face_count, Edge.BY_STITCH) if edge is None else edge
    kinds = np.stack([edge, fabric.stitch, fabric.n_bottom, fabric.n_top, *_twists(fabric).T], axis=1)
    unique, kind = np.unique(kinds, axis=0, return_inverse=True)
    position = fabric.corner_position if corner_position is None else corner_position
    density = points_per_width(points_per_stitch)
    groups = []
    for number, (edge_kind, stitch, n_bottom, n_top, *twists) in enumerate(unique.tolist()):
        faces = np.flatnonzero(kind == number)
        sides = n_bottom, n_top, tuple(twists[:n_top])
        shape = (
            template(Stitch(stitch), *sides) if edge_kind == Edge.BY_STITCH else edge_template(Edge(edge_kind), *sides)
        )
        groups += _place_template(fabric, faces, shape, position, radius, density)
    return _concatenated(groups)


def _twists(fabric: StitchMesh) -> IntArray:
    """Half turns of each face's loops on top from left to right, zero where there is none, shape (F, most tops)."""
    loop = np.arange(fabric.n_top.max())
    side = (fabric.face_start[:-1] + fabric.n_bottom + fabric.n_top)[:, None] - loop  # top sides run right to left
    return np.where(loop < fabric.n_top[:, None], fabric.twist[side], 0)


def _place_template(
    fabric: StitchMesh, faces: IntArray, shape: Template, corner_position: FloatArray, radius: float, density: float
) -> list[PlacedParts]:
    """The parts of all faces of one kind, one group for each part of the template."""
    first = fabric.face_start[:-1][faces]
    corners = first[:, None] + np.arange(len(shape.polygon))
    position, normal = corner_position[corners], fabric.vertex_normal[fabric.face_vertex[corners]]
    groups = []
    for index, part in enumerate(shape.parts):
        flat = part.resampled(max(FEWEST_POINTS, round(density * part.length)))
        weights = mean_value_weights(shape.polygon, flat[:, :2])
        out = np.einsum("pc,fcd->fpd", weights, normal)
        out /= np.maximum(np.linalg.norm(out, axis=2, keepdims=True), 1e-12)
        points = np.einsum("pc,fcd->fpd", weights, position) + out * (flat[:, 2] * radius)[None, :, None]
        sides = np.stack([first + part.start.place, first + part.end.place], axis=1)
        rows = _rows_below(fabric, sides[:, 0]) if part.is_head else fabric.row[faces]
        groups.append(
            PlacedParts(
                points=points.reshape(-1, 3),
                start=np.arange(len(faces) + 1) * len(flat),
                face=faces,
                row=rows,
                index=np.full(len(faces), index),
                end_side=sides,
                end_slot=np.tile([part.start.slot, part.end.slot], (len(faces), 1)),
            )
        )
    return groups


def _rows_below(fabric: StitchMesh, sides: IntArray) -> IntArray:
    """Row in which the loop on each bottom side was made, slipped stitches passed by; the face's own at a border."""
    slipped_from = _slipped_from(fabric)
    for _ in range(fabric.face_count):  # slipped all the way around a ring of rows, a loop has no beginning
        across = np.where(fabric.twin[sides] < 0, sides, fabric.twin[sides])
        slipped = slipped_from[across] >= 0
        if not slipped.any():
            break
        sides = np.where(slipped, slipped_from[across], sides)
    return fabric.row[fabric.side_face[across]]


def _slipped_from(fabric: StitchMesh) -> IntArray:
    """For the top side of each slipped loop the bottom side that it comes from, else -1, shape (C,)."""
    result = np.full(fabric.side_count, -1)
    for stitch, definition in VOCABULARY.items():
        for loop, made in enumerate(definition.made):
            if made == "s":  # such a stitch has one bottom side, its face's first
                first = fabric.face_start[:-1][fabric.stitch == stitch]
                result[first + definition.n_bottom + definition.n_top - loop] = first
    return result


def _concatenated(groups: list[PlacedParts]) -> PlacedParts:
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
