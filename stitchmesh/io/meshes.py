# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Polygon meshes from and to files, by suffix."""

from __future__ import annotations

from os import fspath

import numpy as np

from stitchmesh.errors import MeshError
from stitchmesh.io import meshio_mesh
from stitchmesh.io.contents import FilePath, suffix_of
from stitchmesh.io.obj_mesh import read_obj_polygons, write_obj_mesh
from stitchmesh.io.off_mesh import read_off_polygons
from stitchmesh.io.ply_mesh import read_ply_polygons
from stitchmesh.io.units import DEFAULT_UNIT, centimetres
from stitchmesh.mesh import Mesh

OWN_READERS = {".obj": read_obj_polygons, ".off": read_off_polygons, ".ply": read_ply_polygons}

READABLE = (*OWN_READERS, *meshio_mesh.FORMATS)
"""Suffixes of the polygon meshes that can be read."""

WRITABLE = (".obj",)


def read_mesh(path: FilePath, *, unit: str = DEFAULT_UNIT) -> Mesh:
    """Read a polygon mesh; its polygons keep their size and their order.

    Args:
        path: an ``.obj``, ``.off``, ``.ply``, ``.stl``, ``.vtk``, ``.vtu``, ``.msh`` or ``.mesh`` file. The points of
            an STL file are welded where they are exactly equal.
        unit: unit of the file's coordinates: mm, cm, dm, m or inch.

    Returns:
        The mesh in centimetres.

    Raises:
        ParameterError: the unit is unknown.
        FileError: the file cannot be read or is malformed; the message names the line.
        MeshError: the polygons do not form an oriented manifold surface.
    """
    scale = centimetres(unit)
    suffix = suffix_of(path, READABLE)
    if suffix in OWN_READERS:
        vertices, faces = OWN_READERS[suffix](path)
    else:
        vertices, faces = meshio_mesh.read_meshio_polygons(path, suffix)
    try:
        return Mesh.from_polygons(np.asarray(vertices, dtype=np.float64).reshape(-1, 3) * scale, faces)
    except MeshError as error:
        raise MeshError(f"{fspath(path)}: {error}") from error


def write_mesh(path: FilePath, mesh: Mesh, *, unit: str = DEFAULT_UNIT) -> None:
    """Write the polygons of a mesh as an OBJ file.

    Args:
        path: an ``.obj`` file; missing folders are made.
        mesh: its lattice, if any, is not written.
        unit: unit of the file's coordinates: mm, cm, dm, m or inch.

    Raises:
        ParameterError: the unit is unknown.
        FileError: the suffix is not ``.obj``, or the file cannot be written.
    """
    suffix_of(path, WRITABLE)
    write_obj_mesh(path, mesh, centimetres(unit))
