# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The items of one written row: words, groups, crossings and bars, by recursive descent.

    items = { item | "|" | "," }
    item  = ( word | group | cross ) [ "*" number ]
    group = "[" { item | "," } "]"
    cross = "cross" "(" numbers ";" numbers ":" { item | "," } ")"

A word may carry marks of its own: twists, twists of the loops below, a yarn (``words.py``).
"""

from __future__ import annotations

from stitchmesh.errors import PatternError
from stitchmesh.patterns.language.tokens import END, Token
from stitchmesh.patterns.language.word_stitches import WordStitches, cable
from stitchmesh.patterns.language.words import WordError, read_word
from stitchmesh.patterns.pattern import Loop, check_cables

BAR = "|"
DEEPEST = 32
"""How deep groups may stand in one another."""
LONGEST = 100_000
"""How many stitches a row may have."""


class Items:
    """Reads tokens from one place on; what it gives is in the order of reading."""

    def __init__(self, tokens: list[Token], yarn: int, *, leftwards: bool) -> None:
        """Start at the first token.

        Args:
            tokens: a line's tokens, its end included.
            yarn: the yarn of words that name none.
            leftwards: whether words follow one another from right to left, as they are worked; a chart's do not.
        """
        self.tokens = tokens
        self.yarn = yarn
        self.leftwards = leftwards
        self.next = 0
        self.crossing = False

    @property
    def token(self) -> Token:
        """The token that comes."""
        return self.tokens[self.next]

    def take(self) -> Token:
        """Step over one token."""
        self.next += 1
        return self.tokens[self.next - 1]

    def expect(self, text: str, expected: str) -> Token:
        """Step over a token that must be there.

        Raises:
            PatternError: it is another one.
        """
        if self.token.text.lower() != text:
            raise self.token.unexpected(expected)
        return self.take()

    def row(self) -> tuple[list[WordStitches], list[int]]:
        """All items up to the end of the line.

        Returns:
            The pieces and, for each bar, how many pieces stand before it; both left to right as the reader faces them.

        Raises:
            PatternError: a word means nothing, a bracket or a bar is alone, or there is no stitch at all.
        """
        first = self.token
        pieces: list[WordStitches] = []
        bars: list[tuple[int, Token]] = []
        while self.token.text != END:
            if self.token.text == BAR:
                bars.append((len(pieces), self.take()))
            else:
                pieces += self.item(0)
            _check_length(pieces, first)
        if not any(piece.cells for piece in pieces):
            raise first.unexpected("stitches, such as k2 p2")
        if len(bars) not in (0, 2):
            raise bars[-1][1].unexpected("no bars, or two around the stitches that repeat")
        places = [place for place, _ in bars]
        if self.leftwards:
            return pieces[::-1], [len(pieces) - place for place in places[::-1]]
        return pieces, places

    def item(self, depth: int) -> list[WordStitches]:
        """One item, or none where a comma stands."""
        token = self.token
        if token.text == ",":
            self.take()
            return []
        if token.text == "[":
            pieces = self.group(depth)
        elif token.text.lower() == "cross":
            pieces = [self.cross(depth)]
        else:
            pieces = self.word()
        if self.token.text != "*":
            return pieces
        self.take()
        times = self.number("how many times", LONGEST, least=1)
        _check_length(pieces, token, times)
        return pieces * times

    def group(self, depth: int) -> list[WordStitches]:
        """Items in brackets."""
        opening = self.take()
        if depth == DEEPEST:
            raise opening.unexpected(f"brackets no more than {DEEPEST} deep")
        pieces: list[WordStitches] = []
        while self.token.text != "]":
            if self.token.text == END:
                raise opening.place.error("got '[' without its partner; expected ']' on the same row")
            pieces += self.item(depth + 1)
            _check_length(pieces, opening)
        self.take()
        return pieces

    def word(self) -> list[WordStitches]:
        """A stitch, a cable, or several."""
        token = self.take()
        if token.text in ("]", ")", "(", ":", ";", "*", BAR, END) or token.text.startswith('"'):
            raise token.unexpected("a stitch, '[' or cross(...)")
        try:
            return read_word(token.text, self.yarn)
        except WordError as error:
            raise token.place.error(str(error)) from None

    def cross(self, depth: int) -> WordStitches:
        """A crossing of any kind: places, layers, and what is worked on the reordered loops."""
        opening = self.take()
        if self.crossing:
            raise opening.place.error("got a crossing within a crossing; cables must not overlap")
        self.expect("(", "'(' after cross")
        target = self.numbers(";")
        layers = self.numbers(":")
        self.crossing = True
        pieces: list[WordStitches] = []
        while self.token.text != ")":
            if self.token.text == END:
                raise opening.place.error("got cross( without its partner; expected ')' on the same row")
            pieces += self.item(depth + 1)
        self.crossing = False
        self.take()
        return self._crossing(opening, target, layers, pieces)

    def numbers(self, end: str) -> list[int]:
        """Numbers up to a sign, which is stepped over."""
        found = []
        while self.token.text != end:
            found.append(self.number(f"places or layers counted from 0, and {end!r} after them", LONGEST))
        self.take()
        return found

    def number(self, what: str, most: int, least: int = 0) -> int:
        """A number in figures.

        Raises:
            PatternError: something else stands there, or it is too small or too large.
        """
        token = self.take()
        if not (token.text.isascii() and token.text.isdigit() and len(token.text) < 10):
            raise token.unexpected(what)
        if not least <= int(token.text) <= most:
            raise token.unexpected(f"{what}, {least} to {most}")
        return int(token.text)

    def _crossing(
        self, opening: Token, target: list[int], layers: list[int], pieces: list[WordStitches]
    ) -> WordStitches:
        ordered = pieces[::-1] if self.leftwards else pieces
        cells = tuple(cell for piece in ordered for cell in piece.cells)
        below = [loop for piece in ordered for loop in piece.loops]
        if any(loop.shift for loop in below):
            raise opening.place.error("got a cable within a crossing; cables must not overlap")
        if any(piece.tuck for piece in pieces):
            raise opening.place.error("got a tuck within a crossing; expected it before or after")
        if not len(target) == len(layers) == len(below):
            found = f"{len(target)} places, {len(layers)} layers and stitches on {len(below)} loops"
            raise opening.place.error(f"got {found}; expected as many of each")
        last = len(target) - 1
        if self.leftwards:
            target, layers = [last - end for end in reversed(target)], layers[::-1]
        try:
            check_cables([Loop(end - place, layers[place]) for place, end in enumerate(target)], [0, len(target), 0])
        except PatternError as error:
            raise opening.place.error(str(error).replace(" of the tile", " from the left")) from None
        return cable(cells, target, layers, [loop.twist for loop in below])


def _check_length(pieces: list[WordStitches], token: Token, times: int = 1) -> None:
    if times * sum(max(len(piece.cells), 1) for piece in pieces) > LONGEST:
        raise token.place.error(f"got more than {LONGEST} stitches in a row; expected fewer")
