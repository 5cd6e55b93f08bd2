# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Colour charts as PNG: one pixel a stitch, the bottom row of pixels the first row, every stitch knit."""

from __future__ import annotations

from collections.abc import Sequence
from io import BytesIO
from os import fspath
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike, NDArray

from stitchmesh.errors import FileError, ParameterError, PatternError
from stitchmesh.io.atomic import write_bytes
from stitchmesh.io.contents import FilePath, read_bytes, suffix_of
from stitchmesh.patterns.pattern import Cell, Pattern, Row
from stitchmesh.stitch import Stitch

if TYPE_CHECKING:
    from PIL.Image import Image

MOST_COLOURS = 256
"""As many as a PNG palette holds."""
MOST_STITCHES = 4_000_000
"""More pixels than this are a photograph, not a chart."""


def read_colour_chart(path: FilePath, palette: ArrayLike | None = None) -> Pattern:
    """A pattern of knit stitches from the pixels of a PNG.

    Args:
        path: the file.
        palette: the colour of each yarn, shape (Y, 3), 0 to 255. Without it yarns are numbered by the palette of the
            file, and where that has none by their first use, from the lower left pixel to the right and upwards.

    Raises:
        FileError: the file cannot be read, is no PNG, is too large, or has transparent pixels.
        PatternError: a pixel has none of the palette's colours, or there are more than 256.
        ParameterError: the palette has a wrong shape or colours beyond 0 to 255.
    """
    suffix_of(path, (".png",))
    image = _open(path)
    if palette is None and image.mode == "P":
        yarns = np.asarray(image, dtype=np.int64)
    else:
        yarns = _numbered(np.asarray(image.convert("RGB")), palette, fspath(path))
    knits = {int(yarn): Cell(Stitch.KNIT, yarn=int(yarn)) for yarn in np.unique(yarns)}
    rows = tuple(Row(tuple(knits[yarn] for yarn in row)) for row in yarns[::-1].tolist())
    return Pattern(Path(path).stem.replace('"', "'"), "", rows)


def write_colour_chart(path: FilePath, pattern: Pattern, palette: ArrayLike) -> None:
    """Write a pattern of knit stitches as a PNG with a palette.

    Args:
        path: the file.
        pattern: a pattern of plain knit stitches without borders.
        palette: the colour of each yarn, shape (Y, 3), 0 to 255, two to be told apart.

    Raises:
        PatternError: the pattern holds more than knit stitches.
        ParameterError: the palette has a wrong shape, colours beyond 0 to 255, or too few of them.
        FileError: the suffix is not ``.png``, or the file cannot be written.
    """
    suffix_of(path, (".png",))
    colours = _checked(palette)
    yarns = _yarns(pattern)
    if pattern.yarn_count > len(colours):
        found = f"got {len(colours)} colours for yarns 0 to {pattern.yarn_count - 1}"
        raise ParameterError(f"palette: {found}; expected one for each")
    from PIL import Image

    image = Image.fromarray(yarns[::-1].astype(np.uint8), mode="P")
    image.putpalette(colours.tobytes())
    content = BytesIO()
    image.save(content, format="PNG")
    write_bytes(path, content.getvalue())


def chart_palette(path: FilePath) -> NDArray[np.uint8]:
    """The colour of each yarn of a colour chart, numbered as ``read_colour_chart`` numbers them, shape (Y, 3).

    Raises:
        FileError: as for ``read_colour_chart``.
        PatternError: there are more than 256 colours.
    """
    image = _open(path)
    if image.mode == "P":
        return np.array(image.getpalette("RGB"), dtype=np.uint8).reshape(-1, 3)
    return _first_used(np.asarray(image.convert("RGB")), fspath(path))


def _open(path: FilePath) -> Image:
    from PIL import Image, UnidentifiedImageError

    name = fspath(path)
    try:
        image = Image.open(BytesIO(read_bytes(path)), formats=["PNG"])
        if image.width * image.height > MOST_STITCHES:
            found = f"{image.width} x {image.height} pixels"
            raise FileError(f"{name}: has {found}, one a stitch; expected {MOST_STITCHES} at most, scale it down")
        image.load()
    except (OSError, ValueError, SyntaxError, Image.DecompressionBombError) as error:
        reason = "it is no image" if isinstance(error, UnidentifiedImageError) else error
        raise FileError(f"{name}: is not a whole PNG ({reason}); write it again as PNG") from error
    if image.convert("RGBA").getchannel("A").getextrema() != (255, 255):
        raise FileError(f"{name}: has transparent pixels; fill every stitch with a colour")
    return image


def _numbered(pixels: NDArray, palette: ArrayLike | None, name: str) -> NDArray[np.int64]:
    colours = _first_used(pixels, name) if palette is None else _checked(palette)
    numbers = {colour: number for number, colour in reversed(list(enumerate(_packed(colours).tolist())))}
    packed = _packed(pixels)
    strange = ~np.isin(packed[::-1], list(numbers))
    if strange.any():
        row, column = divmod(int(strange.argmax()), pixels.shape[1])
        found = "#" + "".join(f"{part:02x}" for part in pixels[::-1][row, column])
        where = f"row {row + 1}, stitch {column + 1} from the left"
        raise PatternError(f"{name}: {where}: got colour {found}; expected one of the {len(colours)} of the palette")
    return np.vectorize(numbers.__getitem__, otypes=[np.int64])(packed)


def _first_used(pixels: NDArray, name: str) -> NDArray[np.uint8]:
    flat = pixels[::-1].reshape(-1, 3)
    _, first = np.unique(_packed(flat), return_index=True)
    if len(first) > MOST_COLOURS:
        found = f"got {len(first)} colours"
        raise PatternError(f"{name}: {found}; expected {MOST_COLOURS} at most, reduce them to those of the yarns")
    return np.asarray(flat[np.sort(first)], dtype=np.uint8)


def _packed(colours: NDArray) -> NDArray[np.int64]:
    return np.asarray(colours, dtype=np.int64) @ np.array([65536, 256, 1])


def _checked(palette: ArrayLike) -> NDArray[np.uint8]:
    try:
        colours = np.asarray(palette, dtype=np.float64)
    except (TypeError, ValueError) as error:
        raise ParameterError(f"palette: got {palette!r}; expected rows of red, green and blue, 0 to 255") from error
    if colours.ndim != 2 or colours.shape[1:] != (3,) or not 1 <= len(colours) <= MOST_COLOURS:
        raise ParameterError(f"palette: got shape {colours.shape}; expected (Y, 3) with 1 to {MOST_COLOURS} yarns")
    if not ((colours >= 0) & (colours <= 255) & (colours == np.round(colours))).all():
        raise ParameterError("palette: got colours beyond 0 to 255, or fractions; expected whole numbers in between")
    return colours.astype(np.uint8)


def _yarns(pattern: Pattern) -> NDArray[np.int64]:
    rows: Sequence[Row] = pattern.rows
    for index, row in enumerate(rows):
        plain = all(cell.stitch == Stitch.KNIT and cell.twist == (0,) for cell in row.cells)
        if not plain or row.left or row.right or any(loop.shift or loop.twist for loop in row.loops):
            found = "holds more than plain knit stitches of one tile"
            raise PatternError(f"pattern {pattern.name!r}, row {index + 1}: {found}; a colour chart has no more")
    return np.array([[cell.yarn for cell in row.cells] for row in rows], dtype=np.int64)
