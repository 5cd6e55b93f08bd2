# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Changes of a stitch mesh, as data with an exact inverse.

A ``Patch`` removes faces and adds other faces. ``Marks`` change numbers of faces or sides. Both store the numbers of
faces and vertices before and after the change. A ``PaletteChange`` replaces the colours of the yarns, and an
``OwnStitchesChange`` the stitches of the user's own. A change followed by its inverse therefore restores every array to
the last bit, numbering included. Only the changed faces and their neighbours are checked, because the rest of the mesh
was valid before the change.
"""

from __future__ import annotations

from dataclasses import dataclass, fields, replace
from typing import Any

import numpy as np

from stitchmesh.errors import MeshError
from stitchmesh.mesh.connectivity import check_fans
from stitchmesh.mesh.own_stitch import OwnStitch
from stitchmesh.mesh.palette import Palette, checked_palette
from stitchmesh.mesh.polygon_mesh import BORDER, FloatArray, IntArray, ranges
from stitchmesh.mesh.renumbering import Renumbering
from stitchmesh.mesh.stitch_mesh import PER_FACE, PER_SIDE, StitchMesh

UNKNOWN_STRETCH = np.nan
"""Stretch of an edge that was added after the mesh relaxation."""


@dataclass(frozen=True, eq=False)
class Marks:
    """New numbers for some faces or sides."""

    name: str
    """Field that changes: ``stitch``, ``row`` or ``yarn`` (of faces), or a name of ``PER_SIDE`` (of sides)."""
    places: IntArray
    """Faces or sides that change, shape (n,)."""
    values: IntArray
    """New numbers of these faces or sides, shape (n,)."""


@dataclass(frozen=True, eq=False)
class Patch:
    """Faces and vertices that are removed from a stitch mesh, and faces and vertices that are added.

    n, m and c below are the numbers of added faces, of added vertices and of corners of added faces.
    """

    removed_faces: IntArray
    """Numbers of the removed faces before the change, ascending."""
    removed_vertices: IntArray
    """Numbers of the removed vertices before the change, ascending."""
    added_faces: IntArray
    """Numbers of the added faces after the change, ascending, shape (n,)."""
    added_vertices: IntArray
    """Numbers of the added vertices after the change, ascending, shape (m,)."""
    positions: FloatArray
    """Positions of the added vertices [cm], shape (m, 3)."""
    face_size: IntArray
    """Number of corners of each added face, shape (n,)."""
    corners: IntArray
    """Vertex of each corner of the added faces, by its number after the change, shape (c,)."""
    twin: IntArray
    """Twin of each added side: its face after the change and its place in the face, or (-1, -1), shape (c, 2)."""
    faces: dict[str, IntArray]
    """``PER_FACE`` fields of the added faces, shape (n,) each."""
    sides: dict[str, IntArray]
    """``PER_SIDE`` fields of the sides of the added faces, shape (c,) each."""
    stretch: FloatArray
    """Stretch at the sides of the added faces, shape (c,); used only if the mesh has a stretch."""


@dataclass(frozen=True, eq=False)
class PaletteChange:
    """New colours of the yarns."""

    palette: Palette
    """The new palette (sRGB), shape (P, 3)."""


@dataclass(frozen=True, eq=False)
class OwnStitchesChange:
    """New stitches of the user's own; stitches that faces use keep their places."""

    own_stitches: tuple[OwnStitch, ...]
    """The new ``StitchMesh.own_stitches``."""


Change = Marks | Patch | PaletteChange | OwnStitchesChange


def apply_change(fabric: StitchMesh, change: Change) -> StitchMesh:
    """Return the stitch mesh after a change.

    Raises:
        MeshError: the mesh has a lattice, the change does not fit this mesh, or the surface would not be an oriented
            manifold.
        LabelError: a face would not be a legal stitch face.
    """
    if fabric.lattice is not None:
        raise MeshError("change: the mesh repeats on a lattice; edit the chart from which the mesh was made")
    if isinstance(change, PaletteChange):
        return _apply_palette(fabric, change)
    if isinstance(change, OwnStitchesChange):
        return replace(fabric, own_stitches=change.own_stitches)
    return _apply_marks(fabric, change) if isinstance(change, Marks) else _apply_patch(fabric, change)


def inverse_change(fabric: StitchMesh, change: Change) -> Change:
    """Return the change that restores this stitch mesh after ``change`` has been applied to it."""
    if isinstance(change, Marks):
        return Marks(change.name, change.places, getattr(fabric, change.name)[change.places])
    if isinstance(change, PaletteChange):
        return PaletteChange(fabric.palette)
    if isinstance(change, OwnStitchesChange):
        return OwnStitchesChange(fabric.own_stitches)
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
    """Return the stretch of the edges of some sides, ``UNKNOWN_STRETCH`` if the mesh has no stretch, shape (n,)."""
    if fabric.stretch is None:
        return np.full(len(sides), UNKNOWN_STRETCH)
    return fabric.stretch[fabric.side_edge[sides]]


def vertices_left(fabric: StitchMesh, removed: IntArray, corners: IntArray) -> IntArray:
    """Find the vertices of removed faces that no remaining and no added face uses, ascending.

    Args:
        fabric: stitch mesh before the change.
        removed: removed faces.
        corners: vertices of the corners of the added faces that exist before the change.
    """
    left = fabric.face_vertex[fabric.sides_of(removed)]
    uses = np.bincount(fabric.face_vertex, minlength=len(fabric.vertices))
    uses -= np.bincount(left, minlength=len(fabric.vertices))
    uses[corners] += 1
    return np.unique(left[uses[left] == 0])


def _apply_palette(fabric: StitchMesh, change: PaletteChange) -> StitchMesh:
    values = {part.name: getattr(fabric, part.name) for part in fields(StitchMesh)}
    return _unchecked({**values, "palette": checked_palette(change.palette, MeshError)})


def _apply_marks(fabric: StitchMesh, change: Marks) -> StitchMesh:
    values = {part.name: getattr(fabric, part.name) for part in fields(StitchMesh)}
    array = values[change.name].copy()
    bad = change.places[(change.places < 0) | (change.places >= len(array))]
    if len(bad):
        kind = "face" if change.name in PER_FACE else "side"
        raise MeshError(f"change of {change.name}: there is no {kind} {bad[0]}; expected 0 to {len(array) - 1}")
    array[change.places] = change.values
    result = _unchecked({**values, change.name: array})
    faces = change.places if change.name in PER_FACE else fabric.side_face[change.places]
    if len(faces):
        result.check_stitch_faces(np.unique(faces))
    return result


def _apply_patch(fabric: StitchMesh, patch: Patch) -> StitchMesh:
    face = _numbering("face", fabric.face_count, patch.removed_faces, patch.added_faces)
    vertex = _numbering("vertex", len(fabric.vertices), patch.removed_vertices, patch.added_vertices)
    start = np.concatenate([[0], np.cumsum(face.merged(np.diff(fabric.face_start), patch.face_size))])
    kept, moved, added = fabric.sides_of(face.kept), ranges(start, face.moved), ranges(start, patch.added_faces)
    side = Renumbering(fabric.side_count, kept, moved, added)
    side_after = np.append(side.after, BORDER)  # The last entry is indexed by BORDER = -1.
    corner = side.merged(vertex.after[fabric.face_vertex], patch.corners)
    if corner.min(initial=0) < 0:
        raise MeshError("change: removes a vertex that a face still uses; remove all faces around the vertex")
    result = _unchecked({
        "vertices": vertex.merged(fabric.vertices, patch.positions),
        "face_start": start,
        "face_vertex": corner,
        "twin": _merge_twins(side, side_after[fabric.twin], start, patch.twin),
        "lattice": None,
        "corner_image": None,
        "stretch": None,
        "palette": fabric.palette,
        "own_stitches": fabric.own_stitches,
        **{name: face.merged(getattr(fabric, name), patch.faces[name]) for name in PER_FACE},
        **{name: side.merged(getattr(fabric, name), patch.sides[name]) for name in PER_SIDE},
    })  # fmt: skip
    if fabric.stretch is not None:
        by_side = side.merged(stretch_at(fabric, np.arange(fabric.side_count)), patch.stretch)
        _set(result, "stretch", by_side[result.edge_side])
    beside_removed = fabric.twin[fabric.sides_of(patch.removed_faces)]
    _check_changed(result, patch.added_faces, side_after[beside_removed])
    return result


def _numbering(what: str, count: int, removed: IntArray, added: IntArray) -> Renumbering:
    """Return the numbers of faces or vertices before and after a patch."""
    if len(removed) and (removed[0] < 0 or removed[-1] >= count):
        raise MeshError(f"change: there is no {what} {removed[-1]}; expected 0 to {count - 1}")
    return Renumbering.of(count, removed, added)


def _merge_twins(side: Renumbering, kept: IntArray, start: IntArray, added: IntArray) -> IntArray:
    """Return the twin of each side after a patch, set on both sides of each edge of the added faces.

    Args:
        side: numbers of the sides before and after.
        kept: twin after the patch of each side before the patch.
        start: first corner of each face after the patch.
        added: ``Patch.twin``.
    """
    at_border = added[:, 0] < 0
    across = np.where(at_border, BORDER, start[added[:, 0]] + added[:, 1])
    twin = side.merged(kept, across)
    twin[across[~at_border]] = side.added[~at_border]
    return twin


def _unchecked(values: dict[str, Any]) -> StitchMesh:
    """Build a stitch mesh without the checks of its constructor; the caller checks the parts that have changed."""
    result: StitchMesh = object.__new__(StitchMesh)
    for name, value in values.items():
        _set(result, name, value)
    return result


def _set(fabric: StitchMesh, name: str, value: Any) -> None:
    if isinstance(value, np.ndarray):
        value.setflags(write=False)
    object.__setattr__(fabric, name, value)


def _check_changed(fabric: StitchMesh, added: IntArray, beside_removed: IntArray) -> None:
    """Check the added faces and the neighbours of added and removed faces.

    Args:
        fabric: stitch mesh after the patch.
        added: added faces.
        beside_removed: sides across the sides of the removed faces, ``BORDER`` where there is none.
    """
    sides = np.concatenate([fabric.twin[fabric.sides_of(added)], beside_removed])
    faces = np.unique(np.concatenate([added, fabric.side_face[sides[sides != BORDER]]]))
    fabric.check_vertices_used()
    if len(faces):
        fabric.check_polygons(faces)
        _check_fans(fabric, fabric.sides_of(faces))
        fabric.check_stitch_faces(faces)


def _check_fans(fabric: StitchMesh, sides: IntArray) -> None:
    """Check that the faces around the first vertex of each given side form one fan."""
    checked = np.zeros(len(fabric.vertices), dtype=bool)
    checked[fabric.face_vertex[sides]] = True
    corners = np.flatnonzero(checked[fabric.face_vertex])
    place = np.full(fabric.side_count, BORDER)
    place[corners] = np.arange(len(corners))
    across = fabric.twin[corners]
    neighbour = np.where(across == BORDER, BORDER, place[fabric.side_next[across]])
    check_fans(fabric.face_vertex[corners], neighbour, len(fabric.vertices))
