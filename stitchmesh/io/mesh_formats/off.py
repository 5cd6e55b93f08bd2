# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Object File Format (OFF) polygon meshes.

A file consists of the word ``OFF``, the numbers of vertices, faces and edges, a line for each vertex, and a line for
each face: the number of its corners and its vertices, counted from 0. Letters before the word (``ST``, ``C``, ``N``)
say that vertices have more columns, which are ignored. Some programs write the numbers directly behind the word, or
leave it out. This module exists because meshio reads and writes only the triangles of the format.
"""

from __future__ import annotations

import re
from os import fspath

from stitchmesh.errors import FileError
from stitchmesh.io.atomic import write_text
from stitchmesh.io.contents import FilePath, is_coordinate, read_lines
from stitchmesh.mesh import FloatArray

HEAD = re.compile(r"(?:ST)?C?N?(4?n?)OFF([0-9]*)")
"""First word of a file: variants, variants of other dimensions, the word, and a number behind it."""

Line = tuple[int, list[str]]
"""Line number, counted from 1, and the fields of the line."""


def read_off_polygons(path: FilePath, fewest_corners: int = 3) -> tuple[list[list[float]], list[list[int]]]:
    """Read polygons.

    Args:
        path: an ``.off`` file.
        fewest_corners: smallest number of corners of a face; below 3 for files that will be repaired.

    Returns:
        Positions of the vertices in the file's unit, and the vertices of each face, counted from 0.

    Raises:
        FileError: the file is missing, a folder, unreadable, empty, binary, cut short or malformed; the message
            names the line.
    """
    name = fspath(path)
    lines = [(number, line.partition("#")[0].split()) for number, line in enumerate(read_lines(path), start=1)]
    lines = [line for line in lines if line[1]]
    body = _body(name, lines)
    vertex_count, face_count = _counts(name, body)
    body = body[1:]
    if len(body) < vertex_count + face_count:
        found = f"got {len(body)} lines for {vertex_count} vertices and {face_count} faces"
        raise FileError(f"{name}: {found}; the file was cut short")
    vertices = [_vertex(name, line) for line in body[:vertex_count]]
    lines = body[vertex_count : vertex_count + face_count]
    faces = [_face(name, line, vertex_count, fewest_corners) for line in lines]
    return vertices, faces


def write_off_polygons(path: FilePath, vertices: FloatArray, faces: list[list[int]]) -> None:
    """Write polygons; coordinates have all digits that are needed to read the same numbers again.

    Args:
        path: an ``.off`` file.
        vertices: positions in the file's unit, shape (V, 3).
        faces: vertices of each face, counted from 0.

    Raises:
        FileError: the file cannot be written.
    """
    lines = ["OFF", f"{len(vertices)} {len(faces)} 0"]
    lines += [f"{x!r} {y!r} {z!r}" for x, y, z in vertices.tolist()]
    lines += [" ".join(map(str, [len(face), *face])) for face in faces]
    write_text(path, "\n".join(lines) + "\n")


def _body(name: str, lines: list[Line]) -> list[Line]:
    """Return the lines from the numbers of vertices and faces on."""
    number, fields = lines[0] if lines else (1, [""])
    head = HEAD.fullmatch(fields[0])
    if head is None and not fields[0].isdecimal():
        raise FileError(f"{name}: line 1: expected the word OFF")
    if head is None:
        return lines
    if head[1] or fields[1:2] == ["BINARY"]:
        found = " ".join(fields)[:20]
        raise FileError(f"{name}: line {number}: got {found!r}; expected OFF in text, with three coordinates a vertex")
    first = [head[2]] * bool(head[2]) + fields[1:]  # The numbers may follow on the same line.
    return [(number, first), *lines[1:]] if first else lines[1:]


def _counts(name: str, body: list[Line]) -> tuple[int, int]:
    number, fields = body[0] if body else (1, [])
    try:
        vertex_count, face_count = (int(text) for text in fields[:2])
    except ValueError as error:
        raise FileError(f"{name}: line {number}: expected the numbers of vertices, faces and edges") from error
    if vertex_count < 1 or face_count < 1:
        raise FileError(f"{name}: line {number}: got {vertex_count} vertices and {face_count} faces; expected a mesh")
    return vertex_count, face_count


def _vertex(name: str, line: Line) -> list[float]:
    number, fields = line
    try:
        position = [float(text) for text in fields[:3]]
    except ValueError:
        position = []
    if len(position) != 3 or not all(map(is_coordinate, position)):
        raise FileError(f"{name}: line {number}: got {' '.join(fields)[:40]!r}; expected three finite coordinates")
    return position


def _face(name: str, line: Line, vertex_count: int, fewest_corners: int) -> list[int]:
    number, fields = line
    try:
        size, *corners = (int(text) for text in fields[: int(fields[0]) + 1])
    except ValueError:
        size, corners = 0, []
    if size < fewest_corners or len(corners) != size:
        found = f"{name}: line {number}: got {' '.join(fields)[:40]!r}"
        raise FileError(f"{found}; expected a corner count of at least {fewest_corners} and the corners")
    bad = [vertex for vertex in corners if not 0 <= vertex < vertex_count]
    if bad:
        raise FileError(f"{name}: line {number}: vertex {bad[0]} does not exist; expected 0 to {vertex_count - 1}")
    return corners
