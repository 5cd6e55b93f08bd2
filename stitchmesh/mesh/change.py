# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""What an edit changes in a stitch mesh, as data with an exact inverse.

A ``Patch`` takes faces out and puts others in; ``Marks`` change numbers that faces or sides carry. Both know the
numbers of faces and vertices before and after, so a change and then its inverse restore every array to the last
bit, numbering included. Only what a change touches is checked; the rest of the mesh was valid before.
"""

from __future__ import annotations

from dataclasses import dataclass, fields
from typing import Any

import numpy as np

from stitchmesh.errors import MeshError
from stitchmesh.mesh.connectivity import check_fans
from stitchmesh.mesh.polygon_mesh import BORDER, FloatArray, IntArray, ranges
from stitchmesh.mesh.renumbering import Renumbering
from stitchmesh.mesh.stitch_mesh import PER_FACE, PER_SIDE, StitchMesh

UNKNOWN_STRETCH = np.nan
"""Stretch of an edge that no mesh relaxation has seen."""


@dataclass(frozen=True, eq=False)
class Marks:
    """Other numbers for some faces or sides."""

    name: str
    """Which of ``stitch``, ``row``, ``yarn`` (of faces), ``twist``, ``cable_shift`` or ``cable_layer`` (of sides)."""
    places: IntArray
    """Faces or sides, shape (n,)."""
    values: IntArray
    """Their numbers, shape (n,)."""


@dataclass(frozen=True, eq=False)
class Patch:
    """Faces and vertices that leave a stitch mesh, and those that come in their stead."""

    removed_faces: IntArray
    """Faces taken out, by their numbers before, ascending."""
    removed_vertices: IntArray
    """Vertices taken out, by their numbers before, ascending."""
    added_faces: IntArray
    """Numbers after of the faces put in, ascending, shape (n,)."""
    added_vertices: IntArray
    """Numbers after of the vertices put in, ascending, shape (m,)."""
    positions: FloatArray
    """Where they lie [cm], shape (m, 3)."""
    face_size: IntArray
    """Corners of each face put in, shape (n,)."""
    corners: IntArray
    """Vertex numbers after, of all corners of the faces put in, shape (c,)."""
    twin: IntArray
    """Side across each side put in, as (face after, place within it), (-1, -1) at a border, shape (c, 2)."""
    faces: dict[str, IntArray]
    """``PER_FACE`` fields of the faces put in."""
    sides: dict[str, IntArray]
    """``PER_SIDE`` fields of their sides."""
    stretch: FloatArray
    """Stretch at their sides, shape (c,); used where the mesh has a stretch."""


Change = Marks | Patch


def apply_change(fabric: StitchMesh, change: Change) -> StitchMesh:
    """The stitch mesh after a change.

    Raises:
        MeshError: the change does not fit this mesh, or the surface would not be an oriented manifold.
        LabelError: a face would not be a legal stitch face.
    """
    if fabric.lattice is not None:
        raise MeshError("change: the mesh repeats on a lattice; edit the chart that it was made from")
    return _marked(fabric, change) if isinstance(change, Marks) else _patched(fabric, change)


def inverse_change(fabric: StitchMesh, change: Change) -> Change:
    """What undoes a change once it has been applied to this stitch mesh."""
    if isinstance(change, Marks):
        return Marks(change.name, change.places, getattr(fabric, change.name)[change.places])
    sides = fabric.sides_of(change.removed_faces)
    across = fabric.twin[sides]
    twin = np.stack([fabric.side_face[across], fabric.side_place[across]], axis=1)
    twin[across == BORDER] = BORDER
    return Patch(
        removed_faces=change.added_faces,
        removed_vertices=change.added_vertices,
        added_faces=change.removed_faces,
        added_vertices=change.removed_vertices,
        positions=fabric.vertices[change.removed_vertices],
        face_size=np.diff(fabric.face_start)[change.removed_faces],
        corners=fabric.face_vertex[sides],
        twin=twin,
        faces={name: getattr(fabric, name)[change.removed_faces] for name in PER_FACE},
        sides={name: getattr(fabric, name)[sides] for name in PER_SIDE},
        stretch=stretch_at(fabric, sides),
    )


def stretch_at(fabric: StitchMesh, sides: IntArray) -> FloatArray:
    """Stretch of the edges of some sides, unknown where the mesh has none, shape (n,)."""
    if fabric.stretch is None:
        return np.full(len(sides), UNKNOWN_STRETCH)
    return fabric.stretch[fabric.side_edge[sides]]


def vertices_left(fabric: StitchMesh, removed: IntArray, corners: IntArray) -> IntArray:
    """Vertices of faces taken out that no other face uses and no corner of those put in, ascending."""
    left = fabric.face_vertex[fabric.sides_of(removed)]
    uses = np.bincount(fabric.face_vertex, minlength=len(fabric.vertices))
    uses -= np.bincount(left, minlength=len(fabric.vertices))
    uses[corners] += 1
    return np.unique(left[uses[left] == 0])


def _marked(fabric: StitchMesh, change: Marks) -> StitchMesh:
    values = {part.name: getattr(fabric, part.name) for part in fields(StitchMesh)}
    array = values[change.name].copy()
    bad = change.places[(change.places < 0) | (change.places >= len(array))]
    if len(bad):
        raise MeshError(f"change of {change.name}: place {bad[0]} is gone; expected 0 to {len(array) - 1}")
    array[change.places] = change.values
    result = _unchecked({**values, change.name: array})
    faces = change.places if change.name in PER_FACE else fabric.side_face[change.places]
    if len(faces):
        result.check_stitch_faces(np.unique(faces))
    return result


def _patched(fabric: StitchMesh, patch: Patch) -> StitchMesh:
    face = _numbering("face", fabric.face_count, patch.removed_faces, patch.added_faces)
    vertex = _numbering("vertex", len(fabric.vertices), patch.removed_vertices, patch.added_vertices)
    start = np.concatenate([[0], np.cumsum(face.merged(np.diff(fabric.face_start), patch.face_size))])
    kept, moved, put = fabric.sides_of(face.kept), ranges(start, face.moved), ranges(start, patch.added_faces)
    side = Renumbering(fabric.side_count, kept, moved, put)
    side_after = np.append(side.after, BORDER)  # its last entry is that of BORDER
    corner = side.merged(vertex.after[fabric.face_vertex], patch.corners)
    if corner.min(initial=0) < 0:
        raise MeshError("change: takes out a vertex that a face still uses; take out all faces around it")
    result = _unchecked({
        "vertices": vertex.merged(fabric.vertices, patch.positions),
        "face_start": start,
        "face_vertex": corner,
        "twin": _linked(side, side_after[fabric.twin], start, patch.twin),
        "lattice": None,
        "corner_image": None,
        "stretch": None,
        **{name: face.merged(getattr(fabric, name), patch.faces[name]) for name in PER_FACE},
        **{name: side.merged(getattr(fabric, name), patch.sides[name]) for name in PER_SIDE},
    })  # fmt: skip
    if fabric.stretch is not None:
        by_side = side.merged(stretch_at(fabric, np.arange(fabric.side_count)), patch.stretch)
        _set(result, "stretch", by_side[result.edge_side])
    lost = fabric.twin[fabric.sides_of(patch.removed_faces)]
    _check_touched(result, patch.added_faces, side_after[lost])
    return result


def _numbering(what: str, count: int, removed: IntArray, added: IntArray) -> Renumbering:
    """Numbers before and after of faces or vertices."""
    if len(removed) and (removed[0] < 0 or removed[-1] >= count):
        raise MeshError(f"change: {what} {removed[-1]} is gone; expected 0 to {count - 1}")
    return Renumbering.of(count, removed, added)


def _linked(side: Renumbering, kept: IntArray, start: IntArray, wanted: IntArray) -> IntArray:
    """Twins after: those that stay, and those of the sides put in, both ways."""
    at_border = wanted[:, 0] < 0
    across = np.where(at_border, BORDER, start[wanted[:, 0]] + wanted[:, 1])
    twin = side.merged(kept, across)
    twin[across[~at_border]] = side.added[~at_border]
    return twin


def _unchecked(values: dict[str, Any]) -> StitchMesh:
    """A stitch mesh whose maker checks what differs from a valid one."""
    result: StitchMesh = object.__new__(StitchMesh)
    for name, value in values.items():
        _set(result, name, value)
    return result


def _set(fabric: StitchMesh, name: str, value: Any) -> None:
    if isinstance(value, np.ndarray):
        value.setflags(write=False)
    object.__setattr__(fabric, name, value)


def _check_touched(fabric: StitchMesh, added: IntArray, freed: IntArray) -> None:
    """Check the faces put in and those beside them."""
    sides = np.concatenate([fabric.twin[fabric.sides_of(added)], freed])
    faces = np.unique(np.concatenate([added, fabric.side_face[sides[sides != BORDER]]]))
    fabric.check_vertices_used()
    if len(faces):
        fabric.check_polygons(faces)
        _check_fans(fabric, fabric.sides_of(faces))
        fabric.check_stitch_faces(faces)


def _check_fans(fabric: StitchMesh, sides: IntArray) -> None:
    """The faces around each vertex of some sides must form one fan."""
    touched = np.zeros(len(fabric.vertices), dtype=bool)
    touched[fabric.face_vertex[sides]] = True
    corners = np.flatnonzero(touched[fabric.face_vertex])
    place = np.full(fabric.side_count, BORDER)
    place[corners] = np.arange(len(corners))
    across = fabric.twin[corners]
    neighbour = np.where(across == BORDER, BORDER, place[fabric.side_next[across]])
    check_fans(fabric.face_vertex[corners], neighbour, len(fabric.vertices))
