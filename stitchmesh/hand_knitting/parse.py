# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Reading of written instructions: the stitches of each row, from the text that ``knitting_instructions`` writes.

The parser reads the lines of the pieces, of their cast-on and of their rows. It skips the legend, the charts and the
treatment of remaining loops, because they say nothing more about the stitches.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, replace
from functools import cache

from stitchmesh.errors import PatternError, check_kind
from stitchmesh.hand_knitting.rhythm import MARKER
from stitchmesh.hand_knitting.rows import WrittenStitch
from stitchmesh.hand_knitting.sizes import instructions_of_size, names_of_sizes
from stitchmesh.hand_knitting.words import MADE_ONES, ONE_LOOP, stitch_word
from stitchmesh.hand_knitting.written_pieces import (
    WrittenCrossing,
    WrittenPiece,
    WrittenRow,
    over_pairs,
)
from stitchmesh.mesh.stitch import SIDE_COUNTS, VOCABULARY, Stitch

FIRST_WORDS = "Knitting instructions:"
"""Words with which instructions begin."""
MOST_ROWS, MOST_STITCHES, MOST_DEPTH = 10_000, 100_000, 16
"""Largest numbers of rows of a piece, of stitches of a row, and of nested brackets."""
MOST_IN_RHYTHM = 1_000_000
"""Largest number of stitches of the shaped rows of one line."""
_TAKEN = {Stitch.CAST_ON: 0, Stitch.DRAW_THROUGH: 1}
_TURNS_MADE = {word: turn for turn, word in MADE_ONES.items()}
_PIECE = re.compile(r"Piece \d+, worked (in rounds|to and fro)")
_CAST_ON = re.compile(r"Cast on (\d{1,6}) sts\b.*")
_ROW = re.compile(r"(?:Row|Round) (\d{1,6})(?: \((RS|WS)\))?((?: in yarn \w+)?:.*)")
_REPEATED = re.compile(r"(?:Row|Round)s? (\d{1,6})(?: to (\d{1,6}))?: as (?:row|round)s? (\d{1,6})(?: to (\d{1,6}))?\.")
_RHYTHM = re.compile(
    r"(?:Row|Round)s (\d{1,6}) to (\d{1,6})(?: \((RS|WS)\))?(?: in yarn (\w+))?: (?:decrease|increase) [^:]*? every "
    r"(?:(\d{1,6})(?:st|nd|rd|th) )?(?:row|round), (\d{1,6}) times: (.*?)(?:; [^;.]*)?\."
    r"(?: Markers? after sts? ([\d, ]+)\.)? \((\d{1,6}) to (\d{1,6}) sts\)"
)
_RUN = re.compile(r"([kp]) to (?:(\d{1,6}) before marker|marker|last (\d{1,6})|end)")
_BODY = re.compile(
    r"(?: in yarn (?P<yarn>\w+))?:(?: first bind off sts (?P<bound>[\d, ]+);)? (?:pass (?P<passed>\d{1,6}), )?"
    r"(?P<words>.*?)(?P<turned>, turn)?\.(?: \(\d+ sts\))?"
)
_TIMES = re.compile(r"\[(.*)\] (\d{1,6}) times")
_COUNTED = re.compile(r"(k|p|co|dt|bo)(\d{1,6})")
_COLOUR = re.compile(r"([A-Z]|Y\d{1,6}): (.*)")
_HALVES = re.compile(r"c(\d{1,4})([fb])")
_BUNDLES = re.compile(r"cross (\d{1,4})/(\d{1,4}) (front|back)")
_ORDER = re.compile(r"cross to ([\d-]+) front to back ([\d-]+)")
_TURNS = re.compile(r"[LR]\d{1,2}")


def parse_instructions(text: str, name: str = "instructions", *, size: str | None = None) -> tuple[WrittenPiece, ...]:
    """Read the stitches of written instructions.

    ``parse_instructions(knitting_instructions(fabric))`` gives ``written_pieces(fabric)``.

    Args:
        text: a text of ``knitting_instructions`` or of ``graded_instructions``.
        name: name of the text in messages.
        size: name of the size that is read; None if the text is of one garment without a size.

    Raises:
        PatternError: the text holds no pieces, or a row cannot be read; the message gives the line. Or the text has
            several sizes and none is named, or it does not have the named one.
    """
    check_kind("parse_instructions", text, str, "pathlib.Path(file).read_text()")
    sizes = names_of_sizes(text)
    if size is None and sizes:
        raise PatternError(f"{name}: got the sizes {', '.join(sizes)}; name one of them, such as size={sizes[0]!r}")
    if size is not None:
        text = instructions_of_size(text, size, name)
    parser = _Parser()
    for number, line in enumerate(text.splitlines(), start=1):
        try:
            parser.read(line.rstrip())
        except _Unreadable as error:
            raise PatternError(f"{name}: line {number}: {error}") from None
    if not parser.pieces:
        raise PatternError(f"{name}: got no line such as 'Piece 1, worked in rounds'; expected written instructions")
    return tuple(piece.written() for piece in parser.pieces)


class _Unreadable(Exception):
    """A line cannot be read; the reader adds its number."""


@dataclass
class _Piece:
    """A piece whose rows are being read."""

    in_rounds: bool
    cast_on: int = 0
    rows: dict[int, WrittenRow] = field(default_factory=dict)

    def written(self) -> WrittenPiece:
        return WrittenPiece(self.in_rounds, self.cast_on, tuple(self.rows[number] for number in sorted(self.rows)))


class _Parser:
    """Reads one line after another."""

    def __init__(self) -> None:
        self.pieces: list[_Piece] = []

    def read(self, line: str) -> None:
        """Read a line; lines that say nothing about stitches are left out."""
        if match := _PIECE.fullmatch(line):
            self.pieces.append(_Piece(match[1] == "in rounds"))
        elif self.pieces and (match := _CAST_ON.fullmatch(line)):
            self.pieces[-1].cast_on = int(match[1])
        elif self.pieces and (match := _REPEATED.fullmatch(line)):
            self._repeat(*(int(group) if group else 0 for group in match.groups()))
        elif self.pieces and (match := _RHYTHM.fullmatch(line)):
            self._add_rhythm(*match.groups())
        elif self.pieces and (match := _ROW.fullmatch(line)):
            self._add(int(match[1]), _row(match[3], right_side=match[2] != "WS"))
        elif self.pieces and re.match(r"(Row|Round)s? \d", line):
            raise _Unreadable(f"got {line[:60]!r}; expected a row such as 'Row 1 (RS): k3, p2.'")

    def _add(self, number: int, row: WrittenRow) -> None:
        if number in self.pieces[-1].rows or not 1 <= number <= MOST_ROWS:
            raise _Unreadable(f"got row {number}; expected each row once, numbered 1 to {MOST_ROWS}")
        self.pieces[-1].rows[number] = row

    def _add_rhythm(
        self, first: str, last: str, side: str | None, yarn: str | None, apart: str | None, times: str, words: str,
        markers: str | None, loops: str, left: str,
    ) -> None:  # fmt: skip
        """Work shaped rows at equal distances, with plain rows between them (``stitchmesh.hand_knitting.rhythm``)."""
        number, colour, step = int(first), _yarn_number(yarn or "A"), int(apart or 1)
        places = [int(place) for place in re.findall(r"\d{1,6}", markers or "")]
        if number + step * (int(times) - 1) != int(last) or not 1 <= step or int(last) > MOST_ROWS:
            raise _Unreadable(f"got rows {first} to {last}, {times} times every {step}; expected as many rows")
        count, right_side = int(loops), side != "WS"
        if count * int(times) > MOST_IN_RHYTHM:
            raise _Unreadable(f"got {times} rows of {count} sts in one line; expected {MOST_IN_RHYTHM:,} sts at most")
        while number <= int(last):
            row = _Words(right_side, colour, count, places)
            row.read(words, 0)
            if row.loops != count:
                raise _Unreadable(f"got words on {row.loops} sts for {count} sts; expected as many")
            self._add(number, row.row())
            count, places, number = row.made, row.markers_after, number + 1
            plain = [_plain_row(turned, colour, count) for turned in (right_side != (side is not None), right_side)]
            for between in range(step - 1 if number <= int(last) else 0):
                self._add(number, plain[between % 2])
                number += 1
        if count != int(left):
            raise _Unreadable(f"got {left} sts in the end; expected {count}, as the words leave")

    def _repeat(self, first: int, last: int, source: int, end: int) -> None:
        """Copy rows, as in ``Rows 5 to 8: as rows 1 to 2.`` of a text."""
        rows, height = self.pieces[-1].rows, max(end, source) - source + 1
        if any(number not in rows for number in range(source, source + min(height, MOST_ROWS))):
            raise _Unreadable(f"got a repeat of row {source}; expected rows that are written above")
        for number in range(first, min(max(last, first), MOST_ROWS + 1) + 1):
            self._add(number, rows[source + (number - first) % height])


def _plain_row(right_side: bool, yarn: int, count: int) -> WrittenRow:
    """A row that is knit, as seen from the right side."""
    words = _Words(right_side, yarn)
    words.read(f"{'k' if right_side else 'p'}{count}", 0)
    return words.row()


def _row(text: str, *, right_side: bool) -> WrittenRow:
    match = _BODY.fullmatch(text)
    if not match:
        raise _Unreadable(f"got {text[:60]!r}; expected words such as ': k3, p2.'")
    words = _Words(right_side, _yarn_number(match["yarn"] or "A"))
    words.read(match["words"], 0)
    bound = tuple(int(place) - 1 for place in re.findall(r"\d{1,6}", match["bound"] or ""))
    row = words.row()
    return replace(row, passed=int(match["passed"] or 0), turned=bool(match["turned"]), bound_off=bound)


class _Words:
    """The stitches and crossings of a row, in working order."""

    def __init__(self, right_side: bool, yarn: int, on_needle: int = 0, markers: Sequence[int] = ()) -> None:
        """Begin a row.

        Args:
            right_side: whether the knitter looks at the right side.
            yarn: number of the yarn.
            on_needle: loops on the needle, for words such as ``k to last 3``.
            markers: numbers of loops before the markers, for words such as ``k to 3 before marker``.
        """
        self.right_side, self.yarn = right_side, yarn
        self.on_needle, self.markers = on_needle, list(markers)
        self.made = 0
        self.markers_after: list[int] = []
        self.stitches: list[WrittenStitch] = []
        self.crossings: list[tuple[int, tuple[int, ...], frozenset[tuple[int, int]]]] = []
        self.loops = 0

    def read(self, text: str, depth: int) -> None:
        """Read words between commas, and repeats in brackets."""
        if depth > MOST_DEPTH:
            raise _Unreadable(f"got brackets in more than {MOST_DEPTH} brackets; expected fewer")
        for part in _between_commas(text):
            if match := _TIMES.fullmatch(part):
                for _ in range(int(match[2])):
                    self.read(match[1], depth + 1)
            else:
                colour = _COLOUR.fullmatch(part)
                self._word(colour[2] if colour else part, _yarn_number(colour[1]) if colour else self.yarn)
            if len(self.stitches) > MOST_STITCHES:
                raise _Unreadable(f"got more than {MOST_STITCHES} stitches in a row; expected fewer")

    def _word(self, word: str, yarn: int) -> None:
        if word == MARKER or (match := _RUN.fullmatch(word)):
            end = self.markers[0] if self.markers else self.on_needle
            if word == MARKER:
                if not self.markers or self.loops != self.markers.pop(0):
                    raise _Unreadable(f"got a marker after {self.loops} sts; expected one where the line says")
                self.markers_after.append(self.made)
            elif match:
                count = end - int(match[2] or match[3] or 0) - self.loops
                self._stitches(match[1], (), yarn, count)
            return
        if crossing := _crossing(word):
            place, front = crossing
            self.crossings.append((self.loops, place, over_pairs(place, front)))
            if match := _HALVES.fullmatch(word):
                self._stitches("k", (), yarn, int(match[1]))
            return
        if word in _TURNS_MADE:
            self.stitches.append(WrittenStitch(Stitch.YARN_OVER, yarn=yarn, made=_TURNS_MADE[word]))
            self.made += 1
            return
        if match := _COUNTED.fullmatch(word):
            self._stitches(match[1], (), yarn, int(match[2]))
            return
        self._stitches(*_without_turns(word), yarn, 1)

    def _stitches(self, word: str, turns: tuple[tuple[int, int], ...], yarn: int, count: int) -> None:
        stitch = _stitches_by_word(self.right_side).get(word)
        if stitch is None or not 1 <= count <= MOST_STITCHES:
            raise _Unreadable(f"got the word {word[:40]!r}; expected a stitch such as k3, ssk or yo")
        taken = _TAKEN[stitch] if stitch in _TAKEN else SIDE_COUNTS[stitch][0]
        twists = [0] * taken
        for place, twist in turns:
            if not 1 <= place <= taken:
                raise _Unreadable(f"got a turn of st {place} for {word}; it is worked on {taken}")
            twists[place - 1] = twist
        ordered = tuple(twists[::-1] if self.right_side else twists)
        self.stitches += [WrittenStitch(stitch, ordered, yarn)] * count
        self.loops += taken * count
        self.made += SIDE_COUNTS[stitch][1] * count if stitch in SIDE_COUNTS else 0

    def row(self) -> WrittenRow:
        """Return the row from left to right, as seen from the right side.

        Raises:
            _Unreadable: there are no stitches, or loops cross beyond the end of the row.
        """
        last = max((start + len(place) for start, place, _ in self.crossings), default=0)
        if not self.stitches or last > self.loops:
            raise _Unreadable(f"got stitches on {self.loops} loops, {last} of them to be crossed; expected as many")
        if not self.right_side:
            crossed = tuple(WrittenCrossing(start, place, _swapped(over)) for start, place, over in self.crossings)
            return WrittenRow(False, tuple(self.stitches), crossed)
        turned = tuple(self._seen_from_left(*crossing) for crossing in self.crossings[::-1])
        return WrittenRow(True, tuple(self.stitches[::-1]), turned)

    def _seen_from_left(self, start: int, place: tuple[int, ...], over: frozenset[tuple[int, int]]) -> WrittenCrossing:
        last = len(place) - 1
        destination = tuple(last - end for end in place[::-1])
        pairs = frozenset((last - one, last - other) for one, other in over)
        return WrittenCrossing(self.loops - start - len(place), destination, pairs)


def _swapped(over: frozenset[tuple[int, int]]) -> frozenset[tuple[int, int]]:
    """Return the pairs seen from behind, where the other loop of each pair is in front."""
    return frozenset((other, one) for one, other in over)


def _between_commas(text: str) -> Iterator[str]:
    """Give the parts between commas outside brackets."""
    depth, begin = 0, 0
    for place, letter in enumerate(text):
        depth += (letter in "[(") - (letter in "])")
        if letter == "," and depth == 0:
            yield text[begin:place].strip()
            begin = place + 1
    yield text[begin:].strip()


def _crossing(word: str) -> tuple[tuple[int, ...], tuple[int, ...]] | None:
    """Return, for each loop in working order, its new place, and how far in front of the others it is.

    None if the word crosses no loops.
    """
    if match := _HALVES.fullmatch(word):
        return _bundles(int(match[1]) // 2, int(match[1]) // 2, match[2] == "f")
    if match := _BUNDLES.fullmatch(word):
        return _bundles(int(match[1]), int(match[2]), match[3] == "front")
    if not (match := _ORDER.fullmatch(word)):
        return None
    order, depth = ([int(loop or 0) - 1 for loop in match[group].split("-")] for group in (1, 2))
    if sorted(order) != list(range(len(order))) or sorted(depth) != sorted(order):
        raise _Unreadable(f"got {word!r}; expected each st once in the order and once from front to back")
    return _inverse(order), tuple(-rank for rank in _inverse(depth))


def _bundles(first: int, second: int, front: bool) -> tuple[tuple[int, ...], tuple[int, ...]]:
    if not first or not second:
        raise _Unreadable(f"got {first} over {second} sts; expected at least 1 of each to cross")
    place = (*range(second, first + second), *range(second))
    return place, (int(front),) * first + (int(not front),) * second


def _inverse(order: list[int]) -> tuple[int, ...]:
    return tuple(sorted(range(len(order)), key=order.__getitem__))


def _without_turns(word: str) -> tuple[str, tuple[tuple[int, int], ...]]:
    """Return the word of a stitch, and the loops that are turned, numbered from 1, with their half turns."""
    stem, turning, turned = word.partition(" turning ")
    turns = [(int(turn[1:]), 1 if turn[0] == "L" else -1) for turn in _TURNS.findall(turned)]
    if not turning and word.endswith(" tbl"):
        stem, turns = word.removesuffix(" tbl"), [(1, -1)]
    if turns and stem.removesuffix("1") in ONE_LOOP:
        stem = stem.removesuffix("1")
    return stem, tuple(turns)


@cache
def _stitches_by_word(right_side: bool) -> dict[str, Stitch]:
    """Return the stitch, as seen from the right side, of each word of a row."""
    known = (*VOCABULARY, Stitch.CAST_ON, Stitch.DRAW_THROUGH, Stitch.BIND_OFF)
    return {"(k1, p1) in 1 st": Stitch.PK} | {stitch_word(stitch, right_side): stitch for stitch in known}


def _yarn_number(letter: str) -> int:
    """Return the number of the yarn of a letter: A is 0, and Y27 is 26."""
    if re.fullmatch(r"Y\d{1,6}", letter):
        return int(letter[1:]) - 1
    if not re.fullmatch(r"[A-Z]", letter):
        raise _Unreadable(f"got the yarn {letter[:20]!r}; expected a letter, or Y27 and so on")
    return ord(letter) - ord("A")
