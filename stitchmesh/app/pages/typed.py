# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The input of a user: rows of numbers, stitches in words, directions, and names of files."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from stitchmesh.errors import ParameterError
from stitchmesh.mesh import IntArray, StitchMesh
from stitchmesh.mesh.upright import Direction, Y, Z
from stitchmesh.selection import parse_selection, select
from stitchmesh.selection.selection import with_paths

AXES: dict[str, Direction] = {
    "+y": Y, "+z": Z, "+x": (1.0, 0.0, 0.0), "-y": (0.0, -1.0, 0.0), "-z": (0.0, 0.0, -1.0), "-x": (-1.0, 0.0, 0.0),
}  # fmt: skip
"""Directions that can point up, by the axis along which they lie."""
BODY_SUFFIXES = (".obj", ".ply", ".off", ".stl")
"""Suffixes of the files of bodies."""


def file_name(name: str) -> str:
    """Return the name of a file that a browser has sent, without the folders in it."""
    return Path(name.replace("\\", "/")).name


def three_numbers(name: str, text: object, unit: str = "cm") -> tuple[float, float, float]:
    """Return the three numbers of a text.

    Raises:
        ParameterError: the text does not have three numbers.
    """
    numbers = typed_numbers(text)
    if len(numbers) != 3:
        raise ParameterError(f"{name}: got {str(text)[:40]!r}; expected three numbers of {unit}, such as 1, 2.5, -1")
    x, y, z = numbers
    return x, y, z


def typed_numbers(text: object) -> tuple[float, ...]:
    """Return the finite numbers of a text, separated by commas or spaces; none if a part is no number."""
    try:
        numbers = tuple(float(part) for part in str(text).replace(";", " ").replace(",", " ").split())
    except ValueError:
        return ()
    return numbers if np.isfinite(numbers).all() else ()


def as_text(numbers: tuple[float, ...]) -> str:
    """Return numbers as a text that a user could type."""
    return ", ".join(f"{number:g}" for number in numbers)


def selected_by_words(fabric: StitchMesh, text: str) -> IntArray:
    """Return the faces that a text of the selection language names.

    Raises:
        ParameterError: an error of ``select``, or the text names a file, because a browser must not make the server
            read files.
    """
    with_paths(parse_selection(text), _refuse_file)
    return select(fabric, text)


def _refuse_file(path: str) -> str:
    raise ParameterError(f"selection: got the file {path!r}; the application reads no files by name; list the faces")
