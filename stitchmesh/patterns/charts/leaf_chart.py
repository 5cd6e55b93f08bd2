# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Tile codes as a PNG: one pixel for each character of a code, as Leaf et al. 2018, section 7.1, paint patterns."""

from __future__ import annotations

from os import fspath

import numpy as np

from stitchmesh.io.atomic import write_bytes
from stitchmesh.io.contents import FilePath, suffix_of
from stitchmesh.patterns.charts.chart_image import number_pixels, open_chart, png_of_numbers
from stitchmesh.patterns.language.text_charts import leaf_codes, parse_leaf_codes
from stitchmesh.patterns.pattern import Pattern

PALETTE: dict[str, tuple[int, int, int]] = {
    "K": (244, 236, 216),
    "P": (79, 109, 143),
    "F": (209, 73, 91),
    "B": (46, 139, 87),
    "Y": (242, 193, 78),
    "S": (155, 93, 229),
    "2": (224, 122, 45),
    "U": (111, 69, 24),
    "3": (0, 166, 166),
}
"""The colour of each character: red, green and blue, 0 to 255."""
SUFFIX = ".leaf.png"
"""Suffix of such a file; ``read_pattern`` uses it to distinguish tile codes from a chart of yarn colours."""


def read_leaf_chart(path: FilePath) -> Pattern:
    """Read a pattern from a PNG painted with ``PALETTE``; the top row of pixels is the last row of the pattern.

    Raises:
        FileError: the file cannot be read, is not a PNG, is too large, or has transparent pixels.
        PatternError: a pixel has none of the palette's colours, or adjacent characters form no code; the message counts
            lines and columns of pixels from the upper left.
    """
    suffix_of(path, (".png",))
    colours = np.array(list(PALETTE.values()), dtype=np.uint8)
    numbers = number_pixels(np.asarray(open_chart(path).convert("RGB")), colours, fspath(path))
    characters = np.array(list(PALETTE))[numbers]
    return parse_leaf_codes("\n".join("".join(line) for line in characters), fspath(path))


def write_leaf_chart(path: FilePath, pattern: Pattern) -> None:
    """Write a pattern as a PNG from which ``read_leaf_chart`` reads the same rows.

    Raises:
        PatternError: the pattern holds stitches, borders or marks that have no tile code.
        FileError: the suffix is not ``.png``, or the file cannot be written.
    """
    suffix_of(path, (".png",))
    write_bytes(path, leaf_image(pattern))


def leaf_image(pattern: Pattern) -> bytes:
    """Return the content of the PNG that ``write_leaf_chart`` writes.

    Raises:
        PatternError: the pattern holds stitches, borders or marks that have no tile code.
    """
    number = {character: index for index, character in enumerate(PALETTE)}
    numbers = [[number[character] for character in line] for line in leaf_codes(pattern).splitlines()]
    return png_of_numbers(np.array(numbers), np.array(list(PALETTE.values()), dtype=np.uint8))
