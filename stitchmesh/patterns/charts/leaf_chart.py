# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Tile codes as a painted PNG: one pixel a character of a code, as Leaf et al. 2018, section 7.1, paints patterns."""

from __future__ import annotations

from os import fspath

import numpy as np

from stitchmesh.io.contents import FilePath, suffix_of
from stitchmesh.patterns.charts.chart_image import number_pixels, open_chart, write_numbers
from stitchmesh.patterns.language.leaf_codes import leaf_codes, parse_leaf_codes
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
"""How the name of such a file ends, so that ``read_pattern`` knows it from a chart of yarn colours."""


def read_leaf_chart(path: FilePath) -> Pattern:
    """A pattern from a PNG painted with ``PALETTE``, its top row of pixels the last row.

    Raises:
        FileError: the file cannot be read, is no PNG, is too large, or has transparent pixels.
        PatternError: a pixel has none of the palette's colours, or characters side by side are no code; lines and
            columns are those of the pixels, from the upper left.
    """
    suffix_of(path, (".png",))
    colours = np.array(list(PALETTE.values()), dtype=np.uint8)
    numbers = number_pixels(np.asarray(open_chart(path).convert("RGB")), colours, fspath(path))
    characters = np.array(list(PALETTE))[numbers]
    return parse_leaf_codes("\n".join("".join(line) for line in characters), fspath(path))


def write_leaf_chart(path: FilePath, pattern: Pattern) -> None:
    """Write a pattern as a PNG: ``read_leaf_chart`` reads the same rows.

    Raises:
        PatternError: the pattern holds what has no tile code.
        FileError: the suffix is not ``.png``, or the file cannot be written.
    """
    suffix_of(path, (".png",))
    number = {character: index for index, character in enumerate(PALETTE)}
    numbers = [[number[character] for character in line] for line in leaf_codes(pattern).splitlines()]
    write_numbers(path, np.array(numbers), np.array(list(PALETTE.values()), dtype=np.uint8))
