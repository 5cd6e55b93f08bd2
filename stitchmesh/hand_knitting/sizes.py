# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""One text of instructions for several sizes of a garment, and the text of one size out of it.

    Sizes: S (M, L).
    Cast on 76 (84, 92) sts in yarn C; join in the round.
    Round 1 in yarn C: [k2, p2] 19 (21, 23) times.
    Sizes M (L) only: Round 31 (33) in yarn A: k5 (6), k2tog, k12.

Lines of two sizes are the same line if only their numbers differ. Each number that differs is written once for each
size, in the order of the sizes. A line that some sizes do not have, or have in other words, begins with the names of
its sizes, and has one number for each of these. The lines of the sizes are aligned in order, piece by piece, so that as
many lines as possible are common, the long ones first.
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence

from stitchmesh.errors import ParameterError, PatternError
from stitchmesh.hand_knitting.text import COUNTING, knitting_instructions
from stitchmesh.mesh import StitchMesh

MOST_SIZES = 30
"""Largest number of sizes of one text."""
_NAME = re.compile(r"[\w+](?:[\w+ -]{0,38}[\w+])?")
_NUMBER = re.compile(r"\b(k|p|co|dt|bo)?(\d+(?:\.\d+)?)\b")
_NUMBERS = re.compile(r"\b((?:k|p|co|dt|bo)?)(\d+(?:\.\d+)?) \((\d+(?:\.\d+)?(?:, \d+(?:\.\d+)?)*)\)")
_SIZES = re.compile(r"Sizes: ([^()]+?)(?: \(([^()]+)\))?\.")
_ONLY = re.compile(r"Sizes? ([^():]+?)(?: \(([^():]+)\))? only: (.*)")
_ONE_REPEATED = re.compile(r"(Row|Round) (\d+): as ")

_Lines = list[str | None]
"""The line of each size; None for a size that does not have it."""


def check_size_name(name: str) -> str:
    """Return the name of a size.

    Raises:
        ParameterError: the name is empty, longer than 40 characters, or has a character that could separate sizes in a
            text, or folders in a path.
    """
    if not _NAME.fullmatch(name):
        raise ParameterError(
            f"size {name[:60]!r}: expected 1 to 40 letters, digits, +, - and single spaces between them, such as M"
        )
    return name


def graded_instructions(fabrics: Mapping[str, StitchMesh], facts: Sequence[str] = ()) -> str:
    """Write the hand-knitting instructions of several sizes of a garment as one text.

    ``parse_instructions(text, size=name)`` gives ``written_pieces(fabrics[name])``.

    Args:
        fabrics: the stitch mesh of each size, by the name of the size.
        facts: lines that stand below the names of the sizes, such as finished measures.

    Raises:
        ParameterError: there is no size, there are more than ``MOST_SIZES``, a name is not possible, or as for
            ``knitting_instructions``.
        LabelError: as for ``knitting_instructions``.
    """
    names = [check_size_name(name) for name in fabrics]
    if not 1 <= len(names) <= MOST_SIZES:
        raise ParameterError(f"sizes: got {len(names)}; expected 1 to {MOST_SIZES}")
    texts = [knitting_instructions(fabric, charts=False) for fabric in fabrics.values()]
    heads = [text.partition("\nPiece ")[0].splitlines() for text in texts]
    sections = [_sections(text) for text in texts]
    body: list[str] = []
    for header in sorted({header for one in sections for header in one}, key=_order):
        body.append("")
        for lines in _aligned([[header, *one[header]] if header in one else [] for one in sections]):
            body += _written(lines, names)
    words = dict.fromkeys(line for head in heads for line in head if line.startswith("  "))
    first = _written([head[0] for head in heads], names)
    one_number = ["Where one number is given, it holds for all sizes."] if len(names) > 1 else []
    top = [first[0], f"Sizes: {_listed(names)}.", *one_number, *facts, COUNTING]
    return "\n".join([*top, "", "Words", *sorted(words), *body]) + "\n"


def names_of_sizes(text: str) -> tuple[str, ...]:
    """Return the names of the sizes of a text, in order; none if the text is of one garment without a size."""
    head = text.partition("\nPiece ")[0].splitlines()
    match = next(filter(None, map(_SIZES.fullmatch, head)), None)
    return () if match is None else _names(match[1], match[2])


def instructions_of_size(text: str, size: str, name: str = "instructions") -> str:
    """Return the instructions of one size; the lines keep their numbers, and lines of other sizes are empty.

    Args:
        text: a text of ``graded_instructions``.
        size: name of the size.
        name: name of the text in messages.

    Raises:
        PatternError: the text has no such size, or a line names sizes that the text does not have.
    """
    names = names_of_sizes(text)
    if size not in names:
        known = f"expected one of {', '.join(names)}" if names else "the text is of one size only; leave the size out"
        raise PatternError(f"{name}: got the size {size[:40]!r}; {known}")
    lines = []
    for number, line in enumerate(text.splitlines(), start=1):
        own, sizes = line, names
        if match := _ONLY.fullmatch(line):
            own, sizes = match[3], _names(match[1], match[2])
            if not set(sizes) <= set(names):
                given = ", ".join(sizes)[:60]
                raise PatternError(f"{name}: line {number}: got sizes {given}; expected some of {', '.join(names)}")
        lines.append(_of_one(own, sizes.index(size), len(sizes)) if size in sizes else "")
    return "\n".join(lines) + "\n"


def graded_numbers(values: Sequence[object]) -> str:
    """Write one value for each size: ``80 (88, 96)``; a value that all sizes share is written once."""
    texts = [str(value) for value in values]
    return texts[0] if len(set(texts)) == 1 else _listed(texts)


def _listed(texts: Sequence[str]) -> str:
    first, *others = texts
    return f"{first} ({', '.join(others)})" if others else first


def _names(first: str, others: str | None) -> tuple[str, ...]:
    return first, *(others.split(", ") if others else ())


def _sections(text: str) -> dict[str, list[str]]:
    """Return the lines of each piece, and of the finishing, by their first lines."""
    found: dict[str, list[str]] = {}
    header = ""
    for line in text.splitlines():
        if line.startswith("Piece ") or line == "To finish:":
            header = line
            found[header] = []
        elif header and line:
            found[header].append(line)
    return found


def _order(header: str) -> tuple[bool, int, str]:
    number = _NUMBER.search(header)
    return header == "To finish:", int(number[2]) if number else 0, header


def _aligned(sizes: Sequence[list[str]]) -> list[_Lines]:
    """Align the lines of one section; one size after the other is joined to the sizes before."""
    made: list[_Lines] = [[line] for line in sizes[0]]
    for count, lines in enumerate(sizes[1:], start=1):
        pairs = _matched([_shape(next(filter(None, one))) for one in made], [_shape(line) for line in lines])
        made = [
            [*(made[one] if one is not None else [None] * count), lines[other] if other is not None else None]
            for one, other in pairs
        ]
    return made


def _shape(line: str) -> str:
    """Return what two lines that differ in numbers only have in common."""
    return _NUMBER.sub(r"\1#", _ONE_REPEATED.sub(r"\1s \2 to \2: as ", line))


def _matched(one: list[str], other: list[str]) -> list[tuple[int | None, int | None]]:
    """Return the pairs of an alignment in order, by the sequence of equal shapes with the largest weight.

    A long line weighs more than a short one, and of two equal lines the one at the more similar place more.
    """
    rows, columns = len(one), len(other)
    best = [[0.0] * (columns + 1) for _ in range(rows + 1)]
    for row in range(rows - 1, -1, -1):
        for column in range(columns - 1, -1, -1):
            skipped = max(best[row + 1][column], best[row][column + 1])
            if one[row] == other[column]:
                apart = abs(row / rows - column / columns)
                weight = 1.0 + 0.02 * min(len(one[row]), 100) + 0.5 * (1.0 - apart)
                skipped = max(skipped, weight + best[row + 1][column + 1])
            best[row][column] = skipped
    pairs: list[tuple[int | None, int | None]] = []
    row = column = 0
    while row < rows or column < columns:
        if row < rows and best[row][column] == best[row + 1][column]:
            pairs.append((row, None))
            row += 1
        elif column < columns and best[row][column] == best[row][column + 1]:
            pairs.append((None, column))
            column += 1
        else:
            pairs.append((row, column))
            row, column = row + 1, column + 1
    return pairs


def _written(lines: _Lines, names: Sequence[str]) -> list[str]:
    """Return the lines of some sizes as one line, after the names of the sizes if others do not have it."""
    own = [line for line in lines if line is not None]
    if len(set(own)) > 1:
        own = [_ONE_REPEATED.sub(r"\1s \2 to \2: as ", line) for line in own]
    merged = _merged(own)
    if len(own) == len(names):
        return [merged]
    sizes = [name for name, line in zip(names, lines, strict=True) if line is not None]
    return [f"Size{'s' if len(sizes) > 1 else ''} {_listed(sizes)} only: {merged}"]


def _merged(lines: Sequence[str]) -> str:
    """Return lines that differ in numbers only as one line."""
    numbers = zip(*([match[2] for match in _NUMBER.finditer(line)] for line in lines), strict=True)
    written = map(graded_numbers, numbers)
    return _NUMBER.sub(lambda match: (match[1] or "") + next(written), lines[0])


def _of_one(line: str, place: int, count: int) -> str:
    """Return a line with the numbers of one of its sizes."""

    def chosen(match: re.Match[str]) -> str:
        values = [match[2], *match[3].split(", ")]
        return match[1] + values[place] if len(values) == count else match[0]

    return _NUMBERS.sub(chosen, line)
