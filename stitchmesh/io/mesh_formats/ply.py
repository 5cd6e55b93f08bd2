# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Polygon File Format (PLY) meshes, ASCII and binary of either byte order.

The header names elements, each with a count and its properties; a property is a number or a list with its own
count. Read here: x, y, z of ``vertex`` and the list ``vertex_indices`` or ``vertex_index`` of ``face``. All else is
passed over. meshio waits for ever at a header that was cut short, and knows only one of the two names.
"""

from __future__ import annotations

import struct
from dataclasses import dataclass, field
from os import fspath
from typing import Protocol

import numpy as np

from stitchmesh.errors import FileError
from stitchmesh.io.atomic import write_bytes
from stitchmesh.io.contents import FilePath, read_bytes
from stitchmesh.mesh import FloatArray

NUMBERS = {
    "char": "i1", "int8": "i1", "uchar": "u1", "uint8": "u1", "short": "i2", "int16": "i2", "ushort": "u2",
    "uint16": "u2", "int": "i4", "int32": "i4", "uint": "u4", "uint32": "u4", "float": "f4", "float32": "f4",
    "double": "f8", "float64": "f8",
}  # fmt: skip
"""NumPy's name of each type of number."""
BYTE_ORDERS = {"binary_little_endian": "<", "binary_big_endian": ">"}
CORNER_LISTS = ("vertex_indices", "vertex_index")


@dataclass(frozen=True)
class _Property:
    name: str
    number: str
    """NumPy's name of the type of number."""
    count: str = ""
    """The same for the count of a list, empty where the property is one number."""


@dataclass
class _Element:
    name: str
    count: int
    properties: list[_Property] = field(default_factory=list)


class _Body(Protocol):
    def take(self, number: str, count: int) -> list[float]:
        """The next numbers, or fewer where the file ends."""

    def left(self) -> int:
        """How many numbers there can be at most in what is left."""


class _AsciiBody:
    def __init__(self, content: bytes) -> None:
        self.words = content.split()
        self.at = 0

    def take(self, number: str, count: int) -> list[float]:
        words = self.words[self.at : self.at + count]
        self.at += count
        return [float(word) if number[0] == "f" else int(word) for word in words]

    def left(self) -> int:
        return len(self.words) - self.at


class _BinaryBody:
    def __init__(self, content: bytes, order: str) -> None:
        self.content = content
        self.order = order
        self.at = 0

    def take(self, number: str, count: int) -> list[float]:
        size = int(number[1]) * count
        part = self.content[self.at : self.at + size]
        self.at += size
        return np.frombuffer(part, self.order + number).tolist() if len(part) == size else []

    def left(self) -> int:
        return len(self.content) - self.at


def read_ply_polygons(path: FilePath) -> tuple[FloatArray, list[list[int]]]:
    """Vertices as written and faces as 0-based vertex numbers.

    Raises:
        FileError: the file is missing, a folder, unreadable, empty, cut short or malformed, a coordinate is not
            finite, or there are no faces.
    """
    name = fspath(path)
    content = read_bytes(path)
    order, elements, start = _header(name, content)
    body = _BinaryBody(content[start:], order) if order else _AsciiBody(content[start:])
    vertices, faces = np.zeros((0, 3)), []
    for element in elements:
        if element.count > body.left():
            raise _cut_short(name, element, 0)
        rows = [_row(name, body, element, index) for index in range(element.count)]
        if element.name == "vertex":
            vertices = _positions(name, element, rows)
        elif element.name == "face":
            faces = [_corners(name, element, index, row) for index, row in enumerate(rows)]
    if not len(vertices) or not faces:
        raise FileError(f"{name}: got {len(vertices)} vertices and {len(faces)} faces; expected a polygon mesh")
    bad = [index for index, face in enumerate(faces) if not 0 <= min(face) <= max(face) < len(vertices)]
    if bad:
        found = f"face {bad[0]} has the vertices {faces[bad[0]][:6]}"
        raise FileError(f"{name}: {found}; expected numbers from 0 to {len(vertices) - 1}")
    return vertices, faces


def write_ply_polygons(path: FilePath, vertices: FloatArray, faces: list[list[int]]) -> None:
    """Write the polygons in binary, coordinates in full.

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


def _header(name: str, content: bytes) -> tuple[str, list[_Element], int]:
    """Byte order (empty for ASCII), the elements, and where the body starts."""
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
    if words[0] == "list":
        return _Property(words[3], NUMBERS[words[2]], NUMBERS[words[1]])
    return _Property(words[1], NUMBERS[words[0]])


def _row(name: str, body: _Body, element: _Element, index: int) -> list[list[float]]:
    """The values of each property of one vertex, face or other thing."""
    row = []
    try:
        for part in element.properties:
            count = int(body.take(part.count, 1)[0]) if part.count else 1
            values = body.take(part.number, count) if 0 <= count <= body.left() else []
            if len(values) != count:
                raise _cut_short(name, element, index)
            row.append(values)
    except IndexError as error:
        raise _cut_short(name, element, index) from error
    except ValueError as error:
        raise FileError(f"{name}: {element.name} {index}: {error}; expected numbers") from error
    return row


def _positions(name: str, element: _Element, rows: list[list[list[float]]]) -> FloatArray:
    names = [part.name for part in element.properties]
    if not {"x", "y", "z"} <= set(names):
        raise FileError(f"{name}: vertices have the properties {' '.join(names)}; expected x, y and z")
    columns = [names.index(axis) for axis in "xyz"]
    positions = np.array([[row[column][0] for column in columns] for row in rows], dtype=np.float64).reshape(-1, 3)
    bad = np.flatnonzero(~np.isfinite(positions).all(axis=1))
    if len(bad):
        raise FileError(f"{name}: vertex {bad[0]} is {positions[bad[0]].tolist()}; coordinates must be finite")
    return positions


def _corners(name: str, element: _Element, index: int, row: list[list[float]]) -> list[int]:
    lists = [values for part, values in zip(element.properties, row, strict=True) if part.name in CORNER_LISTS]
    if not lists:
        raise FileError(f"{name}: faces have no list {' or '.join(CORNER_LISTS)}; expected one")
    if len(lists[0]) < 3:
        raise FileError(f"{name}: face {index} has {len(lists[0])} corners; expected at least 3")
    return [int(vertex) for vertex in lists[0]]


def _cut_short(name: str, element: _Element, index: int) -> FileError:
    return FileError(f"{name}: ends within {element.name} {index} of {element.count}; the file was cut short")
