# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""From stitch faces to yarns with the right topology."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from stitchmesh.cables import cable_groups
from stitchmesh.errors import ParameterError, YarnError
from stitchmesh.mesh import FloatArray, IntArray, StitchMesh
from stitchmesh.quality import Quality, quality_named
from stitchmesh.stitch import Stitch
from stitchmesh.yarn import YarnSet, segment_lengths, segment_points
from stitchmesh.yarngen.bind_off import DRAWN_HEIGHT, with_bind_off
from stitchmesh.yarngen.bridges import Bridges
from stitchmesh.yarngen.cables import cross_loops, opened_corners
from stitchmesh.yarngen.clearance import smallest_distance
from stitchmesh.yarngen.edge_templates import CHAIN_HEIGHT
from stitchmesh.yarngen.embedding import PlacedParts, place_parts, points_per_width
from stitchmesh.yarngen.finish import DEFAULT_FINISH, Finish, edges
from stitchmesh.yarngen.floats import Rows, lay_floats, parted_corners, strands_at_ends
from stitchmesh.yarngen.row_ends import finish_row_ends
from stitchmesh.yarngen.splines import control_points_through
from stitchmesh.yarngen.template import RADIUS_OVER_WIDTH
from stitchmesh.yarngen.tracing import end_crossings, link_ends, trace

THICKEST = 0.2
"""Largest yarn radius over the mean stitch width: beyond it loops have no room for the yarn they hold."""
NEAREST = 0.25
"""Smallest distance between yarns at the start, over the radius; touching yarns are 2 apart."""


@dataclass(frozen=True, eq=False)
class YarnCourse:
    """Yarn parts, and the order in which yarns run through them."""

    whole: StitchMesh
    """The stitch mesh with its bind-off row."""
    face_below: IntArray
    """Face of the given stitch mesh that each face of ``whole`` belongs to, shape (F,)."""
    parts: PlacedParts
    """The yarn parts of ``whole``."""
    bridges: Bridges
    """Where yarn goes elsewhere than across a side."""
    yarns: list[tuple[list[int], bool]]
    """Each yarn's part ends at which its parts are entered (``tracing``), and whether it is closed."""


def generate_yarns(
    fabric: StitchMesh, *, yarn_radius: float | None = None, quality: str | Quality = "standard",
    bind_off: str = "drawn", cast_on: str = "backward", longest_float: int = 12,
) -> YarnSet:  # fmt: skip
    """Yarn curves of a stitch mesh, each one path, linked as its stitches say.

    First rows are cast on, last rows bound off, row ends at borders joined in pairs or tied; rows of a tube are
    rings; rows of opposite wale direction are linked by rings of their own.

    Args:
        fabric: stitch faces, relaxed or not.
        yarn_radius: [cm]; an eighth of the mean stitch width unless given.
        quality: its ``control_points_per_stitch`` sets how finely yarns are drawn.
        bind_off: ``drawn``, a yarn through the last loops, or ``chain``, as knitters bind off: every loop is knitted
            and the one before passed over it.
        cast_on: ``backward`` loops, or ``open`` yarn-overs.
        longest_float: stitches of other yarns behind which a yarn is carried along its row; where there are more, as
            between the blocks of intarsia, it is cut and tied. 0 cuts at every change of yarn.

    Returns:
        Yarns whose rest lengths are as generated, but for the crossing legs of cables (``cables.ease_of``). ``face``
        refers to ``fabric``; bind-off yarn belongs to the last row's faces.

    Raises:
        ParameterError: the radius is not positive, or too thick for the stitches; a choice is unknown.
        YarnError: a face is not a stitch yet, has no template, or yarns start closer than a quarter of the radius.

    Source: Yuksel et al. 2012, sections 4 and 6.2.
    """
    radius = checked_radius(fabric, yarn_radius)
    panels = np.flatnonzero(fabric.stitch == Stitch.PANEL)
    if len(panels):
        raise YarnError(f"face {panels[0]}: is a panel of a coarse mesh, not a stitch; tessellate the mesh first")
    finish = Finish(bind_off, cast_on, longest_float)
    course = yarn_course(fabric, radius, quality_named(quality).control_points_per_stitch, finish)
    result = _assemble(course, radius)
    _check_clearance(result, radius)
    return result


def yarn_course(
    fabric: StitchMesh, radius: float, points_per_stitch: int, finish: Finish = DEFAULT_FINISH
) -> YarnCourse:
    """How the yarns of a stitch mesh run, for a yarn radius [cm] and so many points along a plain stitch."""
    whole = with_bind_off(fabric, CHAIN_HEIGHT if finish.bind_off == "chain" else DRAWN_HEIGHT)
    groups = cable_groups(whole)
    corners = opened_corners(whole, groups)
    rows = Rows(whole, radius, points_per_width(points_per_stitch))
    bridges = finish_row_ends(whole, strands_at_ends(rows, finish.longest_float))
    lay_floats(rows, finish.longest_float, bridges)
    parted = parted_corners(rows, corners)
    edge = edges(whole, bridges, finish)
    parts = place_parts(whole, radius, points_per_stitch, corner_position=parted, edge=edge)
    cross_loops(whole, groups, corners, radius, points_per_width(points_per_stitch), bridges)
    yarns = trace(link_ends(whole, parts, bridges))
    return YarnCourse(whole, _face_below(fabric, whole), parts, bridges, yarns)


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


def _assemble(course: YarnCourse, radius: float) -> YarnSet:
    parts = course.parts
    crossings = end_crossings(parts).tolist()
    yarns = [_pieces_of(parts, crossings, *entries_closed, course.bridges) for entries_closed in course.yarns]
    pieces = [piece for yarn in yarns for piece in yarn]
    sizes = [len(piece.points) for piece in pieces]
    start = np.concatenate([[0], np.cumsum([sum(len(piece.points) for piece in yarn) for yarn in yarns])])
    closed = np.array([flag for _, flag in course.yarns])
    control = control_points_through(np.concatenate([piece.points for piece in pieces]), start, closed)
    part = np.repeat([piece.part for piece in pieces], sizes)
    ease = np.repeat([piece.ease for piece in pieces], sizes)
    segments = segment_points(start, closed)
    return YarnSet(
        points=control,
        start=start,
        closed=closed,
        radius=np.full(len(closed), radius),
        rest_length=segment_lengths(control, segments) * ease[segments[:, 1:3]].mean(axis=1),
        row=parts.row[part],
        face=course.face_below[parts.face[part]],
        part=parts.index[part],
        colour=_colours(course),
    )


@dataclass(frozen=True, eq=False)
class _Piece:
    """Points of a yarn that belong together."""

    points: FloatArray
    """What the yarn passes through [cm], shape (n, 3)."""
    part: int
    """The yarn part that they belong to."""
    ease: float = 1.0
    """Rest length over drawn length."""


def _colours(course: YarnCourse) -> IntArray:
    """Yarn number of the stitches that each yarn was knitted in: those with its feet, for a head is the row's below."""
    is_foot = np.any(course.whole.is_wale[course.parts.end_side], axis=1).tolist()
    colours = []
    for entries, _ in course.yarns:
        own = next((entry // 2 for entry in entries if is_foot[entry // 2]), entries[0] // 2)
        colours.append(int(course.whole.yarn[course.parts.face[own]]))
    return np.array(colours)


def _pieces_of(
    parts: PlacedParts, crossings: list[int], entries: list[int], closed: bool, bridges: Bridges
) -> list[_Piece]:
    """The pieces of one yarn, bridges and tails included."""
    pieces = []
    if not closed:
        pieces.append(_Piece(bridges.tails[crossings[entries[0]]][::-1], entries[0] // 2))
    for entry, following in zip(entries, [*entries[1:], entries[0]], strict=True):
        part, last = entry // 2, entry ^ 1
        points = parts.points[parts.start[part] : parts.start[part + 1]]
        pieces.append(_Piece(points if entry % 2 == 0 else points[::-1], part))
        crossing = crossings[last]
        if crossing in bridges.ways:
            way = bridges.ways[crossing]
            pieces.append(_Piece(way.points, following // 2 if way.is_return else part, way.ease))
        elif crossing in bridges.tails:
            pieces.append(_Piece(bridges.tails[crossing], part))
    return pieces


def _check_clearance(yarns: YarnSet, radius: float) -> None:
    distance, point = smallest_distance(yarns, NEAREST * radius)
    if distance < NEAREST * radius:
        raise YarnError(
            f"face {yarns.face[point]}: yarns start {distance / radius:.2f} radii apart, expected at least {NEAREST}; "
            "relax the stitch mesh first, or use a thinner yarn"
        )
