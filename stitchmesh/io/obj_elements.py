# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The elements of a Wavefront OBJ file that polygon meshes and polylines share: lines, vertices and vertex numbers."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator

from stitchmesh.errors import FileError
from stitchmesh.io.contents import is_coordinate

CORNER = re.compile(r"(-?[0-9]{1,18})(/-?[0-9]{0,18}){0,2}")


def element_lines(lines: Iterable[str]) -> Iterator[tuple[int, list[str]]]:
    """Yield the line number, from 1, and the fields of each element.

    A line that ends in a backslash is joined with the next line. Comments and blank lines are left out.
    """
    pending: list[str] = []
    first = 0
    for number, line in enumerate(lines, start=1):
        text = line.partition("#")[0].rstrip()
        first = first if pending else number
        if text.endswith("\\"):
            pending += [*text[:-1].split(), ""]  # The empty text keeps `pending` true if the line was blank.
            continue
        fields = [*filter(None, pending), *text.split()]
        pending = []
        if fields:
            yield first, fields
    if any(pending):
        yield first, [*filter(None, pending)]


def vertex_position(path: str, number: int, fields: list[str]) -> tuple[float, float, float]:
    """Return the position in the fields of a ``v`` line, in the file's unit.

    Raises:
        FileError: the fields are not three finite numbers; the message names the path and the line number.
    """
    try:
        x, y, z = (float(text) for text in fields[1:4])
    except ValueError as error:
        found = " ".join(fields)[:40]
        raise FileError(f"{path}: line {number}: got {found!r}; expected 'v x y z' with three numbers") from error
    if not (is_coordinate(x) and is_coordinate(y) and is_coordinate(z)):
        found = " ".join(fields)[:40]
        raise FileError(f"{path}: line {number}: got {found!r}; coordinates must be finite; write the file again")
    return x, y, z


def vertex_index(path: str, number: int, corner: str, vertex_count: int) -> int:
    """Return the vertex of a corner such as ``7``, ``7/1``, ``7//2`` or ``-1``, counted from 0.

    Args:
        path: the file, for the error message.
        number: line number, for the error message.
        corner: text of the corner; a negative number counts back from the last vertex before the line.
        vertex_count: number of vertices before the line.

    Raises:
        FileError: the corner is malformed, is 0, or lies before the first vertex.
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
