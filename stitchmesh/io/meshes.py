# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Polygon meshes from and to files, by suffix; each format that is read is written too."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from os import fspath

import numpy as np
from numpy.typing import ArrayLike

from stitchmesh.errors import MeshError
from stitchmesh.io.contents import FilePath, suffix_of
from stitchmesh.io.mesh_formats.by_meshio import read_meshio_polygons, write_meshio_polygons
from stitchmesh.io.mesh_formats.glb import read_glb_polygons, write_glb_polygons
from stitchmesh.io.mesh_formats.obj import read_obj_polygons, write_obj_polygons
from stitchmesh.io.mesh_formats.off import read_off_polygons, write_off_polygons
from stitchmesh.io.mesh_formats.ply import read_ply_polygons, write_ply_polygons
from stitchmesh.io.mesh_formats.triangles import divided
from stitchmesh.io.mesh_formats.vtp import read_vtp_polygons, write_vtp_polygons
from stitchmesh.io.units import DEFAULT_UNIT, centimetres, check_unit_left_out
from stitchmesh.mesh import FloatArray, Mesh


@dataclass(frozen=True)
class MeshFormat:
    """How polygon meshes of one suffix are read and written."""

    read: Callable[[FilePath], tuple[ArrayLike, list[list[int]]]]
    """Vertices in the file's unit and faces as 0-based vertex numbers."""
    write: Callable[[FilePath, FloatArray, list[list[int]]], None]
    """The same to a path."""
    most_corners: int | None = None
    """Corners of the largest face that the format holds; None where it holds polygons of any size."""
    unit: str | None = None
    """Its unit, where the format fixes one."""


def _by_meshio(suffix: str, most_corners: int | None = None) -> MeshFormat:
    return MeshFormat(partial(read_meshio_polygons, suffix=suffix), write_meshio_polygons, most_corners)


FORMATS: dict[str, MeshFormat] = {
    ".obj": MeshFormat(read_obj_polygons, write_obj_polygons),
    ".off": MeshFormat(read_off_polygons, write_off_polygons),
    ".ply": MeshFormat(read_ply_polygons, write_ply_polygons),
    ".vtp": MeshFormat(read_vtp_polygons, write_vtp_polygons),
    ".vtk": _by_meshio(".vtk"),
    ".vtu": _by_meshio(".vtu"),
    ".msh": _by_meshio(".msh", most_corners=4),
    ".mesh": _by_meshio(".mesh", most_corners=4),
    ".stl": _by_meshio(".stl", most_corners=3),
    ".glb": MeshFormat(read_glb_polygons, write_glb_polygons, most_corners=3, unit="m"),
}
"""The formats of polygon meshes."""


def read_mesh(path: FilePath, *, unit: str = DEFAULT_UNIT) -> Mesh:
    """Read a polygon mesh; its polygons keep their size and their order.

    Args:
        path: an ``.obj``, ``.off``, ``.ply``, ``.vtp``, ``.vtk``, ``.vtu``, ``.msh``, ``.mesh``, ``.stl`` or ``.glb``
            file. The points of STL and glTF files are welded where they are exactly equal.
        unit: unit of the file's coordinates: mm, cm, dm, m or inch; glTF files are in metres.

    Returns:
        The mesh in centimetres.

    Raises:
        ParameterError: the unit is unknown, or given for a format that fixes its own.
        FileError: the file cannot be read or is malformed; the message names the line.
        MeshError: the polygons do not form an oriented manifold surface.
    """
    mesh_format = FORMATS[suffix_of(path, FORMATS)]
    scale = _scale(path, mesh_format, unit)
    vertices, faces = mesh_format.read(path)
    try:
        return Mesh.from_polygons(np.asarray(vertices, dtype=np.float64).reshape(-1, 3) * scale, faces)
    except MeshError as error:
        raise MeshError(f"{fspath(path)}: {error}") from error


def write_mesh(path: FilePath, mesh: Mesh, *, unit: str = DEFAULT_UNIT) -> None:
    """Write the polygons of a mesh in the format of the suffix, as ``read_mesh`` reads them.

    Faces keep their size where the format holds it. STL and glTF hold triangles, Gmsh's ``.msh`` and Medit's ``.mesh``
    triangles and quads: larger faces are divided, and a warning says so.

    Args:
        path: an ``.obj``, ``.off``, ``.ply``, ``.vtp``, ``.vtk``, ``.vtu``, ``.msh``, ``.mesh``, ``.stl`` or ``.glb``
            file; missing folders are made.
        mesh: its lattice, if any, is not written.
        unit: unit of the file's coordinates: mm, cm, dm, m or inch; glTF files are in metres.

    Raises:
        ParameterError: the unit is unknown, or given for a format that fixes its own.
        FileError: the suffix is none of these, a face cannot be divided, a coordinate is too large for the float32 of
            STL and glTF, or the file cannot be written.
    """
    mesh_format = FORMATS[suffix_of(path, FORMATS)]
    vertices = mesh.vertices / _scale(path, mesh_format, unit)
    faces = [face.tolist() for face in np.split(mesh.face_vertex, mesh.face_start[1:-1])]
    if mesh_format.most_corners is not None:
        faces = divided(path, vertices, faces, mesh_format.most_corners)
    mesh_format.write(path, vertices, faces)


def _scale(path: FilePath, mesh_format: MeshFormat, unit: str) -> float:
    """Centimetres in the unit of the file's coordinates."""
    scale = centimetres(unit)
    if mesh_format.unit is None:
        return scale
    check_unit_left_out(path, scale)
    return centimetres(mesh_format.unit)
