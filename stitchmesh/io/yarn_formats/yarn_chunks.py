# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Yarns in ``.yarns`` files, the format of smobj-to-yarns and of yarn simulators (github.com/textiles-lab/smobj).

The file is a sequence of chunks: four characters, a uint32 with the number of bytes that follow, and the bytes. Numbers
are little-endian, integers and floats of four bytes.

- ``f3..``: points x, y, z of all yarns; ``src.``: for each point the line of the program that made it, 0 if unknown.
- ``yarn``: for each yarn its first point, the point after its last one, the radius, and the bytes r, g, b, a.
- ``strs``, ``unit`` and ``chk.``, which may be missing: characters; units of length with the place of their name and a
  length; and checkpoints, each a point, a factor and a unit. The products of all checkpoints of a point sum to the
  length of yarn up to the next point that has any.
"""

from __future__ import annotations

import struct
from dataclasses import dataclass
from os import fspath

import numpy as np
from numpy.typing import NDArray

from stitchmesh.errors import FileError
from stitchmesh.io.atomic import write_bytes
from stitchmesh.io.contents import FilePath, check_points, read_bytes
from stitchmesh.io.float32 import from_float32, to_float32
from stitchmesh.mesh import FloatArray, IntArray

CHUNKS = {"f3..": 12, "src.": 4, "yarn": 16, "strs": 1, "unit": 12, "chk.": 12}
"""Tags of the chunks in their order, and the bytes of an element; the last three may be missing."""
_YARN = np.dtype([("begin", "<u4"), ("end", "<u4"), ("radius", "<f4"), ("rgba", "u1", 4)])
_UNIT = np.dtype([("begin", "<u4"), ("end", "<u4"), ("length", "<f4")])
_CHECKPOINT = np.dtype([("point", "<u4"), ("factor", "<f4"), ("unit", "<u4")])


@dataclass(frozen=True, eq=False)
class YarnChunks:
    """The polylines of a ``.yarns`` file; lengths are in the unit of the file."""

    curves: list[FloatArray]
    """Points of each yarn, shape (n, 3) each."""
    radius: FloatArray
    """Radius of each yarn, shape (Y,)."""
    rgba: NDArray[np.uint8]
    """Colour and opacity of each yarn, shape (Y, 4)."""
    lengths: list[dict[int, float]]
    """For each yarn: length up to the next mark, by the number of the marked point within the yarn."""


def read_yarn_chunks(path: FilePath) -> YarnChunks:
    """Read the polylines of a ``.yarns`` file. The source lines of points are not kept.

    Raises:
        FileError: the file cannot be read, was cut short, or violates the format.
    """
    name, chunks = fspath(path), _chunks(path)
    points = from_float32(np.frombuffer(chunks["f3.."], "<f4").reshape(-1, 3))
    check_points(f"{name}: point", points)
    if len(chunks["src."]) // 4 != len(points):
        raise FileError(f"{name}: got {len(chunks['src.']) // 4} source lines of {len(points)} points; expected equal")
    yarns = np.frombuffer(chunks["yarn"], _YARN)
    if not len(yarns):
        raise FileError(f"{name}: got no yarns; expected at least one")
    ranges = np.stack([yarns["begin"], yarns["end"]], axis=1).astype(np.int64)
    _check_ranges(name, ranges, len(points))
    curves = [points[begin:end] for begin, end in ranges.tolist()]
    return YarnChunks(curves, from_float32(yarns["radius"]), yarns["rgba"], _lengths(name, chunks, ranges))


def write_yarn_chunks(path: FilePath, content: YarnChunks) -> None:
    """Write polylines to a ``.yarns`` file; coordinates and lengths are rounded to float32.

    Raises:
        FileError: a coordinate, a radius or a length is too large for float32, or the file cannot be written.
    """
    counts = np.array([len(curve) for curve in content.curves])
    start = np.concatenate([[0], np.cumsum(counts)])
    points = to_float32(path, "the coordinates", np.concatenate(content.curves)).astype("<f4")
    yarns = np.zeros(len(counts), _YARN)
    yarns["begin"], yarns["end"], yarns["rgba"] = start[:-1], start[1:], content.rgba
    yarns["radius"] = to_float32(path, "the radii", content.radius)
    lengths = [sorted(own.items()) for own in content.lengths]
    marks = np.zeros(sum(map(len, lengths)), _CHECKPOINT)
    marks["point"] = [first + point for first, own in zip(start.tolist(), lengths, strict=False) for point, _ in own]
    marks["factor"] = to_float32(path, "the lengths", np.array([length for own in lengths for _, length in own]))
    data = {
        "f3..": points.tobytes(), "src.": np.zeros(len(points), "<u4").tobytes(), "yarn": yarns.tobytes(),
        "strs": b"1", "unit": np.array([(0, 1, 1.0)], _UNIT).tobytes(), "chk.": marks.tobytes(),
    }  # fmt: skip
    write_bytes(path, b"".join(tag.encode() + struct.pack("<I", len(part)) + part for tag, part in data.items()))


def _chunks(path: FilePath) -> dict[str, bytes]:
    """Return the bytes of each chunk; no bytes for a missing chunk."""
    name, content = fspath(path), read_bytes(path)
    found: dict[str, bytes] = {}
    offset = 0
    for tag, size in CHUNKS.items():
        if offset == len(content) and tag not in ("f3..", "src.", "yarn"):
            break
        header = content[offset : offset + 8]
        if len(header) < 8 or header[:4] != tag.encode():
            got = header[:4].decode("latin-1")
            raise FileError(f"{name}: byte {offset}: got {got!r}; expected the chunk {tag!r} of a .yarns file")
        length = int.from_bytes(header[4:], "little")
        if length % size or offset + 8 + length > len(content):
            expected = f"expected a multiple of {size} that the file holds"
            raise FileError(f"{name}: chunk {tag!r} has {length} bytes; {expected}; it was cut short or altered")
        found[tag] = content[offset + 8 : offset + 8 + length]
        offset += 8 + length
    if offset != len(content):
        raise FileError(f"{name}: {len(content) - offset} bytes are left after the last chunk; the file was altered")
    return {tag: found.get(tag, b"") for tag in CHUNKS}


def _check_ranges(name: str, ranges: IntArray, count: int) -> None:
    following = np.concatenate([[0], ranges[:-1, 1]])
    bad = np.flatnonzero((ranges[:, 0] < following) | (ranges[:, 1] - ranges[:, 0] < 2) | (ranges[:, 1] > count))
    if len(bad):
        begin, end = ranges[bad[0]]
        expected = f"expected two or more of the {count} points, after those of the yarn before"
        raise FileError(f"{name}: yarn {bad[0]}: got points {begin} to {end}; {expected}")


def _lengths(name: str, chunks: dict[str, bytes], ranges: IntArray) -> list[dict[int, float]]:
    """Return the length after each marked point of each yarn."""
    units, marks = np.frombuffer(chunks["unit"], _UNIT), np.frombuffer(chunks["chk."], _CHECKPOINT)
    found: list[dict[int, float]] = [{} for _ in ranges]
    owner = np.searchsorted(ranges[:, 0], marks["point"], side="right") - 1
    for number, (yarn, (point, factor, unit)) in enumerate(zip(owner.tolist(), marks.tolist(), strict=True)):
        if yarn < 0 or point >= ranges[yarn, 1] or unit >= len(units):
            raise FileError(f"{name}: checkpoint {number}: got point {point} and unit {unit}, which do not exist")
        length = factor * float(units["length"][unit])
        if not 0.0 <= length < np.inf:
            raise FileError(f"{name}: checkpoint {number}: got a length of {length}; expected a number from 0")
        place = point - int(ranges[yarn, 0])
        found[yarn][place] = found[yarn].get(place, 0.0) + length
    return found
