# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""A cloth from an OBJ mesh whose texture coordinates are its rest shape.

Triangles that share an edge and both of its texture coordinates belong to the same island; each island is a panel. The
seams are the edges at which two triangles meet with different texture coordinates, also where a panel meets itself. The
length of a texture unit is given, or chosen so that the median edge has the same length in space and at rest. An island
that lies in the texture as its mirror image is mirrored back, so that its front is outside.

``read_textured_obj`` reads the ``v``, ``vt`` and ``f`` lines of a Wavefront OBJ file. Every corner of a face needs a
texture coordinate, as ``v/vt`` or ``v/vt/vn``. Polygons are divided into triangles by their ears. Texture coordinates
with the same numbers are one coordinate, whatever their indices are.
"""

from __future__ import annotations

import math
from collections import defaultdict
from dataclasses import dataclass, field, replace
from itertools import pairwise
from os import fspath

import numpy as np
from numpy.typing import NDArray

from stitchmesh.errors import FileError, ParameterError
from stitchmesh.io.contents import FilePath, is_coordinate, read_lines, suffix_of
from stitchmesh.io.obj_elements import element_lines, vertex_index, vertex_position
from stitchmesh.io.units import centimetres
from stitchmesh.mesh import BORDER, FloatArray, IntArray
from stitchmesh.mesh.connectivity import find_twins
from stitchmesh.mesh.face_triangles import clip_ears
from stitchmesh.mixed.cloth.cloth import SMALLEST_AREA, Cloth, signed_areas
from stitchmesh.mixed.cloth.outline import first_crossing


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


def cloth_from_obj(
    path: FilePath, *, unit: str = "cm", texture_unit: float | None = None, seam_angle: float = 0.0,
    weld: float | None = None,
) -> Cloth:  # fmt: skip
    """Read a cloth from an OBJ file.

    Args:
        path: an ``.obj`` file in which every face has texture coordinates.
        unit: unit of the positions in the file.
        texture_unit: length of a unit of the texture [cm]; if it is None, the median edge decides.
        seam_angle: angle of all seams at rest [degrees], positive on a ridge seen from outside.
        weld: distance below which two vertices become one [cm]. Many programs write the vertices of a seam once for
            each island; without a distance such islands are not joined.

    Raises:
        FileError: the file cannot be read or has no texture coordinates (``read_textured_obj``), a triangle has no area
            in the texture, triangles of one island are turned both ways, or the border of an island crosses itself.
        MeshError: the triangles are not an oriented manifold surface.
        ParameterError: the unit is unknown, a length is not positive, or the angle is not finite.
    """
    if weld is not None and not (math.isfinite(weld) and weld > 0.0):
        raise ParameterError(f"weld: got {weld}; expected a positive number of cm")
    if texture_unit is not None and not (math.isfinite(texture_unit) and texture_unit > 0.0):
        raise ParameterError(f"texture unit: got {texture_unit}; expected a positive number of cm")
    if not math.isfinite(seam_angle):
        raise ParameterError(f"seam angle: got {seam_angle}; expected a finite number of degrees")
    mesh = read_textured_obj(path, unit=unit)
    mesh = mesh if weld is None else _welded(mesh, weld)
    twin = find_twins(3 * np.arange(len(mesh.triangles) + 1), mesh.triangles.ravel(), len(mesh.vertices))
    joined = _joined_in_texture(mesh, twin)
    panel, count = _islands(twin, joined)
    rest = _mirrored_back(mesh, panel, count) * (texture_unit or _median_scale(mesh))
    _check_borders(mesh, rest, panel, joined)
    seams = _seams(mesh, twin, joined, panel)
    return Cloth(
        vertices=mesh.vertices,
        triangles=mesh.triangles,
        rest=rest,
        panel=panel,
        panel_names=tuple(f"island {number}" for number in range(count)),
        seam_edges=np.concatenate([np.zeros((0, 2)), *seams]),
        seam_start=np.concatenate([[0], np.cumsum([len(edges) for edges in seams])]),
        seam_angle=np.full(len(seams), math.radians(seam_angle)),
    )


def _welded(mesh: TexturedTriangles, distance: float) -> TexturedTriangles:
    """Merge vertices that are nearer than a distance into one vertex, at the place of the first one."""
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import connected_components
    from scipy.spatial import cKDTree

    one, other = cKDTree(mesh.vertices).query_pairs(distance, output_type="ndarray").T
    count = len(mesh.vertices)
    group = connected_components(coo_array((np.ones(len(one)), (one, other)), shape=(count, count)), directed=False)[1]
    _, first, number = np.unique(group, return_index=True, return_inverse=True)
    return replace(mesh, vertices=mesh.vertices[first], triangles=number[mesh.triangles])


def _joined_in_texture(mesh: TexturedTriangles, twin: IntArray) -> NDArray[np.bool_]:
    """Whether each side has a twin with the same texture coordinates, shape (3 T,)."""
    start, end = mesh.texture_corners.ravel(), np.roll(mesh.texture_corners, -1, axis=1).ravel()
    joined: NDArray[np.bool_] = (twin != BORDER) & (start == end[twin]) & (end == start[twin])
    return joined


def _islands(twin: IntArray, joined: NDArray[np.bool_]) -> tuple[IntArray, int]:
    """Island of each triangle, in order of their first triangles, and their number."""
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import connected_components

    sides = np.flatnonzero(joined)
    count = len(twin) // 3
    graph = coo_array((np.ones(len(sides)), (sides // 3, twin[sides] // 3)), shape=(count, count))
    number, island = connected_components(graph, directed=False)
    _, first = np.unique(island, return_index=True)
    rank = np.empty(number, dtype=np.int64)
    rank[np.argsort(first)] = np.arange(number)
    return rank[island], int(number)


def _mirrored_back(mesh: TexturedTriangles, panel: IntArray, count: int) -> FloatArray:
    """Texture coordinates of the corners of each triangle, anticlockwise, shape (T, 3, 2)."""
    corners: FloatArray = mesh.texture[mesh.texture_corners]
    area = signed_areas(corners)
    longest = ((np.roll(corners, -1, axis=1) - corners) ** 2).sum(axis=2).max(axis=1)
    bad = np.flatnonzero(np.abs(area) <= SMALLEST_AREA * longest)
    if len(bad):
        raise FileError(
            f"{mesh.path}: line {mesh.line[bad[0]]}: a triangle has no area in the texture; expected three corners "
            "that are not on one line; unwrap the mesh again"
        )
    turned = np.bincount(panel, weights=area, minlength=count) < 0.0
    bad = np.flatnonzero((area < 0.0) != turned[panel])
    if len(bad):
        raise FileError(
            f"{mesh.path}: line {mesh.line[bad[0]]}: a triangle is turned over in the texture, unlike most of island "
            f"{panel[bad[0]]}; expected all triangles of an island turned one way; unwrap the mesh again"
        )
    corners[..., 0] *= np.where(turned, -1.0, 1.0)[panel][:, None]
    return corners


def _median_scale(mesh: TexturedTriangles) -> float:
    """Length of a texture unit at which the median edge has the same length in space and in the texture [cm]."""
    lengths = [
        np.linalg.norm(np.roll(points[corners], -1, axis=1) - points[corners], axis=2)
        for points, corners in ((mesh.vertices, mesh.triangles), (mesh.texture, mesh.texture_corners))
    ]
    scale = float(np.median(lengths[0] / lengths[1]))
    if not scale > 0.0:
        raise FileError(f"{mesh.path}: most edges have no length in space; expected a mesh with an extent")
    return scale


def _check_borders(mesh: TexturedTriangles, rest: FloatArray, panel: IntArray, joined: NDArray[np.bool_]) -> None:
    """Check that no island overlaps itself."""
    ends = np.stack([rest, np.roll(rest, -1, axis=1)], axis=2).reshape(-1, 2, 2)
    border = np.flatnonzero(~joined)
    for number in np.unique(panel).tolist():
        sides = border[panel[border // 3] == number]
        crossing = first_crossing(ends[sides, 0], ends[sides, 1])
        if crossing is not None:
            lines = [mesh.line[sides[side] // 3] for side in crossing]
            raise FileError(
                f"{mesh.path}: island {number}: its border crosses or touches itself at the faces of lines {lines[0]} "
                f"and {lines[1]}; expected an island that does not overlap itself; unwrap the mesh again"
            )


def _seams(mesh: TexturedTriangles, twin: IntArray, joined: NDArray[np.bool_], panel: IntArray) -> list[IntArray]:
    """Edges of each seam in order along it, shape (n, 2), forwards along the panel with the lower number."""
    start, end = mesh.triangles.ravel(), np.roll(mesh.triangles, -1, axis=1).ravel()
    sides = np.flatnonzero((twin != BORDER) & ~joined)
    sides = sides[(panel[sides // 3] < panel[twin[sides] // 3])
                  | ((panel[sides // 3] == panel[twin[sides] // 3]) & (sides < twin[sides]))]  # fmt: skip
    pairs = np.stack([panel[sides // 3], panel[twin[sides] // 3]], axis=1)
    seams: list[IntArray] = []
    for pair in np.unique(pairs, axis=0).tolist():
        own = sides[(pairs == pair).all(axis=1)]
        forwards = {(int(start[side]), int(end[side])) for side in own}
        for chain in _chains(sorted(forwards)):
            edges = list(pairwise(chain))
            if edges[0] not in forwards:
                edges = [(other, one) for one, other in reversed(edges)]
            seams.append(np.array(edges))
    return seams


def _chains(edges: list[tuple[int, int]]) -> list[list[int]]:
    """Vertices of the longest chains of edges that do not branch; a closed chain ends where it begins."""
    beside: dict[int, list[int]] = defaultdict(list)
    for one, other in edges:
        beside[one].append(other)
        beside[other].append(one)
    ends = [vertex for vertex, others in beside.items() if len(others) != 2]
    left = set(edges)
    chains = []
    for first in [*ends, *beside]:
        for second in beside[first]:
            chain = [first]
            following = second
            while _take(left, chain[-1], following):
                chain.append(following)
                if following == first or len(beside[following]) != 2:
                    break
                following = next(vertex for vertex in beside[following] if vertex != chain[-2])
            if len(chain) > 1:
                chains.append(chain)
    return chains


def _take(left: set[tuple[int, int]], one: int, other: int) -> bool:
    """Remove an edge from the edges that are left, and return whether it was there."""
    for edge in ((one, other), (other, one)):
        if edge in left:
            left.remove(edge)
            return True
    return False
