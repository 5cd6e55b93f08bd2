# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""VTK's XML formats of points with cells, poly data (``.vtp``) and unstructured grids (``.vtu``), read without VTK.

VTK's own reader ends the process at some damaged files, for example at a number of points that memory cannot hold. This
reader compares each size in the file with the content of the file before it uses the size.

The root element ``VTKFile`` has the attributes ``type``, ``byte_order``, ``header_type`` (of the sizes before binary
numbers) and ``compressor``. A ``Piece`` holds sections (``Points``, ``PointData``, ``Lines``, ``Polys``, ``Cells``) of
elements ``DataArray``, whose numbers are text, or binary in base 64, or binary in ``AppendedData`` behind all pieces.
Compressed numbers are preceded by the number of blocks, the size of a block, the size of the last block if it differs,
and the compressed size of each block.
"""

from __future__ import annotations

import base64
import lzma
import re
import zlib
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from os import fspath
from typing import Any
from xml.parsers import expat

import numpy as np
from numpy.typing import NDArray

from stitchmesh.errors import FileError
from stitchmesh.io.contents import FilePath, check_expansion, read_bytes
from stitchmesh.io.float32 import from_float32
from stitchmesh.mesh import FloatArray, IntArray

NUMBERS = {
    "Int8": "i1", "UInt8": "u1", "Int16": "i2", "UInt16": "u2", "Int32": "i4", "UInt32": "u4", "Int64": "i8",
    "UInt64": "u8", "Float32": "f4", "Float64": "f8",
}  # fmt: skip
"""NumPy's name of each type of number."""
HEADERS = {"UInt32": "u4", "UInt64": "u8"}
"""NumPy's name of each type of sizes."""
BYTE_ORDERS = {"LittleEndian": "<", "BigEndian": ">"}
"""NumPy's character of each byte order."""
COMPRESSORS = {"": "none", "vtkZLibDataCompressor": "zlib", "vtkLZMADataCompressor": "lzma"}
"""Compressions that can be read, by the attribute ``compressor``."""
DEEPEST = 20
"""Largest number of elements that lie within each other; the format needs five."""
DAMAGES = (ValueError, LookupError, OverflowError, zlib.error, lzma.LZMAError, expat.ExpatError)
"""Errors of damaged XML, texts in base 64, compressed blocks and numbers."""
APPENDED = re.compile(rb"<AppendedData([^>]*)>\s*_")
ENCODING = re.compile(rb"encoding\s*=\s*[\"'](\w+)[\"']")


@dataclass(frozen=True, eq=False)
class Cells:
    """Lists of points: polylines, polygons, or cells of several types."""

    start: IntArray
    """First element of ``point`` of each cell, and the number of elements, shape (C + 1,)."""
    point: IntArray
    """Points of all cells."""
    kind: IntArray
    """VTK's number of the type of each cell, shape (C,); empty if the section prescribes the type."""


@dataclass(frozen=True, eq=False)
class VtkPoints:
    """Points with cells and with numbers at the points; the pieces of the file are joined."""

    points: FloatArray
    """Positions in the file's unit, shape (P, 3)."""
    cells: Mapping[str, Cells]
    """Cells of each section: ``Lines`` and ``Polys`` of poly data, ``Cells`` of an unstructured grid."""
    at_points: Mapping[str, FloatArray]
    """Arrays of ``PointData`` by name, shape (P,) or (P, components)."""


@dataclass
class _Array:
    """An element ``DataArray``."""

    attributes: dict[str, str]
    text: list[str] = field(default_factory=list)


@dataclass
class _Piece:
    """An element ``Piece``."""

    attributes: dict[str, str]
    sections: dict[str, list[_Array]] = field(default_factory=dict)


@dataclass
class _Document:
    """The content of the XML of a file."""

    root: dict[str, str] = field(default_factory=dict)
    pieces: list[_Piece] = field(default_factory=list)
    path: list[str] = field(default_factory=list)
    """Names of the elements around the present place."""
    array: _Array | None = None
    """Array whose text is being read."""

    def begin(self, name: str, attributes: dict[str, str]) -> None:
        """Take the start of an element."""
        if len(self.path) == 0:
            self.root = {"": name, **attributes}
        elif name == "Piece":
            self.pieces.append(_Piece(attributes))
        elif name == "DataArray" and self.pieces and len(self.path) > 1:
            self.array = _Array(attributes)
            self.pieces[-1].sections.setdefault(self.path[-1], []).append(self.array)
        self.path.append(name)
        if len(self.path) > DEEPEST:
            raise ValueError(f"elements lie more than {DEEPEST} deep")

    def end(self, name: str) -> None:
        self.path.pop()
        if name == "DataArray":
            self.array = None

    def add_text(self, text: str) -> None:
        if self.array is not None and self.path[-1] == "DataArray":  # Elements within the array hold no numbers.
            self.array.text.append(text)

    def refuse_type(self, *declaration: Any) -> None:
        """Refuse a document type, whose entities could stand for very long texts or other files."""
        raise ValueError("it declares a document type")


def read_vtk_points(path: FilePath, kind: str, sections: Sequence[str]) -> VtkPoints:
    """Read points with cells.

    Args:
        path: the file.
        kind: attribute ``type`` that the root must have: ``PolyData`` or ``UnstructuredGrid``.
        sections: names of the sections of cells that are read.

    Raises:
        FileError: the file cannot be read, is malformed, cut short, of another type or compressed by LZ4, or cells
            name points that do not exist.
    """
    name, content = fspath(path), read_bytes(path)
    try:
        reader = _Reader(content, kind)
        pieces = [reader.piece(piece, sections) for piece in reader.document.pieces]
    except DAMAGES as error:
        reason = " ".join(str(error).split())[:100] or type(error).__name__
        suffix = {"PolyData": "VTP", "UnstructuredGrid": "VTU"}[kind]
        raise FileError(f"{name}: is not a valid {suffix} file; it was cut short or altered ({reason})") from error
    return _joined(pieces, sections)


class _Reader:
    """The content of a file; its XML has been read, its numbers have not."""

    def __init__(self, content: bytes, kind: str) -> None:
        self.content = content
        text, self.appended, self.appended_encoding = _split(content)
        self.document = _parse(text)
        root = self.document.root
        if root[""] != "VTKFile" or root.get("type") != kind:
            raise ValueError(f"the root is {root['']} of type {root.get('type', 'none')}, expected VTKFile of {kind}")
        order = BYTE_ORDERS[root.get("byte_order", "LittleEndian")]
        self.order, self.header = order, np.dtype(order + HEADERS[root.get("header_type", "UInt32")])
        compressor = root.get("compressor", "")
        if compressor not in COMPRESSORS:
            raise ValueError(f"it is compressed by {compressor[:40]}, expected {' or '.join(list(COMPRESSORS)[1:])}")
        self.compression = COMPRESSORS[compressor]
        self.expanded = 0

    def piece(self, piece: _Piece, sections: Sequence[str]) -> VtkPoints:
        """Return the content of a piece."""
        count = _count(piece, "NumberOfPoints")
        own = piece.sections.get("Points", [])
        points = from_float32(self.numbers(own[0])) if own else np.zeros((0, 3))
        points = points.reshape(-1, 3)
        if len(points) != count:
            raise ValueError(f"got {len(points)} points, expected {count}")
        at_points = {}
        for array in piece.sections.get("PointData", []):
            if array.attributes.get("type") in NUMBERS:
                label, values = array.attributes.get("Name", ""), from_float32(self.numbers(array))
                if len(values) != count:
                    raise ValueError(f"the array {label[:40]} has {len(values)} elements, expected {count}")
                at_points[label] = values
        cells = {section: self._cells(piece, section, count) for section in sections}
        return VtkPoints(points, cells, at_points)

    def _cells(self, piece: _Piece, section: str, point_count: int) -> Cells:
        arrays = {array.attributes.get("Name", ""): array for array in piece.sections.get(section, [])}
        count = _count(piece, f"NumberOf{section}")
        if count == 0:
            return Cells(np.zeros(1, dtype=np.int64), np.zeros(0, dtype=np.int64), np.zeros(0, dtype=np.int64))
        ends, point = (self.whole_numbers(arrays[label]) for label in ("offsets", "connectivity"))
        start = np.concatenate([[0], ends])
        if len(ends) != count or (np.diff(start) < 0).any() or start[-1] != len(point):
            raise ValueError(f"the offsets of {section} do not fit its {count} cells of {len(point)} points in total")
        unknown = point[(point < 0) | (point >= point_count)]
        if len(unknown):
            one = {"Lines": "a line", "Polys": "a face"}.get(section, "a cell")
            raise ValueError(f"{one} names point {unknown[0]}; the file has {point_count} points")
        kind = self.whole_numbers(arrays["types"]) if section == "Cells" else np.zeros(0, dtype=np.int64)
        if section == "Cells" and len(kind) != count:
            raise ValueError(f"got {len(kind)} types of {count} cells")
        return Cells(start, point, kind)

    def whole_numbers(self, array: _Array) -> IntArray:
        """Return the numbers of an array of whole numbers, shape (n,)."""
        values = self.numbers(array)
        if values.dtype.kind not in "iu" or values.ndim != 1:
            raise ValueError(f"{array.attributes.get('Name', '')[:40]} is no list of whole numbers")
        return values.astype(np.int64)

    def numbers(self, array: _Array) -> NDArray[Any]:
        """Return the numbers of an array, shape (n,), or (n, components) for more than one component."""
        kind = np.dtype(self.order + NUMBERS[array.attributes["type"]])
        components = int(array.attributes.get("NumberOfComponents", "1"))
        if not 1 <= components <= 100:
            raise ValueError(f"got {components} components, expected 1 to 100")
        values = self._flat(array, kind)
        return values if components == 1 else values.reshape(-1, components)

    def _flat(self, array: _Array, kind: np.dtype[Any]) -> NDArray[Any]:
        form, text = array.attributes.get("format", "ascii"), "".join(array.text)
        if form == "ascii":
            with np.errstate(over="ignore"):  # What is too large for float32 becomes infinite.
                return np.array([_number(word, kind.kind) for word in text.split()], dtype=kind)
        if form == "binary":
            raw = self._binary(base64_part("".join(text.split()).encode("ascii")), 0)
        elif form == "appended":
            offset = int(array.attributes["offset"])
            if not 0 <= offset < len(self.appended):
                raise ValueError(f"the offset {offset} lies outside of the appended data")
            is_raw = self.appended_encoding == b"raw"
            raw = self._binary(raw_part(self.appended) if is_raw else base64_part(self.appended), offset)
        else:
            raise ValueError(f"the format of an array is {form[:40]}, expected ascii, binary or appended")
        return np.frombuffer(raw, kind)

    def _binary(self, part: _Part, offset: int) -> bytes:
        """Return the uncompressed bytes of an array.

        Args:
            part: function that returns bytes of the content.
            offset: place of the sizes before the numbers.
        """
        size = self.header.itemsize
        first = int(np.frombuffer(part(offset, 0, size), self.header)[0])
        if self.compression == "none":
            return part(offset, size, size + first)
        if first == 0:
            return b""
        sizes = np.frombuffer(part(offset, 0, size * (3 + first)), self.header).astype(object)
        block, last, packed = int(sizes[1]), int(sizes[2]), [int(one) for one in sizes[3:]]
        self.expanded += block * (first - 1) + (last or block)
        check_expansion(self.expanded, len(self.content))
        body = part.behind(offset, size * (3 + first), sum(packed))
        blocks, place = [], 0
        for number, length in enumerate(packed):
            expected = last if number == first - 1 and last else block
            blocks.append(_unpacked(self.compression, body[place : place + length], expected))
            place += length
        return b"".join(blocks)


@dataclass(frozen=True)
class _Part:
    """Bytes of a content, by the place of a header in the content and places behind it."""

    content: bytes
    decode: Callable[[bytes], bytes] | None
    """Function that decodes a text; None if the content is the bytes."""

    def __call__(self, offset: int, start: int, end: int) -> bytes:
        """Return the bytes from ``start`` to ``end`` behind the place ``offset``."""
        if self.decode is None:
            found = self.content[offset + start : offset + end]
        else:
            found = self.decode(self.content[offset : offset + 4 * -(-end // 3)])[start:end]
        if len(found) != end - start:
            raise ValueError(f"got {len(found)} of {end - start} bytes of an array")
        return found

    def behind(self, offset: int, head: int, size: int) -> bytes:
        """Return ``size`` bytes behind a header of ``head`` bytes, which is encoded by itself."""
        return self(offset + (head if self.decode is None else 4 * -(-head // 3)), 0, size)


def raw_part(content: bytes) -> _Part:
    """Return the parts of a content that is not encoded."""
    return _Part(content, None)


def base64_part(content: bytes) -> _Part:
    """Return the parts of a content in base 64."""
    return _Part(content, lambda text: base64.b64decode(text, validate=True))


def _split(content: bytes) -> tuple[bytes, bytes, bytes]:
    """Return the XML of a file without appended data, the appended data and their encoding."""
    found = APPENDED.search(content)
    if not found:
        return content, b"", b""
    encoding = ENCODING.search(found[1])
    return content[: found.start()] + b"</VTKFile>", content[found.end() :], encoding[1] if encoding else b"base64"


def _parse(text: bytes) -> _Document:
    document = _Document()
    parser = expat.ParserCreate()
    parser.StartElementHandler, parser.EndElementHandler = document.begin, document.end
    parser.CharacterDataHandler, parser.StartDoctypeDeclHandler = document.add_text, document.refuse_type
    parser.Parse(text, True)
    return document


def _count(piece: _Piece, attribute: str) -> int:
    return int(piece.attributes.get(attribute, "0"))


def _number(word: str, kind: str) -> float:
    return float(word) if kind == "f" else int(word)


def _unpacked(compression: str, packed: bytes, size: int) -> bytes:
    """Return a block of a known uncompressed size [bytes]."""
    if compression == "zlib":
        found = zlib.decompressobj().decompress(packed, size) if size else b""
    else:
        found = lzma.LZMADecompressor().decompress(packed, size)
    if len(found) != size:
        raise ValueError(f"a compressed block has {len(found)} bytes, expected {size}")
    return found


def _joined(pieces: Sequence[VtkPoints], sections: Sequence[str]) -> VtkPoints:
    """Join the pieces of a file; arrays that a piece lacks are left out."""
    first = np.cumsum([0, *(len(piece.points) for piece in pieces)])
    shared = set.intersection(*(set(piece.at_points) for piece in pieces)) if pieces else set()
    shapes = {name: {piece.at_points[name].shape[1:] for piece in pieces} for name in shared}
    cells = {name: _joined_cells([piece.cells[name] for piece in pieces], first) for name in sections}
    at_points = {
        name: np.concatenate([piece.at_points[name] for piece in pieces])
        for name in sorted(shared) if len(shapes[name]) == 1
    }  # fmt: skip
    return VtkPoints(np.concatenate([np.zeros((0, 3)), *(piece.points for piece in pieces)]), cells, at_points)


def _joined_cells(cells: Sequence[Cells], first: IntArray) -> Cells:
    """Join cells; ``first`` is the first point of each piece."""
    none = [np.zeros(0, dtype=np.int64)]
    sizes = np.concatenate(none + [np.diff(part.start) for part in cells])
    point = np.concatenate(none + [part.point + start for part, start in zip(cells, first.tolist(), strict=False)])
    return Cells(np.concatenate([[0], np.cumsum(sizes)]), point, np.concatenate(none + [part.kind for part in cells]))
