# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""What a swatch is a repeat of: a knitting pattern or a weave, by name, from a file or as a value."""

from __future__ import annotations

import difflib
from os import fspath
from pathlib import Path

from stitchmesh.errors import ParameterError
from stitchmesh.io.contents import FilePath, read_lines
from stitchmesh.patterns import Pattern, pattern_names, read_pattern
from stitchmesh.periodic.weave.library import SUFFIX, read_weave, weave_names
from stitchmesh.periodic.weave.weave import Weave

Source = Pattern | Weave


def resolve_pattern(given: FilePath | Source) -> Source:
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
        return _from_library(name)
    if path.suffix.lower() == SUFFIX or name.lower().endswith(f"{SUFFIX}.png") or _is_matrix(path):
        return read_weave(path)
    return read_pattern(path)


def _from_library(name: str) -> Source:
    if name in pattern_names():
        return read_pattern(name)
    if name in weave_names():
        return read_weave(name)
    every = (*pattern_names(), *weave_names())
    near = difflib.get_close_matches(name.lower(), every, n=3, cutoff=0.4)
    hint = f"did you mean {' or '.join(near)}?" if near else "a file needs its suffix"
    raise ParameterError(f"pattern {name!r}: is not in the library of {len(every)} patterns and weaves; {hint}")


def _is_matrix(path: Path) -> bool:
    """Whether a text file begins with a line of 0 and 1."""
    if path.suffix.lower() != ".txt":
        return False
    first = next((line for line in read_lines(path) if line.strip()), "")
    return set(first.replace(" ", "")) <= {"0", "1"} and bool(first.strip())
