# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""VTK's legacy format (``.vtk``): poly data in text and binary. meshio reads the other kinds of data.

Three lines are followed by the kind of data, and by blocks that begin with a word and their sizes. Until version 5.0 a
list of cells holds the number of points of each cell, followed by the points; since 5.1 it is an array of offsets and
an array of points. Binary numbers have the highest byte first. Arrays behind ``POINT_DATA`` and ``CELL_DATA`` are not
read. Sizes are compared with the content before they are used.
"""

from __future__ import annotations

import re
from itertools import islice
from os import fspath

import numpy as np
from numpy.typing import NDArray

from stitchmesh.errors import FileError
from stitchmesh.io.contents import FilePath, check_points, read_bytes, say_left_out
from stitchmesh.io.float32 import from_float32
from stitchmesh.io.mesh_formats.by_meshio import read_meshio_polygons
from stitchmesh.io.mesh_formats.cells import strip_triangles
from stitchmesh.mesh import FloatArray

HEAD = re.compile(
    rb"# vtk DataFile Version\s+(\d+\.\d+)[^\n]*\n[^\n]*\n\s*(ASCII|BINARY)\s+DATASET\s+POLYDATA\b", re.IGNORECASE
)
"""The beginning of a file of poly data."""
NUMBERS = {
    "char": "i1", "unsigned_char": "u1", "short": "i2", "unsigned_short": "u2", "int": "i4", "unsigned_int": "u4",
    "long": "i8", "unsigned_long": "u8", "float": "f4", "double": "f8", "vtkidtype": "i4", "vtktypeint32": "i4",
    "vtktypeint64": "i8",
}  # fmt: skip
"""NumPy's name of each type of number."""
CELLS = (b"VERTICES", b"LINES", b"POLYGONS", b"TRIANGLE_STRIPS")
"""Words before lists of cells."""
WITH_OFFSETS = 5.1
"""First version in which lists of cells have offsets."""
WORD, LINE = re.compile(rb"\S+"), re.compile(rb"[^\n]*\n?")


def read_vtk_polygons(path: FilePath) -> tuple[FloatArray, list[list[int]]]:
    """Read polygons and the triangles of strips; files of other data than poly data are read by meshio.

    Returns:
        Vertices in the file's unit, shape (V, 3), and the vertices of each face, counted from 0.

    Raises:
        FileError: the file cannot be read, is malformed, cut short or has no faces.
    """
    content = read_bytes(path)
    head = HEAD.match(content)
    return read_meshio_polygons(path) if head is None else _poly_data(fspath(path), content, head)


def _poly_data(name: str, content: bytes, head: re.Match[bytes]) -> tuple[FloatArray, list[list[int]]]:
    """Return the vertices and the faces of poly data."""
    blocks = _Blocks(content, head)
    try:
        blocks.read()
    except (ValueError, LookupError, OverflowError) as error:
        reason = " ".join(str(error).split())[:100]
        raise FileError(f"{name}: is not a valid VTK file; it was cut short or altered ({reason})") from error
    strips = [triangle for strip in blocks.cells[b"TRIANGLE_STRIPS"] for triangle in strip_triangles(strip).tolist()]
    faces = [face.tolist() for face in blocks.cells[b"POLYGONS"]] + strips
    if not faces:
        raise FileError(f"{name}: has no faces; expected a polygon mesh")
    bad = [face for face in faces if len(face) < 3 or not 0 <= min(face) <= max(face) < len(blocks.points)]
    if bad:
        found = f"a face names the points {bad[0][:6]}"
        raise FileError(f"{name}: {found}; expected three or more from 0 to {len(blocks.points) - 1}")
    check_points(f"{name}: point", blocks.points)
    others = {word.decode().lower(): len(blocks.cells[word]) for word in CELLS[:2] if blocks.cells[word]}
    say_left_out(name, others, "cells")
    return blocks.points, faces


class _Blocks:
    """The blocks of a file, which are read from start to end."""

    def __init__(self, content: bytes, head: re.Match[bytes]) -> None:
        self.content, self.place = content, head.end()
        self.version, self.binary = float(head[1]), head[2].upper() == b"BINARY"
        self.points = np.zeros((0, 3))
        self.cells: dict[bytes, list[NDArray]] = {word: [] for word in CELLS}

    def read(self) -> None:
        """Read the points and the cells; data at points and cells end the geometry."""
        while words := self._words_of_line():
            word = words[0].upper()
            if word in (b"POINT_DATA", b"CELL_DATA"):
                return
            if word == b"POINTS":
                self.points = from_float32(self._numbers(words[2], 3 * int(words[1]))).reshape(-1, 3)
            elif word in CELLS:
                self.cells[word] = self._lists(int(words[1]), int(words[2]))
            elif word == b"FIELD":
                for _ in range(int(words[2])):
                    _, columns, rows, kind = self._words_of_line()
                    self._numbers(kind, int(columns) * int(rows))
            elif word == b"METADATA":
                while self._line().strip():
                    pass
            else:
                raise ValueError(f"got the word {word[:20].decode('latin-1')}")

    def _lists(self, first: int, second: int) -> list[NDArray]:
        """Return the points of each cell of a list; its line states the two sizes."""
        if self.version >= WITH_OFFSETS:
            offsets, points = (self._numbers(self._words_of_line()[1], size) for size in (first, second))
            if (np.diff(offsets) < 0).any() or (len(offsets) and (offsets[0] != 0 or offsets[-1] != len(points))):
                raise ValueError(f"the offsets of {max(first - 1, 0)} cells do not fit {len(points)} points")
            return np.split(points, offsets[1:-1]) if first > 1 else []
        numbers, cells, place = self._numbers(b"int", second), [], 0
        for _ in range(first):
            size = int(numbers[place])
            cells.append(numbers[place + 1 : place + 1 + size])
            if size < 0 or len(cells[-1]) != size:
                raise ValueError(f"a cell states {size} points")
            place += 1 + size
        return cells

    def _numbers(self, kind: bytes, count: int) -> NDArray:
        """Return the next numbers of a type, shape (count,)."""
        number = np.dtype(">" + NUMBERS[kind.decode("latin-1").lower()])
        size = number.itemsize if self.binary else 1
        if not 0 <= count * size <= len(self.content) - self.place:
            raise ValueError(f"it states {count} numbers, and {len(self.content) - self.place} bytes follow")
        if self.binary:
            start, self.place = self.place, self.place + count * size
            return np.frombuffer(self.content, number, count, start).astype(number.newbyteorder("="))
        words = list(islice(WORD.finditer(self.content, self.place), count))
        if len(words) < count:
            raise ValueError(f"it ends within {count} numbers")
        self.place = words[-1].end() if words else self.place
        read = float if number.kind == "f" else int
        with np.errstate(over="ignore"):  # A number that is too large for float32 becomes infinite.
            return np.array([read(word[0]) for word in words], dtype=number.newbyteorder("="))

    def _words_of_line(self) -> list[bytes]:
        """Return the words of the next line that has any; none at the end."""
        while self.place < len(self.content):
            if words := self._line().split():
                return words
        return []

    def _line(self) -> bytes:
        found = LINE.match(self.content, self.place)
        line = found[0] if found else b""
        self.place += len(line)
        return line
