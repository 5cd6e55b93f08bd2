# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The machine program of a fabric: each piece is cast on, knitted row by row and bound off.

A flat piece is on the front bed and is knitted back and forth. A tube is folded: its front half is on even needles of
the front bed and its back half on odd needles of the back bed, so that the needle opposite to each loop is free. A
round passes over the front half from right to left and over the back half from left to right.

Before each row its loops are moved to the needles where the row needs them, with an empty needle for each yarn-over.
Loops that are worked together are stacked on one needle. A purl stitch is made on the other bed, and its loop stays
there until a stitch needs it on the bed of its half: ribs are transferred once, not in every row.

The cast-on tucks loops on every second needle and then on the needles between, each on the bed where the next row needs
it. The bind-off is a chain along the edge, in which each loop is knit together with the chain before it. Where the
fabric has a yarn drawn through its last loops, the machine binds them off too.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from stitchmesh.errors import ParameterError
from stitchmesh.hand_knitting.pieces import Piece, PieceRow, find_pieces
from stitchmesh.machine_knitting.making import check_makeable, drawn_together
from stitchmesh.machine_knitting.program import BACK, FRONT, MOST_RACK, Half, Program
from stitchmesh.mesh import BORDER, StitchMesh
from stitchmesh.mesh.cable_groups import CableGroup, cable_groups
from stitchmesh.mesh.courses import bottom_sides, top_sides
from stitchmesh.mesh.stitch import VOCABULARY, Stitch


@dataclass
class PlacedStitch:
    """A stitch on its needles; all sequences run from left to right along the bed."""

    face: int
    """Face of the stitch."""
    half: Half
    """Half of the piece, and with it the bed, that makes the stitch."""
    needles: list[int]
    """Needles of the stitch, enough for its loops below and for its loops on top."""
    letters: str
    """Kind of each loop on top (``Making.made``)."""
    below: list[int]
    """Loops below, by their top sides."""
    above: list[int]
    """Loops on top, by their top sides."""
    made: list[int] = field(default_factory=list)
    """Needle of each loop on top."""


def machine_program(fabric: StitchMesh) -> str:
    """Write the program of a fabric as the text of a knitout file, version 2.

    Comments in the program name the face of each loop.

    Args:
        fabric: stitch mesh of separate flat pieces and tubes.

    Raises:
        ParameterError: a machine cannot make a part of the fabric; the message lists the stitches.
        LabelError: the cable marks of the fabric contradict each other.
    """
    pieces = find_pieces(fabric)
    check_makeable(fabric, pieces)
    width = np.maximum(fabric.n_bottom, fabric.n_top)
    widest = max(int(width[list(row.faces)].sum()) for piece in pieces for row in piece.rows)
    program = Program(first=2 * (widest // 2 + MOST_RACK))
    groups = {int(side): group for group in cable_groups(fabric) for side in group.sides}
    for number, piece in enumerate(pieces, start=1):
        program.comment(f"piece {number}")
        _PieceKnitter(fabric, program, piece, groups).knit()
    return program.text()


class _PieceKnitter:
    """The state of one piece on the beds while its program is written."""

    def __init__(self, fabric: StitchMesh, program: Program, piece: Piece, groups: dict[int, CableGroup]) -> None:
        self.fabric, self.program, self.piece, self.groups = fabric, program, piece, groups
        front = Half(FRONT, 2 if piece.in_rounds else 1, 0)
        self.halves = [front, Half(BACK, 2, 1)] if piece.in_rounds else [front]

    def knit(self) -> None:
        """Write all rows, from cast-on to bind-off."""
        rows = self.piece.rows[:-1] if drawn_together(self.fabric, self.piece) else self.piece.rows
        last_row = {int(yarn): number for number, row in enumerate(rows) for yarn in self._yarns(row)}
        for number, row in enumerate(rows):
            self.program.comment(f"row {number}")
            placed = self._place_row(row)
            self._move_loops(placed)
            if number == 0:
                self._cast_on(placed)
            else:
                self._knit_row(placed, row)
            self.program.release()
            self._set_loops(placed)
            for yarn in self._yarns(row):
                if last_row[yarn] == number and number < len(rows) - 1:
                    self.program.take_out(yarn)
        self._bind_off(self._yarns(rows[-1])[-1], rows[-1].right_side)

    def _yarns(self, row: PieceRow) -> list[int]:
        """Yarns of a row in the order of its stitches from the right."""
        return list(dict.fromkeys(self.fabric.yarn[list(row.faces[::-1])].tolist()))

    def _place_row(self, row: PieceRow) -> list[PlacedStitch]:
        """Place the stitches of a row on neighbouring needles, from left to right along each bed, half by half."""
        sides = self._half_of_faces(row)
        placed = []
        for half in self.halves:
            faces = [face for face in row.faces if sides[face] is half]
            faces = faces if half.bed == FRONT else faces[::-1]
            first = half.centred(sum(self._width(face) for face in faces))
            for face in faces:
                width = self._width(face)
                placed.append(self._on_needles(face, half, [first + half.spacing * k for k in range(width)]))
                first += width * half.spacing
        return placed

    def _below(self, face: int) -> list[int]:
        """Loops below a face, by their top sides, from left to right; none below a cast-on."""
        across = self.fabric.twin[bottom_sides(self.fabric, (face,))].tolist()
        return [] if self.fabric.stitch[face] == Stitch.CAST_ON else across

    def _width(self, face: int) -> int:
        """Number of needles of a face."""
        return max(len(self._below(face)), int(self.fabric.n_top[face]))

    def _on_needles(self, face: int, half: Half, needles: list[int]) -> PlacedStitch:
        """Place the stitch of a face on the given needles of a half."""
        below, above = self._below(face), top_sides(self.fabric, (face,))
        stitch = Stitch(int(self.fabric.stitch[face]))
        letters = "y" * len(above) if stitch == Stitch.CAST_ON else VOCABULARY[stitch].made
        if half.bed == BACK:
            below, above, letters = below[::-1], above[::-1], letters[::-1]
        placed = PlacedStitch(face, half, needles, letters, below, above)
        if len(below) > 1:
            first = self._order(placed)[0]
            placed.made = [needles[first]]
        else:
            placed.made = needles[: len(above)]
        return placed

    def _order(self, placed: PlacedStitch) -> list[int]:
        """Places (from left to right along the bed) of the loops below, listed from the outside to the inside."""
        count = len(placed.below)
        order = VOCABULARY[Stitch(int(self.fabric.stitch[placed.face]))].order
        return [loop - 1 if placed.half.bed == FRONT else count - loop for loop in order]

    def _half_of_faces(self, row: PieceRow) -> dict[int, Half]:
        """Choose a half for each stitch: the half with most of its loops, unless the halves become too unequal."""
        if len(self.halves) == 1:
            return dict.fromkeys(row.faces, self.halves[0])
        front, back = self.halves
        sides: dict[int, Half] = {}
        if not front.loops:
            total, seen = sum(self._width(face) for face in row.faces), 0
            for face in row.faces:
                sides[face] = front if 2 * seen < total else back
                seen += self._width(face)
            return sides
        for face in row.faces:
            on_front = [loop in front.loops for loop in self._below(face)]
            known = sides[row.faces[row.faces.index(face) - 1]] if sides else None
            sides[face] = (front if 2 * sum(on_front) >= len(on_front) else back) if on_front else known or front
        self._even_out(row, sides)
        return sides

    def _even_out(self, row: PieceRow, sides: dict[int, Half]) -> None:
        """Move a stitch around the right or the left fold if one half is much wider than the other."""
        front, back = self.halves
        widths = {id(half): sum(self._width(f) for f in row.faces if sides[f] is half) for half in self.halves}
        for right in (True, False):
            excess = widths[id(front)] - widths[id(back)]
            # A stitch is moved around the fold if the widths of the halves of a tube differ by at least this number
            # of stitches.
            if abs(excess) < 3:
                return
            wide, narrow = (front, back) if excess > 0 else (back, front)
            faces = self._along(row, sides, wide)
            face = faces[-1] if right else faces[0]
            if len(faces) > 1 and 2 * self._width(face) <= abs(excess):
                sides[face] = narrow
                widths[id(wide)] -= self._width(face)
                widths[id(narrow)] += self._width(face)

    def _along(self, row: PieceRow, sides: dict[int, Half], half: Half) -> list[int]:
        """Faces of a half, from left to right along its bed."""
        count = len(row.faces)
        mine = [sides[face] is half for face in row.faces]
        starts = [place for place in range(count) if mine[place] and not mine[place - 1]]
        first = starts[0] if starts else 0
        faces = [row.faces[(first + step) % count] for step in range(count) if mine[(first + step) % count]]
        return faces if half.bed == FRONT else faces[::-1]

    def _move_loops(self, placed: list[PlacedStitch]) -> None:
        """Move the loops below a row to the needles of their stitches, cross the cables and stack the decreases."""
        if len(self.halves) == 2:
            self._move_around_folds(placed)
        for half in self.halves:
            mine = [stitch for stitch in placed if stitch.half is half]
            targets = {}
            for stitch in mine:
                targets.update(self._targets(stitch))
            if list(targets) != list(half.loops):
                face = mine[0].face if mine else 0
                raise ParameterError(f"face {face}: its row takes loops in an order that differs from the needles")
            half.move(self.program, targets)
            crossings = self._crossings(half)
            stacked = [stitch for stitch in mine if len(stitch.below) > 1]
            for stitch in stacked:
                half.bring(self.program, stitch.below[self._order(stitch)[0]], across=False)
            half.stack(self.program, [*crossings, *(self._stack(stitch) for stitch in stacked)])
            for stitch in mine:
                for loop in stitch.below[:1]:  # The loops below a stitch share its needle now.
                    half.bring(self.program, loop, across=self._is_across(stitch.face))
        self.program.rack_to(0)

    def _targets(self, stitch: PlacedStitch) -> dict[int, int]:
        """Needle of each loop below a stitch; a single loop is placed below the loop on top that is not a yarn-over."""
        if len(stitch.below) == 1:
            place = next(index for index, letter in enumerate(stitch.letters) if letter != "y")
            return {stitch.below[0]: stitch.needles[place]}
        return dict(zip(stitch.below, stitch.needles, strict=False))

    def _stack(self, stitch: PlacedStitch) -> list[tuple[int, int]]:
        """Moves that stack the loops of a decrease on the needle of the outermost loop."""
        return [(stitch.below[place], stitch.made[0]) for place in self._order(stitch)[1:]]

    def _crossings(self, half: Half) -> list[list[tuple[int, int]]]:
        """Moves of the loops of each cable; the loops in front move first."""
        found: dict[int, list[tuple[int, int]]] = {}
        for side in half.loops:
            group = self.groups.get(side)
            if group is None or id(group) in found:
                continue
            sides = group.sides.tolist()
            if not all(loop in half.loops for loop in sides):
                raise ParameterError(f"face {self.fabric.side_face[side]}: its cable lies on the fold of the tube")
            loops = sorted(range(len(sides)), key=lambda place: (-int(group.layer[place]), place))
            places = [half.loops[loop] for loop in sides]
            moves = [(sides[place], places[int(group.destination[place])]) for place in loops]
            found[id(group)] = moves
        return list(found.values())

    def _move_around_folds(self, placed: list[PlacedStitch]) -> None:
        """Move loops at a fold to the other bed if their stitches are made there, the outermost loop first."""
        half_of_loop = {loop: stitch.half for stitch in placed for loop in stitch.below}
        for half, other in (self.halves, self.halves[::-1]):
            for right in (True, False):
                edge = list(half.loops)[:: -1 if right else 1]
                while edge and half_of_loop[edge[0]] is other:
                    self._move_around_fold(half, other, edge.pop(0), right)
            if any(half_of_loop[loop] is other for loop in half.loops):
                raise ParameterError("knitting machine: the rows of a tube cannot be folded; knit it by hand")

    def _move_around_fold(self, half: Half, other: Half, loop: int, right: bool) -> None:
        """Move one loop around a fold to a needle beyond the last loop there, within the range of racking."""
        half.bring(self.program, loop, across=False)
        needle = half.loops.pop(loop)
        last = list(other.loops.values())[-1 if right else 0] if other.loops else needle + (-1 if right else 1)
        to = max(last + 2, needle - MOST_RACK + 1) if right else min(last - 2, needle + MOST_RACK - 1)
        if abs(to - needle) > MOST_RACK:
            raise ParameterError(
                "knitting machine: the ends of the two halves of a tube are too far apart for racking; make the rows "
                "of the tube more equal in their numbers of stitches"
            )
        self.program.transfer(half.bed, needle, to)
        items = [*other.loops.items(), (loop, to)] if right else [(loop, to), *other.loops.items()]
        other.loops = dict(items)

    def _cast_on(self, placed: list[PlacedStitch]) -> None:
        """Tuck on every second needle, and then on the needles between, so that the second tucks hold the first."""
        loops = self._in_order(placed, right_side=True)
        turns = [loops[::2], loops[1::2]] if self.piece.in_rounds else [loops[::2], loops[1::2][::-1]]
        for number, turn in enumerate(turns):
            for stitch, place in turn:
                yarn = int(self.fabric.yarn[stitch.face])
                direction = self._direction(stitch.half, right_side=self.piece.in_rounds or number == 0)
                note = self._note(stitch, place)
                self.program.stitch("tuck", direction, self._bed(stitch, place), stitch.made[place], yarn, note)

    def _in_order(self, placed: list[PlacedStitch], right_side: bool) -> list[tuple[PlacedStitch, int]]:
        """All loops of a row in the order of the yarn: on the right side from right to left, as seen from outside."""
        loops = [(stitch, place) for stitch in placed for place in range(len(stitch.above))]
        front = [item for item in loops if item[0].half.bed == FRONT]
        back = [item for item in loops if item[0].half.bed == BACK]
        return [*front[::-1], *back] if right_side else front

    def _direction(self, half: Half, right_side: bool) -> str:
        """Direction of the carrier over a half: ``-`` to the left or ``+`` to the right."""
        return "-" if (half.bed == FRONT) == right_side else "+"

    def _note(self, stitch: PlacedStitch, place: int) -> str:
        """Comment of a loop: its face, and its place among the loops of the face, from the left."""
        loops = len(stitch.above)
        return f"face {stitch.face} loop {place + 1 if stitch.half.bed == FRONT else loops - place}"

    def _knit_row(self, placed: list[PlacedStitch], row: PieceRow) -> None:
        """Make the loops of a row, with one pass of the carrier for each yarn."""
        order = self._in_order(placed, row.right_side)
        for yarn in self._yarns(row):
            own = [(stitch, place) for stitch, place in order if self.fabric.yarn[stitch.face] == yarn]
            for stitch, place in own:
                self._make_loop(stitch, place, row.right_side, yarn)
            self._move_carrier_to_end(placed, row, own[-1][0].half, yarn)

    def _is_across(self, face: int) -> bool:
        """Whether a stitch is worked on the other bed: purl stitches, and slipped loops with the yarn in front."""
        stitch = Stitch(int(self.fabric.stitch[face]))
        return stitch == Stitch.SLIP_FRONT or (stitch != Stitch.CAST_ON and "p" in VOCABULARY[stitch].made)

    def _bed(self, stitch: PlacedStitch, place: int) -> str:
        """Bed on which a loop of a stitch is made; a loop that is cast on, where the stitch above it needs it."""
        half, across = stitch.half, stitch.letters[place] != "y" and self._is_across(stitch.face)
        above = int(self.fabric.twin[stitch.above[place]])
        if self.fabric.stitch[stitch.face] == Stitch.CAST_ON and above != BORDER:
            face = int(self.fabric.side_face[above])
            across = self._is_across(face) and len(self._below(face)) == 1
        return half.other if across else half.bed

    def _make_loop(self, stitch: PlacedStitch, place: int, right_side: bool, yarn: int) -> None:
        """Write the operation that makes one loop of a stitch."""
        letter, half = stitch.letters[place], stitch.half
        operation = {"k": "knit", "p": "knit", "y": "tuck", "s": "miss"}[letter]
        is_made_one = letter == "y" and self.fabric.twist[stitch.above[place]] != 0
        direction = self._direction(half, right_side != is_made_one)
        note = self._note(stitch, place)
        self.program.stitch(operation, direction, self._bed(stitch, place), stitch.made[place], yarn, note)

    def _move_carrier_to_end(self, placed: list[PlacedStitch], row: PieceRow, last: Half, yarn: int) -> None:
        """Move the carrier to the end of its row, for a tube around the fold, so that its next row begins there."""
        for half in self.halves[self.halves.index(last) :]:
            needles = [needle for stitch in placed if stitch.half is half for needle in stitch.made]
            direction = self._direction(half, row.right_side)
            end = max(needles) if direction == "+" else min(needles)
            at = self.program.position[yarn]
            if half is not last or (at < end if direction == "+" else at > end):
                self.program.stitch("miss", direction, half.bed, end, yarn)

    def _set_loops(self, placed: list[PlacedStitch]) -> None:
        """Record the needles and beds of the loops of a row that has been made."""
        for half in self.halves:
            mine = [stitch for stitch in placed if stitch.half is half]
            loops = [(stitch, place) for stitch in mine for place in range(len(stitch.above))]
            half.loops = {stitch.above[place]: stitch.made[place] for stitch, place in loops}
            half.across = {stitch.above[place] for stitch, place in loops if self._bed(stitch, place) != half.bed}

    def _bind_off(self, yarn: int, right_side: bool) -> None:
        """Bind off all loops in a chain along the edge, from the position of the yarn."""
        self.program.comment("bind off")
        for half in self.halves:
            first = half.centred(len(half.loops))
            half.move(self.program, {loop: first + half.spacing * k for k, loop in enumerate(half.loops)})
        from_right = self.piece.in_rounds or not right_side
        loops = [(half, *at) for half in self.halves for at in self._in_chain(half, from_right)]
        half, bed, needle = loops[0]
        self.program.stitch("knit", self._direction(half, from_right), bed, needle, yarn, "bind off")
        for number in range(1, len(loops)):
            following, other_bed, to = loops[number]
            same_bed_next = number + 1 < len(loops) and loops[number + 1][1] == other_bed
            if bed == other_bed:
                self.program.transfer(bed, needle, needle)
                self.program.transfer(BACK if bed == FRONT else FRONT, needle, to)
            elif following is half and same_bed_next and abs(to - needle) == half.spacing:
                self.program.transfer(other_bed, to, needle)  # The chain stays opposite to the loop after this one.
                other_bed, to = bed, needle
            else:
                self.program.transfer(bed, needle, to)
            half, bed, needle = following, other_bed, to
            self.program.stitch("knit", self._direction(half, from_right), bed, needle, yarn, "bind off")
        for left in list(self.program.position):
            self.program.take_out(left)
        self.program.drop(bed, needle, "end of the chain, whose yarn is cut")

    def _in_chain(self, half: Half, from_right: bool) -> list[tuple[str, int]]:
        """Bed and needle of each loop of a half in the order of the bind-off."""
        loops = [(half.bed_of(loop), needle) for loop, needle in half.loops.items()]
        return loops[::-1] if (half.bed == FRONT) == from_right else loops
