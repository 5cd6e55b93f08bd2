# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""From stitch faces to yarns with the right topology."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from stitchmesh.errors import ParameterError, YarnError
from stitchmesh.mesh import BORDER, FloatArray, IntArray, StitchMesh
from stitchmesh.mesh.cable_groups import cable_groups
from stitchmesh.mesh.stitch import Stitch
from stitchmesh.quality import DEFAULT_QUALITY, Quality, quality_named
from stitchmesh.yarn import FLOATING, YarnSet, segment_points
from stitchmesh.yarngen.bind_off import DRAWN_HEIGHT, with_bind_off
from stitchmesh.yarngen.bridges import SAME_IMAGE, SLOTS, Bridges, Image
from stitchmesh.yarngen.cables import cross_loops, open_corners
from stitchmesh.yarngen.clearance import smallest_distance
from stitchmesh.yarngen.edge_choice import choose_edges
from stitchmesh.yarngen.embedding import PlacedParts, place_parts, points_per_width
from stitchmesh.yarngen.finish import DEFAULT_FINISH, YarnFinish
from stitchmesh.yarngen.floats_and_tails import Rows, carried_strands, lay_floats, separate_corners
from stitchmesh.yarngen.row_ends import finish_row_ends
from stitchmesh.yarngen.splines import control_points_through
from stitchmesh.yarngen.templates.edge_templates import CHAIN_HEIGHT
from stitchmesh.yarngen.templates.template import RADIUS_OVER_WIDTH
from stitchmesh.yarngen.tracing import end_crossings, link_ends, trace

LARGEST_RADIUS_OVER_WIDTH = 0.2
"""Largest yarn radius over the mean stitch width: beyond it loops have no room for the yarn they hold."""
SMALLEST_DISTANCE_OVER_RADIUS = 0.25
"""Smallest distance between yarns at the start, over the radius; touching yarns are 2 apart."""


@dataclass(frozen=True, eq=False)
class YarnRoutes:
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
    fabric: StitchMesh, *, yarn_radius: float | None = None, quality: str | Quality = DEFAULT_QUALITY,
    bind_off: str = YarnFinish.bind_off, cast_on: str = YarnFinish.cast_on,
    longest_float: int = YarnFinish.longest_float,
) -> YarnSet:  # fmt: skip
    """Yarn curves of a stitch mesh, each one path, linked as its stitches say.

    First rows are cast on, last rows bound off, row ends at borders joined in pairs or tied; rows of a tube are
    rings; rows of opposite wale direction are linked by rings of their own. On a lattice nothing begins or ends: each
    yarn is closed, or cut where a float would be too long, and its points lie one after another in space while it runs
    from image to image.

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
        Yarns whose rest lengths are as generated, but for the crossing legs of cables (``cables.crossing_rest_length_ratio``). ``face``
        refers to ``fabric``; bind-off yarn belongs to the last row's faces.

    Raises:
        ParameterError: the radius is not positive, or too thick for the stitches; a choice is unknown.
        YarnError: a face is not a stitch yet, has no template, or yarns start closer than a quarter of the radius; or
            a fabric on a lattice has borders.

    Source: Yuksel et al. 2012, sections 4 and 6.2.
    """
    radius = checked_radius(fabric, yarn_radius)
    panels = np.flatnonzero(fabric.stitch == Stitch.PANEL)
    if len(panels):
        raise YarnError(f"face {panels[0]}: is a panel of a coarse mesh, not a stitch; tessellate the mesh first")
    border = np.flatnonzero(fabric.twin == BORDER)
    if fabric.lattice is not None and len(border):
        raise YarnError(
            f"{fabric.side_name(border[0])}: is a border of a fabric on a lattice; one that repeats has neighbours all "
            "around, leave the lattice out or close the fabric"
        )
    finish = YarnFinish(bind_off, cast_on, longest_float)
    routes = trace_yarn_routes(fabric, radius, quality_named(quality).control_points_per_stitch, finish)
    result = yarns_along_routes(routes, radius)
    _check_clearance(result, radius)
    return result


def trace_yarn_routes(
    fabric: StitchMesh, radius: float, points_per_stitch: int, finish: YarnFinish = DEFAULT_FINISH
) -> YarnRoutes:
    """How the yarns of a stitch mesh run, for a yarn radius [cm] and so many points along a plain stitch."""
    whole = with_bind_off(fabric, CHAIN_HEIGHT if finish.bind_off == "chain" else DRAWN_HEIGHT)
    groups = cable_groups(whole)
    corners = open_corners(whole, groups)
    rows = Rows(whole, radius, points_per_width(points_per_stitch))
    bridges = finish_row_ends(whole, carried_strands(rows, finish.longest_float))
    lay_floats(rows, finish.longest_float, bridges)
    corner_position = separate_corners(rows, corners)
    edge = choose_edges(whole, bridges, finish)
    parts = place_parts(whole, radius, points_per_stitch, corner_position=corner_position, edge=edge)
    cross_loops(whole, groups, corners, radius, points_per_width(points_per_stitch), bridges)
    yarns = trace(link_ends(whole, parts, bridges))
    return YarnRoutes(whole, _face_below(fabric, whole), parts, bridges, yarns)


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
    if radius > LARGEST_RADIUS_OVER_WIDTH * width:
        raise ParameterError(
            f"yarn radius: got {radius:g} cm, too thick for stitches {width:.3g} cm wide; at most "
            f"{LARGEST_RADIUS_OVER_WIDTH * width:.3g} cm fits"
        )
    return float(radius)


def _face_below(fabric: StitchMesh, whole: StitchMesh) -> IntArray:
    """Face of ``fabric`` that each face of ``whole`` belongs to."""
    added = np.arange(fabric.face_count, whole.face_count)
    below = whole.side_face[whole.twin[whole.face_start[added]]]
    return np.concatenate([np.arange(fabric.face_count), below])


def yarns_along_routes(routes: YarnRoutes, radius: float) -> YarnSet:
    """The yarns of a course, of a radius [cm]."""
    parts = routes.parts
    yarns, steps = _yarns_in_pieces(routes)
    pieces = [piece for yarn in yarns for piece in yarn]
    sizes = [len(piece.points) for piece in pieces]
    start = np.concatenate([[0], np.cumsum([sum(len(piece.points) for piece in yarn) for yarn in yarns])])
    closed = np.array([flag for _, flag in routes.yarns])
    lattice, shift = routes.whole.lattice, routes.whole.shift(np.array([piece.image for piece in pieces]))
    points = np.concatenate([piece.points for piece in pieces]) + np.repeat(shift, sizes, axis=0)
    part = np.repeat([piece.part for piece in pieces], sizes)
    rest_length_ratio = np.repeat([piece.rest_length_ratio for piece in pieces], sizes)
    is_float = np.repeat([piece.is_float for piece in pieces], sizes)
    generated = YarnSet(
        points=control_points_through(points, start, closed, routes.whole.shift(steps)),
        start=start,
        closed=closed,
        radius=np.full(len(closed), radius),
        rest_length=np.ones(len(segment_points(start, closed))),
        row=parts.row[part],
        face=routes.face_below[parts.face[part]],
        part=np.where(is_float, FLOATING, parts.index[part]),
        colour=_colours(routes),
        lattice=lattice,
        lattice_step=None if lattice is None else steps,
    )
    return replace(
        generated, rest_length=generated.lengths * rest_length_ratio[generated.segment_points[:, 1:3]].mean(axis=1)
    )


def control_point_images(routes: YarnRoutes) -> IntArray:
    """The lattice image of its stitch in which each control point of the drawn yarns stands, shape (N, 2)."""
    pieces = [piece for yarn in _yarns_in_pieces(routes)[0] for piece in yarn]
    return np.repeat([piece.image for piece in pieces], [len(piece.points) for piece in pieces], axis=0)


@dataclass(frozen=True, eq=False)
class _Piece:
    """Points of a yarn that belong together."""

    points: FloatArray
    """What the yarn passes through [cm], shape (n, 3)."""
    part: int
    """The yarn part that they belong to."""
    rest_length_ratio: float
    """Rest length over drawn length."""
    image: Image
    """Lattice image in which the yarn is when it comes here."""
    is_float: bool = False
    """Whether they float behind stitches of other yarns."""


def _colours(routes: YarnRoutes) -> IntArray:
    """Yarn number of the stitches that each yarn was knitted in: those with its feet, for a head is the row's below."""
    is_foot = np.any(routes.whole.is_wale[routes.parts.end_side], axis=1).tolist()
    colours = []
    for entries, _ in routes.yarns:
        own = next((entry // 2 for entry in entries if is_foot[entry // 2]), entries[0] // 2)
        colours.append(int(routes.whole.yarn[routes.parts.face[own]]))
    return np.array(colours)


def _yarns_in_pieces(routes: YarnRoutes) -> tuple[list[list[_Piece]], IntArray]:
    """The pieces of each yarn, bridges and tails included, and the image in which a closed one ends, shape (Y, 2)."""
    crossings = end_crossings(routes.parts).tolist()
    images = routes.whole.side_image.tolist()
    yarns, steps = [], []
    for entries, closed in routes.yarns:
        pieces, step = _pieces_of(routes, crossings, images, entries, closed)
        yarns.append(pieces)
        steps.append(step)
    return yarns, np.array(steps)


def _pieces_of(
    routes: YarnRoutes, crossings: list[int], images: list[Image], entries: list[int], closed: bool
) -> tuple[list[_Piece], Image]:
    """The pieces of one yarn, from image to image as it crosses sides, and the image in which a closed one ends.

    Args:
        course: the course of all yarns.
        crossings: where each part end lies.
        images: of the face across each side.
        entries: the part ends at which the yarn's parts are entered.
        closed: whether the last part meets the first.
    """
    parts, bridges = routes.parts, routes.bridges
    pieces, image = [], SAME_IMAGE
    if not closed:
        pieces.append(_Piece(bridges.tails[crossings[entries[0]]][::-1], entries[0] // 2, 1.0, image))
    for entry, following in zip(entries, [*entries[1:], entries[0]], strict=True):
        part, crossing = entry // 2, crossings[entry ^ 1]
        points = parts.points[parts.start[part] : parts.start[part + 1]]
        pieces.append(_Piece(points if entry % 2 == 0 else points[::-1], part, 1.0, image))
        if crossing in bridges.tails:
            pieces.append(_Piece(bridges.tails[crossing], part, 1.0, image))
        elif crossing in bridges.paths:
            path = bridges.paths[crossing]
            before, image = image, (image[0] + path.image[0], image[1] + path.image[1])
            owner = (following // 2, image) if path.belongs_to_target else (part, before)
            pieces.append(_Piece(path.points, owner[0], path.rest_length_ratio, owner[1], path.is_float))
        else:
            across = images[crossing // SLOTS]
            image = (image[0] + across[0], image[1] + across[1])
    return pieces, image if closed else SAME_IMAGE


def _check_clearance(yarns: YarnSet, radius: float) -> None:
    distance, point = smallest_distance(yarns, SMALLEST_DISTANCE_OVER_RADIUS * radius)
    if distance < SMALLEST_DISTANCE_OVER_RADIUS * radius:
        raise YarnError(
            f"face {yarns.face[point]}: yarns start {distance / radius:.2f} radii apart, expected at least {SMALLEST_DISTANCE_OVER_RADIUS}; "
            "relax the stitch mesh first, or use a thinner yarn"
        )
