# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Programs for knitting machines: knitout files (``.k``). They can be written but not read."""

from __future__ import annotations

from stitchmesh.io.atomic import write_text
from stitchmesh.io.contents import FilePath
from stitchmesh.machine_knitting import machine_program
from stitchmesh.mesh import StitchMesh


def write_knitout(path: FilePath, fabric: StitchMesh) -> None:
    """Write the program that knits a fabric on a V-bed machine.

    Raises:
        ParameterError: a machine cannot make the fabric; the message lists the stitches.
        LabelError: the cable marks of the fabric contradict each other.
        FileError: the file cannot be written.
    """
    write_text(path, machine_program(fabric))
