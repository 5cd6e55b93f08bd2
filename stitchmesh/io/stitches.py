# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Stitch meshes from and to HDF5, without loss: explicit twins, stitch types, rows and stretch included.

Also from and to ``.smobj``, and to ``.k``, the instructions of a knitting machine.
"""

from __future__ import annotations

from os import fspath

from stitchmesh.errors import FileError, LabelError
from stitchmesh.io.contents import FilePath, suffix_of
from stitchmesh.io.hdf5 import read_noun, write_noun
from stitchmesh.io.stitch_formats.knitout import write_knitout
from stitchmesh.io.stitch_formats.smobj import read_smobj, write_smobj
from stitchmesh.mesh import StitchMesh
from stitchmesh.mesh.cable_groups import cable_groups

FORMAT = "stitchmesh stitches"
READABLE = (".h5", ".smobj")
WRITABLE = (*READABLE, ".k")
"""Suffixes of stitch meshes."""


def write_stitches(path: FilePath, fabric: StitchMesh) -> None:
    """Write a stitch mesh, labeled or tessellated: ``.h5``, ``.smobj``, or ``.k`` for a knitting machine.

    Raises:
        ParameterError: a knitting machine cannot make the fabric; the message lists the stitches.
        FileError: the suffix is none of these, or the file cannot be written.
    """
    suffix = suffix_of(path, WRITABLE)
    if suffix == ".h5":
        write_noun(path, fabric, FORMAT)
    else:
        {".smobj": write_smobj, ".k": write_knitout}[suffix](path, fabric)


def read_stitches(path: FilePath) -> StitchMesh:
    """Read what ``write_stitches`` wrote, ``.h5`` or ``.smobj``.

    Raises:
        FileError: the file cannot be read, holds something else, is damaged, or is not a valid stitch mesh, its cables
            included.
    """
    is_text = suffix_of(path, READABLE) == ".smobj"
    fabric = read_smobj(path) if is_text else read_noun(path, StitchMesh, FORMAT)
    try:
        cable_groups(fabric)
    except LabelError as error:
        raise FileError(f"{fspath(path)}: {error}") from error
    return fabric
