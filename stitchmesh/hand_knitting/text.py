# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The text of a hand-knitting pattern for a stitch mesh.

The text describes one piece after the other, and each row after the rows that its loops come from. Flat pieces are
worked back and forth; rows on the wrong side are described as the knitter sees them. Tubes and spirals are worked in
rounds on the right side. Repeats within a row are written in brackets, and repeated rows are written once. Loops that
meet loops of another row cannot be worked in rows; they are grafted after all pieces are finished. The text of these
joins names the loops that one piece leaves for another, and the edges that are joined.
"""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Iterable, Sequence
from itertools import groupby

import numpy as np

from stitchmesh.errors import check_kind
from stitchmesh.hand_knitting.chart import piece_charts
from stitchmesh.hand_knitting.pieces import Piece, PieceRow, find_pieces
from stitchmesh.hand_knitting.rhythm import MARKER, RowForRhythm, ShapedWord, fold_words, repeats, rhythm_line, rhythms
from stitchmesh.hand_knitting.rows import CableCrossings, places_below, row_words, stitches_of_face
from stitchmesh.hand_knitting.words import (
    YARN_OVERS,
    cable_meanings,
    colour_letter,
    stitch_meaning,
    stitch_word,
    without_yarn_overs,
)
from stitchmesh.mesh import BORDER, BOTTOM, LEFT, RIGHT, TOP, StitchMesh
from stitchmesh.mesh.stitch import SIDE_COUNTS, Stitch

COUNTING = "Sts on a needle are counted from its right end, right side facing; in rounds, from the start of the round."
MORE_WORDS = {
    r"\) in 1 st": "(...) in 1 st: all of it in the next st; keep: its old loop stays on the needle",
    r" tbl": "tbl: through the back loop",
    r" turning ": "turning R1 L2: first turn the 1st st so that its right leg is in front, the 2nd so that its left is",
    r"\bco\d": "co: cast on with a backward loop",
    r"\bdt\d": "dt: draw the yarn through the st and let the st off the needle",
    r"\bpass \d": "pass 1: leave the next st unworked and continue after it",
    r", turn\.": "turn: leave the other sts unworked and turn the work",
    r" to last \d": "k to last 3: knit until 3 sts of the row are left",
    r" before marker": "k to 3 before marker: knit until 3 sts are left before the next marker",
    rf"\b{MARKER}\b": f"{MARKER}: slip the marker",
    r" the other rows plain": "plain: k in RS rows, p in WS rows",
}
"""Further explanations of the legend, by the regular expression that finds their words in the rows."""


def knitting_instructions(fabric: StitchMesh, *, charts: bool = True) -> str:
    """Write the hand-knitting instructions of a fabric; each line ends with a newline.

    Args:
        fabric: stitch mesh; its marks of twists, cables and yarns are included.
        charts: whether each piece has charts, which repeat its rows in symbols.

    Raises:
        ParameterError: the fabric has panels that are not divided into stitches, or no row can be knitted first.
        LabelError: the cable marks of the fabric contradict each other.
    """
    check_kind("knitting_instructions", fabric, StitchMesh)
    pieces = find_pieces(fabric)
    joins, crossings = Joins(fabric, pieces), CableCrossings.of(fabric)
    body: list[str] = []
    for number, piece in enumerate(pieces, start=1):
        body += ["", *_piece(fabric, number, piece, joins, crossings)]
        body += [line for chart in piece_charts(fabric, piece, crossings) for line in chart.lines()] if charts else []
    last = joins.describe_finishing()
    if last:
        body += ["", "To finish:", *last]
    count = f"{len(pieces)} piece{'s' if len(pieces) > 1 else ''}, {fabric.face_count} stitches"
    return "\n".join([f"Knitting instructions: {count}.", COUNTING, "", *_legend(fabric, pieces, body), *body]) + "\n"


def _legend(fabric: StitchMesh, pieces: list[Piece], body: list[str]) -> list[str]:
    """Lines of the legend: the words that the rows use, with their explanations."""
    rows = "\n".join(line for line in body if line.startswith("Ro"))
    meanings = {word: meaning for word, meaning in YARN_OVERS.items() if re.search(rf"\b{word}\b", rows)}
    for piece in pieces:
        for row in piece.rows:
            for code in sorted(set(fabric.stitch[list(row.faces)].tolist())):
                _, stitch, _ = without_yarn_overs(fabric.stitch_type(code))
                if stitch is not None and fabric.type_code(stitch) in fabric.makings:
                    meanings[stitch_word(stitch, row.right_side)] = stitch_meaning(stitch, row.right_side)
    named = [f"  {word}: {meaning}" for word, meaning in sorted(meanings.items()) if " in 1 st" not in word]
    more = [text for words, text in MORE_WORDS.items() if re.search(words, rows)]
    return ["Words", *named, *(f"  {text}" for text in [*cable_meanings(rows), *more])]


def _piece(fabric: StitchMesh, number: int, piece: Piece, joins: Joins, crossings: CableCrossings) -> list[str]:
    """Lines of one piece: its start, its rows, and the use of its remaining loops."""
    how = "in rounds" if piece.in_rounds else "to and fro"
    lines = [f"Piece {number}, worked {how}"]
    rows = list(enumerate(piece.rows))
    if piece.sources:
        lines.append(f"Take up {joins.describe_start(piece.sources)}; join the yarn.")
        rows = [(index + 1, row) for index, row in rows]
        loops = len(piece.sources)
    else:
        first = piece.rows[0]
        loops = int(fabric.n_top[list(first.faces)].sum())
        lines.append(_cast_on(fabric, first, loops, piece.in_rounds))
        rows = rows[1:]
    bodies, in_rhythm = [], []
    for _, row in rows:
        side = "" if piece.in_rounds else f" ({'RS' if row.right_side else 'WS'})"
        text, loops = _row(fabric, row, loops, crossings)
        bodies.append((side, text))
        in_rhythm.append(_for_rhythm(fabric, row, crossings, side + text.partition(":")[0]))
    lines += _numbered_rhythms(bodies, in_rhythm, rows[0][0] if rows else 0, "Round" if piece.in_rounds else "Row")
    lines += joins.describe_remaining(piece) if piece.needle else ["Cut the yarn and pull it tight."]
    return lines


def _cast_on(fabric: StitchMesh, row: PieceRow, loops: int, in_rounds: bool) -> str:
    """The line of the first row, whose stitches have no loops below."""
    yarns = sorted(set(fabric.yarn[list(row.faces)].tolist()))
    colour = f" in yarn {' and '.join(map(colour_letter, yarns))}" if fabric.yarn.any() else ""
    return f"Cast on {loops} sts{colour}{'; join in the round' if in_rounds else ''}."


def _row(fabric: StitchMesh, row: PieceRow, loops: int, crossings: CableCrossings) -> tuple[str, int]:
    """The text after the number of a row, and the number of loops on the needle after the row."""
    faces = list(row.faces)
    yarns = set(fabric.yarn[faces].tolist())
    colour = f" in yarn {colour_letter(yarns.pop())}" if fabric.yarn.any() and len(yarns) == 1 else ""
    words = fold_words(row_words(fabric, row, crossings))
    passed = f"pass {row.passed}, " if row.passed else ""
    turn = ", turn" if row.left_over else ""
    bound = f" first bind off sts {', '.join(str(place + 1) for place in row.bound_off)};" if row.bound_off else ""
    taken = int(fabric.n_bottom[faces][fabric.stitch[faces] != Stitch.CAST_ON].sum())
    after = loops - len(row.bound_off) - taken + int(fabric.n_top[faces].sum())
    count = f" ({after} sts)" if after != loops else ""
    return f"{colour}:{bound} {passed}{words}{turn}.{count}", after


def _for_rhythm(fabric: StitchMesh, row: PieceRow, crossings: CableCrossings, before: str) -> RowForRhythm | None:
    """The words of a row with the loops that they take and make; None for a row with anything else, such as a cable.

    Args:
        fabric: the stitch mesh.
        row: the row.
        crossings: the cables of the fabric.
        before: text of the line of the row before the words.
    """
    faces = row.faces[::-1] if row.right_side else row.faces
    several = len(set(fabric.yarn[list(faces)].tolist())) > 1
    if row.passed or row.left_over or row.bound_off or several:
        return None
    words = []
    for face in faces:
        stitches = stitches_of_face(fabric, face, crossings)
        if any(place in crossings.group_at for place in places_below(fabric, face)):
            return None
        for one in stitches[::-1] if row.right_side else stitches:
            if one.stitch not in SIDE_COUNTS:
                return None
            words.append(ShapedWord(one.word(row.right_side), *SIDE_COUNTS[one.stitch]))
    return RowForRhythm(tuple(words), before)


def _numbered_rhythms(
    bodies: list[tuple[str, str]], in_rhythm: list[RowForRhythm | None], first: int, name: str
) -> list[str]:
    """Rows with their numbers; rows that are shaped in a rhythm share one line."""
    lines, done = [], 0
    for rhythm, parts in rhythms(in_rhythm):
        lines += _numbered(bodies[done : rhythm.first], first + done, name)
        lines.append(rhythm_line(in_rhythm, rhythm, parts, first, name))
        done = rhythm.last + 1
    return lines + _numbered(bodies[done:], first + done, name)


def _numbered(bodies: list[tuple[str, str]], first: int, name: str) -> list[str]:
    """Rows with their numbers; repeated rows refer to their first occurrence."""
    lines = []
    for start, length, times in repeats(bodies):
        low = first + start
        block = bodies[start : start + length]
        lines += [f"{name} {number}{side}{text}" for number, (side, text) in enumerate(block, start=low)]
        if times > 1:
            high, end = low + length, low + length * times - 1
            repeated = f"{name}s {high} to {end}" if end > high else f"{name} {high}"
            original = f"{name.lower()} {low}" if length == 1 else f"{name.lower()}s {low} to {high - 1}"
            lines.append(f"{repeated}: as {original}.")
    return lines


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
