# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Polygon meshes in VTK's XML format of poly data (``.vtp``), which meshio does not read or write."""

from __future__ import annotations

from os import fspath

import numpy as np

from stitchmesh.errors import FileError
from stitchmesh.io.contents import FilePath
from stitchmesh.io.yarn_formats.vtp import poly_data, write_poly_data
from stitchmesh.mesh import FloatArray


def holds_polygons(path: FilePath) -> bool:
    """Return whether a VTP file has faces.

    Raises:
        FileError: the file cannot be read or is malformed.
    """
    return bool(poly_data(path).GetNumberOfPolys())


def read_vtp_polygons(path: FilePath) -> tuple[FloatArray, list[list[int]]]:
    """Read polygons.

    Returns:
        Positions of the vertices in the file's unit, shape (V, 3), and the vertices of each face, counted from 0.

    Raises:
        FileError: the file cannot be read, is malformed, or has no faces.
    """
    from vtkmodules.util.numpy_support import vtk_to_numpy

    name, data = fspath(path), poly_data(path)
    polygons = data.GetPolys()
    if data.GetPoints() is None or polygons.GetNumberOfCells() == 0:
        raise FileError(f"{name}: has no faces; expected a polygon mesh")
    points = vtk_to_numpy(data.GetPoints().GetData()).astype(np.float64)
    bad = np.flatnonzero(~np.isfinite(points).all(axis=1))
    if len(bad):
        raise FileError(f"{name}: point {bad[0]} is {points[bad[0]].tolist()}; coordinates must be finite")
    starts = vtk_to_numpy(polygons.GetOffsetsArray()).astype(np.int64)
    corners = vtk_to_numpy(polygons.GetConnectivityArray()).astype(np.int64)
    unknown = corners[(corners < 0) | (corners >= len(points))]
    if len(unknown):
        raise FileError(f"{name}: a face names point {unknown[0]}; the file has {len(points)} points")
    return points, [face.tolist() for face in np.split(corners, starts[1:-1])]


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
