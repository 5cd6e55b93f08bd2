# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The objects of a scene: which faces of a mesh file belong to which object, and which objects are garments.

OBJ names objects (``o``) and groups (``g``), glTF names nodes and meshes, and USD names prims. In other files, and
where a file names nothing, the connected parts are the objects, ``part 1`` and so on in the order of their first faces.

A garment has openings, or two layers; a body and a button have neither. If a file also holds objects without them and
the caller chooses no object, these objects are left out.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from stitchmesh.errors import MeshError, ParameterError
from stitchmesh.io.contents import FilePath, read_lines
from stitchmesh.io.mesh_formats.glb import glb_face_names
from stitchmesh.io.mesh_formats.usd_mesh import usd_face_names
from stitchmesh.io.obj_elements import element_lines
from stitchmesh.mesh import FloatArray, IntArray, Mesh
from stitchmesh.mesh.connectivity import linked_groups
from stitchmesh.mesh.layers import parallel_layers
from stitchmesh.mesh.repair.soup import Soup, open_sides, soup_of

SMALLEST_GARMENT_PART = 0.05
"""A connected part with openings is no garment if its area, over the area of all faces, is below this: an eyelash."""
MOST_NAMES = 12
"""Number of names of objects that a message lists."""


@dataclass(frozen=True, eq=False)
class SceneObjects:
    """The faces of a file, with the names of their objects."""

    vertices: FloatArray
    """Positions [cm], shape (V, 3)."""
    faces: list[list[int]]
    """Vertices of each face, counted from 0."""
    face_names: list[tuple[str, ...]]
    """Names of the object and of the groups of each face, the object first; empty where the file names nothing."""

    @cached_property
    def soup(self) -> Soup:
        """The faces with their positions; programs repeat a vertex for its normals, so positions show what touches."""
        positions, number = np.unique(self.vertices, axis=0, return_inverse=True)
        soup = soup_of(self.vertices, self.faces)
        return replace(soup, points=positions, vertex=number.reshape(-1)[soup.vertex])

    @cached_property
    def part(self) -> IntArray:
        """Connected part of each face, numbered in the order of their first faces, shape (F,)."""
        soup, count = self.soup, len(self.soup.points)
        group = linked_groups(count + soup.face_count, soup.vertex, count + soup.side_face)
        _, first, number = np.unique(group[count:], return_index=True, return_inverse=True)
        rank: IntArray = np.argsort(np.argsort(first))[number.reshape(-1)]
        return rank

    @cached_property
    def names(self) -> list[tuple[str, ...]]:
        """Names of each face; the names of the connected parts if the file names nothing."""
        return self.face_names if any(self.face_names) else [(f"part {number + 1}",) for number in self.part.tolist()]

    @cached_property
    def objects(self) -> tuple[str, ...]:
        """First name of each object, in the order of the file."""
        return tuple(dict.fromkeys(names[0] for names in self.names if names))

    def chosen(self, objects: Sequence[str]) -> NDArray[np.bool_]:
        """Return whether each face belongs to one of the given objects or groups, shape (F,).

        Raises:
            ParameterError: nothing in the file has one of the names.
        """
        for name in objects:
            if not any(name in names for names in self.names):
                expected = f"expected one of {_listed(self.objects)}"
                raise ParameterError(f"object {name!r}: the file has no such object or group; {expected}")
        return np.array([not set(objects).isdisjoint(names) for names in self.names])

    def garments(self) -> NDArray[np.bool_]:
        """Return whether each face probably belongs to a garment, shape (F,)."""
        part_count = int(self.part.max()) + 1
        if part_count == 1:
            return np.ones(len(self.faces), dtype=bool)
        area, open_face = self.soup.area, self.soup.side_face[open_sides(self.soup)]
        share = np.bincount(self.part, area) / max(float(area.sum()), np.finfo(np.float64).tiny)
        is_open = np.bincount(self.part[open_face], minlength=part_count) > 0
        garment = is_open & (share >= SMALLEST_GARMENT_PART)
        for number in np.flatnonzero(~is_open & (share >= SMALLEST_GARMENT_PART)).tolist():
            garment[number] = self._has_layers(number)
        if not garment.any():
            return np.ones(len(self.faces), dtype=bool)
        kept: NDArray[np.bool_] = (garment | is_open)[self.part]
        return kept

    def _has_layers(self, number: int) -> bool:
        """Return whether a closed part is a garment with a thickness."""
        try:
            mesh = Mesh.from_polygons(*faces_alone(self.vertices, self.faces, self.part == number))
        except MeshError:
            return False
        return parallel_layers(mesh) is not None


def scene_objects(path: FilePath, vertices: FloatArray, faces: list[list[int]]) -> SceneObjects:
    """Return the objects of a file whose polygons were read."""
    reader = READERS.get(Path(path).suffix.lower())
    names = [] if reader is None else reader(path)
    return SceneObjects(vertices, faces, names if len(names) == len(faces) else [()] * len(faces))


def faces_alone(
    vertices: FloatArray, faces: list[list[int]], kept: NDArray[np.bool_]
) -> tuple[FloatArray, list[list[int]]]:
    """Return some polygons with the vertices that they use, in their order."""
    chosen = [faces[face] for face in np.flatnonzero(kept).tolist()]
    used, corner = np.unique([vertex for face in chosen for vertex in face], return_inverse=True)
    ends = np.cumsum([len(face) for face in chosen])[:-1]
    return vertices[used], [face.tolist() for face in np.split(corner.reshape(-1), ends)]


def about_objects(scene: SceneObjects, kept: NDArray[np.bool_]) -> str:
    """Return a sentence about a file of several separate objects if none was chosen; else no text.

    Args:
        scene: the objects.
        kept: whether each face was kept, as ``SceneObjects.garments`` returns it, shape (F,).
    """
    dropped = list(dict.fromkeys(scene.names[face][0] for face in np.flatnonzero(~kept).tolist() if scene.names[face]))
    held = _listed(scene.objects)
    if dropped:
        said = f"the file holds {held}; {_listed(dropped)} was left out, because it is closed on all sides as a body is"
        return f"{said}; --object {dropped[0]!r} knits it instead"
    if len(scene.objects) > 1 and any(scene.face_names) and int(scene.part.max()) > 0:
        return f"the file holds {held}, which are knitted together; --object {scene.objects[0]!r} knits one alone"
    return ""


def _listed(names: Sequence[str]) -> str:
    """Return names in one line; a large scene has more names than the line lists."""
    return ", ".join(names[:MOST_NAMES]) + (" ..." if len(names) > MOST_NAMES else "")


def _obj_names(path: FilePath) -> list[tuple[str, ...]]:
    """Return the names of the object and of the groups of each face of an OBJ file."""
    found, current = [], {"o": list[str](), "g": list[str]()}
    for _, fields in element_lines(read_lines(path)):
        if fields[0] == "o":
            current["o"] = [" ".join(fields[1:])]
        elif fields[0] == "g":
            current["g"] = fields[1:]
        elif fields[0] == "f":
            found.append(tuple(filter(None, [*current["o"], *current["g"]])))
    return found


READERS = {
    ".obj": _obj_names, ".glb": glb_face_names, ".gltf": glb_face_names,
    **dict.fromkeys((".usda", ".usdc", ".usd"), usd_face_names),
}  # fmt: skip
"""Functions that return the names of each face of a file, by its suffix."""
