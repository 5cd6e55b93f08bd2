# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Colour charts as images: one pixel for each knit stitch; the bottom row of pixels is the first row of the pattern."""

from __future__ import annotations

from collections.abc import Sequence
from os import fspath
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike, NDArray

from stitchmesh.errors import ParameterError, PatternError
from stitchmesh.io.contents import FilePath, suffix_of
from stitchmesh.mesh.stitch import Stitch
from stitchmesh.patterns.charts.chart_image import (
    checked_palette,
    colours_in_order_of_use,
    number_pixels,
    open_chart,
    write_numbers,
)
from stitchmesh.patterns.pattern import Cell, Pattern, Row

if TYPE_CHECKING:
    from PIL.Image import Image


def read_colour_chart(path: FilePath, palette: ArrayLike | None = None) -> Pattern:
    """Read a pattern of knit stitches from the pixels of an image.

    Args:
        path: the file.
        palette: the colour of each yarn, shape (Y, 3), 0 to 255. Without a palette, the yarns are numbered by the
            palette of a PNG. If there is none either, the yarns are numbered by the first use of their colours, from
            the lower left pixel to the right and upwards.

    Raises:
        FileError: the file cannot be read, is no image of its suffix, is too large, or has transparent pixels.
        PatternError: a pixel has none of the palette's colours, or the image has more than 256 colours.
        ParameterError: the palette has a wrong shape, or a colour is not a whole number from 0 to 255.
    """
    yarns, colours = read_numbers(path, palette)
    knits = {int(yarn): Cell(Stitch.KNIT, yarn=int(yarn)) for yarn in np.unique(yarns)}
    rows = tuple(Row(tuple(knits[yarn] for yarn in row)) for row in yarns[::-1].tolist())
    own = tuple((int(red), int(green), int(blue)) for red, green, blue in colours[: int(yarns.max()) + 1])
    return Pattern(Path(path).stem.replace('"', "'"), "", rows, own)


def read_numbers(
    path: FilePath, palette: ArrayLike | None = None
) -> tuple[NDArray[np.int64], NDArray[np.uint8]]:
    """Read the number of the colour of each pixel of an image.

    Args:
        path: the file.
        palette: the colour of each number; None has the meaning that ``read_colour_chart`` gives it.

    Returns:
        The numbers, shape (rows, columns), the top row first, and the colour of each number, shape (C, 3).

    Raises:
        FileError, PatternError, ParameterError: an error of ``read_colour_chart``.
    """
    image = open_chart(path)
    if palette is None and image.mode == "P":
        return np.asarray(image, dtype=np.int64), _file_palette(image)
    pixels = np.asarray(image.convert("RGB"))
    colours = colours_in_order_of_use(pixels, fspath(path)) if palette is None else checked_palette(palette)
    return number_pixels(pixels, colours, fspath(path)), colours


def write_colour_chart(path: FilePath, pattern: Pattern, palette: ArrayLike) -> None:
    """Write a pattern of knit stitches as a PNG with a palette.

    Args:
        path: the file.
        pattern: a pattern of plain knit stitches without borders.
        palette: the colour of each yarn, shape (Y, 3), 0 to 255; the colours must differ.

    Raises:
        PatternError: the pattern holds more than knit stitches.
        ParameterError: the palette has a wrong shape, has colours beyond 0 to 255, or has fewer colours than yarns.
        FileError: the suffix is not ``.png``, or the file cannot be written.
    """
    suffix_of(path, (".png",))
    colours = checked_palette(palette)
    yarns = _yarns(pattern)
    if pattern.yarn_count > len(colours):
        found = f"got {len(colours)} colours for yarns 0 to {pattern.yarn_count - 1}"
        raise ParameterError(f"palette: {found}; expected one for each yarn")
    write_numbers(path, yarns[::-1], colours)


def chart_palette(path: FilePath) -> NDArray[np.uint8]:
    """Return the colour of each yarn of a colour chart, shape (Y, 3), as ``read_colour_chart`` numbers the yarns.

    Raises:
        FileError: the file cannot be read, is no image of its suffix, is too large, or has transparent pixels.
        PatternError: the image has more than 256 colours.
    """
    image = open_chart(path)
    if image.mode == "P":
        return _file_palette(image)
    return colours_in_order_of_use(np.asarray(image.convert("RGB")), fspath(path))


def _file_palette(image: Image) -> NDArray[np.uint8]:
    """The palette of a PNG that has one, shape (C, 3)."""
    return np.array(image.getpalette("RGB"), dtype=np.uint8).reshape(-1, 3)


def _yarns(pattern: Pattern) -> NDArray[np.int64]:
    rows: Sequence[Row] = pattern.rows
    for index, row in enumerate(rows):
        plain = all(cell.stitch == Stitch.KNIT and cell.twist == (0,) for cell in row.cells)
        if not plain or row.left or row.right or any(loop.shift or loop.twist for loop in row.loops):
            found = "holds more than plain knit stitches of one tile"
            raise PatternError(f"pattern {pattern.name!r}, row {index + 1}: {found}; a colour chart cannot show more")
    return np.array([[cell.yarn for cell in row.cells] for row in rows], dtype=np.int64)
