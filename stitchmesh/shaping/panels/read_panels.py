# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Reading of sewing patterns: the panels of an OBJ file with texture coordinates or groups.

A seam is an edge whose two faces use different texture vertices, so that it is a border in the flat pattern. Some
programs write the two sides of a seam with common vertices (Blender), some with separate vertices (Marvelous Designer,
CLO), and some repeat the vertices or texture vertices for each face. The panels are the same in all these cases.
Without texture coordinates the panels are the objects, groups and materials of the file, and seams are borders that lie
on each other in space.
"""

from __future__ import annotations

from os import fspath

import numpy as np

from stitchmesh.errors import FileError, MeshError
from stitchmesh.io.contents import FilePath, suffix_of
from stitchmesh.io.mesh_formats.obj_texture import ObjTexture, read_obj_texture
from stitchmesh.io.units import DEFAULT_UNIT, centimetres
from stitchmesh.mesh import BORDER, FloatArray, IntArray, Mesh
from stitchmesh.mesh.connectivity import corner_fans, find_twins, linked_groups, next_sides
from stitchmesh.mesh.polygon_mesh import connected_faces
from stitchmesh.mesh.upright import Direction, Y, upright_turn
from stitchmesh.shaping.panels.panel_mesh import PanelMesh, Seam

NEAR = 1e-3
"""Distance of two vertices on borders, over the mean length of a border side, up to which they are at one place. The
two sides of a seam are written with rounded coordinates."""


def find_seams(mesh: Mesh, face_panel: IntArray) -> tuple[Seam, ...]:
    """Find the seams of a mesh that is cut along them.

    Two border sides are sewn if their vertices lie at equal places up to ``NEAR``, in opposite order. Where three or
    more panels meet along one line, nothing is sewn.

    Args:
        mesh: the panels.
        face_panel: panel of each face, shape (F,).
    """
    across = _sides_across(mesh)
    used = across == BORDER
    seams = []
    for start in _line_starts(mesh, across):
        line: list[int] = []
        side = start
        while not used[side]:
            line.append(side)
            used[[side, across[side]]] = True
            side = _next_on_seam(mesh, across, side)
        if line:
            seams.append(_seam(mesh, face_panel, np.array(line), across[line]))
    return tuple(seams)


def _sides_across(mesh: Mesh) -> IntArray:
    """The border side that lies on each border side in the opposite direction, ``BORDER`` if none does, shape (C,)."""
    border = np.flatnonzero(mesh.twin == BORDER)
    ends = _places(mesh, np.stack([mesh.face_vertex[border], mesh.face_vertex[mesh.side_next[border]]], axis=1))
    _, line, count = np.unique(np.sort(ends, axis=1), axis=0, return_inverse=True, return_counts=True)
    line = line.reshape(-1)
    order = np.argsort(line, kind="stable")
    pairs = order[np.isin(line[order], np.flatnonzero(count == 2))].reshape(-1, 2)
    pairs = pairs[ends[pairs[:, 0], 0] == ends[pairs[:, 1], 1]]
    across = np.full(mesh.side_count, BORDER)
    across[border[pairs[:, 0]]], across[border[pairs[:, 1]]] = border[pairs[:, 1]], border[pairs[:, 0]]
    return across


def _places(mesh: Mesh, ends: IntArray) -> IntArray:
    """Number of the place of each end of some sides, shape (n, 2); vertices that are near each other share a place."""
    from scipy.spatial import cKDTree

    own, end = np.unique(ends, return_inverse=True)
    points = mesh.vertices[own]
    length = np.linalg.norm(mesh.vertices[ends[:, 1]] - mesh.vertices[ends[:, 0]], axis=1)
    pairs = cKDTree(points).query_pairs(NEAR * float(length.mean()), output_type="ndarray") if len(own) else ends
    return linked_groups(len(own), pairs[:, 0], pairs[:, 1])[end.reshape(-1, 2)]


def _line_starts(mesh: Mesh, across: IntArray) -> list[int]:
    """Sides at which seams may begin: first the sides that no other side precedes, then all others for closed seams."""
    sewn = np.flatnonzero(across != BORDER).tolist()
    follows = {_next_on_seam(mesh, across, side) for side in sewn}
    return [*(side for side in sewn if side not in follows), *sewn]


def _next_on_seam(mesh: Mesh, across: IntArray, side: int) -> int:
    """The next border side if it continues the seam of a side; else the side itself.

    A seam ends where another panel begins on either side, and at the tip of a dart.
    """
    following = mesh.next_border_side(side)
    beyond = int(across[following])
    goes_on = beyond not in (BORDER, side) and mesh.next_border_side(beyond) == across[side]
    return following if goes_on else side


def _seam(mesh: Mesh, face_panel: IntArray, sides: IntArray, across: IntArray) -> Seam:
    tail, head = mesh.face_vertex, mesh.face_vertex[mesh.side_next]
    first, second = np.append(tail[sides], head[sides[-1]]), np.append(head[across], tail[across[-1]])
    panels = face_panel[mesh.side_face[[sides[0], across[0]]]].tolist()
    return Seam((panels[0], panels[1]), first, second)


def read_panels(path: FilePath, *, unit: str = DEFAULT_UNIT, up: Direction = Y) -> PanelMesh:
    """Read the panels of a sewing pattern, and find its seams.

    Panels are numbered in the order of their first faces. If the file has no texture coordinates, its objects, groups
    and materials are the panels, and their texture is the panel seen from outside, with the second axis of space up.

    Args:
        path: an ``.obj`` file with texture coordinates, or with groups.
        unit: unit of the coordinates in the file: mm, cm, dm, m or inch. Texture coordinates may have any unit.
        up: direction in the coordinates of the file that points up.

    Returns:
        The panels in centimetres, cut along their seams.

    Raises:
        ParameterError: the unit is unknown, or the direction is zero or not finite.
        FileError: the file cannot be read or is malformed, or has neither texture coordinates nor groups.
        MeshError: the polygons do not form oriented surfaces.
    """
    suffix_of(path, [".obj"])
    scale = centimetres(unit)
    read = read_obj_texture(path)
    if not read.texture and len(set(read.group)) < 2:
        found = f"{fspath(path)}: has no texture coordinates (vt) and no groups (o, g, usemtl)"
        raise FileError(f"{found}; export the garment with the texture coordinates of its pattern")
    try:
        return _panels(read, scale * upright_turn(up))
    except MeshError as error:
        raise MeshError(f"{fspath(path)}: {error}") from error


def _panels(read: ObjTexture, transform: FloatArray) -> PanelMesh:
    """Cut the polygons where texture vertices or groups change; ``transform`` acts on points as columns."""
    second = read.face_texture or _group_numbers(read)
    start = np.concatenate([[0], np.cumsum([len(face) for face in read.faces])])
    vertex, other = (np.array([v for face in faces for v in face]) for faces in (read.faces, second))
    points, texture = np.array(read.vertices), np.array(read.texture).reshape(-1, 2)
    if read.texture:
        # The texture shows which faces are joined; the vertices do not, because a program may repeat them for each
        # face.
        vertex = _equal_rows(points)[vertex]
        other = other if _is_shared(start, other) else _equal_rows(texture)[other]
    mesh, corner_vertex = _cut_mesh(points @ transform.T, start, vertex, other)
    face_panel = connected_faces(mesh)
    if read.texture:
        own = np.zeros((len(mesh.vertices), 2))
        own[corner_vertex] = texture[other]
    else:
        own = _texture_seen_from_outside(mesh, face_panel)
    first = np.unique(face_panel, return_index=True)[1].tolist()
    names = tuple(tuple(filter(None, read.group[face])) for face in first)
    return PanelMesh(mesh, own, face_panel, find_seams(mesh, face_panel), names=names)


def _equal_rows(rows: FloatArray) -> IntArray:
    """Number of the first row that is equal to each row, shape (n,)."""
    _, first, place = np.unique(rows, axis=0, return_index=True, return_inverse=True)
    return first[place.reshape(-1)]


def _is_shared(start: IntArray, other: IntArray) -> bool:
    """Whether two faces share some texture vertex; ``_cut_mesh`` explains ``start`` and ``other``."""
    face = np.repeat(np.arange(len(start) - 1), np.diff(start))
    return len(np.unique(np.stack([face, other], axis=1), axis=0)) > len(np.unique(other))


def _group_numbers(read: ObjTexture) -> list[list[int]]:
    """The number of the group of each face, at each of its corners."""
    number = {name: place for place, name in enumerate(dict.fromkeys(read.group))}
    return [[number[name]] * len(face) for name, face in zip(read.group, read.faces, strict=True)]


def _cut_mesh(points: FloatArray, start: IntArray, vertex: IntArray, other: IntArray) -> tuple[Mesh, IntArray]:
    """Make a mesh in which corners share a vertex if both their numbers agree and their faces are joined by edges.

    Args:
        points: positions [cm], shape (n, 3).
        start: first corner of each face, and their number at the end, shape (F + 1,).
        vertex: vertex of each corner, shape (C,).
        other: texture vertex or group of each corner, shape (C,).

    Returns:
        The mesh, and the vertex of each corner, shape (C,).
    """
    pair = np.unique(np.stack([vertex, other], axis=1), axis=0, return_inverse=True)[1].reshape(-1)
    twin = find_twins(start, pair, int(pair.max()) + 1)
    fan = corner_fans(twin, next_sides(start))
    vertices = np.zeros((int(fan.max()) + 1, 3))
    vertices[fan] = points[vertex]
    return Mesh(vertices, start, fan, twin), fan


def _texture_seen_from_outside(mesh: Mesh, face_panel: IntArray) -> FloatArray:
    """Positions in the mean plane of the panels: to the right and upwards, or along a level panel [cm], (V, 2)."""
    texture = np.zeros((len(mesh.vertices), 2))
    for panel in range(int(face_panel.max()) + 1):
        faces = face_panel == panel
        normal = mesh.face_vector_area[faces].sum(axis=0)
        normal = normal / max(float(np.linalg.norm(normal)), np.finfo(np.float64).tiny)
        upwards = np.array([0.0, 1.0, 0.0]) - normal[1] * normal
        # Cosine of the angle between a panel and the vertical below which the panel lies level.
        if np.linalg.norm(upwards) < 0.3:
            upwards = np.array([0.0, 0.0, -1.0]) + normal[2] * normal
        upwards = upwards / np.linalg.norm(upwards)
        own = np.unique(mesh.face_vertex[faces[mesh.side_face]])
        texture[own] = mesh.vertices[own] @ np.stack([np.cross(upwards, normal), upwards], axis=1)
    return texture
