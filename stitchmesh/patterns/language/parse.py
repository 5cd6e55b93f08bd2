# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The statements of the text language of patterns. ``docs/patterns.md`` gives the whole grammar.

    text  = { "pattern" string | "source" string | "colours" string } ( { row } | chart )
    row   = ( ( "row" | "rows" ) ranges ( "RS" | "WS" ) | ( "round" | "rounds" ) ranges ) [ "yarn" number ] ":" items
          | ( "row" | "rows" | "round" | "rounds" ) ranges ":" "repeat" ranges
    range = number [ "-" number ]

A comma may separate any two items. A comma at the end of a line continues the row on the next line.
"""

from __future__ import annotations

import re
from collections.abc import Iterable
from dataclasses import dataclass, replace

from stitchmesh.errors import ParameterError, PatternError, check_kind, first_few
from stitchmesh.mesh.own_stitch import OwnStitch
from stitchmesh.mesh.palette import make_palette
from stitchmesh.patterns.language.items import ItemParser
from stitchmesh.patterns.language.rows import DescribedRow, finish_rows
from stitchmesh.patterns.language.text_charts import read_chart
from stitchmesh.patterns.language.tokens import END, Line, TextPlace, Token, split_lines
from stitchmesh.patterns.language.words import NO_WORDS, OwnWords, own_words
from stitchmesh.patterns.pattern import Pattern

ROW_WORDS = ("row", "rows", "round", "rounds")
STATEMENTS = "pattern, source, colours, row, rows, round, rounds or chart"
CHART_KINDS = ("letters", "leaf", "colours")
MAX_ROWS = 10_000
_FIRST_WORD = re.compile(rf"(pattern|source|colours|chart|{'|'.join(ROW_WORDS)})(?![a-z0-9])", re.ASCII)
_RANGE = re.compile(r"(\d{1,6})(?:-(\d{1,6}))?", re.ASCII)


def parse_pattern(text: str, name: str = "pattern", stitches: Iterable[OwnStitch] = ()) -> Pattern:
    """Read a pattern from its text.

    Args:
        text: a text in the language of ``docs/patterns.md``.
        name: the name of the text in messages, and the name of the pattern if the text gives none.
        stitches: stitches of your own, whose codes the text may use as words.

    Raises:
        PatternError: the text does not describe a valid pattern; the message gives the line, the column, what was found
            and what was expected.
        ParameterError: the code of a stitch is a word of the language, or two stitches have one code.
    """
    check_kind("parse_pattern", text, str, "pathlib.Path(file).read_text()")
    return _PatternParser(split_lines(text, name), name, own_words(stitches)).parse()


@dataclass(frozen=True)
class WrittenPattern:
    """The words of a pattern in its text, before its rows are checked against one another."""

    name: str
    source: str
    palette: tuple[tuple[int, int, int], ...]
    rows: tuple[DescribedRow, ...]
    """The rows from the bottom up, with their places in the text."""


def parse_written(text: str, name: str = "pattern") -> WrittenPattern:
    """Read the words of a pattern from its text, whether or not its rows fit together.

    Args:
        text: a text in the language of ``docs/patterns.md``.
        name: the name of the text in messages, and the name of the pattern if the text gives none.

    Raises:
        PatternError: a statement cannot be read; the message gives the line and the column.
    """
    return _PatternParser(split_lines(text, name), name).parse_written()


def begins_with_statement(text: str) -> bool:
    """Whether the first word of a text begins a statement of the language."""
    words = (word for line in split_lines(text, "") for word in line.text.split())
    return _FIRST_WORD.match(next(words, "").lower()) is not None


class _PatternParser:
    """Parser of the statements of a text, one after another."""

    def __init__(self, lines: list[Line], name: str, own: OwnWords = NO_WORDS) -> None:
        self.lines, self.own = lines, own
        self.names = {"pattern": name, "source": ""}
        self.palette: tuple[tuple[int, int, int], ...] = ()
        self.file = name
        self.rows: dict[int, DescribedRow] = {}
        self.chart: list[DescribedRow] = []
        self.next = 0

    def parse(self) -> Pattern:
        """Read all statements and return the pattern."""
        written = self.parse_written()
        rows = finish_rows(written.rows)
        try:
            return Pattern(written.name, written.source, rows, written.palette)
        except PatternError as error:
            raise TextPlace(self.file, 1, 1).error(str(error)) from None

    def parse_written(self) -> WrittenPattern:
        """Read all statements."""
        while self.next < len(self.lines):
            line = self.lines[self.next]
            self.next += 1
            if line.text and not line.text.isspace():
                self._statement(line)
        rows = tuple(self.chart or self._in_order())
        return WrittenPattern(self.names["pattern"], self.names["source"], self.palette, rows)

    def _statement(self, line: Line) -> None:
        tokens = line.tokens()
        word = tokens[0].text.lower()
        if word in self.names:
            self.names[word] = quoted_text(tokens)
        elif word == "colours":
            self.palette = quoted_palette(tokens)
        elif word in ROW_WORDS:
            self._require_only_body(self.chart, tokens[0])
            self._row(tokens)
        elif word == "chart":
            self._require_only_body(self.chart or self.rows, tokens[0])
            self._read_chart(tokens)
        else:
            raise tokens[0].unexpected(STATEMENTS)

    def _require_only_body(self, other: object, token: Token) -> None:
        if other:
            raise token.unexpected("nothing more: a pattern consists either of rows or of one chart")

    def _row(self, tokens: list[Token]) -> None:
        while tokens[-2].text == "," and self.next < len(self.lines):  # a final comma continues on the next line
            tokens = tokens[:-1] + self.lines[self.next].tokens()
            self.next += 1
        items = ItemParser(tokens, 0, leftwards=True, own=self.own)
        word = items.take()
        numbers = self._unused_numbers(items)
        side = _side(items, word)
        items.yarn = _yarn(items)
        colon = items.expect(":", "':'")
        if items.token.text.lower() == "repeat":
            if side:
                raise items.token.unexpected("stitches; a repeat copies whole rows, so leave RS and WS out")
            self._repeat(items, numbers, word.place)
            return
        if not side and word.text.lower().startswith("row"):
            raise colon.unexpected("RS or WS before it (or round instead of row)")
        pieces, bars = items.parse_row()
        row = DescribedRow(tuple(pieces), tuple(bars), word.place)
        if side == "ws":
            _check_turns(row)
        for number in numbers:
            self.rows[number] = row.turned() if side == "ws" else row

    def _unused_numbers(self, items: ItemParser) -> list[int]:
        place = items.token.place
        numbers = _ranges(items, "the number of a row, or a range such as 3-4")
        seen = set(self.rows)
        for number in numbers:
            if number in seen:
                raise place.error(f"got row {number} a second time; expected each row once")
            seen.add(number)
        return numbers

    def _repeat(self, items: ItemParser, numbers: list[int], place: TextPlace) -> None:
        items.take()
        sources = items.token.place
        copied = _ranges(items, "the rows to repeat, such as 1-2")
        if items.token.text != END:
            raise items.token.unexpected(END)
        missing = [number for number in copied if number not in self.rows]
        if missing:
            raise sources.error(f"got row {missing[0]} to repeat; expected rows that are written above")
        if len(numbers) % len(copied):
            found = f"got {len(copied)} rows to repeat for {len(numbers)}"
            raise sources.error(f"{found}; expected a whole number of repeats")
        for index, number in enumerate(numbers):
            self.rows[number] = replace(self.rows[copied[index % len(copied)]], place=place)

    def _read_chart(self, tokens: list[Token]) -> None:
        items = ItemParser(tokens, 0, leftwards=False)
        items.take()
        kind = items.take().text.lower() if items.token.text.lower() in CHART_KINDS else "words"
        upwards = items.token.text.lower() == "upwards" and bool(items.take())
        yarn = _yarn(items)
        items.expect(":", f"{', '.join(CHART_KINDS)}, upwards, yarn or ':'")
        if items.token.text != END:
            raise items.token.unexpected("the chart on the lines below")
        lines = self._block()
        if not lines:
            raise tokens[0].place.error("got a chart without lines; expected one line for each row, directly below it")
        self.chart = read_chart(kind, lines, yarn, upwards=upwards, own=self.own)

    def _block(self) -> list[Line]:
        start = self.next
        while self.next < len(self.lines) and self.lines[self.next].text.strip():
            self.next += 1
        return self.lines[start : self.next]

    def _in_order(self) -> list[DescribedRow]:
        if not self.rows:
            end = self.lines[-1].place if self.lines else TextPlace(self.file, 1, 1)
            raise end.error("got the end of a pattern without rows; expected row 1 RS: and stitches, or a chart")
        missing = [number for number in range(1, max(self.rows) + 1) if number not in self.rows]
        if missing:
            last = max(self.rows)
            found = f"got row {last}, but not row {first_few(missing)}"
            raise self.rows[last].place.error(f"{found}; expected all rows from 1")
        return [self.rows[number] for number in sorted(self.rows)]


def _check_turns(row: DescribedRow) -> None:
    """Check that a row on the wrong side holds no stitch of the user's own, which is drawn from the right side."""
    cells = [cell for piece in row.pieces for cell in piece.cells if isinstance(cell.stitch, OwnStitch)]
    if cells:
        found = f"got {cells[0].stitch.name} in a row on the wrong side"
        raise row.place.error(f"{found}; it is drawn as seen from the right side: write the row as RS, or as a round")


def quoted_text(tokens: list[Token]) -> str:
    """Return the quoted text of a statement that has one word before it.

    Raises:
        PatternError: the text is missing, or more follows it.
    """
    if not tokens[1].text.startswith('"'):
        example = "cream, navy" if tokens[0].text.lower() == "colours" else "Seed stitch"
        raise tokens[1].unexpected(f'a text in quotes, such as {tokens[0].text} "{example}"')
    if tokens[2].text != END:
        raise tokens[2].unexpected(END)
    return tokens[1].text[1:-1]


def quoted_palette(tokens: list[Token]) -> tuple[tuple[int, int, int], ...]:
    """Return the colours of the yarns from a quoted list, such as ``colours "cream, navy, #aa2233"``.

    Raises:
        PatternError: the list has no quotes, or a text is no colour.
    """
    try:
        colours = make_palette(quoted_text(tokens).split(","))
    except ParameterError as error:
        raise tokens[1].place.error(str(error)) from None
    return tuple((int(red), int(green), int(blue)) for red, green, blue in colours)


def _side(items: ItemParser, word: Token) -> str | None:
    side = items.token.text.lower()
    if side not in ("rs", "ws"):
        return None
    if word.text.lower().startswith("round"):
        raise items.token.unexpected("':'; a round has the right side facing")
    items.take()
    return side


def _yarn(items: ItemParser) -> int:
    if items.token.text.lower() != "yarn":
        return 0
    items.take()
    return items.parse_number("the number of a yarn", 999_999)


def _ranges(items: ItemParser, expected: str) -> list[int]:
    numbers: list[int] = []
    while True:
        token = items.token
        match = _RANGE.fullmatch(token.text)
        if not match:
            if numbers:
                return numbers
            raise token.unexpected(expected)
        items.take()
        first, last = int(match[1]), int(match[2] or match[1])
        if not 1 <= min(first, last) <= max(first, last) <= MAX_ROWS:
            raise token.unexpected(f"rows numbered 1 to {MAX_ROWS}")
        numbers += range(first, last + 1) if first <= last else range(first, last - 1, -1)
        if items.token.text == ",":
            items.take()
