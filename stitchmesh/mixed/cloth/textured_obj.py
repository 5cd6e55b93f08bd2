# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Wavefront OBJ meshes with texture coordinates, as triangles.

The reader uses ``v``, ``vt`` and ``f`` lines. Every corner of a face needs a texture coordinate, as ``v/vt`` or
``v/vt/vn``. Polygons are divided into triangles by their ears. Texture coordinates with the same numbers are one,
whatever their indices are.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from os import fspath

import numpy as np

from stitchmesh.errors import FileError
from stitchmesh.io.contents import FilePath, is_coordinate, read_lines, suffix_of
from stitchmesh.io.obj_elements import element_lines, vertex_index, vertex_position
from stitchmesh.io.units import centimetres
from stitchmesh.mesh import FloatArray, IntArray
from stitchmesh.mesh.ears import clip_ears


@dataclass(frozen=True, eq=False)
class TexturedTriangles:
    """Triangles with positions in space and in the texture."""

    path: str
    """The file, for messages."""
    vertices: FloatArray
    """Positions of the vertices [cm], shape (V, 3); every vertex belongs to a triangle."""
    texture: FloatArray
    """Texture coordinates, all different, shape (U, 2)."""
    triangles: IntArray
    """Vertices of each triangle, shape (T, 3)."""
    texture_corners: IntArray
    """Texture coordinates of each triangle, shape (T, 3)."""
    line: IntArray
    """Line of the file of each triangle, from 1, shape (T,)."""


@dataclass
class _Elements:
    """The elements of the lines that have been read so far."""

    path: str
    vertices: list[tuple[float, float, float]] = field(default_factory=list)
    texture: list[tuple[float, float]] = field(default_factory=list)
    faces: list[list[tuple[int, int]]] = field(default_factory=list)
    """Vertex and texture coordinate of each corner of each face, both from 0."""
    line: list[int] = field(default_factory=list)
    """Line of each face, from 1."""


def read_textured_obj(path: FilePath, *, unit: str = "cm") -> TexturedTriangles:
    """Read triangles with texture coordinates.

    Args:
        path: an ``.obj`` file.
        unit: unit of the positions in the file.

    Raises:
        FileError: the file cannot be read, a line is malformed, a vertex or a texture coordinate does not exist, there
            are no faces, or a face has no texture coordinates. The message names the line.
        ParameterError: there is no unit of that name.
    """
    suffix_of(path, [".obj"])
    scale = centimetres(unit)
    elements = _Elements(fspath(path))
    for number, fields in element_lines(read_lines(path)):
        if fields[0] == "v":
            elements.vertices.append(vertex_position(elements.path, number, fields))
        elif fields[0] == "vt":
            elements.texture.append(_texture_coordinate(elements.path, number, fields))
        elif fields[0] == "f":
            _add_face(elements, number, fields)
    if not elements.line:
        found = f"got {len(elements.vertices)} vertices and no faces"
        raise FileError(f"{elements.path}: {found}; expected a mesh with texture coordinates")
    return _triangles(elements, scale)


def _texture_coordinate(path: str, number: int, fields: list[str]) -> tuple[float, float]:
    try:
        u, v = (float(text) for text in fields[1:3])
    except ValueError:
        u = v = math.nan
    if not (is_coordinate(u) and is_coordinate(v)):
        found = " ".join(fields)[:40]
        raise FileError(f"{path}: line {number}: got {found!r}; expected 'vt u v' with two finite numbers")
    return u, v


def _add_face(elements: _Elements, number: int, fields: list[str]) -> None:
    if len(fields) < 4:
        found = f"got a face of {len(fields) - 1} corners"
        raise FileError(f"{elements.path}: line {number}: {found}; expected at least 3")
    elements.faces.append([_corner(elements, number, text) for text in fields[1:]])
    elements.line.append(number)


def _corner(elements: _Elements, number: int, text: str) -> tuple[int, int]:
    parts = text.split("/")
    vertex = vertex_index(elements.path, number, text, len(elements.vertices))
    if len(parts) < 2 or not parts[1]:
        raise FileError(
            f"{elements.path}: line {number}: corner {text[:20]!r} has no texture coordinates; expected v/vt; unwrap "
            "the mesh, or describe its panels by outlines"
        )
    return vertex, vertex_index(elements.path, number, parts[1], len(elements.texture))


def _triangles(elements: _Elements, scale: float) -> TexturedTriangles:
    corners = np.array([corner for face in elements.faces for corner in face])
    size = np.array([len(face) for face in elements.faces])
    line = np.repeat(elements.line, size)
    for name, column, count in (
        ("vertex", 0, len(elements.vertices)),
        ("texture coordinate", 1, len(elements.texture)),
    ):
        bad = np.flatnonzero(corners[:, column] >= count)
        if len(bad):
            where = f"{elements.path}: line {line[bad[0]]}: {name} {int(corners[bad[0], column]) + 1}"
            raise FileError(f"{where} does not exist; the file has {count}; perhaps it was cut short")
    vertices = np.array(elements.vertices)
    triangles = clip_ears(vertices[corners[:, 0]], corners[:, 0], size).triangles
    used, vertex = np.unique(corners[triangles, 0], return_inverse=True)
    own_texture = np.array(elements.texture)[corners[triangles, 1].ravel()]
    texture, place = np.unique(own_texture, axis=0, return_inverse=True)
    return TexturedTriangles(
        path=elements.path,
        vertices=vertices[used] * scale,
        texture=texture,
        triangles=vertex.reshape(-1, 3),
        texture_corners=place.reshape(-1, 3),
        line=line[triangles[:, 0]],
    )
