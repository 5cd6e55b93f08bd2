# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Pattern text as lines of tokens, each with its place."""

from __future__ import annotations

import re
from dataclasses import dataclass

from stitchmesh.errors import PatternError

_TOKEN = re.compile(r'\s+|"[^"]*"|[][|():;*,]|[^][|():;*,"\s]+')
_COMMENT = re.compile(r'^((?:[^"#]|"[^"]*")*)#.*$')
END = "the end of the line"


@dataclass(frozen=True)
class Place:
    """Where in a text something stands, counted from 1."""

    file: str
    line: int
    column: int

    def error(self, message: str) -> PatternError:
        """The message with this place before it."""
        return PatternError(f"{self.file}: line {self.line}, column {self.column}: {message}")


@dataclass(frozen=True)
class Token:
    """A word, a quoted string or a sign."""

    text: str
    place: Place

    def unexpected(self, expected: str) -> PatternError:
        """That this token is not what had to come."""
        found = END if self.text == END else repr(self.text)
        return self.place.error(f"got {found}; expected {expected}")


@dataclass(frozen=True)
class Line:
    """A line of text without its comment."""

    text: str
    place: Place
    """Its first column."""

    def tokens(self) -> list[Token]:
        """Its tokens, and one for its end.

        Raises:
            PatternError: a quoted string has no end.
        """
        found, column = [], 0
        while column < len(self.text):
            match = _TOKEN.match(self.text, column)
            if not match:
                raise self.at(column).error('got a quote without its partner; expected another " on the same line')
            if not match[0].isspace():
                found.append(Token(match[0], self.at(column)))
            column = match.end()
        return [*found, Token(END, self.at(len(self.text)))]

    def at(self, column: int) -> Place:
        """The place of one of its characters, counted from 0."""
        return Place(self.place.file, self.place.line, column + 1)


def split_lines(text: str, file: str) -> list[Line]:
    """The lines of a text, comments cut off, blank ones included."""
    lines = []
    for number, line in enumerate(text.splitlines(), start=1):
        comment = _COMMENT.match(line)
        lines.append(Line((comment[1] if comment else line).rstrip(), Place(file, number, 1)))
    return lines
