# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The items of one written row: words, groups, crossings and bars, read by recursive descent.

    items = { item | "|" | "," }
    item  = ( word | group | cross ) [ "*" number ]
    group = "[" { item | "," } "]"
    cross = "cross" "(" numbers ";" numbers ":" { item | "," } ")"

A word may carry marks: twists of its loops, twists of the loops below, and a yarn (``words.py``). The stitches of one
word are called a piece (``WordStitches``).
"""

from __future__ import annotations

from stitchmesh.errors import PatternError
from stitchmesh.patterns.language.tokens import END, Token
from stitchmesh.patterns.language.words import NO_WORDS, OwnWords, WordError, WordStitches, cable, read_word
from stitchmesh.patterns.pattern import Loop, check_cables

BAR = "|"
MAX_DEPTH = 32
"""Maximum depth of nested groups."""
MAX_STITCHES = 100_000
"""Maximum number of stitches in a row."""


class ItemParser:
    """Parser of the items of one row. Each method starts at the next token and moves past the tokens it reads."""

    def __init__(self, tokens: list[Token], yarn: int, *, leftwards: bool, own: OwnWords = NO_WORDS) -> None:
        """Start at the first token.

        Args:
            tokens: the tokens of a line, including the token that marks its end.
            yarn: the yarn of words that name no yarn.
            leftwards: whether the words run from right to left, in the order of working, as in rows; charts run the
                other way.
            own: stitches of the user's own by their codes.
        """
        self.tokens = tokens
        self.yarn = yarn
        self.leftwards = leftwards
        self.own = own
        self.next = 0
        self.crossing = False

    @property
    def token(self) -> Token:
        """The next token."""
        return self.tokens[self.next]

    def take(self) -> Token:
        """Move past the next token and return that token."""
        self.next += 1
        return self.tokens[self.next - 1]

    def expect(self, text: str, expected: str) -> Token:
        """Move past a token that must have a given text, and return that token.

        Args:
            text: the required text, in lower case.
            expected: the description of the token in the error message.

        Raises:
            PatternError: the next token has another text.
        """
        if self.token.text.lower() != text:
            raise self.token.unexpected(expected)
        return self.take()

    def parse_row(self) -> tuple[list[WordStitches], list[int]]:
        """Read all items up to the end of the line.

        Returns:
            The pieces and, for each bar, the number of pieces before that bar; both from left to right as the reader
            faces the fabric.

        Raises:
            PatternError: a word is unknown, a bracket or bar has no partner, or the row has no stitches.
        """
        first = self.token
        pieces: list[WordStitches] = []
        bars: list[tuple[int, Token]] = []
        length = 0
        while self.token.text != END:
            if self.token.text == BAR:
                bars.append((len(pieces), self.take()))
                continue
            item = self.parse_item(0)
            pieces += item
            length += _length(item)
            _check_length(length, first)
        if not any(piece.cells for piece in pieces):
            raise first.unexpected("stitches, such as k2 p2")
        if len(bars) not in (0, 2):
            raise bars[-1][1].unexpected("no bars, or two around the stitches that repeat")
        places = [place for place, _ in bars]
        if self.leftwards:
            return pieces[::-1], [len(pieces) - place for place in places[::-1]]
        return pieces, places

    def parse_item(self, depth: int) -> list[WordStitches]:
        """Read one item; a comma gives no pieces."""
        token = self.token
        if token.text == ",":
            self.take()
            return []
        if token.text == "[":
            pieces = self.parse_group(depth)
        elif token.text.lower() == "cross":
            pieces = [self.parse_cross(depth)]
        else:
            pieces = self.parse_word()
        if self.token.text != "*":
            return pieces
        self.take()
        times = self.parse_number("the number of repeats", MAX_STITCHES, least=1)
        _check_length(times * _length(pieces), token)
        return pieces * times

    def parse_group(self, depth: int) -> list[WordStitches]:
        """Read the items of a group in brackets."""
        opening = self.take()
        if depth == MAX_DEPTH:
            raise opening.unexpected(f"at most {MAX_DEPTH} nested brackets")
        pieces: list[WordStitches] = []
        length = 0
        while self.token.text != "]":
            if self.token.text == END:
                raise opening.place.error("got '[' without its partner; expected ']' on the same row")
            item = self.parse_item(depth + 1)
            pieces += item
            length += _length(item)
            _check_length(length, opening)
        self.take()
        return pieces

    def parse_word(self) -> list[WordStitches]:
        """Read a word: a stitch, a cable, or several equal ones."""
        token = self.take()
        if token.text in ("]", ")", "(", ":", ";", "*", BAR, END) or token.text.startswith('"'):
            raise token.unexpected("a stitch, '[' or cross(...)")
        try:
            return read_word(token.text, self.yarn, self.own)
        except WordError as error:
            raise token.place.error(str(error)) from None

    def parse_cross(self, depth: int) -> WordStitches:
        """Read a crossing of any kind: target places, layers, and the stitches worked on the reordered loops."""
        opening = self.take()
        if self.crossing:
            raise opening.place.error("got a crossing within a crossing; cables must not overlap")
        self.expect("(", "'(' after cross")
        target = self.parse_numbers(";")
        layers = self.parse_numbers(":")
        self.crossing = True
        pieces: list[WordStitches] = []
        while self.token.text != ")":
            if self.token.text == END:
                raise opening.place.error("got cross( without its partner; expected ')' on the same row")
            pieces += self.parse_item(depth + 1)
        self.crossing = False
        self.take()
        return self._crossing(opening, target, layers, pieces)

    def parse_numbers(self, end: str) -> list[int]:
        """Read numbers up to a closing sign, and move past the sign."""
        found = []
        while self.token.text != end:
            found.append(self.parse_number(f"places or layers counted from 0, and {end!r} after them", MAX_STITCHES))
        self.take()
        return found

    def parse_number(self, description: str, most: int, least: int = 0) -> int:
        """Read a number written in digits.

        Args:
            description: the name of the number in the error message.
            most: the largest number allowed.
            least: the smallest number allowed.

        Raises:
            PatternError: the next token is no number, or the number is too small or too large.
        """
        token = self.take()
        if not (token.text.isascii() and token.text.isdigit() and len(token.text) < 10):
            raise token.unexpected(description)
        if not least <= int(token.text) <= most:
            raise token.unexpected(f"{description}, {least} to {most}")
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
            raise opening.place.error(f"got {found}; expected equal numbers of places, layers and loops")
        last = len(target) - 1
        if self.leftwards:
            target, layers = [last - end for end in reversed(target)], layers[::-1]
        try:
            check_cables([Loop(end - place, layers[place]) for place, end in enumerate(target)], [0, len(target), 0])
        except PatternError as error:
            raise opening.place.error(str(error).replace(" of the tile", " from the left")) from None
        return cable(cells, target, layers, [loop.twist for loop in below])


def _length(pieces: list[WordStitches]) -> int:
    """Return the number of stitches of pieces; a piece without stitches counts as one."""
    return sum(max(len(piece.cells), 1) for piece in pieces)


def _check_length(length: int, token: Token) -> None:
    if length > MAX_STITCHES:
        raise token.place.error(f"got more than {MAX_STITCHES} stitches in a row; expected fewer")
