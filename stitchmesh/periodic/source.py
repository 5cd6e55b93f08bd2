# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""What a swatch is a repeat of: a knitting pattern or a weave, by name, from a file or as a value."""

from __future__ import annotations

from os import fspath
from pathlib import Path

from stitchmesh.io.contents import FilePath, read_lines
from stitchmesh.patterns import Pattern, pattern_names, read_pattern
from stitchmesh.periodic.weave import Weave
from stitchmesh.periodic.weave_library import SUFFIX, read_weave, weave_names

Source = Pattern | Weave


def pattern_or_weave(given: FilePath | Source) -> Source:
    """A pattern or a weave.

    Args:
        given: either; the name of one of the library; or the path of a file: ``.weave`` or a text of 0 and 1 for a
            weave, an image of two colours whose name ends in ``.weave.png``, all else for a pattern.

    Raises:
        FileError: the file cannot be read.
        ParameterError: the library has neither a pattern nor a weave of that name.
        PatternError: the file says neither.
    """
    if isinstance(given, Pattern | Weave):
        return given
    path = Path(given)
    name = fspath(given)
    if path.name == name and not path.suffix:
        return read_weave(name) if name in weave_names() and name not in pattern_names() else read_pattern(name)
    if path.suffix.lower() == SUFFIX or name.lower().endswith(f"{SUFFIX}.png") or _is_matrix(path):
        return read_weave(path)
    return read_pattern(path)


def _is_matrix(path: Path) -> bool:
    """Whether a text file begins with a line of 0 and 1."""
    if path.suffix.lower() != ".txt":
        return False
    first = next((line for line in read_lines(path) if line.strip()), "")
    return set(first.replace(" ", "")) <= {"0", "1"} and bool(first.strip())


