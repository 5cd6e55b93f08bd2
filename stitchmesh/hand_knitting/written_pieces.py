# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The content of written instructions as a value: pieces, rows, stitches and crossings.

``written_pieces`` takes the value from a fabric. ``parse_instructions`` takes the same value from the text that
``knitting_instructions`` writes.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from stitchmesh.errors import check_kind
from stitchmesh.hand_knitting.pieces import Piece, PieceRow, find_pieces
from stitchmesh.hand_knitting.rows import CableCrossings, WrittenStitch, places_below, stitches_of_face
from stitchmesh.mesh import StitchMesh
from stitchmesh.mesh.cable_groups import CableGroup


@dataclass(frozen=True)
class WrittenCrossing:
    """Loops that cross before they are worked, as seen from the right side."""

    first: int
    """Number of loops that the row works to the left of them."""
    destination: tuple[int, ...]
    """Place among the loops to which each loop moves, from left to right."""
    over: frozenset[tuple[int, int]]
    """Pairs of loops that cross, numbered from 0 at the left before the crossing: the loop in front, then the other."""


@dataclass(frozen=True)
class WrittenRow:
    """One row or round after the cast-on row."""

    right_side: bool
    """Whether the knitter looks at the right side."""
    stitches: tuple[WrittenStitch, ...]
    """Stitches from left to right, as seen from the right side."""
    crossings: tuple[WrittenCrossing, ...] = ()
    """Crossings from left to right."""
    passed: int = 0
    """Number of loops that are left unworked before the first stitch."""
    turned: bool = False
    """Whether loops are left unworked after the last stitch."""
    bound_off: tuple[int, ...] = ()
    """Loops that are bound off first, by their places on the needle, counted from 0 at the right."""


@dataclass(frozen=True)
class WrittenPiece:
    """Rows on one needle."""

    in_rounds: bool
    """Whether the piece is worked in rounds; otherwise it is worked back and forth."""
    cast_on: int
    """Number of loops of the first row that are cast on; 0 if the piece takes up loops of other pieces."""
    rows: tuple[WrittenRow, ...]
    """Rows in working order, without the cast-on row."""


def written_pieces(fabric: StitchMesh) -> tuple[WrittenPiece, ...]:
    """Return the content of the instructions of a fabric.

    Raises:
        ParameterError, LabelError: as for ``knitting_instructions``.
    """
    check_kind("written_pieces", fabric, StitchMesh)
    crossings = CableCrossings.of(fabric)
    return tuple(_piece(fabric, piece, crossings) for piece in find_pieces(fabric))


def over_pairs(destination: Sequence[int], depth: Sequence[int]) -> frozenset[tuple[int, int]]:
    """Return the pairs of loops that cross, the loop in front first.

    Args:
        destination: place to which each loop moves.
        depth: number of each loop; where two loops cross, the loop with the higher number is in front.
    """
    count = range(len(destination))
    crossed = [(one, other) for other in count for one in range(other) if destination[one] > destination[other]]
    return frozenset((one, other) if depth[one] > depth[other] else (other, one) for one, other in crossed)


def _piece(fabric: StitchMesh, piece: Piece, crossings: CableCrossings) -> WrittenPiece:
    first = 0 if piece.sources else 1
    cast_on = 0 if piece.sources else int(fabric.n_top[list(piece.rows[0].faces)].sum())
    rows = tuple(_row(fabric, row, crossings) for row in piece.rows[first:])
    return WrittenPiece(piece.in_rounds, cast_on, rows)


def _row(fabric: StitchMesh, row: PieceRow, crossings: CableCrossings) -> WrittenRow:
    stitches: list[WrittenStitch] = []
    crossed: list[WrittenCrossing] = []
    loops = 0
    for face in row.faces:
        for index, place in enumerate(places_below(fabric, face)):
            group = crossings.group_at.get(place)
            if group is not None and place == int(group.sides[0]):
                crossed.append(_crossing(group, loops + index))
        worked = stitches_of_face(fabric, face, crossings)
        loops += sum(len(stitch.twists) for stitch in worked)
        stitches += worked
    return WrittenRow(row.right_side, tuple(stitches), tuple(crossed), row.passed, bool(row.left_over), row.bound_off)


def _crossing(group: CableGroup, first: int) -> WrittenCrossing:
    destination = tuple(group.destination.tolist())
    return WrittenCrossing(first, destination, over_pairs(destination, group.layer.tolist()))
