# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The strands of all faces of a face mesh, in space, and which of their ends meet.

A drawing is mapped to its face by mean value coordinates of its polygon. A height moves a point along the normal of the
face, in the scale of the face. Where two sides are joined, each crossing of one side meets the nearest crossing of the
other. Yarns end at crossings that meet no other. The two legs of a loop on a side that is not joined are an exception:
they meet each other.

The drawing of a type of face comes from the user's libraries, from the stitch that the type is, or from its labels. A
drawing from labels is for types that no library has. It has the right strands at the right sides, and they lie as far
as possible as the labels and the name tell:

- Loops that enter and leave run straight through, and the yarn of the row passes behind them.
- Where loops enter and none leave, they end in an arch, like the loops of a dropped stitch.
- Where loops leave and none enter, they are made of the yarn of the row, like the loops of a tuck.
- Knits and purls on several loops or with several yarns have arches of the loops below, and legs of the yarn through
  them.
- Two threads that cross, as in a weave: the first one is in front, unless the name begins with ``under``.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np

from stitchmesh.errors import YarnError
from stitchmesh.faces.face_drawing import FaceDrawing, FaceLibrary, SideCrossing, Strand
from stitchmesh.faces.face_mesh import FaceMesh
from stitchmesh.faces.face_type import ENTERING, LEAVING, LOOP, YARN, FaceType, stitch_of
from stitchmesh.mesh import FloatArray
from stitchmesh.mesh.mean_value import mean_value_weights
from stitchmesh.mesh.stitch import Stitch
from stitchmesh.yarngen.templates.table import template
from stitchmesh.yarngen.templates.template import (
    FOOT_SHARE,
    RADIUS_OVER_WIDTH,
    STITCH_HEIGHT,
    Crossing,
    Template,
    crossing_point,
)  # fmt: skip

POINTS_PER_STRAND = 10
"""Points of the control polygon of a strand of a stitch; the curve of the polygon keeps within 1 % of a stitch width of
the strand."""
LEGS = (0.25, 0.75)
"""Places where the two legs of a loop cross a side."""
RADIUS = RADIUS_OVER_WIDTH
"""Yarn radius of a drawing, in stitch widths."""
MOST_STRANDS = 20
"""Most loops or yarns on a side of a face that is drawn from its labels."""
SPREAD = 0.12
"""Distance of neighbouring strands along a side, as a share of the side."""
FREE = -1
"""Stands for the partner of an end of a strand that meets no other end: the yarn ends there."""


def drawing_of(kind: FaceType, library: FaceLibrary) -> tuple[FaceDrawing, bool]:
    """Return the drawing of a type, and whether it was made from its labels."""
    found = library.find(kind)
    if found is not None:
        return found, False
    stitch = stitch_of(kind)
    if stitch is not None and stitch != Stitch.PANEL:
        return _of_stitch(kind, stitch), False
    return _from_labels(kind), True


def _of_stitch(kind: FaceType, stitch: Stitch) -> FaceDrawing:
    n_bottom = sum(side.kind == LOOP and side.direction == ENTERING for side in kind.sides)
    shape = template(stitch, n_bottom, len(kind.sides) - n_bottom - 2)
    return FaceDrawing(kind, shape.polygon, tuple(_strands(shape)))


def _strands(shape: Template) -> list[Strand]:
    scale = [1.0, 1.0, RADIUS]
    ends = [(_crossing(shape, part.start), _crossing(shape, part.end)) for part in shape.parts]
    inner = [part.resampled(POINTS_PER_STRAND) * scale for part in shape.parts]
    return [Strand(start, points, end) for (start, end), points in zip(ends, inner, strict=True)]


def _crossing(shape: Template, crossing: Crossing) -> SideCrossing:
    """Return the place of a crossing of a template along its side."""
    point = np.array(crossing_point(shape.n_bottom, shape.n_top, crossing)[:2])
    start, end = shape.polygon[crossing.place], np.roll(shape.polygon, -1, axis=0)[crossing.place]
    along = float(np.linalg.norm(point - start) / np.linalg.norm(end - start))
    return SideCrossing(crossing.place, along, 0.0)


def _from_labels(kind: FaceType) -> FaceDrawing:
    """Return a drawing that shows what the labels of a type say.

    Raises:
        YarnError: a side has too many strands.
    """
    if max(side.strands for side in kind.sides) > MOST_STRANDS:
        raise YarnError(f"face type {kind}: got more than {MOST_STRANDS} strands on a side; give a library (--faces)")
    polygon = _polygon(kind)
    entering, leaving = _places(kind, LOOP, ENTERING), _places(kind, LOOP, LEAVING)
    yarn = [place for place in (_places(kind, YARN, ENTERING), _places(kind, YARN, LEAVING)) if place]
    feeds = list(zip(*yarn, strict=False)) if len(yarn) == 2 else []
    knits = kind.name.startswith(("knit", "purl")) and entering and leaving and feeds
    strands: list[Strand] = []
    if knits or not leaving or not entering:
        strands += _arches(entering, polygon, kind)
        strands += _made_loops(leaving, feeds, polygon, kind)
    else:
        strands += _straight_loops(entering, leaving, polygon)
        strands += [_between(_foot(a, kind), _foot(b, kind), polygon, -RADIUS) for a, b in feeds]
    return FaceDrawing(kind, polygon, (*strands, *_threads(kind, polygon)))


Place = tuple[int, int, int]
"""A side, the number of a strand on it, and the number of strands of the side."""


def _places(kind: FaceType, letter: str, direction: int) -> list[Place]:
    """Return the strands of all sides of a kind and direction, from left to right for sides on top."""
    sides = [k for k, side in enumerate(kind.sides) if (side.kind, side.direction) == (letter, direction)]
    ordered = sides if direction == ENTERING else sides[::-1]
    return [(side, k, kind.sides[side].strands) for side in ordered for k in range(kind.sides[side].strands)]


def _polygon(kind: FaceType) -> FloatArray:
    """Return a regular polygon whose first side lies at the bottom and has the length of a stitch width."""
    count = len(kind.sides)
    angle = 2 * np.pi * (np.arange(count) - 0.5) / count - np.pi / 2
    corners = np.stack([np.cos(angle), np.sin(angle)], axis=1) / (2 * np.sin(np.pi / count))
    return corners * [1.0, STITCH_HEIGHT] if count == 4 else corners


def _arches(entering: list[Place], polygon: FloatArray, kind: FaceType) -> list[Strand]:
    """Return loops that enter and turn back; the loops of a purl turn in front of the legs."""
    front = -1.0 if kind.name.startswith("purl") else 1.0
    return [_arch(place, polygon, front) for place in entering]


def _arch(place: Place, polygon: FloatArray, front: float) -> Strand:
    side, strand, count = place
    level = _level(strand, count)
    start, end = (SideCrossing(side, leg, level) for leg in LEGS)
    first, last = (_point(polygon, crossing) for crossing in (start, end))
    inward = _inward(polygon, side)
    reach, low = inward * (0.75 * STITCH_HEIGHT), inward * (0.3 * STITCH_HEIGHT)
    middle = [first + low, first + 0.8 * reach, (first + last) / 2 + reach, last + 0.8 * reach, last + low]
    height = level + front * RADIUS * np.array([1.0, -1.2, -1.5, -1.2, 1.0])
    return Strand(start, np.column_stack([middle, height]), end)


def _made_loops(
    leaving: list[Place], feeds: list[tuple[Place, Place]], polygon: FloatArray, kind: FaceType
) -> list[Strand]:
    """Return the legs of loops that the yarn makes, yarn by yarn; further yarns run straight through."""
    front = -1.0 if kind.name.startswith("purl") else 1.0
    strands = []
    for number, (enters, leaves) in enumerate(feeds):
        first, last, loops = _foot(enters, kind), _foot(leaves, kind), leaving[number :: len(feeds)]
        legs = [SideCrossing(side, leg, _level(k, n)) for side, k, n in loops for leg in LEGS[::-1]]
        ends = [first, *(legs[::-1] if _runs_left(polygon, enters, leaves) else legs), last]
        pairs = zip(ends[::2], ends[1::2], strict=True)
        strands += [_leg(a, b, polygon, front) if legs else _between(a, b, polygon, 0.0) for a, b in pairs]
    return strands


def _runs_left(polygon: FloatArray, enters: Place, leaves: Place) -> bool:
    middles = (polygon + np.roll(polygon, -1, axis=0)) / 2
    return bool(middles[enters[0], 0] > middles[leaves[0], 0])


def _leg(start: SideCrossing, end: SideCrossing, polygon: FloatArray, front: float) -> Strand:
    """Return yarn that passes behind at the foot and comes to the front on its way up."""
    first, last = _point(polygon, start), _point(polygon, end)
    points = [first + share * (last - first) for share in (0.35, 0.7)]
    heights = np.array([-1.2, 1.2]) * front * RADIUS + [start.height, end.height]
    return Strand(start, np.column_stack([points, heights]), end)


def _straight_loops(entering: list[Place], leaving: list[Place], polygon: FloatArray) -> list[Strand]:
    """Return the legs of loops that enter from below and leave on top; the left leg below is the left leg on top."""
    strands = []
    for (side, k, n), (across, m, count) in zip(entering, leaving, strict=False):
        for leg in LEGS:
            start, end = SideCrossing(side, leg, _level(k, n)), SideCrossing(across, 1.0 - leg, _level(m, count))
            strands.append(_between(start, end, polygon, RADIUS))
    return strands


def _between(start: SideCrossing, end: SideCrossing, polygon: FloatArray, height: float) -> Strand:
    first, last = _point(polygon, start), _point(polygon, end)
    points = [first + share * (last - first) for share in (1 / 3, 2 / 3)]
    heights = [height + start.height, height + end.height]
    return Strand(start, np.column_stack([points, heights]), end)


def _across(place: Place) -> SideCrossing:
    side, strand, count = place
    return SideCrossing(side, 0.5 + SPREAD * (strand - (count - 1) / 2), 0.0)


def _foot(place: Place, kind: FaceType) -> SideCrossing:
    """Return the crossing of yarn at the foot of a wale side of a stitch-like face."""
    side, strand, _ = place
    lower = SPREAD * strand + FOOT_SHARE
    return SideCrossing(side, lower if side * 2 < len(kind.sides) else 1.0 - lower, 0.0)


def _threads(kind: FaceType, polygon: FloatArray) -> list[Strand]:
    """Return straight threads between sides of any other kind that enter and leave, the first ones in front."""
    words = dict.fromkeys(side.kind for side in kind.sides if side.kind not in (LOOP, YARN))
    front = -RADIUS if kind.name.startswith("under") else RADIUS
    strands = []
    for word in words:
        pairs = zip(_places(kind, word, ENTERING), _places(kind, word, LEAVING), strict=False)
        strands += [_between(_across(a), _across(b), polygon, front) for a, b in pairs]
        front = -front
    return strands


def _level(strand: int, count: int) -> float:
    """Return the height of one of several loops on a side."""
    return 2.0 * RADIUS * ((count - 1) / 2 - strand)


def _point(polygon: FloatArray, crossing: SideCrossing) -> FloatArray:
    start, end = polygon[crossing.side], polygon[(crossing.side + 1) % len(polygon)]
    point: FloatArray = start + crossing.along * (end - start)
    return point


def _inward(polygon: FloatArray, side: int) -> FloatArray:
    """Return the unit vector from a side into a polygon that runs counter-clockwise."""
    along = polygon[(side + 1) % len(polygon)] - polygon[side]
    inward: FloatArray = np.array([-along[1], along[0]]) / np.linalg.norm(along)
    return inward


@dataclass(frozen=True, eq=False)
class PlacedStrand:
    """A strand on its face."""

    face: int
    """The face."""
    points: FloatArray
    """Control polygon from crossing to crossing [cm], shape (n, 3)."""
    ends: tuple[SideCrossing, SideCrossing]
    """Where the strand starts and ends."""


@dataclass(frozen=True)
class PlacedDrawings:
    """The strands of all faces, and the types that were drawn from their labels."""

    strands: tuple[PlacedStrand, ...]
    """The strands, face by face."""
    by_labels: tuple[FaceType, ...]
    """Types of faces that are no stitches and that no library has."""


def place_drawings(mesh: FaceMesh, library: FaceLibrary) -> PlacedDrawings:
    """Return the strands of all faces.

    Raises:
        YarnError: no face has a strand.
    """
    drawings = {kind: drawing_of(mesh.types[kind], library) for kind in sorted(set(mesh.face_type.tolist()))}
    strands: list[PlacedStrand] = []
    for face, kind in enumerate(mesh.face_type.tolist()):
        strands += _on_face(face, mesh.corners_of(face), drawings[kind][0])
    if not strands:
        raise YarnError("face mesh: no type of its faces has yarn; give a library that draws them (--faces)")
    return PlacedDrawings(tuple(strands), tuple(drawn.type for drawn, by_labels in drawings.values() if by_labels))


def _on_face(face: int, corners: FloatArray, drawing: FaceDrawing) -> list[PlacedStrand]:
    normal, scale = _normal(corners), _perimeter(corners) / _perimeter(drawing.polygon)
    placed = []
    for strand in drawing.strands:
        flat = np.concatenate(
            [_at(drawing.polygon, strand.start), strand.points, _at(drawing.polygon, strand.end)], axis=0
        )
        points = _mapped(drawing.polygon, flat[:, :2], corners) + flat[:, 2:] * scale * normal
        placed.append(PlacedStrand(face, points, (strand.start, strand.end)))
    return placed


def _mapped(polygon: FloatArray, points: FloatArray, corners: FloatArray) -> FloatArray:
    """Return the places of points of a drawing on a face; loops may bulge beyond the polygon."""
    weights = mean_value_weights(polygon, points)
    mapped: FloatArray = weights @ corners
    return mapped


def _at(polygon: FloatArray, crossing: SideCrossing) -> FloatArray:
    start, end = polygon[crossing.side], polygon[(crossing.side + 1) % len(polygon)]
    return np.array([[*(start + crossing.along * (end - start)), crossing.height]])


def _normal(corners: FloatArray) -> FloatArray:
    """Return the unit normal of a polygon; zero if it has no area."""
    spokes = corners - corners.mean(axis=0)
    area = np.cross(spokes, np.roll(spokes, -1, axis=0)).sum(axis=0)
    length = float(np.linalg.norm(area))
    return area / length if length > 0.0 else np.zeros(3)


def _perimeter(corners: FloatArray) -> float:
    return float(np.linalg.norm(np.roll(corners, -1, axis=0) - corners, axis=1).sum())


def partners_of_ends(mesh: FaceMesh, strands: Sequence[PlacedStrand]) -> list[int]:
    """Return the end that meets each end, ``FREE`` where a yarn ends.

    End ``2 s`` is the start of strand ``s`` and end ``2 s + 1`` is its end.
    """
    on_side = ends_by_side(mesh, strands)
    partner = [FREE] * (2 * len(strands))
    for (first, second), reverses in zip(mesh.joins.tolist(), mesh.reverses.tolist(), strict=True):
        for a, b in _nearest_pairs(on_side.pop(first, []), _seen_across(on_side.pop(second, []), reverses)):
            partner[a], partner[b] = b, a
    for corner, ends in on_side.items():
        face, side = mesh.side_at(corner)
        if mesh.type_of(face).sides[side].kind == LOOP:
            for (_, _, a), (_, _, b) in zip(ends[: len(ends) // 2], reversed(ends), strict=False):
                partner[a], partner[b] = b, a
    return partner


End = tuple[float, float, int]
"""Share along a side, height, and number of an end that crosses the side there."""


def ends_by_side(mesh: FaceMesh, strands: Sequence[PlacedStrand]) -> dict[int, list[End]]:
    """Return the ends on each side that any cross, in their order along the side."""
    found: dict[int, list[End]] = {}
    for number, strand in enumerate(strands):
        for k, crossing in enumerate(strand.ends):
            corner = int(mesh.face_start[strand.face]) + crossing.side
            found.setdefault(corner, []).append((crossing.along, crossing.height, 2 * number + k))
    return {corner: sorted(ends) for corner, ends in found.items()}


def _seen_across(ends: Iterable[End], reverses: bool) -> list[End]:
    """Return the ends of a side, as seen from the side that is joined to it; without reversal the cloth turns over."""
    return [(1.0 - along, height, end) if reverses else (along, -height, end) for along, height, end in ends]


def _nearest_pairs(ends: list[End], others: list[End]) -> list[tuple[int, int]]:
    """Pair the ends of two sides, the nearest ones first."""
    distances = sorted(
        (abs(along - there) + 0.1 * abs(height - high), a, b) for along, height, a in ends for there, high, b in others
    )
    used: set[int] = set()
    pairs = []
    for _, a, b in distances:
        if not used & {a, b}:
            used |= {a, b}
            pairs.append((a, b))
    return pairs
