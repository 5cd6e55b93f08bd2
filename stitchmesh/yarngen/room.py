# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Room for the yarns where a surface is folded more sharply than a stitch.

At the corners of a mouth or between toes, two parts of a surface come closer to each other than the centre lines of two
yarns may start. A fabric spans such places. Stitches around them are therefore smoothed, each vertex by half of the way
to the mean of its neighbours, and the yarns are looked at again, until they have room. All other stitches stay where
they are. The vertices of a border are moved towards their neighbours on the border, and its corners stay.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from stitchmesh.errors import YarnError, check_kind
from stitchmesh.mesh import BORDER, FloatArray, IntArray, StitchMesh
from stitchmesh.quality import DEFAULT_QUALITY, Quality, quality_named
from stitchmesh.yarngen.clearance import crowded_points
from stitchmesh.yarngen.finish import DEFAULT_FINISH, YarnFinish
from stitchmesh.yarngen.generate import (
    SMALLEST_DISTANCE_OVER_RADIUS,
    checked_radius,
    trace_yarn_routes,
    yarns_along_routes,
)

if TYPE_CHECKING:
    from scipy.sparse import csr_array

WANTED_OVER_SMALLEST = 1.1
"""Distance that yarns get over the smallest permitted one, so that rounding does not decide what is permitted."""
RINGS = 4
"""Edges from a crowded stitch up to which vertices are smoothed. With fewer, the stitches of a deep fold are pressed
together in its middle."""
ROUNDS_OF_RING = 3
"""Looks at the yarns after which one more ring of vertices is smoothed: what does not get room by itself takes part of
its neighbours'."""
HALF_STEPS = 6
"""Number of smoothing steps between two looks at the yarns."""
MOST_ROUNDS = 18
"""Number of looks at the yarns after which the stitches stay as they are."""


@dataclass(frozen=True)
class Room:
    """Where stitches were moved to make room for yarns."""

    faces: tuple[int, ...]
    """Stitches whose yarns were crowded."""
    farthest: float
    """Largest distance by which a vertex was moved [cm]."""


def make_room(
    fabric: StitchMesh, *, yarn_radius: float | None = None, quality: str | Quality = DEFAULT_QUALITY,
    finish: YarnFinish = DEFAULT_FINISH,
) -> StitchMesh:  # fmt: skip
    """Smooth stitches where the yarns of a fabric would start too close, until the yarns have room.

    The arguments and the errors are those of ``make_room_with_report``.

    Returns:
        The fabric; the same one if its yarns have room, or cannot be given any.
    """
    return make_room_with_report(fabric, yarn_radius=yarn_radius, quality=quality, finish=finish)[0]


def make_room_with_report(
    fabric: StitchMesh, *, yarn_radius: float | None = None, quality: str | Quality = DEFAULT_QUALITY,
    finish: YarnFinish = DEFAULT_FINISH,
) -> tuple[StitchMesh, Room]:  # fmt: skip
    """Smooth stitches as ``make_room`` does, and return also what was moved.

    Args:
        fabric: stitch faces after mesh relaxation.
        yarn_radius: contact radius of the yarn [cm]; an eighth of the mean stitch width if not given.
        quality: the quality with which the yarns will be generated.
        finish: how rows are cast on and bound off, and which floats are cut.

    Returns:
        The fabric, and what was moved. If the yarns are still crowded after ``MOST_ROUNDS``, the given fabric and no
        faces.

    Raises:
        ParameterError, YarnError: as for ``generate_yarns``; also a fabric on a lattice is a ``YarnError``.
    """
    check_kind("make_room", fabric, StitchMesh)
    if fabric.lattice is not None:
        raise YarnError("make_room: got a fabric on a lattice, which lies on no surface; relax its swatch instead")
    radius = checked_radius(fabric, yarn_radius)
    points_per_stitch = quality_named(quality).control_points_per_stitch
    found: set[int] = set()
    smoothed, neighbours = fabric, None
    for number in range(MOST_ROUNDS):
        yarns = yarns_along_routes(trace_yarn_routes(smoothed, radius, points_per_stitch, finish), radius)
        crowded = crowded_points(yarns, WANTED_OVER_SMALLEST * SMALLEST_DISTANCE_OVER_RADIUS * radius)
        if not len(crowded):
            return (_moved(fabric, smoothed.vertices) if found else fabric), _room(fabric, smoothed, found)
        faces = np.unique(yarns.face[crowded])
        found.update(faces.tolist())
        neighbours = _neighbours(fabric) if neighbours is None else neighbours
        smoothed = replace(smoothed, vertices=_smoothed(smoothed, faces, neighbours, RINGS + number // ROUNDS_OF_RING))
    return fabric, Room((), 0.0)


def _room(fabric: StitchMesh, smoothed: StitchMesh, faces: set[int]) -> Room:
    """What was moved."""
    moved = np.linalg.norm(smoothed.vertices - fabric.vertices, axis=1)
    return Room(tuple(sorted(faces)), float(moved.max(initial=0.0)))


def _moved(fabric: StitchMesh, vertices: FloatArray) -> StitchMesh:
    """Return a fabric with other positions; the stretch of its edges changes with their lengths."""
    moved = replace(fabric, vertices=vertices)
    if fabric.stretch is None:
        return moved
    sides = fabric.edge_side
    return replace(moved, stretch=fabric.stretch * moved.side_length[sides] / fabric.side_length[sides])


def _neighbours(fabric: StitchMesh) -> csr_array:
    """Matrix that is 1 for each vertex, row, and each vertex towards which smoothing moves it, shape (V, V).

    Vertices of a border move along it; its corners, at which one stitch or three and more meet, stay where they are.
    """
    from scipy.sparse import coo_array

    sides = np.stack([fabric.face_vertex, fabric.face_vertex[fabric.side_next]])
    along = sides[:, fabric.twin == BORDER]
    ends, along = (np.concatenate([pairs, pairs[::-1]], axis=1) for pairs in (sides, along))
    stitches = np.bincount(fabric.face_vertex, minlength=len(fabric.vertices))
    inner, between = np.ones(len(stitches), dtype=bool), stitches == 2
    inner[along[0]] = False
    both = np.unique(np.concatenate([ends[:, inner[ends[0]]], along[:, between[along[0]]]], axis=1), axis=1)
    size = (len(fabric.vertices),) * 2
    return coo_array((np.ones(both.shape[1]), (both[0], both[1])), shape=size).tocsr()


def _smoothed(fabric: StitchMesh, faces: IntArray, neighbours: csr_array, rings: int) -> FloatArray:
    """Positions after smoothing up to some edges from some faces [cm]."""
    near = np.zeros(len(fabric.vertices))
    near[fabric.face_vertex[fabric.sides_of(faces)]] = 1.0
    for _ in range(rings):
        near = np.maximum(near, (neighbours.T @ near > 0.0) | (neighbours @ near > 0.0))
    count = np.asarray(neighbours.sum(axis=1))
    free = np.flatnonzero((near > 0.0) & (count > 0.0))
    vertices, own, count = fabric.vertices.copy(), neighbours[free], count[free, None]
    for _ in range(HALF_STEPS):
        vertices[free] = 0.5 * (vertices[free] + (own @ vertices) / count)
    return vertices
