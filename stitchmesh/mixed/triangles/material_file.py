# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Materials of cloth as files: TOML with the fields of ``ClothMaterial`` as keys."""

from __future__ import annotations

import json
import tomllib
from collections.abc import Iterator, Sequence
from dataclasses import fields
from os import fspath
from pathlib import Path

from stitchmesh.errors import FileError, ParameterError
from stitchmesh.io.atomic import write_text
from stitchmesh.io.checked import check_table
from stitchmesh.io.contents import FilePath, read_bytes, suffix_of
from stitchmesh.mixed.triangles.cloth_material import ClothMaterial
from stitchmesh.mixed.triangles.measured_cloths import named_material

SUFFIX = ".toml"
HEADER = "# A material of cloth. Courses (wefts) run along x in the coordinates of a panel, wales (warps) along y.\n"
UNITS = {
    "stretch_course": "dyn/cm, Young's modulus times thickness",
    "stretch_wale": "dyn/cm",
    "shear": "dyn/cm",
    "bending_course": "dyn cm",
    "bending_wale": "dyn cm",
    "density": "g/cm^2",
    "twist": "dyn cm",
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
    name = fspath(path)
    suffix_of(path, [SUFFIX])
    try:
        table = tomllib.loads(read_bytes(path).decode("utf-8"))
    except (tomllib.TOMLDecodeError, UnicodeDecodeError, RecursionError) as error:
        raise FileError(f"{name}: is no TOML ({error})") from error
    try:
        return check_table(table, ClothMaterial)
    except ParameterError as error:
        raise FileError(f"{name}: {error}") from error


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
    comments = [f"# {line}".rstrip() for note in notes for line in note.splitlines()]
    write_text(path, HEADER + "\n".join([*_lines(material), *comments]) + "\n")


def _lines(material: ClothMaterial) -> Iterator[str]:
    for part in fields(material):
        value = getattr(material, part.name)
        if value != part.default:
            unit = f"  # {UNITS[part.name]}" if part.name in UNITS else ""
            yield f"{part.name} = {_text(value)}{unit}"


def _text(value: object) -> str:
    """Return a value as TOML: a text, a number, or a list of these."""
    if isinstance(value, tuple):
        return f"[{', '.join(_text(part) for part in value)}]"
    if isinstance(value, str):
        return json.dumps(value, ensure_ascii=False).replace("\x7f", "\\u007f")
    return repr(float(value))  # type: ignore[arg-type]
