# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Materials of cloth as files: TOML with the fields of ``ClothMaterial`` as keys."""

from __future__ import annotations

from collections.abc import Sequence
from os import fspath
from pathlib import Path

from stitchmesh.io.atomic import write_text
from stitchmesh.io.contents import FilePath, suffix_of
from stitchmesh.io.toml_file import SUFFIX, changed_fields, read_dataclass, table_lines
from stitchmesh.mixed.triangles.cloth_material import ClothMaterial
from stitchmesh.mixed.triangles.measured_cloths import named_material

HEADER = "# A material of cloth. Courses (wefts) run along x in the coordinates of a panel, wales (warps) along y.\n"
UNITS = {
    "stretch_course": "dyn/cm, Young's modulus times thickness",
    "stretch_wale": "dyn/cm",
    "shear": "dyn/cm",
    "bending_course": "dyn cm",
    "bending_wale": "dyn cm",
    "density": "g/cm^2",
    "twist": "dyn cm",
    "moment_course": "dyn, curls the courses towards the normals",
    "moment_wale": "dyn",
    "damping": "s",
    "mass_damping": "1/s",
    "tension_course": "strain and tension [dyn/cm] at constant width",
    "tension_wale": "strain and tension [dyn/cm] at constant width",
    "shear_table": "strain 2 E_12 and stress [dyn/cm]",
    "coupling_table": "strain E_11 + E_22 and stress [dyn/cm]",
}
"""Comments beside the keys of a written material."""


def material_of(name_or_path: FilePath) -> ClothMaterial:
    """Return a measured material by its name, or read a material file, whose name ends with ``.toml``.

    Raises:
        ParameterError: there is no material of that name; the message states the nearest name.
        FileError: the file cannot be read, or is not a material.
    """
    text = fspath(name_or_path)
    return read_material(text) if Path(text).suffix == SUFFIX else named_material(text)


def read_material(path: FilePath) -> ClothMaterial:
    """Read a material from a TOML file.

    Raises:
        FileError: the file cannot be read, is not TOML, or has a key or a value that no material has; the message names
            the key and, for an unknown key, the nearest known one.
    """
    return read_dataclass(path, ClothMaterial)


def write_material(path: FilePath, material: ClothMaterial, notes: Sequence[str] = ()) -> None:
    """Write a material as a TOML file; the file is written atomically. Keys whose value is the default are left out.

    Args:
        path: name of the file.
        material: the material.
        notes: lines that stand at the end of the file as comments, for example how well the material fits.

    Raises:
        FileError: the file cannot be written, or its suffix is not ``.toml``.
    """
    suffix_of(path, [SUFFIX])
    lines = table_lines(changed_fields(material), comments=UNITS)
    comments = [f"# {line}".rstrip() for note in notes for line in note.splitlines()]
    write_text(path, HEADER + "\n".join([*lines, *comments]) + "\n")
