# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Reading and writing of polygon meshes; the suffix of the file decides the format.

Each format that is read can also be written.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from os import fspath
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike

from stitchmesh.errors import MeshError, check_kind
from stitchmesh.io.contents import FilePath, suffix_of
from stitchmesh.io.examples import mesh_file
from stitchmesh.io.mesh_formats.by_meshio import read_meshio_polygons, write_meshio_polygons
from stitchmesh.io.mesh_formats.cells import divide_large_faces
from stitchmesh.io.mesh_formats.glb import read_glb_polygons, write_glb_polygons
from stitchmesh.io.mesh_formats.medit import read_medit_polygons
from stitchmesh.io.mesh_formats.obj import read_obj_polygons, write_obj_polygons
from stitchmesh.io.mesh_formats.off import read_off_polygons, write_off_polygons
from stitchmesh.io.mesh_formats.ply import read_ply_polygons, write_ply_polygons
from stitchmesh.io.mesh_formats.stl import read_stl_polygons, write_stl_polygons
from stitchmesh.io.mesh_formats.usd_mesh import read_usd_polygons, write_usd_polygons
from stitchmesh.io.mesh_formats.vtk_legacy import read_vtk_polygons
from stitchmesh.io.mesh_formats.vtp import read_vtp_polygons, read_vtu_polygons, write_vtp_polygons
from stitchmesh.io.units import DEFAULT_UNIT, centimetres, check_unit_left_out
from stitchmesh.mesh import FloatArray, Mesh
from stitchmesh.mesh.repair import DEFAULT_REPAIR, Repaired, RepairOptions, repair_mesh

Read = Callable[[FilePath], tuple[ArrayLike, list[list[int]]]]
"""Function that returns the vertices in the file's unit, shape (V, 3), and the vertices of each face from 0."""


@dataclass(frozen=True)
class MeshFormat:
    """A format of polygon meshes: its functions and its limits."""

    read: Read
    """Function that reads the polygons, and refuses faces with fewer than three corners."""
    write: Callable[[FilePath, FloatArray, list[list[int]]], None]
    """Function that writes vertices in the file's unit, shape (V, 3), and the vertices of each face from 0."""
    most_corners: int | None = None
    """Largest number of corners of a face in the format; None if the number is not limited."""
    unit: str | None = None
    """Unit of length that the format prescribes; None if it prescribes none."""
    read_all: Read | None = None
    """Function that also reads faces with fewer than three corners; None if ``read`` serves for this too."""


FORMATS: dict[str, MeshFormat] = {
    ".obj": MeshFormat(read_obj_polygons, write_obj_polygons, read_all=partial(read_obj_polygons, fewest_corners=1)),
    ".off": MeshFormat(read_off_polygons, write_off_polygons, read_all=partial(read_off_polygons, fewest_corners=1)),
    ".ply": MeshFormat(read_ply_polygons, write_ply_polygons, read_all=partial(read_ply_polygons, fewest_corners=1)),
    ".vtp": MeshFormat(read_vtp_polygons, write_vtp_polygons),
    ".vtk": MeshFormat(read_vtk_polygons, write_meshio_polygons),
    ".vtu": MeshFormat(read_vtu_polygons, write_meshio_polygons),
    ".msh": MeshFormat(read_meshio_polygons, write_meshio_polygons, most_corners=4),
    ".mesh": MeshFormat(read_medit_polygons, write_meshio_polygons, most_corners=4),
    ".stl": MeshFormat(read_stl_polygons, write_stl_polygons, most_corners=3),
    ".glb": MeshFormat(read_glb_polygons, write_glb_polygons, most_corners=3, unit="m"),
    ".gltf": MeshFormat(read_glb_polygons, write_glb_polygons, most_corners=3, unit="m"),
    **dict.fromkeys((".usda", ".usdc", ".usd"), MeshFormat(read_usd_polygons, write_usd_polygons, unit="cm")),
}
"""Formats of polygon meshes, by suffix."""


def read_mesh(path: FilePath, *, unit: str = DEFAULT_UNIT) -> Mesh:
    """Read a polygon mesh; the polygons keep their corners and their order.

    Args:
        path: an ``.obj``, ``.off``, ``.ply``, ``.vtp``, ``.vtk``, ``.vtu``, ``.msh``, ``.mesh``, ``.stl``, ``.glb``,
            ``.gltf``, ``.usda``, ``.usdc`` or ``.usd`` file. Points of STL and glTF files at exactly equal positions
            become one vertex. A word without a folder and a suffix, such as ``hat``, is the name of an example of
            ``stitchmesh examples``.
        unit: unit of the coordinates in the file: mm, cm, dm, m or inch. glTF files are always in metres, and USD files
            state their unit; leave the unit out for them.

    Returns:
        The mesh in centimetres.

    Raises:
        ParameterError: the unit is unknown, or it is given for a format that prescribes its unit.
        FileError: the file cannot be read or is malformed; for text formats the message names the line.
        MeshError: the polygons do not form an oriented manifold surface.
    """
    vertices, faces = read_strict_polygons(path, unit=unit)
    try:
        return Mesh.from_polygons(vertices, faces)
    except MeshError as error:
        raise MeshError(f"{fspath(path)}: {error}") from error


def read_strict_polygons(path: FilePath, *, unit: str = DEFAULT_UNIT) -> tuple[FloatArray, list[list[int]]]:
    """Read polygons of three corners or more; arguments, result and errors are the same as for ``read_polygons``.

    Raises:
        FileError: a face has fewer than three corners, in addition to the errors of ``read_polygons``.
    """
    path = mesh_file(path)
    mesh_format = FORMATS[suffix_of(path, FORMATS)]
    return _in_centimetres(path, mesh_format, mesh_format.read, unit)


def read_polygons(path: FilePath, *, unit: str = DEFAULT_UNIT) -> tuple[FloatArray, list[list[int]]]:
    """Read polygons that need not form a surface: faces may be degenerate, occur twice or have any direction.

    Args:
        path: a file, as for ``read_mesh``.
        unit: unit of the coordinates in the file, as for ``read_mesh``.

    Returns:
        Vertices [cm], shape (V, 3), and the vertices of each face, counted from 0, in the order of the file.

    Raises:
        ParameterError: as for ``read_mesh``.
        FileError: as for ``read_mesh``; a face with fewer than three corners is no error.
    """
    path = mesh_file(path)
    mesh_format = FORMATS[suffix_of(path, FORMATS)]
    return _in_centimetres(path, mesh_format, mesh_format.read_all or mesh_format.read, unit)


def read_repaired_mesh(
    path: FilePath, *, unit: str = DEFAULT_UNIT, options: RepairOptions = DEFAULT_REPAIR
) -> Repaired:
    """Read polygons and make a valid mesh of them.

    Args:
        path: a file, as for ``read_mesh``.
        unit: unit of the coordinates in the file, as for ``read_mesh``.
        options: what the repair may change.

    Returns:
        The mesh in centimetres, and what was changed. The actions count vertices and faces from 0 in the order of the
        file; for STL and glTF files they count the different points.

    Raises:
        ParameterError: as for ``read_mesh`` and ``repair_mesh``.
        FileError: as for ``read_polygons``.
        MeshError: as for ``repair_mesh``; the message starts with the path.
    """
    vertices, faces = read_polygons(path, unit=unit)
    try:
        return repair_mesh(vertices, faces, options)
    except MeshError as error:
        raise MeshError(f"{fspath(path)}: {error}") from error


def _in_centimetres(
    path: FilePath, mesh_format: MeshFormat, read: Read, unit: str
) -> tuple[FloatArray, list[list[int]]]:
    """Read polygons with vertices in centimetres."""
    scale = _scale(path, mesh_format, unit)
    vertices, faces = read(path)
    return np.asarray(vertices, dtype=np.float64).reshape(-1, 3) * scale, faces


def stated_unit(path: FilePath) -> str | None:
    """Return the unit that the format of a mesh file fixes; None for another file, whose unit the user states."""
    mesh_format = FORMATS.get(Path(path).suffix.lower())
    return None if mesh_format is None else mesh_format.unit


def write_mesh(path: FilePath, mesh: Mesh, *, unit: str = DEFAULT_UNIT) -> None:
    """Write the polygons of a mesh in the format of the suffix; ``read_mesh`` reads every such file.

    STL and glTF hold only triangles, Gmsh's ``.msh`` and Medit's ``.mesh`` only triangles and quads. Larger faces are
    divided into triangles for these formats, and a warning is logged. The other formats hold polygons of any size.

    Args:
        path: an ``.obj``, ``.off``, ``.ply``, ``.vtp``, ``.vtk``, ``.vtu``, ``.msh``, ``.mesh``, ``.stl``, ``.glb``,
            ``.gltf``, ``.usda``, ``.usdc`` or ``.usd`` file; missing folders are made.
        mesh: the mesh; a lattice is not written.
        unit: unit of the coordinates in the file: mm, cm, dm, m or inch. glTF files are always in metres; leave the
            unit out for them.

    Raises:
        ParameterError: the unit is unknown, or it is given for a format that prescribes its unit.
        FileError: the suffix is unknown, a face cannot be divided, a coordinate is too large for the float32 of STL and
            glTF, or the file cannot be written.
    """
    mesh_format = FORMATS[suffix_of(path, FORMATS)]
    check_kind("write_mesh", mesh, Mesh)
    vertices, faces = mesh.vertices / _scale(path, mesh_format, unit), mesh.polygons
    if mesh_format.most_corners is not None:
        faces = divide_large_faces(path, vertices, faces, mesh_format.most_corners)
    mesh_format.write(path, vertices, faces)


def _scale(path: FilePath, mesh_format: MeshFormat, unit: str) -> float:
    """Return the number of centimetres in one unit of the file's coordinates."""
    scale = centimetres(unit)
    if mesh_format.unit is None:
        return scale
    check_unit_left_out(path, scale)
    return centimetres(mesh_format.unit)
