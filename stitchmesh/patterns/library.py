# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The library of patterns that comes with the package, and the reading of patterns from files."""

from __future__ import annotations

import difflib
import logging
import re
from collections.abc import Iterable, Sequence
from functools import cache
from os import fspath
from pathlib import Path

from stitchmesh.errors import FileError, ParameterError, PatternError
from stitchmesh.hand_knitting.parse import FIRST_WORDS
from stitchmesh.io.contents import FilePath, check_path, read_bytes, read_lines
from stitchmesh.mesh.own_stitch import OwnStitch
from stitchmesh.patterns.capture.from_instructions import pattern_from_instructions
from stitchmesh.patterns.charts.chart_image import CHART_IMAGES, OTHER_IMAGES, picture_text
from stitchmesh.patterns.charts.colour_chart import read_colour_chart
from stitchmesh.patterns.charts.leaf_chart import SUFFIX as LEAF_SUFFIX
from stitchmesh.patterns.charts.leaf_chart import read_leaf_chart
from stitchmesh.patterns.language.parse import begins_with_statement, parse_pattern
from stitchmesh.patterns.language.text_charts import holds_digits, parse_colour_digits, parse_leaf_codes
from stitchmesh.patterns.pattern import Pattern

SUFFIX = ".knit"
READ_AS_COLOURS = "read as a chart of yarn colours, one digit for each stitch; name a matrix of a weave .weave"
"""Note on a text of digits, which could also be the matrix of a weave."""
FREE_WORDS = re.compile(r"\((?:RS|WS)\)|\brep(?:eat)? from|;\s*rep(?:eat)?\b|\bsts?\b", re.IGNORECASE)
"""Words of free instructions as people write them; the language of patterns does not have them."""
IMAGES = "PNG, GIF, BMP or TIFF"
READ_AS_PATTERN = (
    "the language of patterns ('row 1 RS: k2 [k2tog yo]*3'), instructions that StitchMesh wrote, tile codes, yarn "
    f"numbers or a chart as {IMAGES}"
)
"""The kinds of text that are read as a pattern, for messages."""
logger = logging.getLogger(__name__)
_PACKAGE = Path(__file__).resolve().parent.parent
_PATTERN_FOLDERS = (_PACKAGE / "assets" / "patterns", _PACKAGE.parent / "assets" / "patterns")
"""Folders that may hold the library: inside an installed package, or beside the package in the repository."""
FAMILIES = ("Knit and purl", "Cables", "Lace", "Slipped and tucked", "Colours")
"""Names of the families, in the order of a list."""


def pattern_folder() -> Path:
    """Return the folder that holds the patterns and the weaves of the library."""
    return next((folder for folder in _PATTERN_FOLDERS if folder.is_dir()), _PATTERN_FOLDERS[0])


def pattern_names() -> tuple[str, ...]:
    """Return the names of the library's patterns, sorted."""
    return tuple(sorted(path.stem for path in pattern_folder().glob(f"*{SUFFIX}")))


def read_pattern(name_or_path: FilePath, stitches: Iterable[OwnStitch] = ()) -> Pattern:
    """Read a pattern from the library or from a file.

    Args:
        name_or_path: a name of ``pattern_names``, such as ``rib2x2``, or the path of a file. The file is a text in the
            language of ``docs/patterns.md``, a text of tile codes alone (``.leaf``, or ``.txt`` that does not begin
            with a statement), written instructions of one piece (``.txt``), a text of yarn numbers alone (``.txt``
            whose first line is digits), an image of tile codes (``.leaf.png``), a picture of a chart that holds its
            text, or an image of yarn colours (``.png``, ``.gif``, ``.bmp``, ``.tif``). A string with neither a folder
            nor a suffix is a name.
        stitches: stitches of your own, whose codes a text may use as words.

    Raises:
        ParameterError: the library has no pattern of that name.
        FileError: the file cannot be read, is empty or holds binary data.
        PatternError: the file does not describe a valid pattern; the message gives the line and the column.
    """
    check_path(name_or_path)
    path = Path(name_or_path)
    if path.name == fspath(name_or_path) and not path.suffix:
        return _from_library(path.name)
    if path.name.lower().endswith(LEAF_SUFFIX):
        return read_leaf_chart(path)
    suffix = path.suffix.lower()
    if suffix in OTHER_IMAGES:
        read_bytes(path)
        found = f"{suffix[1:].upper()} does not keep the colour of each pixel"
        raise FileError(f"{fspath(path)}: {found}; save the chart as {IMAGES}, with one pixel for each stitch")
    if suffix in CHART_IMAGES:
        held = picture_text(fspath(name_or_path), read_bytes(path))
        return read_colour_chart(path) if held is None else parse_pattern(held, fspath(name_or_path), stitches)
    text = "\n".join(read_lines(path))
    try:
        return _of_text(text, suffix, fspath(name_or_path), stitches)
    except PatternError as error:
        own = text.startswith(FIRST_WORDS)  # Instructions that StitchMesh wrote have messages of their own.
        free = FREE_WORDS.search(text) if suffix == ".txt" and not own else None
        if free is None:
            raise
        found = f"line {text[: free.start()].count(chr(10)) + 1}: got {free[0]!r}, as in instructions that people write"
        raise PatternError(f"{fspath(path)}: {found}; expected {READ_AS_PATTERN}") from error


def _of_text(text: str, suffix: str, name: str, stitches: Iterable[OwnStitch]) -> Pattern:
    """Return the pattern of a text; the suffix and the first words decide the kind of text."""
    if suffix == ".txt" and holds_digits(text):
        logger.warning("%s: %s", name, READ_AS_COLOURS)
        return parse_colour_digits(text, name)
    if suffix == ".txt" and text.startswith(FIRST_WORDS):
        return pattern_from_instructions(text, name)
    if suffix == ".leaf" or (suffix == ".txt" and not begins_with_statement(text)):
        return parse_leaf_codes(text, name)
    return parse_pattern(text, name, stitches)


@cache
def _from_library(name: str) -> Pattern:
    path = pattern_folder() / f"{name}{SUFFIX}"
    if name not in pattern_names():
        raise unknown_name("pattern", name, pattern_names(), "patterns")
    return parse_pattern("\n".join(read_lines(path)), path.name)


def unknown_name(what: str, name: str, names: Sequence[str], kinds: str) -> ParameterError:
    """Return the error for a name that the library does not have; ``kinds`` says what its ``names`` are names of."""
    near = difflib.get_close_matches(name.lower(), names, n=3, cutoff=0.4)
    hint = f"did you mean {' or '.join(near)}?" if near else "the path of a file needs its suffix"
    return ParameterError(f"{what} {name!r}: is not in the library of {len(names)} {kinds}; {hint}")


def family_of(pattern: Pattern) -> str:
    """Return the family of a pattern: the last of ``FAMILIES`` whose stitches the pattern has."""
    if pattern.yarn_count > 1:
        return "Colours"
    makings = [cell.making for row in pattern.rows for cell in row.cells]
    if any("s" in making.made for making in makings):
        return "Slipped and tucked"
    if any((making.n_bottom, making.n_top) != (1, 1) for making in makings):
        return "Lace"
    return "Cables" if any(loop.shift for row in pattern.rows for loop in row.loops) else "Knit and purl"
