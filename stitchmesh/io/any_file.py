# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Reading of a file whose kind is not known beforehand: a polygon mesh, a stitch mesh or yarns."""

from __future__ import annotations

from os import fspath
from pathlib import Path

from stitchmesh.errors import ParameterError
from stitchmesh.faces.face_mesh import FaceMesh
from stitchmesh.io.contents import FilePath, read_bytes, read_lines, suffix_of
from stitchmesh.io.examples import mesh_file
from stitchmesh.io.hdf5 import stored_format
from stitchmesh.io.mesh_formats.usd_mesh import holds_curves
from stitchmesh.io.mesh_formats.vtp import holds_polygons
from stitchmesh.io.meshes import FORMATS as MESH_FORMATS
from stitchmesh.io.meshes import read_mesh
from stitchmesh.io.stitch_formats.face_meshes import holds_foreign_faces, read_face_mesh
from stitchmesh.io.stitches import FORMAT as STITCHES
from stitchmesh.io.stitches import read_stitches
from stitchmesh.io.units import DEFAULT_UNIT
from stitchmesh.io.yarns import FORMATS as YARN_FORMATS
from stitchmesh.io.yarns import read_yarns
from stitchmesh.mesh import Mesh
from stitchmesh.yarn import YarnSet


def read_any(path: FilePath, *, unit: str = DEFAULT_UNIT, radius: float | None = None) -> Mesh | YarnSet | FaceMesh:
    """Read a polygon mesh, a stitch mesh or yarns; the suffix and the content of the file decide which.

    If some faces of a file are no stitches, the file is read as a face mesh.

    Args:
        path: any file that ``read_mesh``, ``read_stitches`` or ``read_yarns`` reads.
        unit: unit of the coordinates in the file; leave it out for formats that state or fix their unit.
        radius: radius of all yarns [cm]. If it is None, the radius is found as in ``read_yarns``.

    Raises:
        ParameterError: the unit is unknown, a radius is given for a file without yarns, the radius is not positive, or
            the file states no radius and the radius cannot be estimated.
        FileError: the file cannot be read or is malformed.
        MeshError: the polygons do not form an oriented manifold surface.
        YarnError: the yarns are malformed.
    """
    path = mesh_file(path)
    suffix = suffix_of(path, dict.fromkeys([*YARN_FORMATS, *MESH_FORMATS, ".smobj", ".st"]))
    read_bytes(path)  # The errors of a missing file and of a folder are raised here, with one message for all formats.
    stitches = suffix in (".smobj", ".st") or (suffix == ".h5" and stored_format(path) == STITCHES)
    if not stitches and not holds_mesh(path):
        return read_yarns(path, unit=unit, radius=radius)
    if radius is not None:
        raise ParameterError(f"radius: {fspath(path)} holds no yarns; leave the yarn radius out")
    if suffix == ".smobj" and holds_foreign_faces(path):
        return read_face_mesh(path)
    return read_stitches(path) if stitches else read_mesh(path, unit=unit)


def holds_mesh(path: FilePath) -> bool:
    """Return whether a file holds a polygon mesh, by its suffix and its content.

    Raises:
        FileError: the file cannot be read.
    """
    suffix = Path(path).suffix.lower()
    return suffix in MESH_FORMATS and not _holds_polylines(path, suffix)


def _holds_polylines(path: FilePath, suffix: str) -> bool:
    """Return whether a file holds yarns; its format (VTP, OBJ or USD) can hold both meshes and yarns."""
    if suffix == ".vtp":
        return not holds_polygons(path)
    if suffix in (".usda", ".usdc", ".usd"):
        return holds_curves(path)
    lines = read_lines(path) if suffix == ".obj" else []
    return not any(line.startswith("f ") for line in lines) and any(line.startswith("l ") for line in lines)
