# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Drawings of faces: the strands of yarn in a flat polygon, and drawings derived from others."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace

import numpy as np

from stitchmesh.errors import ParameterError
from stitchmesh.faces.face_type import YARN, FaceType
from stitchmesh.mesh import FloatArray


@dataclass(frozen=True)
class SideCrossing:
    """A place where a strand crosses a side of its face."""

    side: int
    """Side, counted from 0."""
    along: float
    """Share of the side from its start, 0 to 1."""
    height: float
    """Height over the polygon, in the unit of the drawing."""


@dataclass(frozen=True, eq=False)
class Strand:
    """A piece of yarn between two sides of a face."""

    start: SideCrossing
    """Where the strand starts."""
    points: FloatArray
    """Points of its control polygon between the ends, with heights, shape (n, 3)."""
    end: SideCrossing
    """Where the strand ends."""


@dataclass(frozen=True, eq=False)
class FaceDrawing:
    """The strands of yarn of one type of face."""

    type: FaceType
    """Type of the face."""
    polygon: FloatArray
    """Corners, counter-clockwise; side ``i`` starts at corner ``i``, shape (sides, 2)."""
    strands: tuple[Strand, ...]
    """The strands."""


@dataclass(frozen=True)
class FaceLibrary:
    """Drawings of types of faces; if a type has two drawings, the first is used."""

    drawings: tuple[FaceDrawing, ...] = ()

    def find(self, kind: FaceType) -> FaceDrawing | None:
        """Return the drawing of exactly this type, else a drawing whose varying counts fit, else None."""
        exact = (drawing for drawing in self.drawings if drawing.type == kind)
        fitting = (drawing for drawing in self.drawings if drawing.type.stands_for(kind))
        return next(exact, None) or next(fitting, None)


def derived(source: FaceDrawing, kind: FaceType, operations: Iterable[str]) -> FaceDrawing:
    """Return the drawing of another type.

    Args:
        source: the drawing to start with.
        kind: type of the new drawing. Its labels decide which side is the first side.
        operations: ``mirror-x``, ``mirror-z`` and ``reverse-yarn``.

    Raises:
        ParameterError: an operation is unknown, or the result does not have the labels of the type.
    """
    result = source
    for operation in operations:
        if operation not in _OPERATIONS:
            raise ParameterError(f"derive: got {operation!r}; expected {', '.join(_OPERATIONS)}")
        result = _OPERATIONS[operation](result)
    for turn in range(len(kind.labels)):
        turned = _turned(result, turn)
        if turned.type.labels == kind.labels:
            return replace(turned, type=kind)
    found = " ".join(result.type.labels)
    raise ParameterError(f"derive {kind.name}: got sides {found} in some order; expected {' '.join(kind.labels)}")


def _mirrored(drawing: FaceDrawing) -> FaceDrawing:
    """Return a drawing with left and right exchanged; side 0 stays side 0."""
    count = len(drawing.polygon)
    labels = tuple(drawing.type.labels[-side % count] for side in range(count))
    corners = drawing.polygon[(1 - np.arange(count)) % count] * [-1.0, 1.0]

    def crossing(old: SideCrossing) -> SideCrossing:
        return SideCrossing(-old.side % count, 1.0 - old.along, old.height)

    strands = [Strand(crossing(s.start), s.points * [-1.0, 1.0, 1.0], crossing(s.end)) for s in drawing.strands]
    return FaceDrawing(replace(drawing.type, labels=labels), corners, tuple(strands))


def _turned_over(drawing: FaceDrawing) -> FaceDrawing:
    """Return a drawing with all heights negated."""

    def crossing(old: SideCrossing) -> SideCrossing:
        return replace(old, height=-old.height)

    strands = [Strand(crossing(s.start), s.points * [1.0, 1.0, -1.0], crossing(s.end)) for s in drawing.strands]
    return replace(drawing, strands=tuple(strands))


def _reversed(drawing: FaceDrawing) -> FaceDrawing:
    """Return a drawing whose yarn sides have the opposite directions."""
    opposite = {"+": "-", "-": "+"}
    sides = zip(drawing.type.labels, drawing.type.sides, strict=True)
    labels = tuple(opposite.get(label[0], "") + label[1:] if side.kind == YARN else label for label, side in sides)
    return replace(drawing, type=replace(drawing.type, labels=labels))


def _turned(drawing: FaceDrawing, turn: int) -> FaceDrawing:
    """Return a drawing that begins with another side."""
    count = len(drawing.polygon)
    labels = drawing.type.labels[turn:] + drawing.type.labels[:turn]

    def crossing(old: SideCrossing) -> SideCrossing:
        return replace(old, side=(old.side - turn) % count)

    strands = tuple(Strand(crossing(s.start), s.points, crossing(s.end)) for s in drawing.strands)
    return FaceDrawing(replace(drawing.type, labels=labels), np.roll(drawing.polygon, -turn, axis=0), strands)


_OPERATIONS = {"mirror-x": _mirrored, "mirror-z": _turned_over, "reverse-yarn": _reversed}
"""Function of each operation."""
