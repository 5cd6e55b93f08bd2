# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Reading and writing of stitch meshes; the suffix of the file decides the format.

HDF5 (``.h5``) keeps every field of a stitch mesh without loss. ``.smobj`` is the text format of augmented stitch
meshes, which is read and written. ``.st`` holds traced stitches, which are only read. ``.k`` is a program for a
knitting machine, which is only written.
"""

from __future__ import annotations

from os import fspath

from stitchmesh.errors import FileError, LabelError, ParameterError, check_kind
from stitchmesh.io.atomic import write_text
from stitchmesh.io.contents import FilePath, suffix_of
from stitchmesh.io.hdf5 import read_dataclass, write_dataclass
from stitchmesh.io.stitch_formats.smobj import read_smobj, write_smobj
from stitchmesh.io.stitch_formats.traced_stitches import read_traced_stitches
from stitchmesh.machine_knitting import machine_program
from stitchmesh.mesh import StitchMesh
from stitchmesh.mesh.cable_groups import cable_groups

FORMAT = "stitchmesh stitches"
"""Attribute ``format`` of HDF5 files of stitch meshes."""
TWO_WAY = (".h5", ".smobj")
"""Suffixes of stitch meshes that can be read and written."""
READABLE = (*TWO_WAY, ".st")
"""Suffixes of stitch meshes that can be read."""
WRITABLE = (*TWO_WAY, ".k")
"""Suffixes of stitch meshes that can be written."""


def write_knitout(path: FilePath, fabric: StitchMesh) -> None:
    """Write the program that knits a fabric on a V-bed machine.

    Raises:
        ParameterError: a machine cannot make the fabric; the message lists the stitches.
        LabelError: the cable marks of the fabric contradict each other.
        FileError: the file cannot be written.
    """
    write_text(path, machine_program(fabric))


def write_stitches(path: FilePath, fabric: StitchMesh) -> None:
    """Write a stitch mesh, labeled or tessellated.

    Args:
        path: an ``.h5`` or ``.smobj`` file, or a ``.k`` file for a knitting machine; missing folders are made.
        fabric: the stitch mesh.

    Raises:
        ParameterError: a knitting machine cannot make the fabric; the message lists the stitches. Or an ``.smobj``
            file cannot hold the fabric's stitches of the user's own.
        FileError: the suffix is unknown, or the file cannot be written.
    """
    suffix = suffix_of(path, WRITABLE)
    check_kind("write_stitches", fabric, StitchMesh)
    if fabric.own_stitches and suffix == ".smobj":
        found = f"holds the stitch {fabric.own_stitches[0].code!r} of your own"
        raise ParameterError(f"{fspath(path)}: the stitch mesh {found}; write an .h5 file, which holds its drawing")
    if suffix == ".h5":
        write_dataclass(path, fabric, FORMAT)
    else:
        {".smobj": write_smobj, ".k": write_knitout}[suffix](path, fabric)


def read_stitches(path: FilePath) -> StitchMesh:
    """Read a stitch mesh.

    Args:
        path: an ``.h5``, ``.smobj`` or ``.st`` file.

    Raises:
        FileError: the file cannot be read, holds something else, is damaged, or does not describe a valid stitch mesh
            with valid cables.
    """
    fabric = _READERS[suffix_of(path, READABLE)](path)
    try:
        cable_groups(fabric)
    except LabelError as error:
        raise FileError(f"{fspath(path)}: {error}") from error
    return fabric


def _read_hdf5(path: FilePath) -> StitchMesh:
    return read_dataclass(path, StitchMesh, FORMAT)


_READERS = {".h5": _read_hdf5, ".smobj": read_smobj, ".st": read_traced_stitches}
"""Function that reads each format."""
