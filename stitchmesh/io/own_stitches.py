# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Files of stitches of the user's own: JSON with the drawing of each stitch, by its code (``docs/own-stitches.md``)."""

from __future__ import annotations

from os import fspath

import msgspec

from stitchmesh.errors import FileError, ParameterError
from stitchmesh.io.checked import check_value, parse_json
from stitchmesh.io.contents import FilePath, read_bytes
from stitchmesh.mesh.own_stitch import DrawnPart, OwnStitch

LARGEST_FILE = 4_000_000
"""Largest file of drawings [bytes]."""
MOST_WAYPOINTS = 200
"""Most points of one part."""
LARGEST_COORDINATE = 100.0
"""Largest coordinate of a point, in its unit; a face is a few stitch widths wide and yarns are a few radii high."""


class _Part(msgspec.Struct, forbid_unknown_fields=True, rename={"start": "from", "end": "to"}):
    start: str
    end: str
    through: list[tuple[float, float, float]]
    head: bool = False


class _Drawing(msgspec.Struct, forbid_unknown_fields=True):
    makes: str
    parts: list[_Part]
    instruction: str = ""


def read_own_drawings(path: FilePath) -> tuple[OwnStitch, ...]:
    """Read stitches of the user's own from a file; their yarn is not checked yet.

    Raises:
        FileError: the file cannot be read or is no file of drawings; the message names the stitch and the key.
    """
    return parse_own_drawings(fspath(path), read_bytes(path))


def parse_own_drawings(name: str, content: bytes) -> tuple[OwnStitch, ...]:
    """Return the stitches of a text of drawings; their yarn is not checked yet.

    Args:
        name: name of the file, for messages.
        content: the text, in UTF-8.

    Raises:
        FileError: the text is no file of drawings; the message names the stitch and the key.
    """
    if len(content) > LARGEST_FILE:
        raise FileError(f"{name}: got {len(content)} bytes; expected drawings of at most {LARGEST_FILE}")
    try:
        drawings = check_value(parse_json(content.decode("utf-8", errors="replace")), dict[str, object])
        if not drawings:
            raise ParameterError("holds no stitch; expected the drawing of each stitch by its code")
        return tuple(_own(code, drawing) for code, drawing in drawings.items())
    except ParameterError as error:
        raise FileError(f"{name}: {error}") from error


def format_own_drawings(stitches: tuple[OwnStitch, ...]) -> bytes:
    """Return the text of drawings, which ``parse_own_drawings`` reads without loss."""
    drawings = {
        stitch.code: _Drawing(
            stitch.makes,
            [_Part(part.start, part.end, list(part.through), part.head) for part in stitch.parts],
            stitch.instruction,
        )
        for stitch in stitches
    }
    return msgspec.json.encode(drawings)


def _own(code: str, content: object) -> OwnStitch:
    try:
        drawing = check_value(content, _Drawing)
    except ParameterError as error:
        raise ParameterError(f"stitch {code!r}: {error}") from error
    longest = max((len(part.through) for part in drawing.parts), default=0)
    if longest > MOST_WAYPOINTS:
        raise ParameterError(f"stitch {code!r}: got a part through {longest} points; expected {MOST_WAYPOINTS} at most")
    for number, part in enumerate(drawing.parts, start=1):
        _check_points(f"stitch {code!r}: part {number}", part.through)
    parts = tuple(DrawnPart(part.start, part.end, part.head, tuple(part.through)) for part in drawing.parts)
    return OwnStitch(code, drawing.makes, parts, drawing.instruction)


def _check_points(where: str, points: list[tuple[float, float, float]]) -> None:
    """Check that coordinates are possible on a face, and that a curve can pass through the points in their order."""
    for number, point in enumerate(points):
        if not all(abs(coordinate) <= LARGEST_COORDINATE for coordinate in point):
            raise ParameterError(f"{where}: got the point {point}; expected coordinates within {LARGEST_COORDINATE:g}")
        if point in points[number - 1 : number]:
            raise ParameterError(f"{where}: got the point {point} twice in a row; remove one")
