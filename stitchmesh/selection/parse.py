# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The language of selections, for a recursive descent parser.

- selection: and-part, then any number of: ``or`` and-part
- and-part: not-part, then any number of: ``and`` not-part
- not-part: ``not`` not-part, a selection in parentheses, or one of the selections of ``docs/selections.md``
- numbers: spans with commas between them
- span: ``N``, ``N-N`` or ``N-``, then optionally ``step N``, then optionally ``height N``
"""

from __future__ import annotations

import difflib
import re
from typing import cast

from stitchmesh.errors import ParameterError
from stitchmesh.hand_knitting.words import STITCHES_BY_NAME
from stitchmesh.selection.selection import (
    BORDER_NAMES,
    PLACES,
    SIDED,
    STITCH_GROUPS,
    AtBorder,
    Both,
    Direction,
    Either,
    Everything,
    Faces,
    FacesOfFile,
    GarmentPart,
    Hand,
    LastRows,
    OfYarn,
    Rectangle,
    RectangleBetween,
    Ring,
    RowRange,
    Selection,
    Span,
    Spans,
    Stitches,
    Wale,
    WalePanel,
    Without,
)

TOKEN = re.compile(r'\s*(?:"([^"]*)"|(\d+)|(x)(?=\s*\d)|([A-Za-z][\w+-]*)|([-,()]))')
SINGULARS = {
    **{one: name for name, one in SIDED.items()}, "tip": "tips", "row": "rows", "face": "faces", "wales": "wale",
    "rings": "ring", "stitches": "stitch", "yarns": "yarn",
}  # fmt: skip
"""Other forms of words, and the form that the parser compares with."""
FIRST_WORDS = (
    "all", "rows", "last", *BORDER_NAMES, *PLACES, "stitch", *STITCH_GROUPS, "yarn", "faces", "file", "wale", "ring",
    "rectangle",
)  # fmt: skip
"""Words with which a selection begins."""
SIDES = ("front", "back", "left", "right")
LARGEST = 2**31 - 1
"""Largest number in a selection."""
MOST_PARTS = 100
"""Largest number of parts that ``and``, ``or``, ``not`` and parentheses join, because selections are nested values."""
MOST_CHARACTERS = 200
"""Number of characters of the text that a message shows."""


def parse_selection(text: str) -> Selection:
    """Return the selection that a text describes, for example ``hem 6`` or ``front and rows 20-40``.

    Raises:
        ParameterError: the text is not a selection; the message shows the word, and for an unknown word the nearest
            known one.
    """
    return _Parser(text).whole()


class _Parser:
    """A recursive descent parser of one text."""

    def __init__(self, text: str) -> None:
        self._text = text
        self._words = self._tokens()
        self._next = 0
        self._parts = 0

    def _tokens(self) -> list[str]:
        """Split the text into words; a word in quotation marks begins with one."""
        words: list[str] = []
        at = 0
        text = self._text.rstrip()
        while at < len(text):
            found = TOKEN.match(text, at)
            if found is None:
                remedy = "; put the name of the file in quotation marks" if words[-1:] == ["file"] else ""
                raise self._error(f"cannot be read from {text[at:].strip()[:20]!r}{remedy}")
            words.append(f'"{found[1]}' if found[1] is not None else next(part for part in found.groups()[1:] if part))
            at = found.end()
        return words

    def _error(self, reason: str) -> ParameterError:
        return ParameterError(f"selection {_shown(self._text)!r}: {reason}")

    def whole(self) -> Selection:
        """Return the selection; nothing may follow it."""
        if not self._words:
            raise self._error("is empty; expected a selection such as 'hem 6' or 'rows 10-20'")
        selection = self._either()
        if self._peek():
            near = difflib.get_close_matches(self._peek(), ("and", "or", "panel", *SIDED.values()), n=1)
            hint = f"did you mean {near[0]!r}?" if near else "expected 'and', 'or' or the end"
            raise self._error(f"got {_shown(self._peek())!r} after {_shown(str(selection))!r}; {hint}")
        return selection

    def _peek(self) -> str:
        """Return the next word in its usual form, an empty text at the end."""
        if self._next == len(self._words):
            return ""
        word = self._words[self._next]
        return word if word.startswith('"') else SINGULARS.get(word.lower(), word.lower())

    def _take(self, word: str) -> bool:
        """Return whether the next word is the given one, and move past it if so."""
        found = self._peek() == word
        self._next += found
        return found

    def _either(self) -> Selection:
        left = self._both()
        while self._take("or"):
            left = Either(left, self._both())
        return left

    def _both(self) -> Selection:
        left = self._single()
        while self._take("and"):
            left = Both(left, self._single())
        return left

    def _single(self) -> Selection:
        self._parts += 1
        if self._parts > MOST_PARTS:
            raise self._error(f"has more than {MOST_PARTS} parts; write the faces into a file")
        if self._take("not"):
            return Without(self._single())
        if self._take("("):
            inner = self._either()
            if not self._take(")"):
                raise self._error("a parenthesis is not closed")
            return inner
        return self._simple()

    def _simple(self) -> Selection:
        word = self._peek()
        if word not in FIRST_WORDS:
            raise self._error(self._unknown(word, FIRST_WORDS))
        self._next += 1
        if word in SIDES:
            return self._of_side(word)
        if word in PLACES:
            return GarmentPart(word)
        if word in STITCH_GROUPS:
            return Stitches(word)
        if word in BORDER_NAMES:
            return self._at_border(word, None)
        return cast(Selection, getattr(self, f"_{word}")())

    def _unknown(self, word: str, known: tuple[str, ...]) -> str:
        """Return the message of an error at a word that is not one of the known words."""
        if not word:
            return f"ends too early; expected one of {', '.join(known)}"
        near = difflib.get_close_matches(word, [*known, *(one for one in SINGULARS if SINGULARS[one] in known)], n=1)
        hint = f"did you mean {near[0]!r}?" if near else f"expected one of {', '.join(known)}"
        return f"{_shown(word)!r} is unknown; {hint}"

    def _of_side(self, side: str) -> Selection:
        """Return the selection that begins with front, back, left or right."""
        if self._take("panel"):
            return WalePanel(side, self._number("the width of the panel in wales", least=1))
        following = self._peek()
        if side in ("left", "right") and following in SIDED:
            self._next += 1
            if following in PLACES:
                return GarmentPart(following, cast(Hand, side))
            return self._at_border(following, cast(Hand, side))
        return GarmentPart(side)

    def _at_border(self, name: str, hand: Hand | None) -> Selection:
        number = self._number("the number of a border") if name == "border" else None
        if not self._peek().isdigit():
            return AtBorder(name, hand=hand, number=number)
        spans = self._spans()
        if len(spans) == 1 and spans[0] == Span(spans[0].first, spans[0].first):
            spans = (Span(1, spans[0].first),) if spans[0].first else spans
        if min(span.first for span in spans) < 1:
            raise self._error(f"distances from a border are counted from 1; got {spans[0]}")
        return AtBorder(name, spans, hand, number)

    def _all(self) -> Selection:
        return Everything()

    def _rows(self) -> Selection:
        return RowRange(self._spans())

    def _last(self) -> Selection:
        count = self._number("a number of rows", least=1)
        if not self._take("rows"):
            raise self._error(f"got {self._peek() or 'the end'!r} after 'last {count}'; expected 'rows'")
        return LastRows(count)

    def _yarn(self) -> Selection:
        return OfYarn(self._spans())

    def _faces(self) -> Selection:
        return Faces(self._spans())

    def _file(self) -> Selection:
        word = self._words[self._next] if self._peek() else ""
        if not word.startswith('"'):
            raise self._error('expected the path of a file in quotation marks, such as file "faces.txt"')
        self._next += 1
        return FacesOfFile(word[1:])

    def _stitch(self) -> Selection:
        word = self._peek()
        if word not in STITCHES_BY_NAME:
            raise self._error(self._unknown(word, tuple(STITCHES_BY_NAME)))
        self._next += 1
        return Stitches(word)

    def _wale(self) -> Selection:
        if self._take("side"):
            side = self._number("the number of a side")
            self._take("up")
            return Wale(side, "up", self._optional_number(), from_side=True)
        return Wale(self._number("the number of a face"), self._direction(), self._optional_number())

    def _ring(self) -> Selection:
        return Ring(self._number("the number of a face"), self._direction(), self._optional_number() or 1)

    def _rectangle(self) -> Selection:
        face = self._number("the number of a face")
        if self._take("to"):
            return RectangleBetween(face, self._number("the number of the opposite face"))
        width = self._number("a width in wales, as in 'rectangle 120 20x30'", least=1)
        if not self._take("x"):
            raise self._error("expected 'x' between width and height, as in 'rectangle 120 20x30'")
        return Rectangle(face, width, self._number("a height in rows", least=1))

    def _direction(self) -> Direction:
        return "up" if self._take("up") else "down" if self._take("down") else "both"

    def _number(self, what: str, *, least: int = 0) -> int:
        word = self._peek()
        if not word.isdigit() or len(word) > len(str(LARGEST)) or not least <= int(word) <= LARGEST:
            raise self._error(f"got {_shown(word) or 'the end'!r}; expected {what}, a whole number from {least}")
        self._next += 1
        return int(word)

    def _optional_number(self) -> int | None:
        return self._number("a number", least=1) if self._peek().isdigit() else None

    def _spans(self) -> Spans:
        spans = [self._span()]
        while self._take(","):
            spans.append(self._span())
        return tuple(spans)

    def _span(self) -> Span:
        first = self._number("a number, or numbers such as 10-20")
        last: int | None = first
        if self._take("-"):
            last = self._number("a number") if self._peek().isdigit() else None
        step = self._number("a step", least=1) if self._take("step") else 1
        height = self._number("a height", least=1) if self._take("height") else 1
        return Span(first, last, step, height)


def _shown(text: str) -> str:
    """Return the start of a text for a message."""
    return text if len(text) <= MOST_CHARACTERS else f"{text[:MOST_CHARACTERS]} ..."
