# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Polygon meshes of the formats that meshio reads and writes.

meshio prints its errors and ends the process; here both become one ``FileError``.
"""

from __future__ import annotations

import io
import warnings
from contextlib import redirect_stderr, redirect_stdout
from itertools import groupby
from os import fspath
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from stitchmesh.errors import FileError
from stitchmesh.io.atomic import atomic_path
from stitchmesh.io.contents import FilePath, read_bytes
from stitchmesh.io.float32 import rounded
from stitchmesh.mesh import FloatArray

FORMATS = {".stl": "stl", ".vtk": "vtk", ".vtu": "vtu", ".msh": "gmsh", ".mesh": "medit"}
"""meshio's name of the format behind each suffix."""
OPTIONS: dict[str, dict[str, Any]] = {".stl": {"binary": True}, ".msh": {"file_format": "gmsh22"}}
"""How meshio writes a format where its own choice, text or a recent version, is read by fewer programs."""

SURFACE_CELLS = ("triangle", "quad", "polygon")
PASSED_OVER = ("vertex", "line")
"""Cells that often come along with a surface and say nothing about it."""


def read_meshio_polygons(path: FilePath, suffix: str) -> tuple[NDArray[np.float64], list[list[int]]]:
    """Vertices as written and faces as 0-based vertex numbers, in file order.

    Raises:
        FileError: the file is missing, a folder, unreadable, empty or malformed, holds cells that are not polygons,
            or no faces.
    """
    name = fspath(path)
    read_bytes(path)
    content = _read(name, FORMATS[suffix])
    points = np.asarray(content.points, dtype=np.float64)
    if points.ndim != 2 or points.shape[1] != 3:
        raise FileError(f"{name}: got points of shape {points.shape}; expected three coordinates each")
    _check_numbers(name, points)
    faces = _polygons(name, content.cells)
    return weld(points, faces) if suffix == ".stl" else (points, faces)


def write_meshio_polygons(path: FilePath, vertices: FloatArray, faces: list[list[int]]) -> None:
    """Write polygons, in runs of as many corners.

    Raises:
        FileError: a coordinate is too large for a format of float32, or the file cannot be written.
    """
    import meshio

    suffix = Path(path).suffix.lower()
    points = rounded(path, "the coordinates", vertices) if suffix == ".stl" else vertices
    runs = [(size, list(run)) for size, run in groupby(faces, key=len)]
    content = meshio.Mesh(points, [(_cell_type(size), np.array(run)) for size, run in runs])
    options = {"file_format": FORMATS[suffix], **OPTIONS.get(suffix, {})}
    with atomic_path(path) as temporary, redirect_stdout(io.StringIO()), redirect_stderr(io.StringIO()):
        meshio.write(temporary, content, **options)


def _cell_type(corners: int) -> str:
    return {3: "triangle", 4: "quad"}.get(corners, "polygon")


def weld(points: NDArray[np.float64], faces: list[list[int]]) -> tuple[NDArray[np.float64], list[list[int]]]:
    """Merge points at exactly the same place; the first of them keeps its turn in the order."""
    _, first, place = np.unique(points + 0.0, axis=0, return_index=True, return_inverse=True)  # + 0.0: -0 becomes 0
    order = np.argsort(first)
    rank = np.empty_like(order)
    rank[order] = np.arange(len(order))
    number = rank[place.ravel()].tolist()
    return points[first[order]], [[number[v] for v in face] for face in faces]


def _read(name: str, file_format: str) -> Any:
    import meshio

    printed = io.StringIO()
    try:
        with redirect_stdout(printed), redirect_stderr(printed), warnings.catch_warnings():
            warnings.simplefilter("ignore")  # its guess at the kind of an STL file overflows
            return meshio.read(name, file_format=file_format)
    except (SystemExit, Exception) as error:  # meshio leaves by sys.exit, or by whatever a malformed line brings up
        said = printed.getvalue() if isinstance(error, SystemExit) else str(error)
        reason = next((line.strip() for line in said.splitlines() if line.strip()), type(error).__name__)
        raise FileError(f"{name}: is not a valid {file_format} file ({reason[:100]}); write it again") from error


def _check_numbers(name: str, points: NDArray[np.float64]) -> None:
    bad = np.flatnonzero(~np.isfinite(points).all(axis=1))
    if len(bad):
        raise FileError(f"{name}: point {bad[0]} is {points[bad[0]].tolist()}; coordinates must be finite")


def _polygons(name: str, blocks: list[Any]) -> list[list[int]]:
    faces: list[list[int]] = []
    for block in blocks:
        if block.type in SURFACE_CELLS:
            faces += [[int(v) for v in cell] for cell in block.data]
        elif block.type not in PASSED_OVER:
            raise FileError(f"{name}: got {block.type} cells; expected a surface of triangles, quads or polygons")
    if not faces:
        raise FileError(f"{name}: has no faces; expected a polygon mesh")
    return faces
