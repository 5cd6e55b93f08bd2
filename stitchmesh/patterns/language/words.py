# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The words of the language: the stitches that each abbreviation describes, as the reader faces the fabric.

The loops of a code of ``stitch.CODES`` are read from left to right as seen, even if the row that holds the code is read
from right to left. An abbreviation describes what a hand knitter does. In a loop worked through its back leg, and in a
backward loop (make one, leaning left), the leg that comes from the right lies in front; this is a twist of -1.
``docs/patterns.md`` lists all words.

Each word describes its stitches and the loops below them, from left to right as the reader faces the fabric.
"""

from __future__ import annotations

import difflib
import re
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace

from stitchmesh.errors import ParameterError
from stitchmesh.mesh.own_stitch import OwnStitch, StitchType, built_in
from stitchmesh.mesh.stitch import CODES, Stitch, from_wrong_side
from stitchmesh.patterns.pattern import Cell, Loop

OwnWords = Mapping[str, OwnStitch]
"""Stitches of the user's own by their codes, which are words too."""
NO_WORDS: OwnWords = {}
RESERVED = frozenset({"cross", "repeat", "yarn", "lt", "rt", "rs", "ws"})
"""Words of the language that are no stitches."""


@dataclass(frozen=True)
class WordStitches:
    """Stitches of one word: a single stitch, a cable, or nothing for an empty square of a chart."""

    cells: tuple[Cell, ...]
    """The stitches, left to right."""
    loops: tuple[Loop, ...]
    """How the loops below are held, left to right before any crossing."""
    columns: int = 1
    """Number of squares of a chart that the word covers."""
    tuck: bool = False
    """Whether the next row works the two loops of this stitch together."""

    def turned(self) -> WordStitches:
        """Return the same stitches seen from the other side of the fabric, turned about the wale."""
        front = max((loop.layer for loop in self.loops), default=0)
        cells = tuple(
            Cell(from_wrong_side(built_in(cell.stitch)), cell.twist[::-1], cell.yarn) for cell in reversed(self.cells)
        )  # a half turn of a loop has the same direction when it is seen from behind
        loops = tuple(Loop(-loop.shift, front - loop.layer, loop.twist) for loop in reversed(self.loops))
        return replace(self, cells=cells, loops=loops)


def single(cell: Cell, twist_below: tuple[int, ...] = (), *, tuck: bool = False) -> WordStitches:
    """Return one stitch on loops that no cable moves; ``twist_below`` gives the half turn of each loop below."""
    below = twist_below or (0,) * cell.n_bottom
    return WordStitches((cell,), tuple(Loop(twist=twist) for twist in below), tuck=tuck)


def cable(cells: tuple[Cell, ...], target: list[int], layers: list[int], twists: list[int]) -> WordStitches:
    """Return stitches on loops that are reordered before they are worked.

    Args:
        cells: the stitches, left to right.
        target: loop i moves to place ``target[i]``.
        layers: the layer of each loop, in the order before the crossing.
        twists: the half turn that the stitches give to each loop, in the order after the crossing.
    """
    loops = [Loop(end - place, layers[place], twists[end]) for place, end in enumerate(target)]
    return WordStitches(cells, tuple(loops), columns=max(len(target), len(cells)))


@dataclass(frozen=True)
class Meaning:
    """The stitch that an abbreviation describes."""

    stitch: StitchType
    twist: int = 0
    """Half turn of the loop that the stitch makes."""
    below: int = 0
    """Half turn that the stitch gives to the loop on which it is worked."""


ABBREVIATIONS: dict[str, Meaning] = {
    "yo": Meaning(Stitch.YARN_OVER),
    "m1l": Meaning(Stitch.YARN_OVER, twist=-1),
    "m1r": Meaning(Stitch.YARN_OVER, twist=1),
    "m1": Meaning(Stitch.YARN_OVER, twist=-1),
    "ktbl": Meaning(Stitch.KNIT, below=-1),
    "ptbl": Meaning(Stitch.PURL, below=-1),
    "slwyib": Meaning(Stitch.SLIP_BACK),
    "slwyif": Meaning(Stitch.SLIP_FRONT),
    "sl": Meaning(Stitch.SLIP_BACK),
    "k2tog": Meaning(Stitch.D12K),
    "ssk": Meaning(Stitch.D21K),
    "skp": Meaning(Stitch.D21K),
    "p2tog": Meaning(Stitch.D12P),
    "ssp": Meaning(Stitch.D21P),
    "k3tog": Meaning(Stitch.D123K),
    "sssk": Meaning(Stitch.D321K),
    "sk2p": Meaning(Stitch.D312K),
    "s2kp": Meaning(Stitch.D231K),
    "cdd": Meaning(Stitch.D231K),
    "p3tog": Meaning(Stitch.D123P),
    "sssp": Meaning(Stitch.D321P),
    "kfb": Meaning(Stitch.PK),
    "pfb": Meaning(Stitch.KP),
    "kyok": Meaning(Stitch.KYK),
}
"""Abbreviations in addition to the codes of ``stitch.CODES``."""

TUCK = "t"
"""Word for a tuck: a slipped loop with a yarn-over; a k or p of the next row works both together."""
NO_STITCH = "none"
"""Word for a square of a chart that holds no stitch."""
CROSSING_EXAMPLES = tuple("lt rt c4f c4b c6f c6b t3f t3b t4f t4b 2/1lc 2/1rc 2/1lpc 2/1rpc".split())
"""Words for cables that the message for an unknown word suggests."""

_MARKS = re.compile(r"(?P<code>[a-z0-9/]+)(?P<twist>([+-][01])*)(~(?P<below>([+-][01])+))?(@(?P<yarn>\d{1,6}))?")
_COUNTED = re.compile(r"(?P<word>[a-z]+)(?P<count>\d{1,6})")
_COUNT_INSIDE = re.compile(r"(?P<start>k|p|sl)(?P<count>\d{1,6})(?P<end>tbl|wyib|wyif)")
_EVEN_CABLE = re.compile(r"c(?P<width>\d{1,3})(?P<hand>[fb])")
_TRAVELLING = re.compile(r"t(?P<width>\d{1,3})(?P<hand>[fb])")
_CROSS = re.compile(r"(?P<front>\d{1,3})/(?P<back>\d{1,3})(?P<hand>[lr])(?P<purl>p?)c")
_TWISTS = {"lt": "1/1lc", "rt": "1/1rc"}


class WordError(ValueError):
    """A word is unknown or malformed; the parser adds the place to the message."""


def read_word(text: str, yarn: int, own: OwnWords = NO_WORDS) -> list[WordStitches]:
    """Read a word.

    Args:
        text: the word, in upper or lower case.
        yarn: the yarn if the word names no yarn.
        own: stitches of the user's own by their codes.

    Returns:
        The stitches, left to right as the reader faces the fabric: one piece, or several equal ones for a word with a
        count.

    Raises:
        WordError: the word is unknown or its marks do not fit its stitch.
    """
    marks = _MARKS.fullmatch(text.lower())
    if not marks:
        raise WordError(unknown(text, own))
    code, count = _without_count(marks["code"], own)
    if count == 0:
        raise WordError(f"got {text!r}; expected a count of 1 or more")
    chosen = int(marks["yarn"]) if marks["yarn"] else yarn
    crossing = read_crossing(code, chosen)
    if crossing or code == NO_STITCH:
        if marks["twist"] or marks["below"]:
            raise WordError(f"got {text!r}; expected no twists on {code}, write the twists within cross(...)")
        return [crossing or WordStitches((), ())] * count
    return [_stitch(text, code, _signs(marks["twist"]), _signs(marks["below"]), chosen, own)] * count


def own_words(stitches: Iterable[OwnStitch]) -> OwnWords:
    """Return stitches of the user's own by their codes.

    Raises:
        ParameterError: a code is a word of the language, or two stitches have one code.
    """
    found: dict[str, OwnStitch] = {}
    for stitch in stitches:
        if stitch.code in found or stitch.code in RESERVED or is_word(stitch.code):
            raise ParameterError(f"stitch {stitch.code!r}: this code is taken already; choose another word")
        found[stitch.code] = stitch
    return found


def is_word(code: str) -> bool:
    """Return whether a word without a count and marks describes a stitch."""
    return code in ABBREVIATIONS or code in CODES or code in (TUCK, NO_STITCH)


def unknown(text: str, own: OwnWords = NO_WORDS) -> str:
    """Return the message for an unknown word, with similar words."""
    known = [*own, *ABBREVIATIONS, *CODES, *CROSSING_EXAMPLES, TUCK, NO_STITCH]
    near = difflib.get_close_matches(text.lower(), known, n=3, cutoff=0.5)
    hint = f"did you mean {' or '.join(near)}?" if near else "docs/patterns.md lists all words"
    return f"got {text!r}; expected a stitch such as k, p2, yo, k2tog, c4f: {hint}"


def read_crossing(code: str, yarn: int) -> WordStitches | None:
    """Read a word for a cable: a number of loops crosses in front of another number, to the left or to the right.

    Args:
        code: the word in lower case, without marks.
        yarn: the yarn of the stitches.

    Returns:
        The stitches, or None if the word is not a cable.

    Raises:
        WordError: the number of loops does not allow the cable.
    """
    match = _CROSS.fullmatch(_TWISTS.get(code, code))
    if match:
        return _crossing(int(match["front"]), int(match["back"]), match["hand"] == "l", bool(match["purl"]), yarn)
    match = _EVEN_CABLE.fullmatch(code)
    if match:
        width = int(match["width"])
        if width % 2 or not width:
            half = width // 2
            raise WordError(f"got {code!r}; expected an even number of loops, or write {half + 1}/{max(half, 1)}lc")
        return _crossing(width // 2, width // 2, match["hand"] == "f", False, yarn)
    match = _TRAVELLING.fullmatch(code)
    if match:
        width = int(match["width"])
        if width < 2:
            raise WordError(f"got {code!r}; expected 2 loops or more")
        return _crossing(width - width // 2, width // 2, match["hand"] == "f", True, yarn)
    return None


def _crossing(front: int, back: int, leftwards: bool, purl: bool, yarn: int) -> WordStitches:
    """Return a cable: the front loops cross to the left or right and are knit; the back loops are knit or purled."""
    if not front or not back:
        raise WordError(f"got {front} loops over {back}; expected at least 1 of each to cross")
    knit, behind = Cell(Stitch.KNIT, yarn=yarn), Cell(Stitch.PURL if purl else Stitch.KNIT, yarn=yarn)
    width = front + back
    if leftwards:
        target = [front + place for place in range(back)] + list(range(front))
        return cable((knit,) * front + (behind,) * back, target, [0] * back + [1] * front, [0] * width)
    target = [back + place for place in range(front)] + list(range(back))
    return cable((behind,) * back + (knit,) * front, target, [1] * front + [0] * back, [0] * width)


def _without_count(code: str, own: OwnWords) -> tuple[str, int]:
    if is_word(code) or code in own:
        return code, 1
    match = _COUNT_INSIDE.fullmatch(code)
    if match:
        return match["start"] + match["end"], int(match["count"])
    match = _COUNTED.fullmatch(code)
    if match and (is_word(match["word"]) or match["word"] in own):
        return match["word"], int(match["count"])
    return code, 1


def _stitch(
    text: str, code: str, twist: tuple[int, ...], below: tuple[int, ...], yarn: int, own: OwnWords
) -> WordStitches:
    if not is_word(code) and code not in own:
        raise WordError(unknown(text, own))
    if code == TUCK:
        meaning = Meaning(Stitch.SY)
    elif code in own:
        meaning = Meaning(own[code])
    else:
        meaning = ABBREVIATIONS.get(code) or Meaning(CODES[code])
    plain = Cell(meaning.stitch)
    twist = twist or (meaning.twist,) * plain.n_top
    below = below or (meaning.below,) * plain.n_bottom
    if len(twist) != plain.n_top or len(below) != plain.n_bottom:
        needed = f"{plain.n_top} on top and {plain.n_bottom} below"
        raise WordError(f"got {text!r}; expected a twist for each of its loops or for none: {needed}")
    return single(Cell(meaning.stitch, twist, yarn), below, tuck=code == TUCK)


def _signs(text: str | None) -> tuple[int, ...]:
    return tuple(int(sign) for sign in re.findall(r"[+-][01]", text or ""))
