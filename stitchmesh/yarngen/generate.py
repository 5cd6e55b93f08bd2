# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""From stitch faces to yarns with the right topology."""

from __future__ import annotations

import numpy as np

from stitchmesh.errors import ParameterError, YarnError
from stitchmesh.mesh import FloatArray, IntArray, StitchMesh
from stitchmesh.quality import Quality, quality_named
from stitchmesh.stitch import Stitch
from stitchmesh.yarn import YarnSet, segment_lengths, segment_points
from stitchmesh.yarngen.bind_off import with_bind_off
from stitchmesh.yarngen.clearance import smallest_distance
from stitchmesh.yarngen.embedding import PlacedParts, place_parts
from stitchmesh.yarngen.row_ends import RowEnds, finish_row_ends
from stitchmesh.yarngen.splines import control_points_through
from stitchmesh.yarngen.template import RADIUS_OVER_WIDTH
from stitchmesh.yarngen.tracing import link_ends, trace

THICKEST = 0.2
"""Largest yarn radius over the mean stitch width: beyond it loops have no room for the yarn they hold."""
NEAREST = 0.25
"""Smallest distance between yarns at the start, over the radius; touching yarns are 2 apart."""


def generate_yarns(
    fabric: StitchMesh, *, yarn_radius: float | None = None, quality: str | Quality = "standard"
) -> YarnSet:
    """Yarn curves of a stitch mesh, each one path, linked as its stitches say.

    First rows are cast on, last rows bound off, row ends at borders joined in pairs or tied; rows of a tube are
    rings; rows of opposite wale direction are linked by rings of their own.

    Args:
        fabric: stitch faces, relaxed or not.
        yarn_radius: [cm]; an eighth of the mean stitch width unless given.
        quality: its ``control_points_per_stitch`` sets how finely yarns are drawn.

    Returns:
        Yarns whose rest lengths are as generated. ``face`` refers to ``fabric``; bind-off yarn belongs to the
        last row's faces.

    Raises:
        ParameterError: the radius is not positive, or too thick for the stitches.
        YarnError: a face is not a stitch yet, has no template, or yarns start closer than a quarter of the radius.

    Source: Yuksel et al. 2012, sections 4 and 6.2.
    """
    radius = checked_radius(fabric, yarn_radius)
    panels = np.flatnonzero(fabric.stitch == Stitch.PANEL)
    if len(panels):
        raise YarnError(f"face {panels[0]}: is a panel of a coarse mesh, not a stitch; tessellate the mesh first")
    whole = with_bind_off(fabric)
    parts = place_parts(whole, radius, quality_named(quality).control_points_per_stitch)
    ends = finish_row_ends(whole)
    yarns = trace(link_ends(whole, parts, ends.partner))
    result = _assemble(parts, yarns, ends, _face_below(fabric, whole), radius)
    _check_clearance(result, radius)
    return result


def mean_stitch_width(fabric: StitchMesh) -> float:
    """Mean length of the course sides [cm]."""
    return float(fabric.side_length[~fabric.is_wale].mean())


def checked_radius(fabric: StitchMesh, radius: float | None) -> float:
    """The yarn radius [cm] to use for these stitches."""
    width = mean_stitch_width(fabric)
    if radius is None:
        return RADIUS_OVER_WIDTH * width
    if not (np.isfinite(radius) and radius > 0.0):
        raise ParameterError(f"yarn radius: got {radius} cm; expected a positive number")
    if radius > THICKEST * width:
        raise ParameterError(
            f"yarn radius: got {radius:g} cm, too thick for stitches {width:.3g} cm wide; at most "
            f"{THICKEST * width:.3g} cm fits"
        )
    return float(radius)


def _face_below(fabric: StitchMesh, whole: StitchMesh) -> IntArray:
    """Face of ``fabric`` that each face of ``whole`` belongs to."""
    added = np.arange(fabric.face_count, whole.face_count)
    below = whole.side_face[whole.twin[whole.face_start[added]]]
    return np.concatenate([np.arange(fabric.face_count), below])


def _assemble(
    parts: PlacedParts, yarns: list[tuple[list[int], bool]], ends: RowEnds, face_below: IntArray, radius: float
) -> YarnSet:
    pieces, part_of, counts = [], [], []
    for entries, is_ring in yarns:
        yarn_pieces, yarn_parts = _pieces_of(parts, entries, is_ring, ends)
        pieces += yarn_pieces
        part_of += yarn_parts
        counts.append(sum(len(piece) for piece in yarn_pieces))
    start = np.concatenate([[0], np.cumsum(counts)])
    closed = np.array([flag for _, flag in yarns])
    control = control_points_through(np.concatenate(pieces), start, closed)
    part = np.repeat(part_of, [len(piece) for piece in pieces])
    return YarnSet(
        points=control,
        start=start,
        closed=closed,
        radius=np.full(len(yarns), radius),
        rest_length=segment_lengths(control, segment_points(start, closed)),
        row=parts.row[part],
        face=face_below[parts.face[part]],
        part=parts.index[part],
    )


def _pieces_of(
    parts: PlacedParts, entries: list[int], closed: bool, ends: RowEnds
) -> tuple[list[FloatArray], list[int]]:
    """Point arrays along one yarn, turns and tails included, and the part that each belongs to."""
    pieces, part_of = [], []
    if not closed:
        pieces.append(ends.tail[int(parts.end_side.ravel()[entries[0]])][::-1])
        part_of.append(entries[0] // 2)
    for entry in entries:
        part, last = entry // 2, entry ^ 1
        points = parts.points[parts.start[part] : parts.start[part + 1]]
        pieces.append(points if entry % 2 == 0 else points[::-1])
        side = int(parts.end_side.ravel()[last])
        turn = ends.turn.get(side, ends.tail.get(side))
        if turn is not None:
            pieces.append(turn)
        part_of += [part] * (1 if turn is None else 2)
    return pieces, part_of


def _check_clearance(yarns: YarnSet, radius: float) -> None:
    distance, point = smallest_distance(yarns, NEAREST * radius)
    if distance < NEAREST * radius:
        raise YarnError(
            f"face {yarns.face[point]}: yarns start {distance / radius:.2f} radii apart, expected at least {NEAREST}; "
            "relax the stitch mesh first, or use a thinner yarn"
        )
