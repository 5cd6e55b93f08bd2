# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Wavefront OBJ polygon meshes, read so that polygons keep their corners and their order.

Read: ``v x y z`` (further columns ignored) and ``f`` with ``v``, ``v/vt``, ``v//vn`` or ``v/vt/vn`` corners, 1-based
or counted back from the last vertex; a line that ends in a backslash goes on in the next. Normals, texture
coordinates, groups, materials and comments say nothing about a surface and are passed over.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from os import fspath

from stitchmesh.errors import FileError
from stitchmesh.io.atomic import write_text
from stitchmesh.io.contents import FilePath, read_lines
from stitchmesh.io.obj_elements import element_lines, vertex_index, vertex_position
from stitchmesh.mesh import FloatArray

PASSED_OVER = frozenset(
    "vn vt vp g o s mg usemtl usemap mtllib maplib l p curv curv2 surf parm trim hole scrv sp end con bevel c_interp "
    "d_interp lod shadow_obj trace_obj cstype deg bmat step ctech stech".split()
)
"""Elements of the format that are not vertices or faces."""


@dataclass
class _Elements:
    """Vertices and faces as far as they have been read."""

    path: str
    vertices: list[tuple[float, float, float]] = field(default_factory=list)
    faces: list[list[int]] = field(default_factory=list)
    face_line: list[int] = field(default_factory=list)


def read_obj_polygons(path: FilePath) -> tuple[list[tuple[float, float, float]], list[list[int]]]:
    """Vertices as written and faces as 0-based vertex numbers.

    Raises:
        FileError: the file is missing, a folder, unreadable, empty or binary, a line is malformed, a coordinate is
            not finite, an index points nowhere, or there are no faces. The message names the line.
    """
    elements = _Elements(fspath(path))
    for number, fields in element_lines(read_lines(path)):
        if fields[0] == "v":
            elements.vertices.append(vertex_position(elements.path, number, fields))
        elif fields[0] == "f":
            elements.faces.append(_face(elements, number, fields))
            elements.face_line.append(number)
        elif fields[0] not in PASSED_OVER:
            raise FileError(f"{elements.path}: line {number}: unknown element {fields[0][:20]!r}; expected an OBJ file")
    _check_indices(elements)
    return elements.vertices, elements.faces


def write_obj_polygons(path: FilePath, vertices: FloatArray, faces: list[list[int]]) -> None:
    """Write the polygons with every digit that their coordinates need.

    Raises:
        FileError: the file cannot be written.
    """
    lines = ["# StitchMesh"]
    lines += [f"v {x!r} {y!r} {z!r}" for x, y, z in vertices.tolist()]
    lines += ["f " + " ".join(str(vertex + 1) for vertex in face) for face in faces]
    write_text(path, "\n".join(lines) + "\n")


def _face(elements: _Elements, number: int, fields: list[str]) -> list[int]:
    if len(fields) < 4:
        raise FileError(f"{elements.path}: line {number}: got a face of {len(fields) - 1} corners; expected at least 3")
    count = len(elements.vertices)
    return [vertex_index(elements.path, number, corner, count) for corner in fields[1:]]


def _check_indices(elements: _Elements) -> None:
    count = len(elements.vertices)
    if not elements.faces:
        raise FileError(f"{elements.path}: got {count} vertices and no faces; expected a polygon mesh")
    for face, line in zip(elements.faces, elements.face_line, strict=True):
        if max(face) >= count:
            where = f"{elements.path}: line {line}: vertex {max(face) + 1} does not exist"
            raise FileError(f"{where}; the file has {count} vertices, perhaps it was cut short")
