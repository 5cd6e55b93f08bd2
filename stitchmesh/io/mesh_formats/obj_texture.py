# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Texture coordinates and groups of Wavefront OBJ files, for sewing patterns.

A corner ``v/vt`` or ``v/vt/vn`` of a face has a texture vertex, a point of the flat panel that the face was cut from.
Texture vertices are counted from 1, or, if negative, back from the last one. The lines ``o``, ``g`` and ``usemtl``
begin a group, to which the following faces belong.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from os import fspath

from stitchmesh.errors import FileError
from stitchmesh.io.contents import FilePath, is_coordinate, read_lines
from stitchmesh.io.mesh_formats.obj import read_obj_polygons
from stitchmesh.io.obj_elements import element_lines

GROUP_ELEMENTS = ("o", "g", "usemtl")
"""Elements that begin a group."""


@dataclass(frozen=True)
class ObjTexture:
    """Polygons with the texture vertices of their corners and with their groups."""

    vertices: list[tuple[float, float, float]]
    """Positions of the vertices, in the file's unit."""
    faces: list[list[int]]
    """Vertices of each face, counted from 0."""
    texture: list[tuple[float, float]]
    """Texture coordinates (u, v) of the texture vertices; empty if the file has none."""
    face_texture: list[list[int]]
    """Texture vertices of each face, counted from 0; empty if the file has no texture coordinates."""
    group: list[tuple[str, ...]]
    """Names of the object, the group and the material of each face; ``""`` where none is set."""


@dataclass
class _Parts:
    """What has been read so far."""

    path: str
    texture: list[tuple[float, float]] = field(default_factory=list)
    face_texture: list[list[int]] = field(default_factory=list)
    face_line: list[int] = field(default_factory=list)
    group: list[tuple[str, ...]] = field(default_factory=list)
    current: dict[str, str] = field(default_factory=lambda: dict.fromkeys(GROUP_ELEMENTS, ""))


def read_obj_texture(path: FilePath) -> ObjTexture:
    """Read polygons with texture vertices and groups.

    Args:
        path: an ``.obj`` file.

    Raises:
        FileError: as for ``read_obj_polygons``; a texture coordinate is malformed or not finite, a texture vertex does
            not exist, or some corners have a texture vertex and others have none. The message names the line.
    """
    vertices, faces = read_obj_polygons(path)
    parts = _Parts(fspath(path))
    for number, fields in element_lines(read_lines(path)):
        if fields[0] == "vt":
            parts.texture.append(_texture_position(parts.path, number, fields))
        elif fields[0] == "f":
            parts.face_texture.append([_texture_index(parts, number, corner) for corner in fields[1:]])
            parts.face_line.append(number)
            parts.group.append(tuple(parts.current.values()))
        elif fields[0] in GROUP_ELEMENTS:
            parts.current[fields[0]] = " ".join(fields[1:])
    if not any(any(place >= 0 for place in face) for face in parts.face_texture):
        return ObjTexture(vertices, faces, [], [], parts.group)
    _check_all_have_texture(parts)
    return ObjTexture(vertices, faces, parts.texture, parts.face_texture, parts.group)


def _texture_position(path: str, number: int, fields: list[str]) -> tuple[float, float]:
    """Return the texture coordinates in the fields of a ``vt`` line; the second one is 0 if it is missing."""
    try:
        u, v = (float(text) for text in [*fields[1:3], "0"][:2])
    except ValueError:
        u = v = float("nan")
    if not (is_coordinate(u) and is_coordinate(v)):
        found = " ".join(fields)[:40]
        raise FileError(f"{path}: line {number}: got {found!r}; expected 'vt u v' with finite numbers")
    return u, v


def _texture_index(parts: _Parts, number: int, corner: str) -> int:
    """Return the texture vertex of a corner, counted from 0, or -1 if it has none."""
    fields = corner.split("/")
    if len(fields) < 2 or not fields[1]:
        return -1
    index = int(fields[1])
    count = len(parts.texture)
    if index == 0 or index < -count:
        found = f"{parts.path}: line {number}: texture vertex {index} does not exist"
        raise FileError(f"{found}; {count} texture vertices come before this line, and OBJ counts from 1")
    return index - 1 if index > 0 else count + index


def _check_all_have_texture(parts: _Parts) -> None:
    count = len(parts.texture)
    for face, line in zip(parts.face_texture, parts.face_line, strict=True):
        if min(face) < 0:
            found = f"{parts.path}: line {line}: a corner has no texture vertex, and others have one"
            raise FileError(f"{found}; write texture coordinates for all faces, or for none")
        if max(face) >= count:
            found = f"{parts.path}: line {line}: texture vertex {max(face) + 1} does not exist"
            raise FileError(f"{found}; the file has {count} texture vertices, perhaps it was cut short")
