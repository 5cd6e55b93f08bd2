# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Generate yarns from stitch faces, so that the yarns are interlocked as the stitches define."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from stitchmesh.errors import ParameterError, YarnError, check_kind, check_positive
from stitchmesh.mesh import BORDER, FloatArray, IntArray, StitchMesh
from stitchmesh.mesh.cable_groups import cable_groups
from stitchmesh.mesh.stitch import Stitch
from stitchmesh.quality import DEFAULT_QUALITY, Quality, quality_named
from stitchmesh.yarn import APPARENT_OVER_CONTACT, FLOATING, YarnSet, segment_points
from stitchmesh.yarngen.bind_off import DRAWN_HEIGHT, choose_edges, drawn_sides, with_bind_off
from stitchmesh.yarngen.bridges import SLOTS, BridgePath, Bridges
from stitchmesh.yarngen.cables import cross_loops, open_corners
from stitchmesh.yarngen.edge_tension import edge_tension, rest_length_ratios
from stitchmesh.yarngen.embedding import PlacedParts, place_parts, points_per_width
from stitchmesh.yarngen.finish import DEFAULT_FINISH, YarnFinish
from stitchmesh.yarngen.floats_and_tails import FloatRows, carried_strands, lay_floats, separate_corners
from stitchmesh.yarngen.row_ends import finish_row_ends
from stitchmesh.yarngen.splines import control_points_through
from stitchmesh.yarngen.templates.edge_templates import CHAIN_HEIGHT
from stitchmesh.yarngen.templates.template import RADIUS_OVER_WIDTH
from stitchmesh.yarngen.tracing import TIED, end_crossings, link_ends, trace

LARGEST_RADIUS_OVER_WIDTH = 0.2
"""Largest yarn radius over the mean stitch width. Thicker yarn does not fit into the loops that hold it."""
LARGEST_DRAWN_OVER_CONTACT = 5.0
"""Largest apparent radius over contact radius: at five radii even stitches far apart would fill one another."""
SMALLEST_DISTANCE_OVER_RADIUS = 0.25
"""Smallest distance between the centre lines of generated yarns, over the radius. Touching yarns are 2 apart."""


@dataclass(frozen=True, eq=False)
class YarnRoutes:
    """Yarn parts on a stitch mesh, and the order in which each yarn runs through them."""

    whole: StitchMesh
    """The stitch mesh with its bind-off row."""
    face_below: IntArray
    """Face of the given stitch mesh to which each face of ``whole`` belongs, shape (F,). A bind-off face belongs to the
    face below it."""
    parts: PlacedParts
    """The yarn parts of ``whole``."""
    bridges: Bridges
    """Bridges and tails, where yarn does not continue across a side."""
    yarns: list[tuple[list[int], bool]]
    """For each yarn the part ends at which the yarn enters its parts (``tracing``), and whether the yarn is closed."""
    tension: FloatArray
    """Rest length of the yarn in each face of ``whole`` over its length without tension (``edge_tension``), shape
    (F,)."""


def generate_yarns(
    fabric: StitchMesh, *, yarn_radius: float | None = None, drawn_radius: float | None = None,
    mass_per_length: float | None = None, quality: str | Quality = DEFAULT_QUALITY,
    finish: YarnFinish = DEFAULT_FINISH, device: str | None = "cpu",
) -> YarnSet:  # fmt: skip
    """Generate the yarn curves of a stitch mesh. Each yarn is one path, and the yarns interlock as the stitches define.

    First rows are cast on and last rows are bound off. Row ends at borders are joined in pairs or tied off. A row of a
    tube is a closed ring. Two rows of opposite wale direction are linked by small rings of their own. On a lattice no
    yarn begins or ends: each yarn is closed, unless it is cut because a float would be too long. The points of a yarn
    then follow each other in space, while the yarn runs from lattice image to lattice image.

    Args:
        fabric: stitch faces, relaxed or not.
        yarn_radius: contact radius of the yarn [cm]; an eighth of the mean stitch width if not given.
        drawn_radius: apparent radius of the yarn in pictures and files for renderers [cm];
            ``APPARENT_OVER_CONTACT`` contact radii if not given.
        mass_per_length: mass of a length of yarn [g/cm] that the yarns state (``YarnSet``); none if not given.
        quality: its ``control_points_per_stitch`` is the number of control points of a plain stitch.
        finish: how the first and the last rows are finished, and the largest number of stitches of other yarns behind
            which a yarn is carried along its row. A yarn that would pass more stitches, as between the blocks of
            intarsia, is cut and tied off. 0 cuts at every change of yarn.
        device: where the distances of the yarns are checked: "cpu", "cuda:0" ...; None for the first GPU, or the CPU if
            there is no GPU. The yarns do not depend on it.

    Returns:
        Yarns whose rest lengths are their generated lengths, except for the crossing legs of cables
        (``cables.crossing_rest_length_ratio``), for increases and decreases (``edge_tension``), and for edges
        (``edge_tension``), which are shorter. ``face`` refers to ``fabric``; bind-off yarn belongs to the faces of
        the last row.

    Raises:
        ParameterError: a radius or the mass is not positive, a radius is too large for the stitches, or the
            device is unknown.
        YarnError: a face is a panel or has no template, two yarns start closer than a quarter of the radius, or a
            fabric on a lattice has borders.

    Source: Yuksel et al. 2012, sections 4 and 6.2.
    """
    check_kind("generate_yarns", fabric, StitchMesh)
    radius = checked_radius(fabric, yarn_radius)
    drawn = checked_drawn_radius(radius, drawn_radius)
    panels = np.flatnonzero(fabric.stitch == Stitch.PANEL)
    if len(panels):
        raise YarnError(f"face {panels[0]}: is a panel of a coarse mesh, not a stitch; tessellate the mesh first")
    border = np.flatnonzero(fabric.twin == BORDER)
    if fabric.lattice is not None and len(border):
        raise YarnError(
            f"{fabric.side_name(border[0])}: is a border of a fabric on a lattice; a periodic fabric has no "
            "borders, remove the lattice or close the fabric"
        )
    routes = trace_yarn_routes(fabric, radius, quality_named(quality).control_points_per_stitch, finish)
    result = yarns_along_routes(routes, radius)
    _check_clearance(result, radius, device)
    mass = np.nan
    if mass_per_length is not None:
        check_positive("mass per length", mass_per_length, "g/cm")
        mass = mass_per_length
    return replace(
        result, drawn_radius=np.full(result.yarn_count, drawn), mass_per_length=np.full(result.yarn_count, mass)
    )


def trace_yarn_routes(
    fabric: StitchMesh, radius: float, points_per_stitch: int, finish: YarnFinish = DEFAULT_FINISH
) -> YarnRoutes:
    """The routes of all yarns through a stitch mesh.

    Args:
        fabric: stitch faces.
        radius: yarn radius [cm].
        points_per_stitch: number of points along one plain loop.
        finish: the finish of first and last rows, and the longest float.

    Raises:
        YarnError: a face has no template, two parts use the same crossing, or a loop is not held.
    """
    whole = with_bind_off(fabric, CHAIN_HEIGHT if finish.bind_off == "chain" else DRAWN_HEIGHT)
    groups = cable_groups(whole)
    corners = open_corners(whole, groups)
    rows = FloatRows(whole, radius, points_per_width(points_per_stitch))
    bridges = finish_row_ends(whole, carried_strands(rows, finish.longest_float))
    lay_floats(rows, finish.longest_float, bridges)
    corner_position = separate_corners(rows, corners)
    edge = choose_edges(whole, bridges, finish, drawn_sides(fabric))
    parts = place_parts(whole, radius, points_per_stitch, corner_position=corner_position, edge=edge)
    cross_loops(whole, groups, corners, radius, points_per_width(points_per_stitch), bridges)
    yarns = trace(link_ends(whole, parts, bridges))
    return YarnRoutes(whole, _face_below(fabric, whole), parts, bridges, yarns, edge_tension(whole, edge, parts))


def mean_stitch_width(fabric: StitchMesh) -> float:
    """Mean length of the course sides [cm]."""
    return float(fabric.side_length[~fabric.is_wale].mean())


def checked_radius(fabric: StitchMesh, radius: float | None) -> float:
    """The yarn radius [cm] for these stitches; an eighth of the mean stitch width if ``radius`` is not given.

    Raises:
        ParameterError: the radius is not positive, or it is too large for the stitches.
    """
    width = mean_stitch_width(fabric)
    if radius is None:
        return RADIUS_OVER_WIDTH * width
    check_positive("yarn radius", radius, "cm")
    if radius > LARGEST_RADIUS_OVER_WIDTH * width:
        raise ParameterError(
            f"yarn radius: got {radius:g} cm, too thick for stitches {width:.3g} cm wide; at most "
            f"{LARGEST_RADIUS_OVER_WIDTH * width:.3g} cm fits"
        )
    return float(radius)


def checked_drawn_radius(radius: float, drawn: float | None) -> float:
    """The apparent radius [cm] of yarn with a contact radius; ``APPARENT_OVER_CONTACT`` radii if ``drawn`` is None.

    Raises:
        ParameterError: the apparent radius is not positive, or not from a half to ``LARGEST_DRAWN_OVER_CONTACT``
            contact radii.
    """
    if drawn is None:
        return APPARENT_OVER_CONTACT * radius
    least, most = 0.5 * radius, LARGEST_DRAWN_OVER_CONTACT * radius
    if not least <= drawn <= most:
        raise ParameterError(
            f"drawn radius: got {drawn:g} cm for yarn with a contact radius of {radius:.3g} cm; expected "
            f"{least:.3g} to {most:.3g} cm"
        )
    return float(drawn)


def _face_below(fabric: StitchMesh, whole: StitchMesh) -> IntArray:
    """Face of ``fabric`` to which each face of ``whole`` belongs, shape (F,)."""
    added = np.arange(fabric.face_count, whole.face_count)
    below = whole.side_face[whole.twin[whole.face_start[added]]]
    return np.concatenate([np.arange(fabric.face_count), below])


def yarns_along_routes(routes: YarnRoutes, radius: float) -> YarnSet:
    """The yarns along their routes.

    Args:
        routes: the routes of all yarns.
        radius: yarn radius [cm].
    """
    pieces, steps = pieces_along(routes)
    start = np.concatenate([[0], np.cumsum(np.bincount(pieces.yarn, pieces.count, len(routes.yarns)).astype(np.int64))])
    closed = np.array([flag for _, flag in routes.yarns])
    parts, lattice, whole = routes.parts, routes.whole.lattice, routes.whole
    points = pieces.points[pieces.order]
    if lattice is not None:
        points += np.repeat(whole.shift(pieces.image), pieces.count, axis=0)
    part = np.repeat(pieces.part, pieces.count)
    generated = YarnSet(
        points=control_points_through(points, start, closed, whole.shift(steps)),
        start=start,
        closed=closed,
        radius=np.full(len(closed), radius),
        rest_length=np.ones(len(segment_points(start, closed))),
        row=parts.row[part],
        face=routes.face_below[parts.face[part]],
        part=np.repeat(np.where(pieces.is_float, FLOATING, parts.index[pieces.part]), pieces.count),
        colour=_colours(routes),
        lattice=lattice,
        lattice_step=None if lattice is None else steps,
        palette=whole.palette,
    )
    ratio = np.repeat(pieces.rest_length_ratio, pieces.count)[generated.segment_points[:, 1:3]].mean(axis=1)
    return replace(generated, rest_length=generated.lengths * ratio)


def control_point_images(routes: YarnRoutes) -> IntArray:
    """The lattice image of its stitch in which each control point of the generated yarns lies, shape (N, 2)."""
    pieces, _ = pieces_along(routes)
    return np.repeat(pieces.image, pieces.count, axis=0)


@dataclass(frozen=True, eq=False)
class RoutePieces:
    """Pieces of the yarns, one after another: consecutive points on one part, one bridge or one tail."""

    points: FloatArray
    """Points of all parts, bridges and tails [cm], shape (M, 3)."""
    first: IntArray
    """The row of ``points`` at which each piece begins, shape (P,)."""
    forward: IntArray
    """1, or -1 where the yarn passes the rows of a piece in falling order, shape (P,)."""
    count: IntArray
    """Number of points of each piece, shape (P,)."""
    yarn: IntArray
    """Yarn of each piece, ascending, shape (P,)."""
    part: IntArray
    """Yarn part to which the points of each piece belong, shape (P,)."""
    image: IntArray
    """Lattice image of this yarn part, shape (P, 2)."""
    rest_length_ratio: FloatArray
    """Rest length over generated length, shape (P,)."""
    is_part: np.ndarray
    """Whether a piece is a part, not a bridge or a tail, shape (P,)."""
    is_float: np.ndarray
    """Whether a piece is a float, which lies behind stitches of other yarns, shape (P,)."""

    @property
    def order(self) -> IntArray:
        """Rows of ``points`` in the order of the yarns."""
        place = np.arange(self.count.sum()) - np.repeat(np.cumsum(self.count) - self.count, self.count)
        return np.repeat(self.first, self.count) + np.repeat(self.forward, self.count) * place


def _colours(routes: YarnRoutes) -> IntArray:
    """Yarn number of the stitches in which each yarn was knitted, shape (Y,).

    The number comes from a stitch in which the yarn has a foot, because a head belongs to the row below.
    """
    is_foot = np.any(routes.whole.is_wale[routes.parts.end_side], axis=1).tolist()
    colours = []
    for entries, _ in routes.yarns:
        own = next((entry // 2 for entry in entries if is_foot[entry // 2]), entries[0] // 2)
        colours.append(int(routes.whole.yarn[routes.parts.face[own]]))
    return np.array(colours)


def pieces_along(routes: YarnRoutes) -> tuple[RoutePieces, IntArray]:
    """The pieces of all yarns, and the lattice image in which each closed yarn ends, shape (Y, 2)."""
    parts, bridges = routes.parts, routes.bridges
    sizes, closed = [len(entries) for entries, _ in routes.yarns], np.array([closed for _, closed in routes.yarns])
    entry = np.array([entry for entries, _ in routes.yarns for entry in entries])
    yarn, last = np.repeat(np.arange(len(sizes)), sizes), np.cumsum(sizes) - 1
    first = last + 1 - sizes
    following = np.roll(entry, -1)
    following[last] = entry[first]
    crossings = end_crossings(parts)

    strands = _Strands.of(routes.whole, bridges)
    after = strands.at[crossings[entry ^ 1]]
    moves = np.where(after < 0, routes.whole.side_image[crossings[entry ^ 1] // SLOTS].T, strands.image[after].T).T
    ends = np.cumsum(moves, axis=0)
    image = ends - moves
    image, ends = image - image[first][yarn], ends - image[first][yarn]
    is_opening = np.zeros(len(entry), dtype=bool)
    is_opening[first] = ~closed
    before = np.where(is_opening, strands.at[crossings[entry]], -1)

    # Three pieces for each entry: the tail before it, the part, and the bridge or the tail after it
    own, target = entry // 2, strands.belongs_to_target[after]
    own_size, strand_size = np.diff(parts.start)[own], np.append(np.diff(strands.start), 0)
    size = np.stack([strand_size[before], own_size, strand_size[after]], axis=1)
    backward = np.stack([np.ones_like(own), entry % 2, np.zeros_like(own)], axis=1)
    begin = np.stack([strands.start[before], parts.start[own], strands.start[after]], axis=1)
    begin[:, [0, 2]] += len(parts.points)
    ratio = rest_length_ratios(routes.whole, parts) * routes.tension[parts.face]
    exists = np.stack([before >= 0, np.ones_like(is_opening), after >= 0], axis=1)
    pieces = RoutePieces(
        points=np.concatenate([parts.points, strands.points]),
        first=(begin + backward * (size - 1))[exists],
        forward=(1 - 2 * backward)[exists],
        count=size[exists],
        yarn=np.stack([yarn] * 3, axis=1)[exists],
        part=np.stack([own, own, np.where(target, following // 2, own)], axis=1)[exists],
        image=np.stack([image, image, np.where(target[:, None], ends, image)], axis=1)[exists],
        rest_length_ratio=np.stack([np.ones(len(own)), ratio[own], strands.rest_length_ratio[after]], axis=1)[exists],
        is_part=np.stack([np.full_like(is_opening, kind == 1) for kind in range(3)], axis=1)[exists],
        is_float=np.stack([np.zeros_like(is_opening)] * 2 + [strands.is_float[after]], axis=1)[exists],
    )
    return pieces, np.where(closed[:, None], ends[last], 0)


@dataclass(frozen=True, eq=False)
class _Strands:
    """All tails and bridges as arrays; the last element of each array stands for a place without a strand."""

    at: IntArray
    """The strand that begins at each crossing, -1 for none, shape (C * SLOTS,)."""
    points: FloatArray
    """Points of all strands [cm], shape (M, 3)."""
    start: IntArray
    """First point of each strand, shape (T + 1,)."""
    image: IntArray
    """Lattice image at the other end of each strand, shape (T + 1, 2)."""
    belongs_to_target: np.ndarray
    """Whether the points belong to the part at the other end, shape (T + 1,)."""
    rest_length_ratio: FloatArray
    """Rest length over generated length, shape (T + 1,)."""
    is_float: np.ndarray
    """Whether the strand is a float, shape (T + 1,)."""

    @classmethod
    def of(cls, fabric: StitchMesh, bridges: Bridges) -> _Strands:
        """The tails and bridges of a fabric."""
        no_points = np.zeros((0, 3))
        tails = [BridgePath(TIED, tail, belongs_to_target=False) for tail in bridges.tails.values()]
        strands = [*bridges.paths.values(), *tails, BridgePath(TIED, no_points, belongs_to_target=False)]
        at = np.full(fabric.side_count * SLOTS, -1)
        crossings = [*bridges.paths, *bridges.tails]
        at[crossings] = np.arange(len(crossings))
        return cls(
            at=at,
            points=np.concatenate([strand.points for strand in strands]),
            start=np.concatenate([[0], np.cumsum([len(strand.points) for strand in strands[:-1]], dtype=np.int64)]),
            image=np.array([strand.image for strand in strands]),
            belongs_to_target=np.array([strand.belongs_to_target for strand in strands]),
            rest_length_ratio=np.array([strand.rest_length_ratio for strand in strands]),
            is_float=np.array([strand.is_float for strand in strands]),
        )


def _check_clearance(yarns: YarnSet, radius: float, device: str | None) -> None:
    """Raise ``YarnError`` if two yarns start closer than the smallest permitted distance."""
    from stitchmesh.yarngen.clearance import smallest_distance

    distance, points = smallest_distance(yarns, SMALLEST_DISTANCE_OVER_RADIUS * radius, device)
    if distance < SMALLEST_DISTANCE_OVER_RADIUS * radius:
        place = yarns.points[points[0]].round(1).tolist()
        one, other = yarns.face[list(points)].tolist()
        raise YarnError(
            f"face {one}{'' if one == other else f' and {other}'}: yarns start {distance / radius:.2f} radii apart, "
            f"expected at least {SMALLEST_DISTANCE_OVER_RADIUS}",
            face=one,
            remedy=f"near {place} cm, relax the stitch mesh first, make room (sm.make_room), or use a thinner yarn",
        )
