# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Wavefront OBJ polygon meshes; the polygons keep their corners and their order.

The reader uses ``v x y z`` lines, whose further columns are ignored, and ``f`` lines with corners of the form ``v``,
``v/vt``, ``v//vn`` or ``v/vt/vn``. Vertices are counted from 1, or, if negative, back from the last vertex. A line that
ends in a backslash continues in the next line. Normals, texture coordinates, groups, materials and comments are
ignored, because they do not change the surface. All other elements, such as lines, points, curved surfaces and the
states of simulators, are left out, and one line of the log names them.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from os import fspath

from stitchmesh.errors import FileError
from stitchmesh.io.atomic import write_text
from stitchmesh.io.contents import FilePath, read_lines, say_left_out
from stitchmesh.io.obj_elements import element_lines, vertex_index, vertex_position
from stitchmesh.mesh import FloatArray

IGNORED_ELEMENTS = frozenset(
    "vn vt vp g o s mg usemtl usemap mtllib maplib bevel c_interp d_interp lod shadow_obj trace_obj".split()
)
"""Elements of the format that say how vertices and faces are grouped and look."""


@dataclass
class _Elements:
    """The vertices and faces of the lines that have been read so far."""

    path: str
    """The file, for error messages."""
    fewest_corners: int
    """Smallest number of corners of a face."""
    vertices: list[tuple[float, float, float]] = field(default_factory=list)
    """Positions of the vertices, in the file's unit."""
    faces: list[list[int]] = field(default_factory=list)
    """Vertices of each face, counted from 0."""
    face_line: list[int] = field(default_factory=list)
    """Line number of each face, counted from 1."""
    others: dict[str, list[int]] = field(default_factory=dict)
    """Line numbers of the elements that are left out, by their first word."""


def read_obj_polygons(
    path: FilePath, fewest_corners: int = 3
) -> tuple[list[tuple[float, float, float]], list[list[int]]]:
    """Read polygons.

    Args:
        path: an ``.obj`` file.
        fewest_corners: smallest number of corners of a face; below 3 for files that will be repaired.

    Returns:
        Positions of the vertices in the file's unit, and the vertices of each face, counted from 0.

    Raises:
        FileError: the file is missing, a folder, unreadable, empty or binary, a line is malformed, a coordinate is
            not finite, a vertex does not exist, or there are no faces. The message names the line.
    """
    elements = _Elements(fspath(path), fewest_corners)
    for number, fields in element_lines(read_lines(path)):
        if fields[0] == "v":
            elements.vertices.append(vertex_position(elements.path, number, fields))
        elif fields[0] == "f":
            elements.faces.append(_face(elements, number, fields))
            elements.face_line.append(number)
        elif fields[0] not in IGNORED_ELEMENTS:
            elements.others.setdefault(fields[0], []).append(number)
    _check_indices(elements)
    say_left_out(path, {word: len(lines) for word, lines in elements.others.items()}, "lines")
    return elements.vertices, elements.faces


def write_obj_polygons(path: FilePath, vertices: FloatArray, faces: list[list[int]]) -> None:
    """Write polygons; coordinates have all digits that are needed to read the same numbers again.

    Args:
        path: an ``.obj`` file.
        vertices: positions in the file's unit, shape (V, 3).
        faces: vertices of each face, counted from 0.

    Raises:
        FileError: the file cannot be written.
    """
    lines = ["# StitchMesh"]
    lines += [f"v {x!r} {y!r} {z!r}" for x, y, z in vertices.tolist()]
    lines += ["f " + " ".join(str(vertex + 1) for vertex in face) for face in faces]
    write_text(path, "\n".join(lines) + "\n")


def _face(elements: _Elements, number: int, fields: list[str]) -> list[int]:
    if len(fields) <= elements.fewest_corners:
        found = f"got a face of {len(fields) - 1} corners"
        raise FileError(f"{elements.path}: line {number}: {found}; expected at least {elements.fewest_corners}")
    count = len(elements.vertices)
    return [vertex_index(elements.path, number, corner, count) for corner in fields[1:]]


def _check_indices(elements: _Elements) -> None:
    count = len(elements.vertices)
    if not elements.faces and not count and elements.others:
        word, lines = next(iter(elements.others.items()))
        raise FileError(f"{elements.path}: line {lines[0]}: unknown element {word[:20]!r}; expected an OBJ file")
    if not elements.faces:
        raise FileError(f"{elements.path}: got {count} vertices and no faces; expected a polygon mesh")
    for face, line in zip(elements.faces, elements.face_line, strict=True):
        if max(face) >= count:
            where = f"{elements.path}: line {line}: vertex {max(face) + 1} does not exist"
            raise FileError(f"{where}; the file has {count} vertices, perhaps it was cut short")
