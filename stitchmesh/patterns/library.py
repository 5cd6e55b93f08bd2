# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The library of patterns that comes with the package, and patterns from files."""

from __future__ import annotations

import difflib
from functools import cache
from os import fspath
from pathlib import Path

from stitchmesh.errors import ParameterError
from stitchmesh.io.contents import FilePath, read_lines
from stitchmesh.patterns.charts.colour_chart import read_colour_chart
from stitchmesh.patterns.charts.leaf_chart import SUFFIX as LEAF_SUFFIX
from stitchmesh.patterns.charts.leaf_chart import read_leaf_chart
from stitchmesh.patterns.language.leaf_codes import parse_leaf_codes
from stitchmesh.patterns.language.parse import begins_with_statement, parse_pattern
from stitchmesh.patterns.pattern import Pattern

SUFFIX = ".knit"
_PACKAGE = Path(__file__).resolve().parent.parent
_FOLDERS = (_PACKAGE / "assets" / "patterns", _PACKAGE.parent / "assets" / "patterns")
"""Where the library lies: in an installed package, or beside it in the repository."""


def pattern_names() -> tuple[str, ...]:
    """The names of the library's patterns, sorted."""
    return tuple(sorted(path.stem for path in _folder().glob(f"*{SUFFIX}")))


def read_pattern(name_or_path: FilePath) -> Pattern:
    """A pattern of the library, or of a file.

    Args:
        name_or_path: a name of ``pattern_names``, such as ``rib2x2``; else the path of a text file in the language of
            ``docs/patterns.md``, of tile codes alone (``.leaf``, or ``.txt`` that does not begin with a statement), of
            tile codes painted (``.leaf.png``), or of a colour chart (``.png``). What has neither folder nor suffix is
            a name.

    Raises:
        ParameterError: the library has no pattern of that name.
        FileError: the file cannot be read, is empty or holds binary data.
        PatternError: the text says no pattern; with line and column.
    """
    path = Path(name_or_path)
    if path.name == fspath(name_or_path) and not path.suffix:
        return _from_library(path.name)
    if path.name.lower().endswith(LEAF_SUFFIX):
        return read_leaf_chart(path)
    suffix = path.suffix.lower()
    if suffix == ".png":
        return read_colour_chart(path)
    text = "\n".join(read_lines(path))
    if suffix == ".leaf" or (suffix == ".txt" and not begins_with_statement(text)):
        return parse_leaf_codes(text, fspath(name_or_path))
    return parse_pattern(text, fspath(name_or_path))


@cache
def _from_library(name: str) -> Pattern:
    path = _folder() / f"{name}{SUFFIX}"
    if name not in pattern_names():
        near = difflib.get_close_matches(name.lower(), pattern_names(), n=3, cutoff=0.4)
        hint = f"did you mean {' or '.join(near)}?" if near else "a file needs its suffix"
        raise ParameterError(f"pattern {name!r}: is not in the library of {len(pattern_names())} patterns; {hint}")
    return parse_pattern("\n".join(read_lines(path)), path.name)


def _folder() -> Path:
    return next((folder for folder in _FOLDERS if folder.is_dir()), _FOLDERS[0])
