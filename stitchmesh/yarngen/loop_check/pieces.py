# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Pieces of yarns: which control points came from which part of a stitch, in the order of the yarn.

A yarn set stores the stitch face and the part of each control point (``YarnSet.face``, ``YarnSet.part``), and a
relaxation does not change them. A bind-off face counts as the face below it, and a bridge counts as the part beside it.
The routes of the yarns are therefore computed again from the stitch mesh and compared with the control points.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from stitchmesh.errors import YarnError
from stitchmesh.mesh import IntArray, StitchMesh
from stitchmesh.quality import PRESETS
from stitchmesh.yarn import YarnSet
from stitchmesh.yarngen.finish import DEFAULT_FINISH, YarnFinish
from stitchmesh.yarngen.generate import (
    LARGEST_RADIUS_OVER_WIDTH,
    YarnRoutes,
    mean_stitch_width,
    pieces_along,
    trace_yarn_routes,
)
from stitchmesh.yarngen.tracing import end_crossings


@dataclass(frozen=True, eq=False)
class YarnPieces:
    """The parts of stitches along each yarn, with the control points of each part."""

    routes: YarnRoutes
    """The routes of the yarns."""
    yarn: IntArray
    """Yarn of each piece, ascending, shape (P,)."""
    face: IntArray
    """Face of ``routes.whole`` of each piece, shape (P,)."""
    index: IntArray
    """Number of each piece within its template, shape (P,)."""
    ends: IntArray
    """Crossings (``bridges``) at which the yarn enters and leaves each piece, shape (P, 2)."""
    points: IntArray
    """The first control point of each piece and the point after its last, without bridges and tails, shape (P, 2)."""
    point_count: int
    """Number of control points of all yarns."""

    @cached_property
    def leaving(self) -> list[int]:
        """The crossing at which the yarn leaves each piece."""
        crossings: list[int] = self.ends[:, 1].tolist()
        return crossings


def yarn_pieces(fabric: StitchMesh, yarns: YarnSet, finish: YarnFinish = DEFAULT_FINISH) -> YarnPieces:
    """Find the pieces of the yarns of a stitch mesh.

    Args:
        fabric: the stitch mesh.
        yarns: the yarns generated from it, relaxed or not.
        finish: the finish with which the yarns were generated.

    Raises:
        YarnError: the yarns were not generated from this stitch mesh with this finish.
    """
    radius, points_per_draft_stitch = generation_radius(fabric, yarns), PRESETS["draft"].control_points_per_stitch
    pieces = _pieces(trace_yarn_routes(fabric, radius, points_per_draft_stitch, finish))
    likely = round(points_per_draft_stitch * len(yarns.points) / pieces.point_count)
    for points_per_stitch in (likely, likely - 1, likely + 1, likely - 2, likely + 2):
        pieces = _pieces(trace_yarn_routes(fabric, radius, max(points_per_stitch, 1), finish))
        if _matches(pieces, yarns):
            return pieces
    raise YarnError(
        "yarns: their routes differ from those of this stitch mesh; give the mesh and the finish with which the yarns "
        "were generated"
    )


def generation_radius(fabric: StitchMesh, yarns: YarnSet) -> float:
    """The radius with which yarns are generated again [cm].

    It is the radius of the yarns, but at most the largest radius with which yarns can be generated.
    """
    return min(float(yarns.radius[0]), LARGEST_RADIUS_OVER_WIDTH * mean_stitch_width(fabric))


def points_before(pieces: YarnPieces, yarns: YarnSet) -> list[int]:
    """The control point before the first control point of each piece; before the first of a yarn, its last one."""
    first, begin, end = pieces.points[:, 0], yarns.start[pieces.yarn], yarns.start[pieces.yarn + 1]
    before: list[int] = np.where(first > begin, first - 1, end - 1).tolist()
    return before


def _pieces(routes: YarnRoutes) -> YarnPieces:
    """The pieces of yarns along their routes."""
    crossings = end_crossings(routes.parts)
    entries = np.array([entry for yarn, _ in routes.yarns for entry in yarn], dtype=np.int64)
    ends = np.stack([crossings[entries], crossings[entries ^ 1]], axis=1)
    pieces, _ = pieces_along(routes)
    following = np.cumsum(pieces.count)
    own, count = following[pieces.is_part], pieces.count[pieces.is_part]
    return YarnPieces(
        routes=routes,
        yarn=pieces.yarn[pieces.is_part],
        face=routes.parts.face[entries // 2],
        index=routes.parts.index[entries // 2],
        ends=ends,
        points=np.stack([own - count, own], axis=1),
        point_count=int(following[-1]),
    )


def _matches(pieces: YarnPieces, yarns: YarnSet) -> bool:
    """Whether the control points of the yarns belong to these pieces, one by one."""
    if pieces.point_count != len(yarns.points) or pieces.yarn[-1] != yarns.yarn_count - 1:
        return False
    count = np.diff(pieces.points, axis=1)[:, 0]
    own = np.arange(count.sum()) + np.repeat(pieces.points[:, 0] - (np.cumsum(count) - count), count)
    expected = np.stack([pieces.yarn, pieces.routes.face_below[pieces.face], pieces.index], axis=1)
    found = np.stack([yarns.point_yarn, yarns.face, yarns.part], axis=1)[own]
    return np.array_equal(np.repeat(expected, count, axis=0), found)
