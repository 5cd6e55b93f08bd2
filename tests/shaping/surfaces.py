# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Surfaces of triangles that tests of shaping share."""

from __future__ import annotations

from itertools import pairwise

import numpy as np

from stitchmesh.mesh import Mesh
from stitchmesh.mesh.face_triangles import face_triangles
from stitchmesh.shaping.triangle_surface import TriangleSurface


def in_triangles(mesh: Mesh) -> Mesh:
    """The same surface without quads, so that nothing is left of modelled rows."""
    return Mesh.from_polygons(mesh.vertices, mesh.face_vertex[face_triangles(mesh).corners].tolist())


def surface_of(mesh: Mesh) -> TriangleSurface:
    return TriangleSurface(mesh.vertices, mesh.face_vertex[face_triangles(mesh).corners])


def ring_torus(around: int, along: int, ring: float = 8.0, tube: float = 3.0) -> Mesh:
    """A closed torus that stands on its edge."""
    u, v = np.meshgrid(2 * np.pi * np.arange(along) / along, 2 * np.pi * np.arange(around) / around, indexing="ij")
    far = ring + tube * np.cos(v)
    points = np.stack([far * np.cos(u), far * np.sin(u), tube * np.sin(v)], axis=2).reshape(-1, 3)
    place = np.arange(along * around).reshape(along, around)
    right, up = np.roll(place, -1, axis=0), np.roll(place, -1, axis=1)
    both = np.roll(right, -1, axis=1)
    faces = np.stack([place, right, both, up], axis=2).reshape(-1, 4)
    return in_triangles(Mesh.from_polygons(points, faces.tolist()))


def closed_ball(around: int, rows: int, radius: float = 5.0) -> Mesh:
    """A closed sphere of triangles; its longest axis is that of y because it is a little longer."""
    angle = np.pi * np.arange(1, rows) / rows
    turn = 2 * np.pi * np.arange(around) / around
    rings = [np.stack([radius * np.sin(a) * np.sin(turn), np.full(around, -1.2 * radius * np.cos(a)),
                       radius * np.sin(a) * np.cos(turn)], axis=1) for a in angle]  # fmt: skip
    points = np.concatenate([*rings, [[0.0, -1.2 * radius, 0.0], [0.0, 1.2 * radius, 0.0]]])
    low, high = len(points) - 2, len(points) - 1
    faces = [[low, (c + 1) % around, c] for c in range(around)]
    top = (rows - 2) * around
    faces += [[high, top + c, top + (c + 1) % around] for c in range(around)]
    for row in range(rows - 2):
        for c in range(around):
            a, b = row * around + c, row * around + (c + 1) % around
            faces += [[a, b, b + around], [a, b + around, a + around]]
    return Mesh.from_polygons(points, faces)


def sheet(drawing: str, cell: float) -> Mesh:
    """A flat sheet of triangles in the plane z = 0: a square of some size for each # of a drawing [cm]."""
    lines = drawing.split()[::-1]
    corners = [(x, y) for y, line in enumerate(lines) for x, sign in enumerate(line) if sign == "#"]
    places = sorted({(x + right, y + up) for x, y in corners for right in (0, 1) for up in (0, 1)})
    number = {place: vertex for vertex, place in enumerate(places)}
    faces = [[number[x + a, y + b] for a, b in ((0, 0), (1, 0), (1, 1), (0, 1))] for x, y in corners]
    points = cell * np.array([(x, y, 0.0) for x, y in places])
    return in_triangles(Mesh.from_polygons(points, faces))


def double_sheet(drawing: str, cell: float, thickness: float) -> Mesh:
    """The two sides of a drawing, joined at its outline and around its holes, and open below and above [cm]."""
    lines = drawing.split()[::-1]
    squares = [(x, y) for y, line in enumerate(lines) for x, sign in enumerate(line) if sign == "#"]
    around = ((0, 0), (1, 0), (1, 1), (0, 1))
    places = sorted({(x + a, y + b, side) for x, y in squares for a, b in around for side in (-1, 1)})
    number = {place: vertex for vertex, place in enumerate(places)}
    faces = []
    for x, y in squares:
        ring = [(x + a, y + b) for a, b in around]
        faces += [[number[*p, 1] for p in ring], [number[*p, -1] for p in ring[::-1]]]
        for (a, b), step in zip(pairwise([*ring, ring[0]]), ((0, -1), (1, 0), (0, 1), (-1, 0)), strict=True):
            beside = (x + step[0], y + step[1])
            if beside not in squares and 0 <= beside[1] < len(lines):
                faces.append([number[*b, 1], number[*a, 1], number[*a, -1], number[*b, -1]])
    points = np.array(places) * [cell, cell, 0.5 * thickness]
    return in_triangles(Mesh.from_polygons(points, faces))


def tube_with_holes(drawing: str, cell: float) -> Mesh:
    """A drawing of squares of some size [cm], rolled to a tube."""
    flat = sheet(drawing, cell)
    count = drawing.index(" ")
    angle = 2.0 * np.pi * np.rint(flat.vertices[:, 0] / cell) / count
    radius = count * cell / (2.0 * np.pi)
    points = np.stack([radius * np.sin(angle), flat.vertices[:, 1], radius * np.cos(angle)], axis=1)
    _, first, place = np.unique(np.round(points, 6), axis=0, return_index=True, return_inverse=True)
    return Mesh.from_polygons(points[first], place.ravel()[flat.face_vertex].reshape(-1, 3).tolist())
