# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The strands of all faces of a face mesh, in space, and which of their ends meet.

A drawing is mapped to its face by mean value coordinates of its polygon. A height moves a point along the normal of the
face, scaled as the face is. Of two sides that are joined, each crossing of one side meets the nearest crossing of the
other. Crossings that meet none are the ends of yarns, but the two legs of a loop on a side that is not joined meet.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np

from stitchmesh.errors import YarnError
from stitchmesh.faces.face_drawing import FaceDrawing, FaceLibrary, SideCrossing
from stitchmesh.faces.face_mesh import FaceMesh
from stitchmesh.faces.face_type import FaceType
from stitchmesh.faces.stitch_names import LOOP
from stitchmesh.mesh import FloatArray
from stitchmesh.mesh.mean_value import mean_value_weights
from stitchmesh.yarngen.face_yarns.drawings import drawing_of

FREE = -1
"""Partner of an end of a strand that meets no other: the yarn ends there."""


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
    """Return ends of a side as the side sees them that it is joined to; without reversal the cloth turns over."""
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
