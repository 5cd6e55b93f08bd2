# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Stitch meshes from and to HDF5, without loss: explicit twins, stitch types, rows and stretch included."""

from __future__ import annotations

from stitchmesh.io.contents import FilePath, suffix_of
from stitchmesh.io.hdf5 import read_noun, write_noun
from stitchmesh.mesh import StitchMesh

FORMAT = "stitchmesh stitches"
SUFFIXES = (".h5",)


def write_stitches(path: FilePath, fabric: StitchMesh) -> None:
    """Write a stitch mesh, labeled or tessellated.

    Raises:
        FileError: the suffix is not ``.h5``, or the file cannot be written.
    """
    suffix_of(path, SUFFIXES)
    write_noun(path, fabric, FORMAT)


def read_stitches(path: FilePath) -> StitchMesh:
    """Read what ``write_stitches`` wrote.

    Raises:
        FileError: the file cannot be read, holds something else, is damaged, or is not a valid stitch mesh.
    """
    suffix_of(path, SUFFIXES)
    return read_noun(path, StitchMesh, FORMAT)
