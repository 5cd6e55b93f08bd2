# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Rows that are shaped in a rhythm, written in one line.

    Rounds 5 to 25: decrease 1 st at each side every 4th round, 6 times: k1, ssk, k to last 3, k2tog, k1; k the other
    rounds. (84 to 72 sts)

All rows between the shaped ones are plain. The shaped rows are the same, except for runs of ``k`` or ``p`` that become
longer or shorter. Such a run is worked up to a number of stitches before the end of its part of the row; a part ends at
a marker or at the end of the row. Markers stay between the same stitches, so a part begins with the stitches that the
shaped row before has left in it. The module also writes repeats in a row of words and in a list of rows, as knitting
patterns do: ``k3, [k2tog, yo] 4 times``.
"""

from __future__ import annotations

from collections.abc import Hashable, Iterable, Sequence
from dataclasses import dataclass
from itertools import accumulate, groupby

COUNTED = frozenset({"k", "p", "co", "dt", "bo"})
"""Words whose repeats are counted by a number, as in ``k3``; other words are repeated in brackets."""

Block = tuple[int, int, int]
"""Start, length and number of occurrences of a block."""
MARKER = "sm"
"""Word for a marker that is slipped from needle to needle."""


def repeats(items: Sequence[Hashable]) -> list[Block]:
    """Divide a sequence into blocks; each block occurs once or several times in succession.

    The search goes from left to right. At each place it takes the block whose repeats shorten the sequence most, and
    among equally good blocks the shortest.
    """
    blocks: list[Block] = []
    place = 0
    while place < len(items):
        best = (0, 1, 1)
        # Largest length of a repeated block.
        for length in range(1, min(48, (len(items) - place) // 2) + 1):
            times = _times(items, place, length)
            saved = (times - 1) * length
            if saved > best[0]:
                best = (saved, length, times)
        blocks.append((place, best[1], best[2]))
        place += best[1] * best[2]
    return blocks


def fold_words(words: Sequence[str]) -> str:
    """Return the words of a row as one line with repeats."""
    tokens = [_token(word, len(list(run))) for word, run in groupby(words)]
    parts = []
    for start, length, times in repeats(tokens):
        block = ", ".join(tokens[start : start + length])
        parts.append(block if times == 1 else f"[{block}] {times} times")
    return ", ".join(parts)


def _times(items: Sequence[Hashable], place: int, length: int) -> int:
    """Number of successive occurrences of the block at a place."""
    times, following = 1, place + length
    while items[following : following + length] == items[place : place + length]:
        times += 1
        following += length
    return times


def _token(word: str, count: int) -> str:
    """A word that occurs ``count`` times in succession; the word may begin with a colour, as in ``A: k``."""
    if word.rpartition(": ")[2] in COUNTED:
        return f"{word}{count}"
    return word if count == 1 else f"[{word}] {count} times"


@dataclass(frozen=True)
class ShapedWord:
    """A word of a row, with the loops that it takes and makes."""

    word: str
    taken: int
    made: int


@dataclass(frozen=True)
class RowForRhythm:
    """A row that may belong to a rhythm."""

    words: tuple[ShapedWord, ...]
    """Its words in working order."""
    before: str
    """Text of the line before the words of the row, such as its side and its yarn."""

    @property
    def loops(self) -> int:
        """Loops on the needle before the row."""
        return sum(word.taken for word in self.words)

    @property
    def change(self) -> int:
        """By how many loops the row changes the number on the needle."""
        return sum(word.made for word in self.words) - self.loops

    @property
    def is_plain(self) -> bool:
        """Whether all its stitches are knit, as seen from the right side."""
        return {word.word for word in self.words} == {"p" if "(WS)" in self.before else "k"}


@dataclass(frozen=True)
class Rhythm:
    """Shaped rows at equal distances."""

    first: int
    """Place of the first shaped row among all rows."""
    apart: int
    """Distance from each shaped row to the next, in rows."""
    times: int
    """Number of shaped rows."""

    @property
    def last(self) -> int:
        """Place of the last shaped row."""
        return self.first + self.apart * (self.times - 1)


def rhythms(rows: Sequence[RowForRhythm | None]) -> list[tuple[Rhythm, list[_Part]]]:
    """Find rhythms from the first row on, each as long as possible; return them with the parts of their rows.

    Args:
        rows: the rows; None for a row that belongs to no rhythm.
    """
    found = []
    shaped = [place for place, row in enumerate(rows) if row is not None and row.change]
    place = 0
    while place + 1 < len(shaped):
        first, apart = shaped[place], shaped[place + 1] - shaped[place]
        parts, times = _parts(rows[first], rows[first + apart]), 1
        while parts and place + times < len(shaped) and shaped[place + times] == first + apart * times:
            last = shaped[place + times - 1]
            between = rows[last + 1 : last + apart]
            one, other = rows[last], rows[last + apart]
            if not (_is_plain(between, rows[first]) and _follows(one, other, parts)):
                break
            times += 1
        # Smallest number of shaped rows that are written in one line.
        if times >= 3 and parts:
            found.append((Rhythm(first, apart, times), parts))
        place += max(times, 1)
    return found


def rhythm_line(rows: Sequence[RowForRhythm | None], rhythm: Rhythm, parts: list[_Part], first: int, name: str) -> str:
    """Return the line of a rhythm.

    Args:
        rows: the rows.
        rhythm: the rhythm.
        parts: the parts of its rows.
        first: number of the first of the rows.
        name: ``Row`` or ``Round``.
    """
    row, last = rows[rhythm.first], rows[rhythm.last]
    assert row is not None and last is not None
    kind = name.lower()
    words = [word for place, part in enumerate(parts) for word in part.words(is_last=place == len(parts) - 1)]
    every = f"every {kind}" if rhythm.apart == 1 else f"every {_ordinal(rhythm.apart)} {kind}"
    others = "k the other rounds" if name == "Round" else "work the other rows plain"
    places = list(accumulate(part.taken for part in parts))[:-1]
    many = "s" if len(places) > 1 else ""
    markers = f" Marker{many} after st{many} {', '.join(map(str, places))}." if places else ""
    return (
        f"{name}s {first + rhythm.first} to {first + rhythm.last}{row.before}: {_what(row, parts, name)} {every}, "
        f"{rhythm.times} times: {fold_words(words)}{'' if rhythm.apart == 1 else f'; {others}'}.{markers} "
        f"({row.loops} to {last.loops + last.change} sts)"
    )


@dataclass(frozen=True)
class _Part:
    """A part of a shaped row, from one marker to the next."""

    begin: tuple[ShapedWord, ...]
    """Words before the run that becomes longer or shorter."""
    run: ShapedWord
    """The word of the run."""
    count: int
    """How often the run repeats the word in the first row."""
    end: tuple[ShapedWord, ...]
    """Words after the run."""

    @property
    def taken(self) -> int:
        """Loops that the part takes in the first row."""
        return sum(word.taken for word in (*self.begin, *self.end)) + self.count

    @property
    def changes(self) -> tuple[int, int]:
        """By how many loops its words before and after the run change their number."""
        before, after = (sum(word.made - word.taken for word in words) for words in (self.begin, self.end))
        return before, after

    def words(self, *, is_last: bool) -> list[str]:
        """The words of the part, with the marker at its end unless it is the last part."""
        left = sum(word.taken for word in self.end)
        if is_last:
            run = f"{self.run.word} to last {left}" if left else f"{self.run.word} to end"
        else:
            run = f"{self.run.word} to {left} before marker" if left else f"{self.run.word} to marker"
        marker = [] if is_last else [MARKER]
        return [*(word.word for word in self.begin), run, *(word.word for word in self.end), *marker]


_Runs = list[tuple[ShapedWord, int]]


def _runs(row: RowForRhythm) -> _Runs:
    return [(word, len(list(same))) for word, same in groupby(row.words)]


def _parts(one: RowForRhythm | None, other: RowForRhythm | None) -> list[_Part]:
    """Divide a shaped row at runs that are longer or shorter in another row; no parts if the rows differ otherwise."""
    if one is None or other is None or one.before != other.before:
        return []
    first, second = _runs(one), _runs(other)
    if [word for word, _ in first] != [word for word, _ in second]:
        return []
    moving = [place for place, pair in enumerate(zip(first, second, strict=True)) if pair[0][1] != pair[1][1]]
    if not moving or any(first[place][0].word not in ("k", "p") for place in moving):
        return []
    fixed = [_expanded(first[low + 1 : high]) for low, high in zip([-1, *moving], [*moving, len(first)], strict=True)]
    parts, begin = [], fixed[0]
    for number, place in enumerate(moving):
        word, count = first[place]
        gap, wanted = fixed[number + 1], second[place][1] - count - _change(begin)
        cut = _cut(gap, wanted) if number + 1 < len(moving) else len(gap)
        if cut is None or _change(gap[:cut]) != wanted:
            return []
        parts.append(_Part(tuple(begin), word, count, tuple(gap[:cut])))
        begin = gap[cut:]
    return parts


def _cut(words: Sequence[ShapedWord], change: int) -> int | None:
    """The place nearest to the middle of some words, before which they change the number of loops by ``change``."""
    places = [place for place in range(len(words) + 1) if _change(words[:place]) == change]
    return min(places, key=lambda place: abs(2 * place - len(words)), default=None)


def _follows(one: RowForRhythm | None, other: RowForRhythm | None, parts: list[_Part]) -> bool:
    """Whether a shaped row has the same parts as the one before, each with the stitches that the latter has left."""
    if one is None or other is None or one.before != other.before or one.loops + one.change != other.loops:
        return False
    found = _parts(one, other)
    return [(part.begin, part.run, part.end) for part in found] == [(part.begin, part.run, part.end) for part in parts]


def _is_plain(rows: Sequence[RowForRhythm | None], shaped: RowForRhythm | None) -> bool:
    """Whether the rows between shaped rows are plain and of the same yarn, and all shaped rows are on one side."""
    assert shaped is not None
    if "S)" in shaped.before and len(rows) % 2 == 0:
        return False
    yarn = _yarn(shaped)
    return all(row is not None and row.is_plain and _yarn(row) == yarn for row in rows)


def _yarn(row: RowForRhythm) -> str:
    return row.before.partition(" in yarn ")[2]


def _expanded(runs: _Runs) -> list[ShapedWord]:
    return [word for word, count in runs for _ in range(count)]


def _change(words: Iterable[ShapedWord]) -> int:
    return sum(word.made - word.taken for word in words)


def _what(row: RowForRhythm, parts: list[_Part], name: str) -> str:
    """What a shaped row does, such as ``decrease 1 st at each side``."""
    verb, count = ("decrease" if row.change < 0 else "increase"), abs(row.change)
    at_sides = {abs(change) for part in parts for change in part.changes}
    if len(at_sides) != 1 or 2 * len(parts) * max(at_sides) != count:
        return f"{verb} {count} st{'s' if count > 1 else ''}"
    each = max(at_sides)
    where = " of each marker and of the start of the round" if name == "Round" else " of each part"
    return f"{verb} {each} st{'s' if each > 1 else ''} at each side{where if len(parts) > 1 else ''}"


def _ordinal(number: int) -> str:
    suffix = "th" if number % 100 in (11, 12, 13) else {1: "st", 2: "nd", 3: "rd"}.get(number % 10, "th")
    return f"{number}{suffix}"
