# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""An interpreter of written knitting instructions: a simulated hand knitter.

The interpreter knows only the language of patterns (needles, rows, rounds and abbreviations) and no meshes. It numbers
loops in the order in which they are made, and records which loop was drawn through which. A stitch is recorded as seen
from the right side: its code, the loops that it was worked through and the loops that it made, each from left to right.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass, field

from stitchmesh.mesh.stitch import CODES, VOCABULARY, from_wrong_side

NAMES = {
    "k": "k", "p": "p", "yo": "y", "sl1 wyib": "b", "sl1 wyif": "f", "w1": "x", "k2tog": "d12k", "ssk": "d21k",
    "p2tog": "d12p", "ssp": "d21p", "k3tog": "d123k", "sssk": "d321k", "p3tog": "d123p", "sssp": "d321p",
    "s2kp": "d231k", "sk2p": "d312k", "co": "co", "dt": "dt", "k1": "k", "p1": "p",
    "m1l": "y", "m1r": "y", "kfb": "pk",
}  # fmt: skip
HALF_TURNS = {"m1l": -1, "m1r": 1}
INSIDE = {"k1": "k", "p1": "p", "yo": "y", "keep": "s"}


@dataclass(frozen=True)
class Worked:
    """A worked stitch, as seen from the right side."""

    code: str
    through: tuple[int, ...]
    """Loops that the stitch was worked through, from left to right."""
    made: tuple[int, ...]
    """Loops that the stitch made, from left to right."""
    yarn: str
    turned: tuple[str, ...]
    """For each loop of ``through``: ``L`` or ``R`` if the loop was turned first, else an empty string."""
    half_turns: tuple[int, ...] = ()
    """For each loop of ``made``: -1 if it was made with its right leg in front, 1 with its left leg, else 0."""


@dataclass
class Needle:
    """One piece on its needle."""

    in_rounds: bool
    loops: list[int] = field(default_factory=list)
    """Loops on the needle, from left to right as seen from the right side."""
    position: int = 0
    """Number of loops to the right of the yarn."""
    rows: list[list[Worked]] = field(default_factory=list)
    """Stitches of each row, from right to left even if the row was worked from left to right."""
    sources: list[int] = field(default_factory=list)
    """Loops that the piece starts with, in working order."""
    ends: dict[int, str] = field(default_factory=dict)
    """Use of each loop that is not worked further: ``bound``, ``grafted`` or the number of the piece that takes it."""


@dataclass
class HandKnitter:
    """All needles, and the crossings and grafts that were worked."""

    needles: list[Needle] = field(default_factory=list)
    count: int = 0
    crossed: list[tuple[tuple[int, ...], tuple[int, ...]]] = field(default_factory=list)
    """Pairs of bundles that crossed; the bundle in front, as seen from the right side, comes first."""
    grafted: list[tuple[int, int]] = field(default_factory=list)
    """Pairs of grafted loops."""
    markers: list[int] = field(default_factory=list)
    """Loops from the start of the row to each marker on the needle."""

    def knit(self, text: str) -> HandKnitter:
        """Follow the instructions of a whole text."""
        texts: dict[int, tuple[bool, str]] = {}
        for line in text.split("\n"):
            if match := re.fullmatch(r"Piece \d+, worked (in rounds|to and fro)", line):
                self.needles.append(Needle(match[1] == "in rounds"))
                texts = {}
            elif match := re.match(r"Cast on (\d+) sts", line):
                self._cast_on(int(match[1]))
            elif match := re.fullmatch(r"Take up (.*); join the yarn\.", line):
                self._take_up(match[1])
            elif " times: " in line and re.match(r"(Row|Round)s \d", line):
                self._rhythm(line)
            elif match := re.fullmatch(r"(?:Row|Round) (\d+)( \([RW]S\))?(.*)", line):
                texts[int(match[1])] = match[2] != " (WS)", match[3]
                if not match[3].startswith(": as "):
                    self._row(*texts[int(match[1])])
                else:
                    self._repeat_rows(texts, int(match[1]), int(match[1]), match[3])
            elif match := re.fullmatch(r"(?:Rows|Rounds) (\d+) to (\d+)(: as .*)", line):
                self._repeat_rows(texts, int(match[1]), int(match[2]), match[3])
            elif match := re.match(r"(Bind off|Leave) (all|sts?) ([\d, -]+?)(?: sts)?( on a thread.*)?\.$", line):
                self._end(match[2], match[3], match[4] or "")
            elif match := re.fullmatch(r"Graft sts? (.*) of piece (\d+) to sts? (.*) of piece (\d+) \(.*\)\.", line):
                self._graft(*match.groups())
        return self

    def _rhythm(self, line: str) -> None:
        """Work shaped rows at equal distances and plain rows between them."""
        head, _, rest = line.partition(" times: ")
        first, last = map(int, re.match(r"\w+ (\d+) to (\d+)", head).groups())
        apart = int((re.search(r"every (\d+)", head) or [0, 1])[1])
        yarn = re.search(r" in yarn (\w+)", head)
        rest, _, counts = rest.removesuffix(" sts)").rpartition(" (")
        rest, _, places = rest.partition(" Marker")
        words = rest.removesuffix(".").partition(";")[0]
        needle, side = self.needles[-1], "(WS)" not in head
        self.markers = [int(number) for number in re.findall(r"\d+", places)]
        assert len(needle.loops) == int(counts.split()[0]), line
        colour = f" in yarn {yarn[1]}" if yarn else ""
        for number in range(first, last + 1):
            if (number - first) % apart == 0:
                self._row(side, f"{colour}: {words}.")
            else:
                right, markers = needle.in_rounds or side == ((number - first) % 2 == 0), self.markers
                self._row(right, f"{colour}: {'k' if right else 'p'}{len(needle.loops)}.")
                self.markers = markers
        assert (last - first) // apart + 1 == int(head.split()[-1])
        assert len(needle.loops) == int(counts.split()[-1]), line

    def _repeat_rows(self, texts: dict[int, tuple[bool, str]], low: int, high: int, words: str) -> None:
        """Work rows ``low`` to ``high`` as the rows that the words name."""
        numbers = [int(number) for number in re.findall(r"\d+", words)]
        originals = range(numbers[0], numbers[-1] + 1)
        for number in range(low, high + 1):
            texts[number] = texts[originals[(number - low) % len(originals)]]
            self._row(*texts[number])

    def _new(self) -> int:
        self.count += 1
        return self.count - 1

    def _cast_on(self, count: int) -> None:
        needle = self.needles[-1]
        needle.loops = [self._new() for _ in range(count)]
        needle.rows.append([Worked("co", (), (loop,), "", ()) for loop in needle.loops[::-1]])

    def _take_up(self, words: str) -> None:
        loops: list[int] = []
        for part in re.findall(r"\d+ cast on|sts? [\d, -]+ of piece \d+", words):
            if part.endswith("cast on"):
                loops += [self._new() for _ in range(int(part.split()[0]))]
                continue
            numbers, owner = re.fullmatch(r"sts? (.*) of piece (\d+)", part).groups()
            needle = self.needles[int(owner) - 1]
            for number in numbered(numbers):
                loop = needle.loops[::-1][number - 1]
                assert needle.ends[loop] == str(len(self.needles))
                loops.append(loop)
        self.needles[-1].loops, self.needles[-1].sources = loops[::-1], loops

    def _row(self, right_side: bool, words: str) -> None:
        needle = self.needles[-1]
        head, _, body = words.partition(": ")
        if bound := re.match(r"first bind off sts ([\d, ]+); ", body):
            for number in map(int, bound[1].split(",")):
                needle.ends[needle.loops[::-1][number - 1]] = "bound"
            needle.loops = [loop for loop in needle.loops if loop not in needle.ends]
            needle.position = 0 if right_side else len(needle.loops)
            body = body[bound.end() :]
        body, _, count = body.removesuffix(".").removesuffix(")").partition(". (")
        _Row(self, needle, right_side, head.removeprefix(" in yarn ") if head else "").work(body)
        assert not count or int(count.split()[0]) == len(needle.loops), words

    def _end(self, whole: str, words: str, fate: str) -> None:
        needle = self.needles[-1]
        numbers = range(1, int(words) + 1) if whole == "all" else numbered(words)
        assert whole != "all" or int(words) == len(needle.loops)
        for number in numbers:
            piece = re.search(r"piece (\d+)", fate)
            needle.ends[needle.loops[::-1][number - 1]] = piece[1] if piece else "grafted" if fate else "bound"

    def _graft(self, one: str, first: str, other: str, second: str) -> None:
        pairs = zip(numbered(one), numbered(other), strict=True)
        left, right = self.needles[int(first) - 1].loops[::-1], self.needles[int(second) - 1].loops[::-1]
        self.grafted += [(left[a - 1], right[b - 1]) for a, b in pairs]


@dataclass
class _Row:
    """A row that is being worked."""

    knitter: HandKnitter
    needle: Needle
    right_side: bool
    yarn: str
    waiting: list[int] = field(default_factory=list)
    """Loops that are not worked yet, in working order."""
    behind: list[int] = field(default_factory=list)
    """Loops that this row has made or passed, in working order."""
    stitches: list[Worked] = field(default_factory=list)

    def work(self, body: str) -> None:
        """Work all words of the row, to its end or to the turn."""
        loops = self.needle.loops[:: -1 if self.right_side else 1]
        position = self.needle.position if self.right_side else len(loops) - self.needle.position
        position = 0 if self.needle.in_rounds else position
        self.behind, self.waiting = loops[:position], loops[position:]
        passed_in_round, turned_back = [], False
        markers, self.knitter.markers = self.knitter.markers, []
        for word in words_of(body):
            if word.startswith("pass ") and self.needle.in_rounds:
                passed_in_round = [self.waiting.pop(0) for _ in range(int(word[5:]))]
                self.waiting += passed_in_round
            elif word.startswith("pass "):
                self.behind += [self.waiting.pop(0) for _ in range(int(word[5:]))]
            elif word == "turn":
                turned_back = True
            elif word == "sm":
                assert len(loops) - len(self.waiting) == markers.pop(0), body
                self.knitter.markers.append(len(self.behind))
            elif match := re.fullmatch(r"([kp]) to (?:last (\d+)|(\d+) before marker|marker|end)", word):
                end = markers[0] if "marker" in word else len(loops)
                for _ in range(end - (len(loops) - len(self.waiting)) - int(match[2] or match[3] or 0)):
                    self._stitch(match[1], "", {})
            else:
                self._word(word)
        assert bool(self.waiting) == turned_back, f"{len(self.waiting)} sts left at the end of {body}"
        after = self.behind + self.waiting
        self.needle.loops = after[:: -1 if self.right_side else 1]
        self.needle.position = len(self.behind) if self.right_side else len(self.waiting)
        self.needle.rows.append(self.stitches[:: 1 if self.right_side else -1])

    def _word(self, word: str) -> None:
        colour, _, bare = word.rpartition(": ")
        if match := re.fullmatch(r"c(\d+)([fb])", bare):
            half = int(match[1]) // 2
            self._cross(half, half, match[2] == "f")
            for _ in range(2 * half):
                self._stitch("k", colour, {})
        elif match := re.fullmatch(r"cross (\d+)/(\d+) (front|back)", bare):
            self._cross(int(match[1]), int(match[2]), match[3] == "front")
        else:
            stem, _, turning = bare.partition(" turning ")
            turned = {int(item[1:]): item[0] for item in turning.split()}
            if stem.endswith(" tbl"):
                stem, turned = stem.removesuffix(" tbl"), {1: "R"}
            self._stitch(stem, colour, turned)

    def _cross(self, first: int, second: int, front: bool) -> None:
        held, others = tuple(self.waiting[:first]), tuple(self.waiting[first : first + second])
        self.waiting[: first + second] = [*others, *held]
        held_in_front = front == self.right_side
        self.knitter.crossed.append((held, others) if held_in_front else (others, held))

    def _stitch(self, stem: str, colour: str, turned: dict[int, str]) -> None:
        code = self._code(stem)
        making = VOCABULARY.get(CODES.get(code))
        takes, makes = (making.n_bottom, making.n_top) if making else {"co": (0, 1), "dt": (1, 0)}[code]
        through = [self.waiting.pop(0) for _ in range(takes)]
        made = [self.knitter._new() for _ in range(makes)]
        self.behind += made
        marks = [turned.get(place, "") for place in range(1, takes + 1)]
        if self.right_side:
            through, made, marks = through[::-1], made[::-1], marks[::-1]
        elif making:
            code = VOCABULARY[from_wrong_side(CODES[code])].code
        yarn = colour or self.yarn
        turns = (HALF_TURNS.get(stem, 0),) * len(made)
        self.stitches.append(Worked(code, tuple(through), tuple(made), yarn, tuple(marks), turns))

    def _code(self, stem: str) -> str:
        """The code of a word, as seen from the side that the knitter looks at."""
        if stem in NAMES:
            return NAMES[stem]
        if match := re.fullmatch(r"([kp])3tog-(\d{3})", stem):
            return f"d{match[2]}{match[1]}"
        inside = re.fullmatch(r"\((.*)\) in 1 st", stem)
        assert inside, stem
        return "".join(INSIDE[word] for word in inside[1].split(", "))[::-1]


def words_of(body: str) -> Iterator[str]:
    """The words of a row one by one, with repeats expanded."""
    for part in _split(body):
        if match := re.fullmatch(r"\[(.*)\] (\d+) times", part):
            for _ in range(int(match[2])):
                yield from words_of(match[1])
        elif match := re.fullmatch(r"((?:\w+: )?(?:k|p|co|dt))(\d+)", part):
            yield from [match[1]] * int(match[2])
        else:
            yield part


def _split(body: str) -> list[str]:
    """Split at the commas outside brackets."""
    parts, depth = [""], 0
    for letter in body:
        depth += (letter in "[(") - (letter in "])")
        if letter == "," and depth == 0:
            parts.append("")
        else:
            parts[-1] += letter
    return [part.strip() for part in parts]


def numbered(words: str) -> list[int]:
    """``1-3, 9, 7-6`` as numbers."""
    found: list[int] = []
    for part in words.split(", "):
        low, _, high = part.partition("-")
        step = -1 if high and int(high) < int(low) else 1
        found += range(int(low), int(high or low) + step, step)
    return found
