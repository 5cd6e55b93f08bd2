# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Counts of stitches along single edges, and marked edges, as text: in a file or as words of a command line.

An edge is written as its two vertices, counted from 0 in the order of the file of the mesh: ``4,7``. A count is
``4,7=12``. A file has one of these on each line; a line without a count marks its edge, and ``#`` begins a comment.

    # the hem
    0,1=24
    1,2=24
    # all decreases of the row stand here
    5,9
"""

from __future__ import annotations

import re
from collections.abc import Iterable
from dataclasses import dataclass, field
from os import PathLike, fspath

from stitchmesh.errors import FileError, ParameterError
from stitchmesh.io.contents import read_lines
from stitchmesh.tessellate.counts import EdgeName

VertexPair = tuple[int, int]
"""An edge, named by its two vertices."""
WORD = re.compile(r"\s*([0-9]{1,18})\s*,\s*([0-9]{1,18})\s*(?:=\s*(-?[0-9]{1,18})\s*)?")
COUNT_FORM = "V,W=COUNT with two vertices and a whole number, for example 4,7=12"


@dataclass(frozen=True)
class EdgeSettings:
    """Counts of stitches along single edges, and marked edges."""

    counts: dict[EdgeName, int] = field(default_factory=dict)
    """Number of stitches along each named edge."""
    marked: tuple[VertexPair, ...] = ()
    """Wale edges at which all increases and decreases of their panels stand."""

    def joined(self, other: EdgeSettings) -> EdgeSettings:
        """Return both settings together.

        Raises:
            ParameterError: two counts for one edge differ.
        """
        counts = dict(self.counts)
        for edge, count in other.counts.items():
            _set_count(counts, edge, count)
        return EdgeSettings(counts, tuple(dict.fromkeys((*self.marked, *other.marked))))


def parse_edge(word: str) -> VertexPair:
    """Parse an edge as a user writes it: ``4,7``.

    Raises:
        ParameterError: the word has another form.
    """
    found = WORD.fullmatch(word)
    if not found or found[3] is not None:
        raise ParameterError(f"edge {word!r}: expected the two vertices of an edge, for example 4,7")
    return int(found[1]), int(found[2])


def parse_edge_counts(words: Iterable[str]) -> EdgeSettings:
    """Parse counts as a user writes them: ``4,7=12``.

    Raises:
        ParameterError: a word has another form, or two counts for one edge differ.
    """
    counts: dict[EdgeName, int] = {}
    for word in words:
        found = WORD.fullmatch(word)
        if not found or found[3] is None:
            raise ParameterError(f"count {word!r}: expected {COUNT_FORM}")
        _set_count(counts, (int(found[1]), int(found[2])), int(found[3]))
    return EdgeSettings(counts)


def read_edge_settings(path: str | PathLike[str]) -> EdgeSettings:
    """Read counts and marked edges from a text file.

    Raises:
        FileError: the file cannot be read, or a line has another form; the message names the line.
        ParameterError: two counts for one edge differ.
    """
    return parse_edge_settings(read_lines(path), fspath(path))


def parse_edge_settings(lines: Iterable[str], name: str) -> EdgeSettings:
    """Parse counts and marked edges, one in each line.

    Args:
        lines: the lines.
        name: name of the source of the lines, for messages.

    Raises:
        FileError: a line has another form; the message names the line.
        ParameterError: two counts for one edge differ.
    """
    settings = EdgeSettings()
    for number, line in enumerate(lines, start=1):
        text = line.split("#", 1)[0].strip()
        if not text:
            continue
        found = WORD.fullmatch(text)
        if not found:
            expected = f"an edge V,W that is marked, or {COUNT_FORM}"
            raise FileError(f"{name}:{number}: got {text[:40]!r}; expected {expected}")
        edge = int(found[1]), int(found[2])
        line_setting = EdgeSettings(marked=(edge,)) if found[3] is None else EdgeSettings({edge: int(found[3])})
        settings = settings.joined(line_setting)
    return settings


def edge_settings_text(settings: EdgeSettings) -> str:
    """Return the lines of some settings; ``parse_edge_settings`` reads them.

    Raises:
        ParameterError: an edge is named by the number of a side.
    """
    lines = []
    for edge, count in settings.counts.items():
        if not isinstance(edge, tuple):
            raise ParameterError(f"count of side {edge}: expected an edge, named by its two vertices")
        lines.append(f"{edge[0]},{edge[1]}={count}\n")
    return "".join(lines) + "".join(f"{first},{second}\n" for first, second in settings.marked)


def _set_count(counts: dict[EdgeName, int], edge: EdgeName, count: int) -> None:
    """Add the count of an edge, which may be named from either end."""
    turned = edge[::-1] if isinstance(edge, tuple) else edge
    known = edge if edge in counts else turned
    if counts.get(known, count) != count:
        found = f"got {count} after {counts[known]}"
        raise ParameterError(f"count of edge {edge}: {found}; expected one count")
    counts[known if known in counts else edge] = count
