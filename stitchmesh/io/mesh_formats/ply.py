# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Polygon File Format (PLY) meshes, ASCII and binary of either byte order.

The header names elements, each with a count and its properties. A property is a number, or a list of numbers with its
length. The reader uses the properties x, y and z of ``vertex`` and the list ``vertex_indices`` or ``vertex_index`` of
``face`` or of ``tristrips``, whose strips end at -1, and leaves out all other properties and elements. In a text,
additional numbers at the end of a row are ignored, and a row may continue in the next line. This module exists because
meshio does not terminate for a header that was cut short, and knows only one of the two names of the list.
"""

from __future__ import annotations

import struct
from collections import Counter
from dataclasses import dataclass, field
from os import fspath
from typing import Protocol

import numpy as np

from stitchmesh.errors import FileError
from stitchmesh.io.atomic import write_bytes
from stitchmesh.io.contents import FilePath, check_points, read_bytes, say_left_out
from stitchmesh.io.mesh_formats.cells import strip_triangles
from stitchmesh.mesh import FloatArray

NUMBERS = {
    "char": "i1", "int8": "i1", "uchar": "u1", "uint8": "u1", "short": "i2", "int16": "i2", "ushort": "u2",
    "uint16": "u2", "int": "i4", "int32": "i4", "uint": "u4", "uint32": "u4", "float": "f4", "float32": "f4",
    "double": "f8", "float64": "f8",
}  # fmt: skip
"""NumPy's name of each type of number."""
BYTE_ORDERS = {"binary_little_endian": "<", "binary_big_endian": ">"}
"""NumPy's character of each byte order."""
CORNER_LISTS = ("vertex_indices", "vertex_index")
"""Names of the property that holds the vertices of a face."""


@dataclass(frozen=True)
class _Property:
    """A property of the header."""

    name: str
    number: str
    """NumPy's name of the type of the number, or of the numbers of a list."""
    count: str = ""
    """NumPy's name of the type of a list's length; empty if the property is one number."""


@dataclass
class _Element:
    """An element of the header, for example all vertices."""

    name: str
    count: int
    properties: list[_Property] = field(default_factory=list)


class _Body(Protocol):
    """The part of a file after the header, which is read from start to end."""

    def begin_row(self) -> None:
        """Begin a vertex, a face or another element."""

    def end_row(self, element: str) -> None:
        """End the element."""

    def read_numbers(self, number: str, count: int) -> list[float]:
        """Return the next numbers of a type, or fewer if the file ends before them."""

    def remaining(self) -> int:
        """Return an upper bound of how many numbers of the file, or of the row, have not been read."""

    def rows_left(self) -> int:
        """Return an upper bound of the number of rows that have not been read."""


class _Lines:
    """The numbers of an ASCII file with a line for each row."""

    def __init__(self, content: bytes) -> None:
        self.lines = [line for line in map(bytes.split, content.splitlines()) if line]
        self.row = -1
        self.position = 0
        self.beyond: Counter[str] = Counter()
        """Number of rows of each element that have more numbers than the header says."""

    def begin_row(self) -> None:
        self.row += 1
        self.position = 0

    def end_row(self, element: str) -> None:
        if self.remaining() > 0:
            self.beyond[element] += 1

    def read_numbers(self, number: str, count: int) -> list[float]:
        words = self.lines[self.row][self.position : self.position + count]
        self.position += count
        return [float(word) if number[0] == "f" else int(word) for word in words]

    def remaining(self) -> int:
        return len(self.lines[self.row]) - self.position

    def rows_left(self) -> int:
        return len(self.lines) - self.row - 1


class _Words:
    """The numbers of an ASCII file whose rows are not lines."""

    def __init__(self, content: bytes) -> None:
        self.words = content.split()
        self.position = 0

    def begin_row(self) -> None:
        """Nothing divides rows."""

    def end_row(self, element: str) -> None:
        """A row has no numbers beyond those of the header."""

    def read_numbers(self, number: str, count: int) -> list[float]:
        words = self.words[self.position : self.position + count]
        self.position += count
        return [float(word) if number[0] == "f" else int(word) for word in words]

    def remaining(self) -> int:
        return len(self.words) - self.position

    rows_left = remaining


class _BinaryBody:
    """The numbers of a binary file."""

    def __init__(self, content: bytes, order: str) -> None:
        self.content = content
        self.order = order
        self.position = 0

    def begin_row(self) -> None:
        """Nothing divides rows."""

    def end_row(self, element: str) -> None:
        """A row has no numbers beyond those of the header."""

    def read_numbers(self, number: str, count: int) -> list[float]:
        size = int(number[1]) * count
        part = self.content[self.position : self.position + size]
        self.position += size
        return np.frombuffer(part, self.order + number).tolist() if len(part) == size else []

    def remaining(self) -> int:
        return len(self.content) - self.position

    rows_left = remaining


def read_ply_polygons(path: FilePath, fewest_corners: int = 3) -> tuple[FloatArray, list[list[int]]]:
    """Read polygons.

    Args:
        path: a ``.ply`` file.
        fewest_corners: smallest number of corners of a face; below 3 for files that will be repaired.

    Returns:
        Positions of the vertices in the file's unit, shape (V, 3), and the vertices of each face, counted from 0.

    Raises:
        FileError: the file is missing, a folder, unreadable, empty, cut short or malformed, a coordinate is not
            finite, or there are no faces.
    """
    name = fspath(path)
    content = read_bytes(path)
    order, elements, start = _header(name, content)
    if order:
        vertices, faces = _polygons(name, _BinaryBody(content[start:], order), elements, fewest_corners)
    else:
        lines = _Lines(content[start:])
        try:
            vertices, faces = _polygons(name, lines, elements, fewest_corners)
            say_left_out(path, lines.beyond, "numbers behind those that the header names, in rows")
        except FileError as by_line:
            try:
                vertices, faces = _polygons(name, _Words(content[start:]), elements, fewest_corners)
            except FileError:
                if len(lines.lines) == sum(element.count for element in elements):
                    raise by_line from None
                raise
    others = [one for one in elements if one.name not in ("vertex", "face", "tristrips") and one.count]
    say_left_out(path, {one.name: one.count for one in others}, "elements")
    if not len(vertices) or not faces:
        raise FileError(f"{name}: got {len(vertices)} vertices and {len(faces)} faces; expected a polygon mesh")
    bad = [index for index, face in enumerate(faces) if not 0 <= min(face) <= max(face) < len(vertices)]
    if bad:
        found = f"face {bad[0]} has the vertices {faces[bad[0]][:6]}"
        raise FileError(f"{name}: {found}; expected numbers from 0 to {len(vertices) - 1}")
    return vertices, faces


def write_ply_polygons(path: FilePath, vertices: FloatArray, faces: list[list[int]]) -> None:
    """Write polygons in the binary variant; coordinates are stored as float64, without loss.

    Args:
        path: a ``.ply`` file.
        vertices: positions in the file's unit, shape (V, 3).
        faces: vertices of each face, counted from 0.

    Raises:
        FileError: the file cannot be written.
    """
    count = ("uchar", "B") if max(map(len, faces)) < 256 else ("int", "i")
    head = (
        f"ply\nformat binary_little_endian 1.0\ncomment StitchMesh\nelement vertex {len(vertices)}\n"
        "property double x\nproperty double y\nproperty double z\n"
        f"element face {len(faces)}\nproperty list {count[0]} int vertex_indices\nend_header\n"
    )
    corners = b"".join(struct.pack(f"<{count[1]}{len(face)}i", len(face), *face) for face in faces)
    write_bytes(path, head.encode("ascii") + vertices.astype("<f8").tobytes() + corners)


def _polygons(
    name: str, body: _Body, elements: list[_Element], fewest_corners: int
) -> tuple[FloatArray, list[list[int]]]:
    """Return the positions of the vertices, shape (V, 3), and the vertices of each face."""
    vertices, faces = np.zeros((0, 3)), []
    for element in elements:
        if element.count > body.rows_left():
            raise _cut_short(name, element, 0)
        rows = [_row(name, body, element, index) for index in range(element.count)]
        if element.name == "vertex":
            vertices = _positions(name, element, rows)
        elif element.name == "face":
            faces += [_corners(name, element, index, row, fewest_corners) for index, row in enumerate(rows)]
        elif element.name == "tristrips":
            strips = [np.array(_corners(name, element, index, row, 0)) for index, row in enumerate(rows)]
            parts = [part[part >= 0] for strip in strips for part in np.split(strip, np.flatnonzero(strip == -1))]
            faces += [triangle for part in parts for triangle in strip_triangles(part).tolist()]
    return vertices, faces


def _header(name: str, content: bytes) -> tuple[str, list[_Element], int]:
    """Return the byte order (empty for ASCII), the elements, and the offset of the body [bytes]."""
    head, end, rest = content.partition(b"end_header")
    if content[:3] != b"ply" or not end:
        raise FileError(f"{name}: has no complete PLY header; expected 'ply' to 'end_header'")
    order: str | None = None
    elements: list[_Element] = []
    for number, line in enumerate(head.decode("latin-1").splitlines()[1:], start=2):
        words = line.split()
        try:
            if words[:1] == ["format"]:
                order = "" if words[1] == "ascii" else BYTE_ORDERS[words[1]]
            elif words[:1] == ["element"]:
                elements.append(_Element(words[1], int(words[2])))
            elif words[:1] == ["property"]:
                elements[-1].properties.append(_property(words[1:]))
        except (KeyError, IndexError, ValueError) as error:
            raise FileError(f"{name}: line {number}: got {line[:40]!r}; expected a line of a PLY header") from error
    if order is None:
        raise FileError(f"{name}: the header has no format line; expected ascii or {' or '.join(BYTE_ORDERS)}")
    line_end = rest.find(b"\n") + 1
    return order, elements, len(head) + len(end) + line_end


def _property(words: list[str]) -> _Property:
    """Return the property of a header line: ``TYPE NAME``, or ``list LENGTH_TYPE TYPE NAME``."""
    if words[0] == "list":
        return _Property(words[3], NUMBERS[words[2]], NUMBERS[words[1]])
    return _Property(words[1], NUMBERS[words[0]])


def _row(name: str, body: _Body, element: _Element, index: int) -> list[list[float]]:
    """Return the values of each property of one vertex, face or other element."""
    row = []
    body.begin_row()
    try:
        for part in element.properties:
            count = int(body.read_numbers(part.count, 1)[0]) if part.count else 1
            values = body.read_numbers(part.number, count) if 0 <= count <= body.remaining() else []
            if len(values) != count:
                raise _cut_short(name, element, index)
            row.append(values)
    except IndexError as error:
        raise _cut_short(name, element, index) from error
    except ValueError as error:
        raise FileError(f"{name}: {element.name} {index}: {error}; expected numbers") from error
    body.end_row(element.name)
    return row


def _positions(name: str, element: _Element, rows: list[list[list[float]]]) -> FloatArray:
    names = [part.name for part in element.properties]
    if not {"x", "y", "z"} <= set(names):
        raise FileError(f"{name}: vertices have the properties {' '.join(names)}; expected x, y and z")
    columns = [names.index(axis) for axis in "xyz"]
    positions = np.array([[row[column][0] for column in columns] for row in rows], dtype=np.float64).reshape(-1, 3)
    check_points(f"{name}: vertex", positions)
    return positions


def _corners(name: str, element: _Element, index: int, row: list[list[float]], fewest_corners: int) -> list[int]:
    lists = [values for part, values in zip(element.properties, row, strict=True) if part.name in CORNER_LISTS]
    if not lists:
        raise FileError(f"{name}: faces have no list {' or '.join(CORNER_LISTS)}; expected one")
    if len(lists[0]) < fewest_corners:
        raise FileError(f"{name}: face {index} has {len(lists[0])} corners; expected at least {fewest_corners}")
    return [int(vertex) for vertex in lists[0]]


def _cut_short(name: str, element: _Element, index: int) -> FileError:
    return FileError(f"{name}: ends within {element.name} {index} of {element.count}; the file was cut short")
