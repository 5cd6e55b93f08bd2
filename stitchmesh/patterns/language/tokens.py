# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Pattern text as lines of tokens; each token knows its place in the text."""

from __future__ import annotations

import re
from dataclasses import dataclass

from stitchmesh.errors import PatternError

_TOKEN = re.compile(r'\s+|"[^"]*"|[][|():;*,]|[^][|():;*,"\s]+')
_COMMENT = re.compile(r'^((?:[^"#]|"[^"]*")*)#.*$')
END = "the end of the line"


@dataclass(frozen=True)
class TextPlace:
    """A place in a text: the file, and the line and column counted from 1."""

    file: str
    line: int
    column: int

    def error(self, message: str) -> PatternError:
        """Return an error whose message begins with this place."""
        text = f"{self.file}: line {self.line}, column {self.column}: {message}"
        return PatternError(text, line=self.line, column=self.column)


@dataclass(frozen=True)
class Token:
    """A word, a quoted string or a sign."""

    text: str
    place: TextPlace

    def unexpected(self, expected: str) -> PatternError:
        """Return an error that says that this token stands where another was expected."""
        found = END if self.text == END else repr(self.text)
        return self.place.error(f"got {found}; expected {expected}")


@dataclass(frozen=True)
class Line:
    """A line of text without its comment."""

    text: str
    place: TextPlace
    """Place of the first character of the line."""

    def tokens(self) -> list[Token]:
        """Split the line into tokens; the last token marks the end of the line.

        Raises:
            PatternError: a quoted string has no closing quote.
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

    def at(self, column: int) -> TextPlace:
        """Return the place of a character of the line; ``column`` is counted from 0."""
        return TextPlace(self.place.file, self.place.line, column + 1)


def split_lines(text: str, file: str) -> list[Line]:
    """Split a text into lines without their comments; blank lines are kept."""
    lines = []
    for number, line in enumerate(text.splitlines(), start=1):
        comment = _COMMENT.match(line)
        lines.append(Line((comment[1] if comment else line).rstrip(), TextPlace(file, number, 1)))
    return lines
