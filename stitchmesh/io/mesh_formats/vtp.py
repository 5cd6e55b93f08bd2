# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Polygon meshes in VTK's XML formats of poly data (``.vtp``) and of unstructured grids (``.vtu``)."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping
from itertools import pairwise
from os import fspath

import numpy as np

from stitchmesh.errors import FileError
from stitchmesh.io.contents import FilePath, check_points, say_left_out
from stitchmesh.io.mesh_formats.cells import RINGS, check_cells_left_out, strip_triangles, used_points
from stitchmesh.io.vtk_xml import Cells, read_vtk_points
from stitchmesh.io.yarn_formats.vtp import write_poly_data
from stitchmesh.mesh import FloatArray

STRIP = "strip of triangles"
CELL_NAMES = {
    1: "vertex", 2: "poly_vertex", 3: "line", 4: "polyline", 5: "triangle", 6: STRIP, 7: "polygon", 8: "pixel",
    9: "quad", 10: "tetra", 11: "voxel", 12: "hexahedron", 13: "wedge", 14: "pyramid", 21: "line3", 22: "triangle6",
    23: "quad8", 24: "tetra10", 25: "hexahedron20", 26: "wedge15", 27: "pyramid13", 28: "quad9", 34: "triangle7",
}  # fmt: skip
"""Names of types of cells, by VTK's number."""


def holds_polygons(path: FilePath) -> bool:
    """Return whether a VTP file has faces.

    Raises:
        FileError: the file cannot be read or is malformed.
    """
    cells = read_vtk_points(path, "PolyData", ["Polys", "Strips"]).cells
    return any(len(lists.start) > 1 for lists in cells.values())


def read_vtp_polygons(path: FilePath) -> tuple[FloatArray, list[list[int]]]:
    """Read polygons and the triangles of strips of poly data.

    Returns:
        Positions of the vertices in the file's unit, shape (V, 3), and the vertices of each face, counted from 0.

    Raises:
        FileError: the file cannot be read, is malformed, or has no faces.
    """
    data = read_vtk_points(path, "PolyData", ["Polys", "Strips", "Lines", "Verts"])
    strips = [triangle for strip in _lists(data.cells["Strips"]) for triangle in _strip(strip)]
    faces = _lists(data.cells["Polys"]) + strips
    counts = {"line": len(data.cells["Lines"].start) - 1, "vertex": len(data.cells["Verts"].start) - 1}
    return _checked(path, data.points, faces, {kind: count for kind, count in counts.items() if count})


def read_vtu_polygons(path: FilePath) -> tuple[FloatArray, list[list[int]]]:
    """Read triangles, strips, quads and polygons of an unstructured grid; its points, lines and solids are left out.

    Returns:
        As for ``read_vtp_polygons``.

    Raises:
        FileError: the file cannot be read, is malformed, has cells that are not polygons, or has no faces.
    """
    data = read_vtk_points(path, "UnstructuredGrid", ["Cells"])
    cells, faces, others = data.cells["Cells"], [], Counter[str]()
    for number, cell in zip(cells.kind.tolist(), _lists(cells), strict=True):
        kind = CELL_NAMES.get(number, f"type {number}")
        ring = RINGS.get(kind)
        if kind == STRIP:
            faces += _strip(cell)
        elif ring is None:
            others[kind] += 1
        elif isinstance(ring, slice) or len(cell) > max(ring):
            faces.append(np.array(cell)[ring].tolist())
        else:
            raise FileError(f"{fspath(path)}: a cell of type {number} has {len(cell)} points; expected more")
    return _checked(path, data.points, faces, others)


def _checked(
    path: FilePath, points: FloatArray, faces: list[list[int]], others: Mapping[str, int]
) -> tuple[FloatArray, list[list[int]]]:
    """Return points and faces after checks, without the points of cells that are left out."""
    name = fspath(path)
    check_cells_left_out(name, len(faces), others)
    check_points(f"{name}: point", points)
    say_left_out(path, others, "cells")
    return used_points(name, points, faces) if others else (points, faces)


def _strip(points: list[int]) -> list[list[int]]:
    triangles: list[list[int]] = strip_triangles(np.array(points, dtype=np.int64)).tolist()
    return triangles


def _lists(cells: Cells) -> list[list[int]]:
    return [cells.point[first:last].tolist() for first, last in pairwise(cells.start.tolist())]


def write_vtp_polygons(path: FilePath, vertices: FloatArray, faces: list[list[int]]) -> None:
    """Write polygons.

    Args:
        path: a ``.vtp`` file.
        vertices: positions in the file's unit, shape (V, 3).
        faces: vertices of each face, counted from 0.

    Raises:
        FileError: the file cannot be written.
    """
    import pyvista

    write_poly_data(path, pyvista.PolyData(vertices, faces=np.concatenate([[len(face), *face] for face in faces])))
