# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Polygon meshes of the formats that the library meshio reads and writes.

meshio prints some errors, ends the process with ``sys.exit``, and makes large arrays for small files. It therefore
reads in a process of its own (``stitchmesh.io.guarded_child``), and this module converts its errors to ``FileError``.
"""

from __future__ import annotations

import io
import re
import warnings
from contextlib import redirect_stderr, redirect_stdout
from itertools import groupby
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from stitchmesh.errors import FileError
from stitchmesh.io.atomic import atomic_path
from stitchmesh.io.checkpoint_file import CheckpointFile
from stitchmesh.io.contents import FilePath, check_points, read_bytes, say_left_out
from stitchmesh.io.guarded_child import answer_of_child, answer_parent
from stitchmesh.io.mesh_formats.cells import RINGS, check_cells_left_out, used_points
from stitchmesh.mesh import FloatArray

FORMATS = {".vtk": "vtk", ".vtu": "vtu", ".msh": "gmsh", ".mesh": "medit"}
"""meshio's name of the format behind each suffix."""
OPTIONS: dict[str, dict[str, Any]] = {".msh": {"file_format": "gmsh22"}}
"""Options of meshio for formats whose default variant is read by fewer programs."""

COUNTS = {
    ".vtk": re.compile(rb"(?m)^[A-Za-z_]+[ \t]+(\d+)(?:[ \t]+(\d+))?"),
    ".msh": re.compile(rb"(?m)^\$[A-Za-z]+\s+(\d+)(?:[ \t]+(\d+))?"),
}
"""Numbers of points, cells and other elements in files of the formats that meshio reads, by suffix."""


def read_meshio_polygons(path: FilePath) -> tuple[FloatArray, list[list[int]]]:
    """Read polygons in a process of their own.

    Args:
        path: a file with a suffix of ``COUNTS``.

    Returns:
        Vertices in the file's unit, shape (V, 3), and the vertices of each face, counted from 0, in the order of the
        file.

    Raises:
        FileError: the file is missing, a folder, unreadable, empty or malformed, has cells that are not polygons, or
            has no faces, or the process that reads it ends.
    """
    read = answer_of_child(__name__, path)
    say_left_out(path, read.header["left out"], "cells")
    return polygons_of(read)


def polygons_of(packed: CheckpointFile) -> tuple[FloatArray, list[list[int]]]:
    """Return what ``read_meshio_polygons`` returns, from what ``packed_polygons`` returns."""
    faces = np.split(packed.arrays["corners"], np.cumsum(packed.arrays["counts"])[:-1])
    return packed.arrays["points"], [face.tolist() for face in faces]


def packed_polygons(name: str, file: Path) -> CheckpointFile:
    """Read polygons for the parent of this process.

    Args:
        name: the name of the file, for messages; its suffix decides the format.
        file: where its content lies.

    Raises:
        FileError: as for ``read_meshio_polygons``.
    """
    suffix = Path(name).suffix.lower()
    _check_counts(name, suffix, read_bytes(file))
    content = _read(name, file, FORMATS[suffix])
    points = np.asarray(content.points, dtype=np.float64)
    if points.ndim != 2 or points.shape[1] != 3:
        raise FileError(f"{name}: got points of shape {points.shape}; expected three coordinates each")
    check_points(f"{name}: point", points)
    faces, others = faces_of_cells(name, content.cells)
    points, faces = used_points(name, points, faces) if others else (points, faces)
    corners = np.array([v for face in faces for v in face], dtype=np.int64)
    arrays = {"points": points, "counts": np.array([len(face) for face in faces]), "corners": corners}
    return CheckpointFile({"left out": others}, arrays)


def write_meshio_polygons(path: FilePath, vertices: FloatArray, faces: list[list[int]]) -> None:
    """Write polygons; successive faces with the same number of corners form one block of cells.

    Args:
        path: a file with a suffix of ``FORMATS``.
        vertices: positions in the file's unit, shape (V, 3).
        faces: vertices of each face, counted from 0.

    Raises:
        FileError: the file cannot be written.
    """
    import meshio

    suffix = Path(path).suffix.lower()
    content = meshio.Mesh(vertices, cells_of_faces(faces))
    options = {"file_format": FORMATS[suffix], **OPTIONS.get(suffix, {})}
    with atomic_path(path) as temporary, redirect_stdout(io.StringIO()), redirect_stderr(io.StringIO()):
        meshio.write(temporary, content, **options)


def cells_of_faces(faces: list[list[int]]) -> list[tuple[str, NDArray[np.int64]]]:
    """Return faces as blocks of cells, each of successive faces with the same number of corners."""
    types = {3: "triangle", 4: "quad"}
    runs = [(size, list(run)) for size, run in groupby(faces, key=len)]
    return [(types.get(size, "polygon"), np.array(run)) for size, run in runs]


def _check_counts(name: str, suffix: str, content: bytes) -> None:
    """Refuse a number of elements that the file cannot hold, because meshio would ask for memory for them."""
    for found in COUNTS[suffix].finditer(content):
        largest = max((digits for digits in found.groups() if digits), key=len, default=b"0")
        if len(largest.lstrip(b"0")) > 18 or int(largest) > len(content):
            what = f"states {largest[:20].decode()} elements in {len(content)} bytes"
            raise FileError(f"{name}: is not a valid {FORMATS[suffix]} file ({what}); write it again")


def _read(name: str, file: Path, file_format: str) -> Any:
    import meshio

    printed = io.StringIO()
    try:
        with redirect_stdout(printed), redirect_stderr(printed), warnings.catch_warnings():
            warnings.simplefilter("ignore")  # meshio's test for binary STL overflows on text files.
            return meshio.read(file, file_format=file_format)
    except (SystemExit, Exception) as error:  # meshio calls sys.exit, or raises any exception for a malformed line.
        message = printed.getvalue() if isinstance(error, SystemExit) else str(error)
        message = message.replace(str(file), name)
        reason = next((line.strip() for line in message.splitlines() if line.strip()), type(error).__name__)
        raise FileError(f"{name}: is not a valid {file_format} file ({reason[:100]}); write it again") from error


def faces_of_cells(name: str, blocks: list[Any]) -> tuple[list[list[int]], dict[str, int]]:
    """Return the points of each face of blocks of cells, and the numbers of cells of other types.

    Raises:
        FileError: there are no faces, or cells of a surface that is not read; the message begins with the name.
    """
    faces: list[list[int]] = []
    others: dict[str, int] = {}
    for block in blocks:
        if block.type in RINGS:
            faces += [[int(v) for v in np.asarray(cell)[RINGS[block.type]]] for cell in block.data]
        else:
            others[block.type] = others.get(block.type, 0) + len(block.data)
    check_cells_left_out(name, len(faces), others)
    return faces, others


if __name__ == "__main__":
    answer_parent(packed_polygons, "meshio")
