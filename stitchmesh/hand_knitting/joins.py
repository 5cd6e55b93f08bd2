# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Joins of pieces: loops that one piece leaves for another, and edges that are joined after all pieces are made."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Sequence
from itertools import groupby

import numpy as np

from stitchmesh.hand_knitting.pieces import Piece
from stitchmesh.mesh import BORDER, BOTTOM, LEFT, RIGHT, TOP, StitchMesh

EDGES = {RIGHT: "right", LEFT: "left"}


class Joins:
    """The piece and the row of each face of a fabric, and the numbers of the loops that remain on the needles."""

    def __init__(self, fabric: StitchMesh, pieces: Sequence[Piece]) -> None:
        """Number the loops on the needle of each piece from 1 at its right end, where a round starts."""
        self.fabric = fabric
        self.piece = np.zeros(fabric.face_count, dtype=np.int64)
        self.row = np.zeros(fabric.face_count, dtype=np.int64)
        self.loop: dict[int, tuple[int, int]] = {}
        for number, piece in enumerate(pieces, start=1):
            for index, row in enumerate(piece.rows):
                self.piece[list(row.faces)], self.row[list(row.faces)] = number, index
            for place, side in enumerate(piece.needle[::-1], start=1):
                self.loop[side] = number, place

    def describe_start(self, sources: Iterable[int]) -> str:
        """Describe the loops with which a piece starts, in working order.

        Args:
            sources: top sides of other pieces, ``BORDER`` for a loop that is cast on (``Piece.sources``).
        """
        parts = []
        for owner, run in groupby(sources, lambda side: BORDER if side == BORDER else self.loop[side][0]):
            sides = list(run)
            if owner == BORDER:
                parts.append(f"{len(sides)} cast on")
            else:
                parts.append(f"{_named(self.loop[side][1] for side in sides)} of piece {owner}")
        return ", ".join(parts)

    def describe_remaining(self, piece: Piece) -> list[str]:
        """Describe the treatment of the loops that remain on the needle of a piece, one line for each run of loops."""
        lines = []
        for instruction, run in groupby(piece.needle[::-1], self._loop_instruction):
            places = [self.loop[side][1] for side in run]
            whole = len(places) == len(piece.needle)
            lines.append(instruction.format(f"all {len(places)} sts" if whole else _named(places)))
        return lines

    def _loop_instruction(self, side: int) -> str:
        """Instruction for the remaining loop of a top side, with a place for the numbers of loops."""
        across = int(self.fabric.twin[side])
        if across == BORDER:
            return "Bind off {}."
        if self.fabric.side_role[across] == TOP:
            return "Leave {} on a thread, to be grafted."
        return f"Leave {{}} on a thread for piece {self.piece[self.fabric.side_face[across]]}."

    def describe_finishing(self) -> list[str]:
        """Describe the joins that are made after all pieces are finished."""
        return [*self._grafts(), *self._cast_on_joins(), *self._seams()]

    def _grafts(self) -> list[str]:
        """Grafts of loops to loops, where wale directions do not match (Yuksel et al. 2012, section 4.4)."""
        pairs = sorted(
            (self.loop[side], self.loop[int(self.fabric.twin[side])])
            for side in self.loop
            if self.fabric.twin[side] != BORDER and int(self.fabric.twin[side]) in self.loop
        )
        pairs = [pair for pair in pairs if pair[0] < pair[1]]
        lines = []
        for (first, second), run in groupby(pairs, lambda pair: (pair[0][0], pair[1][0])):
            chosen = list(run)
            one, other = (_named(pair[end][1] for pair in chosen) for end in (0, 1))
            lines.append(f"Graft {one} of piece {first} to {other} of piece {second} (Kitchener stitch).")
        return lines

    def _cast_on_joins(self) -> list[str]:
        """Joins of two cast-on edges, where bottom sides meet bottom sides."""
        fabric = self.fabric
        first = np.arange(fabric.side_count) < fabric.twin
        sides = np.flatnonzero((fabric.side_role == BOTTOM) & fabric.mismatched & first)
        counts = Counter(self._pieces_at(side) for side in sides.tolist())
        return [
            f"Join {count} sts where pieces {one} and {other} begin: cast them on provisionally, then graft them."
            for (one, other), count in sorted(counts.items())
        ]

    def _seams(self) -> list[str]:
        """Seams: wale edges shared by faces that are not neighbours in a row or in consecutive turns of a spiral."""
        fabric, seams = self.fabric, Counter[tuple[int, str, int, str]]()
        for side in np.flatnonzero(fabric.is_wale & (np.arange(fabric.side_count) < fabric.twin)).tolist():
            other = int(fabric.twin[side])
            one_face, other_face = fabric.side_face[[side, other]]
            same_piece = self.piece[one_face] == self.piece[other_face]
            if not fabric.mismatched[side] and same_piece and abs(self.row[one_face] - self.row[other_face]) <= 1:
                continue
            if not fabric.mismatched[side] and fabric.row[one_face] == fabric.row[other_face]:
                continue
            names = (EDGES[int(fabric.side_role[end])] for end in (side, other))
            one, two = sorted(zip(self._pieces_at(side, ordered=False), names, strict=True))
            seams[*one, *two] += 1
        return [
            f"Seam the {one_edge} edge of piece {one} to the {other_edge} edge of piece {other}, {count} rows "
            "(mattress stitch)."
            for (one, one_edge, other, other_edge), count in sorted(seams.items())
        ]

    def _pieces_at(self, side: int, ordered: bool = True) -> tuple[int, ...]:
        """The two pieces at the edge of a side, sorted if ``ordered``."""
        found = [int(self.piece[self.fabric.side_face[end]]) for end in (side, int(self.fabric.twin[side]))]
        return tuple(sorted(found) if ordered else found)


def _named(numbers: Iterable[int]) -> str:
    """Name stitches by their numbers: ``st 3``, ``sts 3-5``."""
    text = _ranges(numbers)
    return f"st {text}" if text.isdigit() else f"sts {text}"


def _ranges(numbers: Iterable[int]) -> str:
    """Write numbers as ascending or descending runs: ``1-4, 9, 8-6``."""
    runs: list[list[int]] = []
    for number in numbers:
        last = runs[-1] if runs else []
        step = number - last[-1] if last else 0
        if last and abs(step) == 1 and (len(last) == 1 or step == last[-1] - last[-2]):
            last.append(number)
        else:
            runs.append([number])
    return ", ".join(str(run[0]) if len(run) == 1 else f"{run[0]}-{run[-1]}" for run in runs)
