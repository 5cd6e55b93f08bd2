# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Polygon meshes in VTK's XML formats of poly data (``.vtp``) and of unstructured grids (``.vtu``)."""

from __future__ import annotations

from itertools import pairwise
from os import fspath

import numpy as np

from stitchmesh.errors import FileError
from stitchmesh.io.contents import FilePath, check_points
from stitchmesh.io.vtk_xml import Cells, read_vtk_points
from stitchmesh.io.yarn_formats.vtp import write_poly_data
from stitchmesh.mesh import FloatArray

SURFACE_CELLS, IGNORED_CELLS = (5, 7, 9), (1, 3)
"""VTK's numbers of the types of cells that become faces (triangle, polygon, quad), and of points and lines."""
CELL_NAMES = {4: "polyline", 6: "triangle strip", 10: "tetra", 12: "hexahedron", 13: "wedge", 14: "pyramid"}
"""Names of frequent types of cells that are no faces."""


def holds_polygons(path: FilePath) -> bool:
    """Return whether a VTP file has faces.

    Raises:
        FileError: the file cannot be read or is malformed.
    """
    return len(read_vtk_points(path, "PolyData", ["Polys"]).cells["Polys"].start) > 1


def read_vtp_polygons(path: FilePath) -> tuple[FloatArray, list[list[int]]]:
    """Read polygons of poly data.

    Returns:
        Positions of the vertices in the file's unit, shape (V, 3), and the vertices of each face, counted from 0.

    Raises:
        FileError: the file cannot be read, is malformed, or has no faces.
    """
    data = read_vtk_points(path, "PolyData", ["Polys"])
    polygons = data.cells["Polys"]
    return _checked(fspath(path), data.points, _lists(polygons))


def read_vtu_polygons(path: FilePath) -> tuple[FloatArray, list[list[int]]]:
    """Read triangles, quads and polygons of an unstructured grid; its points and lines are ignored.

    Returns:
        As for ``read_vtp_polygons``.

    Raises:
        FileError: the file cannot be read, is malformed, has cells that are not polygons, or has no faces.
    """
    name, data = fspath(path), read_vtk_points(path, "UnstructuredGrid", ["Cells"])
    cells = data.cells["Cells"]
    other = np.setdiff1d(cells.kind, [*SURFACE_CELLS, *IGNORED_CELLS])
    if len(other):
        found = CELL_NAMES.get(int(other[0]), f"type {other[0]}")
        raise FileError(f"{name}: got {found} cells; expected a surface of triangles, quads or polygons")
    kept = np.isin(cells.kind, SURFACE_CELLS)
    faces = [face for face, chosen in zip(_lists(cells), kept.tolist(), strict=True) if chosen]
    return _checked(name, data.points, faces)


def _checked(name: str, points: FloatArray, faces: list[list[int]]) -> tuple[FloatArray, list[list[int]]]:
    if not faces:
        raise FileError(f"{name}: has no faces; expected a polygon mesh")
    check_points(f"{name}: point", points)
    return points, faces


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
