# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The input that a user types on the page Drape: rows of numbers, and triangles in words."""

from __future__ import annotations

import numpy as np

from stitchmesh.app.pages.drape.opened_scene import OpenedScene
from stitchmesh.errors import ParameterError
from stitchmesh.mesh import IntArray
from stitchmesh.mixed.placement.chosen_region import triangles_of_faces, triangles_of_panels
from stitchmesh.selection import parse_selection, select
from stitchmesh.selection.selected_faces import in_spans
from stitchmesh.selection.selection import Faces, with_paths


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
    """Return the finite numbers of a text, separated by commas; none if a part is no number."""
    try:
        numbers = tuple(float(part) for part in str(text).replace(";", ",").split(","))
    except ValueError:
        return ()
    return numbers if np.isfinite(numbers).all() else ()


def as_text(numbers: tuple[float, ...]) -> str:
    """Return numbers as a text that a user could type."""
    return ", ".join(f"{number:g}" for number in numbers)


def triangles_named(opened: OpenedScene, text: str) -> IntArray:
    """Return the triangles that a text names, ascending.

    For a cloth of stitches the text is a selection, such as ``hem 6``. For any other cloth it holds names of panels,
    separated by commas, or is ``all``, or names triangles by their numbers, such as ``faces 3, 10-20``.

    Raises:
        ParameterError: the text names nothing that the cloth has.
    """
    words = text.strip()
    if not words:
        raise ParameterError("selection: got nothing; expected words such as hem 6, a panel, or faces 3, 10-20")
    if opened.fabric is not None:
        with_paths(parse_selection(words), _refuse_file)
        return triangles_of_faces(opened.fabric, select(opened.fabric, words))
    if words == "all":
        return np.arange(len(opened.cloth.triangles))
    if words.startswith("faces "):
        return _numbered(parse_selection(words), len(opened.cloth.triangles))
    return triangles_of_panels(opened.cloth, *(name.strip() for name in words.split(",")))


def _numbered(selection: object, count: int) -> IntArray:
    if not isinstance(selection, Faces):
        raise ParameterError("selection: got more than numbers; expected numbers alone, such as faces 3, 10-20")
    beyond = [number for span in selection.spans for number in (span.first, span.last or 0) if number >= count]
    if beyond:
        raise ParameterError(f"selection: got triangle {beyond[0]}; expected 0 to {count - 1}")
    return np.flatnonzero(in_spans(np.arange(count), selection.spans))


def _refuse_file(path: str) -> str:
    raise ParameterError(f"selection: got the file {path!r}; the application reads no files by name; list the faces")
