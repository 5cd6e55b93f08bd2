# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The pattern of a swatch: a knitting pattern or a weave, given by name, by file or as an object."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from os import fspath
from pathlib import Path

from stitchmesh.io.contents import FilePath, check_path, read_lines
from stitchmesh.mesh.own_stitch import OwnStitch
from stitchmesh.patterns import Pattern, pattern_names, read_pattern
from stitchmesh.patterns.charts.chart_image import CHART_IMAGES
from stitchmesh.patterns.library import unknown_name
from stitchmesh.periodic.weave.library import SUFFIX, read_weave, weave_names
from stitchmesh.periodic.weave.weave import Weave
from stitchmesh.periodic.weave.wif import SUFFIX as DRAFT

Source = Pattern | Weave
WEAVE_STATEMENTS = ("weave", "layer", "stitch", "wefts", "warps")
"""First words of statements that only texts of weaves have."""


def resolve_pattern(given: FilePath | Source, stitches: Iterable[OwnStitch] = ()) -> Source:
    """Return a pattern or a weave.

    Args:
        given: a pattern or a weave, the name of one in the library, or the path of a file. A weave is read from a
            ``.weave`` file, from the draft of a loom (``.wif``), from a ``.txt`` file that begins with a statement of a
            weave, or from an image of two colours (``.weave.png``, also ``.gif``, ``.bmp`` and ``.tif``); a pattern is
            read from any other file. A ``.txt`` file of digits alone is a chart of yarn colours.
        stitches: stitches of your own, whose codes the file of a pattern may use as words.

    Raises:
        FileError: the file cannot be read.
        ParameterError: the library has no pattern or weave of that name.
        PatternError: the file does not describe a valid pattern or weave.
    """
    if isinstance(given, Pattern | Weave):
        return given
    check_path(given)
    path = Path(given)
    name = fspath(given)
    if path.name == name and not path.suffix:
        return _from_library(name)
    suffix = path.suffix.lower()
    is_image = suffix in CHART_IMAGES and path.stem.lower().endswith(SUFFIX)
    if suffix in (SUFFIX, DRAFT) or is_image or (suffix == ".txt" and states_a_weave(read_lines(path))):
        return read_weave(path)
    return read_pattern(path, stitches)


def _from_library(name: str) -> Source:
    if name in pattern_names():
        return read_pattern(name)
    if name in weave_names():
        return read_weave(name)
    raise unknown_name("pattern", name, (*pattern_names(), *weave_names()), "patterns and weaves")


def states_a_weave(lines: Sequence[str]) -> bool:
    """Return whether a line of a text begins with a word that only texts of weaves have."""
    words = {line.split()[0].lower() for line in lines if line.strip()}
    return not words.isdisjoint(WEAVE_STATEMENTS)


def stitches_of(source: Source) -> int:
    """Return the number of stitches of a repeat, or the number of crossings of a weave."""
    if isinstance(source, Weave):
        return len(source.matrix) * len(source.matrix[0])
    return source.width * source.height
