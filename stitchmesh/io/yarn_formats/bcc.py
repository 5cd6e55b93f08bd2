# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Binary Curve Collection (BCC), the format of published yarn-level cloth models; numbers are little-endian.

The header has 64 bytes: 0 to 2 the text ``BCC``; 3 the sizes of numbers (0x44: integers and floats of four bytes);
4 and 5 the kind of curve; 6 the number of dimensions (3); 7 the up axis (1 is y, 2 is z); 8 to 15 the number of curves;
16 to 23 the number of points of all curves; 24 to 63 free text. For each curve, an int32 follows with the number of
its points, which is negative for a closed curve, and then the points as float32.
"""

from __future__ import annotations

import struct
from dataclasses import dataclass
from os import fspath

import numpy as np

from stitchmesh.errors import FileError
from stitchmesh.io.atomic import write_bytes
from stitchmesh.io.contents import FilePath, check_points, read_bytes
from stitchmesh.io.float32 import from_float32, to_float32
from stitchmesh.mesh import FloatArray

HEADER = struct.Struct("<3sB2sBBQQ40s")
FOUR_BYTE_NUMBERS = 0x44
UP_Y, UP_Z = 1, 2

CATMULL_ROM, POLYLINE, BSPLINE, BEZIER = b"C0", b"PL", b"BS", b"BZ"
LEAST_POINTS = {CATMULL_ROM: (3, 4), POLYLINE: (3, 2), BSPLINE: (3, 4)}
"""Smallest numbers of points of a closed and of an open curve, for each kind of curve that can be read."""


@dataclass(frozen=True)
class BccCurves:
    """The curves of a BCC file; the y axis points up."""

    kind: bytes
    """Kind of all curves: ``CATMULL_ROM``, ``POLYLINE`` or ``BSPLINE``."""
    curves: list[FloatArray]
    """Points of each curve in the file's unit; each array has the shape (n, 3)."""
    closed: list[bool]
    """Whether each curve is closed."""


def read_bcc(path: FilePath) -> BccCurves:
    """Read the curves of a BCC file; curves of a file with z up are rotated so that y points up.

    Raises:
        FileError: the file cannot be read, was cut short, has additional bytes, or violates the format.
    """
    name = fspath(path)
    content = read_bytes(path)
    if len(content) < HEADER.size or content[:3] != b"BCC":
        raise FileError(f"{name}: does not start with a BCC header; expected a Binary Curve Collection")
    _, sizes, kind, dimensions, up, curve_count, point_count, _ = HEADER.unpack_from(content)
    _check_header(name, sizes, kind, dimensions, up)
    needed = HEADER.size + 4 * curve_count + 12 * point_count
    if curve_count < 1 or len(content) != needed:
        found = f"{curve_count} curves of {point_count} points need {needed} bytes, the file has {len(content)}"
        raise FileError(f"{name}: {found}; it was cut short or altered")
    curves, closed = _curves(name, content, curve_count, kind)
    if up == UP_Z:
        curves = [points[:, [0, 2, 1]] * [1.0, 1.0, -1.0] for points in curves]
    return BccCurves(kind, curves, closed)


def write_bcc(path: FilePath, content: BccCurves) -> None:
    """Write curves to a BCC file with y up; coordinates are rounded to float32.

    Raises:
        FileError: a coordinate is too large for float32, or the file cannot be written.
    """
    count = sum(map(len, content.curves))
    parts = [HEADER.pack(b"BCC", FOUR_BYTE_NUMBERS, content.kind, 3, UP_Y, len(content.curves), count, b"StitchMesh")]
    for index, (points, closed) in enumerate(zip(content.curves, content.closed, strict=True)):
        parts.append(struct.pack("<i", -len(points) if closed else len(points)))
        parts.append(to_float32(path, f"the coordinates of curve {index}", points).astype("<f4").tobytes())
    write_bytes(path, b"".join(parts))


def _check_header(name: str, sizes: int, kind: bytes, dimensions: int, up: int) -> None:
    if sizes != FOUR_BYTE_NUMBERS:
        raise FileError(f"{name}: byte 3 is {sizes:#04x}; expected 0x44, integers and floats of four bytes")
    if kind == BEZIER:
        raise FileError(f"{name}: holds Bezier curves; expected C0 (Catmull-Rom), BS (B-spline) or PL (polyline)")
    if kind not in LEAST_POINTS:
        found = kind.decode("latin-1")
        raise FileError(f"{name}: kind of curve is {found!r}; expected C0 (Catmull-Rom), BS (B-spline), PL (polyline)")
    if dimensions != 3:
        raise FileError(f"{name}: points have {dimensions} dimensions; expected 3")
    if up not in (UP_Y, UP_Z):
        raise FileError(f"{name}: up axis is {up}; expected 1 (y) or 2 (z)")


def _curves(name: str, content: bytes, curve_count: int, kind: bytes) -> tuple[list[FloatArray], list[bool]]:
    curves: list[FloatArray] = []
    closed: list[bool] = []
    offset = HEADER.size
    for index in range(curve_count):
        count = _point_count(name, content, offset, index)
        least = LEAST_POINTS[kind][0 if count < 0 else 1]
        if abs(count) < least:
            shape = "closed" if count < 0 else "open"
            raise FileError(f"{name}: curve {index} is {shape} and has {abs(count)} points; expected at least {least}")
        points = from_float32(np.frombuffer(content, "<f4", 3 * abs(count), offset + 4).reshape(-1, 3))
        check_points(f"{name}: curve {index}, point", points)
        curves.append(points)
        closed.append(count < 0)
        offset += 4 + 12 * abs(count)
    if offset != len(content):
        raise FileError(f"{name}: {len(content) - offset} bytes are left after the last curve; the file was altered")
    return curves, closed


def _point_count(name: str, content: bytes, offset: int, index: int) -> int:
    left = len(content) - offset - 4
    count = int.from_bytes(content[offset : offset + 4], "little", signed=True) if left >= 0 else 0
    if left < 0 or 12 * abs(count) > left:
        raise FileError(f"{name}: curve {index} overruns the file; it was cut short or its counts are wrong")
    return count
