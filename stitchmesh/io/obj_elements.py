# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The elements of a Wavefront OBJ file: lines of fields, vertex positions and references to vertices."""

from __future__ import annotations

import math
import re
from collections.abc import Iterable, Iterator

from stitchmesh.errors import FileError

CORNER = re.compile(r"(-?[0-9]+)(/-?[0-9]*){0,2}")


def element_lines(lines: Iterable[str]) -> Iterator[tuple[int, list[str]]]:
    """Line number and fields of each element; continued lines joined, comments and blank lines left out."""
    pending: list[str] = []
    first = 0
    for number, line in enumerate(lines, start=1):
        text = line.partition("#")[0].rstrip()
        first = first if pending else number
        if text.endswith("\\"):
            pending += [*text[:-1].split(), ""]  # a mark that a line is pending, even where it was blank
            continue
        fields = [*filter(None, pending), *text.split()]
        pending = []
        if fields:
            yield first, fields
    if any(pending):
        yield first, [*filter(None, pending)]


def vertex_position(path: str, number: int, fields: list[str]) -> tuple[float, float, float]:
    """Position in the fields of a ``v`` line.

    Raises:
        FileError: there are not three finite numbers.
    """
    try:
        x, y, z = (float(text) for text in fields[1:4])
    except ValueError as error:
        found = " ".join(fields)[:40]
        raise FileError(f"{path}: line {number}: got {found!r}; expected 'v x y z' with three numbers") from error
    if not (math.isfinite(x) and math.isfinite(y) and math.isfinite(z)):
        found = " ".join(fields)[:40]
        raise FileError(f"{path}: line {number}: got {found!r}; coordinates must be finite: repair what wrote the file")
    return x, y, z


def vertex_index(path: str, number: int, corner: str, vertex_count: int) -> int:
    """The 0-based vertex of a corner such as ``7``, ``7/1``, ``7//2`` or ``-1``.

    Raises:
        FileError: the corner is malformed or points before the first vertex.
    """
    match = CORNER.fullmatch(corner)
    if match is None:
        where = f"{path}: line {number}"
        raise FileError(f"{where}: got corner {corner[:20]!r}; expected v, v/vt, v//vn or v/vt/vn with whole numbers")
    index = int(match[1])
    if index == 0:
        raise FileError(f"{path}: line {number}: vertex 0 does not exist; OBJ counts from 1")
    if index < 0 and -index > vertex_count:
        where = f"{path}: line {number}: vertex {index} does not exist"
        raise FileError(f"{where}; only {vertex_count} vertices come before this line")
    return index - 1 if index > 0 else vertex_count + index
