# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The library of weaves that comes with the package, and the reading of weaves from files."""

from __future__ import annotations

from functools import cache
from os import fspath
from pathlib import Path

from stitchmesh.io.contents import FilePath, check_path, read_lines
from stitchmesh.patterns.charts.chart_image import CHART_IMAGES
from stitchmesh.patterns.library import pattern_folder, unknown_name
from stitchmesh.periodic.weave.image import read_weave_image
from stitchmesh.periodic.weave.text import parse_weave
from stitchmesh.periodic.weave.weave import Weave
from stitchmesh.periodic.weave.wif import SUFFIX as DRAFT
from stitchmesh.periodic.weave.wif import parse_wif

SUFFIX = ".weave"


def weave_names() -> tuple[str, ...]:
    """Return the names of the library's weaves, sorted."""
    return tuple(sorted(path.stem for path in pattern_folder().glob(f"*{SUFFIX}")))


def read_weave(name_or_path: FilePath) -> Weave:
    """Read a weave from the library or from a file.

    Args:
        name_or_path: a name of ``weave_names``, such as ``satin-2x3``, or the path of a file. The file is a text in the
            language of ``weave/text.py``, the draft of a loom (``.wif``), or an image of two colours (``.png``,
            ``.gif``, ``.bmp``, ``.tif``). A string with neither a folder nor a suffix is taken as a name.

    Raises:
        ParameterError: the library has no weave of that name.
        FileError: the file cannot be read, is empty or holds binary data.
        PatternError: the file does not describe a weave, or describes a weave that falls apart.
    """
    check_path(name_or_path)
    path = Path(name_or_path)
    if path.name == fspath(name_or_path) and not path.suffix:
        return _from_library(path.name)
    if path.suffix.lower() in CHART_IMAGES:
        return read_weave_image(path)
    if path.suffix.lower() == DRAFT:
        return parse_wif("\n".join(read_lines(path)), fspath(name_or_path))
    return parse_weave("\n".join(read_lines(path)), fspath(name_or_path))


@cache
def _from_library(name: str) -> Weave:
    if name not in weave_names():
        raise unknown_name("weave", name, weave_names(), "weaves")
    path = pattern_folder() / f"{name}{SUFFIX}"
    return parse_weave("\n".join(read_lines(path)), path.name)
