# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""HDF5 files of partly labeled meshes, so that labeling can be continued later."""

from __future__ import annotations

from dataclasses import dataclass, fields
from os import fspath

import numpy as np
from numpy.typing import NDArray

from stitchmesh.errors import FileError, StitchMeshError
from stitchmesh.io.contents import FilePath, read_bytes, suffix_of
from stitchmesh.io.hdf5 import read_dataclass, stored_format, write_dataclass
from stitchmesh.labeling.growth import EdgeLabels
from stitchmesh.labeling.partial_labeling import PartialLabeling
from stitchmesh.lattice import Lattice
from stitchmesh.mesh import FloatArray, IntArray, Mesh

FORMAT = "stitchmesh labeling"
"""Attribute ``format`` of HDF5 files of partly labeled meshes."""
SUFFIXES = (".h5",)
"""Suffixes of files of partly labeled meshes."""


@dataclass(frozen=True, eq=False, kw_only=True)
class _Contents(EdgeLabels):
    """The datasets of a file: the fields of ``Mesh`` and of ``PartialLabeling``."""

    vertices: FloatArray
    face_start: IntArray
    face_vertex: IntArray
    twin: IntArray
    lattice: Lattice | None = None
    corner_image: IntArray | None = None
    seeded: NDArray[np.bool_]
    held_direction: IntArray


def write_labeling(path: FilePath, labeling: PartialLabeling) -> None:
    """Write a partly labeled mesh.

    Args:
        path: an ``.h5`` file; missing folders are made.
        labeling: the partly labeled mesh.

    Raises:
        FileError: the suffix is not ``.h5``, or the file cannot be written.
    """
    suffix_of(path, SUFFIXES)
    parts = {part.name: getattr(labeling.mesh, part.name) for part in fields(Mesh)}
    parts |= {part.name: getattr(labeling, part.name) for part in fields(PartialLabeling) if part.name != "mesh"}
    write_dataclass(path, _Contents(**parts), FORMAT)


def read_labeling(path: FilePath) -> PartialLabeling:
    """Read a partly labeled mesh.

    Args:
        path: an ``.h5`` file that ``write_labeling`` has written.

    Raises:
        FileError: the file cannot be read, holds something else, is damaged, or its datasets contradict each other.
    """
    suffix_of(path, SUFFIXES)
    contents = vars(read_dataclass(path, _Contents, FORMAT))
    try:
        mesh = Mesh(**{part.name: contents[part.name] for part in fields(Mesh)})
        names = [part.name for part in fields(PartialLabeling) if part.name != "mesh"]
        return PartialLabeling(mesh=mesh, **{name: contents[name] for name in names})
    except (StitchMeshError, ValueError, IndexError, TypeError) as error:
        raise FileError(f"{fspath(path)}: {error}") from error


def holds_labeling(path: FilePath) -> bool:
    """Return whether a file is an HDF5 file of a partly labeled mesh.

    Raises:
        FileError: the file has the suffix ``.h5``, and it cannot be opened or is not HDF5.
    """
    if not fspath(path).lower().endswith(SUFFIXES):
        return False
    read_bytes(path)  # The errors of a missing file and of a folder are raised here.
    return stored_format(path) == FORMAT
