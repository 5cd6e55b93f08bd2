# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The two layers of a garment that is modelled with a thickness, such as by Blender's modifier Solidify.

Such a mesh is the surface of a thin solid. Each face has a counterpart on the other side of the solid, which lies at
the same small distance everywhere, faces the other way, and belongs to the other layer. The rim that joins the layers
at a hem has no such counterpart. The layers are therefore the parts into which the mesh falls without its rims. The
front and the back of a garment that lies flat are not such layers: they are also joined at the sides, but the mesh is
open at hem and neck.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal, get_args

import numpy as np
from numpy.typing import NDArray

from stitchmesh.errors import ParameterError
from stitchmesh.mesh.connectivity import linked_groups
from stitchmesh.mesh.orientation import turn_inside_out
from stitchmesh.mesh.polygon_mesh import BORDER, FloatArray, IntArray, Mesh

Layer = Literal["outer", "inner", "middle"]
"""The layer that is knitted: one of the two, or the surface midway between them."""
TURNED_AWAY = 0.1
"""In the search for the face on the other side, this distance, over the size of the mesh, counts as much as a deviation
of the normal by a radian."""
THINNEST, THICKEST = 1e-4, 0.05
"""Thickness of a garment over the largest dimension of its mesh."""


@dataclass(frozen=True, eq=False)
class ParallelLayers:
    """The faces of two parallel layers of a mesh."""

    outer: IntArray
    """Faces of the larger layer, ascending, shape (n,)."""
    inner: IntArray
    """Faces of the smaller layer, ascending, shape (n,)."""
    thickness: float
    """Distance of the layers [cm]."""


def parallel_layers(mesh: Mesh) -> ParallelLayers | None:
    """Find the two layers of a garment with a thickness; None if the mesh has one layer.

    Args:
        mesh: a mesh without a lattice, whose faces point out of the solid.
    """
    from scipy.spatial import cKDTree

    area = np.linalg.norm(mesh.face_vector_area, axis=1)
    normal = mesh.face_vector_area / area[:, None]
    centre = np.add.reduceat(mesh.corner_position, mesh.face_start[:-1], axis=0) / np.diff(mesh.face_start)[:, None]
    size = float(np.ptp(mesh.vertices, axis=0).max())
    tree = cKDTree(np.concatenate([centre, TURNED_AWAY * size * normal], axis=1))
    across = tree.query(np.concatenate([centre, -TURNED_AWAY * size * normal], axis=1))[1]
    thickness = -np.einsum("fk,fk->f", centre[across] - centre, normal)
    # Below this cosine of the angle between their normals, two faces face opposite ways.
    faces_away = np.einsum("fk,fk->f", normal, normal[across]) < -0.7
    thin = faces_away & (thickness >= THINNEST * size) & (thickness <= THICKEST * size)
    if not thin.any():
        return None
    usual = float(np.median(thickness[thin]))
    # A thickness is even if it deviates from its median by at most half of it.
    thin &= np.abs(thickness - usual) <= 0.5 * usual
    # Most of the area of a mesh of two layers has another side at the distance of the thickness.
    if area[thin].sum() < 0.8 * area.sum():
        return None
    if _joined_at_sides(mesh, across, thin):
        return None
    part = _parts_without_rims(mesh, thin)
    sides = _two_sides(part, np.where(thin, part[across], -1), area)
    return None if sides is None else ParallelLayers(*sides, usual)


def layer_of(mesh: Mesh, layers: ParallelLayers, layer: Layer) -> Mesh:
    """Return one layer of a mesh as a mesh of its own, whose faces point outwards.

    The middle layer has the faces of the outer one, moved inwards by half the thickness.

    Raises:
        ParameterError: there is no layer of that name.
    """
    if layer not in get_args(Layer):
        raise ParameterError(f"layer: got {layer!r}; expected one of {', '.join(get_args(Layer))}")
    if layer == "inner":
        return turn_inside_out(_faces_alone(mesh, layers.inner))
    outer = _faces_alone(mesh, layers.outer)
    return outer if layer == "outer" else _moved_inwards(outer, layers.thickness / 2.0)


def _joined_at_sides(mesh: Mesh, across: IntArray, thin: NDArray[np.bool_]) -> bool:
    """Return whether most faces are connected to the face on their other side by an open surface."""
    inner = np.flatnonzero(mesh.twin != BORDER)
    whole = linked_groups(mesh.face_count, mesh.side_face[inner], mesh.side_face[mesh.twin[inner]])
    is_open = np.isin(whole, whole[mesh.side_face[mesh.twin == BORDER]])
    return bool(np.mean((is_open & (whole == whole[across]))[thin]) > 0.5)


def _parts_without_rims(mesh: Mesh, thin: NDArray[np.bool_]) -> IntArray:
    """Return the number of the part of each face, -1 on a rim, shape (F,).

    A face without another side belongs to the part that it touches; faces that touch several parts are a rim.
    """
    pairs = np.flatnonzero(mesh.twin > np.arange(mesh.side_count))
    one, other = mesh.side_face[pairs], mesh.side_face[mesh.twin[pairs]]
    within, beyond = thin[one] & thin[other], ~thin[one] & ~thin[other]
    part = linked_groups(mesh.face_count, one[within], other[within])
    group = linked_groups(mesh.face_count, one[beyond], other[beyond])
    beside: dict[int, set[int]] = {}
    for first, second in ((one, other), (other, one)):
        crossing = ~thin[first] & thin[second]
        for rim, touched in zip(group[first[crossing]].tolist(), part[second[crossing]].tolist(), strict=True):
            beside.setdefault(rim, set()).add(touched)
    for face in np.flatnonzero(~thin).tolist():
        touched_parts = beside.get(int(group[face]), set())
        part[face] = next(iter(touched_parts)) if len(touched_parts) == 1 else -1
    return part


def _two_sides(part: IntArray, across: IntArray, area: FloatArray) -> tuple[IntArray, IntArray] | None:
    """Divide the parts into the outer and the inner layer.

    Args:
        part: part of each face, -1 on a rim, shape (F,).
        across: part of the face on the other side of each face, -1 without one, shape (F,).
        area: area of each face [cm^2], shape (F,).

    Returns:
        The faces of the outer and of the inner layer: of each two parts that lie across each other, the larger part is
        outer. None if a part lies across itself, or if parts do not lie across each other in pairs.
    """
    parts = np.unique(part[part >= 0])
    seen = {int(number): across[(part == number) & (across >= 0)] for number in parts}
    opposite = {number: int(np.bincount(faces).argmax()) for number, faces in seen.items() if len(faces)}
    if any(opposite[number] == number or opposite.get(opposite[number]) != number for number in opposite):
        return None
    whole = {number: float(area[part == number].sum()) for number in opposite}
    larger = [number for number, other in opposite.items() if (whole[number], -number) > (whole[other], -other)]
    is_outer = np.isin(part, larger)
    return np.flatnonzero(is_outer), np.flatnonzero(~is_outer & (part >= 0))


def _faces_alone(mesh: Mesh, faces: IntArray) -> Mesh:
    """Return some faces of a mesh as a mesh of their own; they keep their order."""
    sides = mesh.sides_of(faces)
    used, corner = np.unique(mesh.face_vertex[sides], return_inverse=True)
    place = np.full(mesh.side_count, BORDER)
    place[sides] = np.arange(len(sides))
    twin = mesh.twin[sides]
    return Mesh(
        vertices=mesh.vertices[used],
        face_start=np.concatenate([[0], np.cumsum(np.diff(mesh.face_start)[faces])]),
        face_vertex=corner.reshape(-1),
        twin=np.where(twin == BORDER, BORDER, place[twin]),
    )


def _moved_inwards(mesh: Mesh, distance: float) -> Mesh:
    """Return a mesh with each vertex moved against the mean normal of its faces by a distance [cm]."""
    normal = np.zeros_like(mesh.vertices)
    np.add.at(normal, mesh.face_vertex, mesh.face_vector_area[mesh.side_face])
    length = np.linalg.norm(normal, axis=1, keepdims=True)
    moved = mesh.vertices - distance * normal / np.where(length > 0.0, length, 1.0)
    return Mesh(moved, mesh.face_start, mesh.face_vertex, mesh.twin)
