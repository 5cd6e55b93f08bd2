# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Whatever a file holds: a polygon mesh, a stitch mesh or yarns."""

from __future__ import annotations

from os import fspath

from stitchmesh.errors import ParameterError
from stitchmesh.io.contents import FilePath, read_bytes, read_lines, suffix_of
from stitchmesh.io.hdf5 import stored_format
from stitchmesh.io.mesh_formats.vtp import holds_polygons
from stitchmesh.io.meshes import FORMATS as MESH_FORMATS
from stitchmesh.io.meshes import read_mesh
from stitchmesh.io.stitches import FORMAT as STITCHES
from stitchmesh.io.stitches import read_stitches
from stitchmesh.io.units import DEFAULT_UNIT
from stitchmesh.io.yarns import FORMATS as YARN_FORMATS
from stitchmesh.io.yarns import read_yarns
from stitchmesh.mesh import Mesh
from stitchmesh.yarn import YarnSet


def read_any(path: FilePath, *, unit: str = DEFAULT_UNIT, radius: float | None = None) -> Mesh | YarnSet:
    """Read a file as the noun that it holds; its suffix and content decide.

    Args:
        path: any file that ``read_mesh``, ``read_stitches`` or ``read_yarns`` reads.
        unit: unit of the file's coordinates, unless it is HDF5 or USD.
        radius: radius of all yarns [cm]; where None, as ``read_yarns`` finds it.

    Raises:
        ParameterError: the unit is unknown, a radius is given for a file that holds no yarns or is not positive, or
            there is none and it cannot be estimated.
        FileError: the file cannot be read or is malformed.
        MeshError: the polygons do not form an oriented manifold surface.
        YarnError: the yarns are malformed.
    """
    suffix = suffix_of(path, dict.fromkeys([*YARN_FORMATS, *MESH_FORMATS, ".smobj"]))
    read_bytes(path)  # a missing file or a folder is told here, in one way for all formats
    stitches = suffix == ".smobj" or (suffix == ".h5" and stored_format(path) == STITCHES)
    if not stitches and (suffix not in MESH_FORMATS or _holds_polylines(path, suffix)):
        return read_yarns(path, unit=unit, radius=radius)
    if radius is not None:
        raise ParameterError(f"radius: {fspath(path)} holds no yarns; leave the yarn radius out")
    return read_stitches(path) if stitches else read_mesh(path, unit=unit)


def _holds_polylines(path: FilePath, suffix: str) -> bool:
    """Whether a file of a format for both meshes and yarns has lines and no faces."""
    if suffix == ".vtp":
        return not holds_polygons(path)
    lines = read_lines(path) if suffix == ".obj" else []
    return not any(line.startswith("f ") for line in lines) and any(line.startswith("l ") for line in lines)
