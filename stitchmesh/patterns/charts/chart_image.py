# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Charts as images with one pixel for each square: pixels to numbers by a palette, and numbers to pixels.

PNG is read and written. GIF, BMP and TIFF are read too (``other_images``), and all of them are lossless.
"""

from __future__ import annotations

import struct
import warnings
import zlib
from collections.abc import Iterator
from contextlib import contextmanager
from io import BytesIO
from os import fspath
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike, NDArray

from stitchmesh.errors import FileError, ParameterError, PatternError
from stitchmesh.io.atomic import write_bytes
from stitchmesh.io.contents import FilePath, check_expansion, read_bytes, suffix_of
from stitchmesh.patterns.charts.other_images import read_other_image

if TYPE_CHECKING:
    from PIL.Image import Image

MAX_COLOURS = 256
"""Maximum number of colours, the size of a PNG palette."""
LARGEST_PICTURE = 20_000_000
"""Maximum number of pixels of a picture that may hold the text of a chart; its pixels are not read."""
LONGEST_SIDE = 10_000
"""Maximum number of pixels of a row or a column: each row of a pattern takes about 1 kB. A circular knitting machine of
30 inches with 28 needles an inch has 2,640 needles."""

CHART_IMAGES = (".png", ".gif", ".bmp", ".tif", ".tiff")
"""Suffixes of images that can be charts."""
OTHER_IMAGES = (".jpg", ".jpeg", ".jfif", ".jp2", ".webp", ".avif", ".heic", ".psd", ".svg", ".pdf", ".eps")
"""Suffixes of images that cannot be charts, because they mix the colours of neighbouring pixels or hold no pixels."""
TEXT_KEY = "stitchmesh chart"
"""Name under which a picture of a chart holds the text of the chart, from which it is read again."""
PNG_BEGINS = b"\x89PNG\r\n\x1a\n"
"""First bytes of a PNG."""
PNG_DAMAGES = (OSError, ValueError, SyntaxError, EOFError, struct.error, zlib.error)
"""Errors that the library of images raises for damaged files."""


def open_chart(path: FilePath) -> Image:
    """Open an image whose pixels have 8 bits; the palette of a PNG stays as it is.

    Raises:
        FileError: the file cannot be read, is no image of the suffix, is too large, or has transparent pixels or pixels
            without a colour.
    """
    from PIL import Image

    if suffix_of(path, CHART_IMAGES) != ".png":
        return Image.fromarray(read_other_image(path))
    name = fspath(path)
    image = opened_png(name, read_bytes(path))
    return loaded_chart(name, image)


def loaded_chart(name: str, image: Image, form: str = "PNG") -> Image:
    """Return a chart with its pixels, of 8 bits each.

    Raises:
        FileError: an error of ``open_chart``.
    """
    # Maximum number of pixels; a larger image is probably a photograph and not a chart.
    _check_pixels(name, image.width, image.height, 1_000_000)
    if max(image.size) > LONGEST_SIDE:
        raise FileError(f"{name}: has {image.width} x {image.height} pixels; expected sides of {LONGEST_SIDE} at most")
    with image_damages(name, form):
        image.load()
        image = _of_8_bits(image)
        opaque = image.convert("RGBA").getchannel("A").getextrema() == (255, 255)
    held = len(image.getpalette("RGB") or []) // 3
    if image.mode == "P" and int(np.asarray(image).max()) >= held:
        raise FileError(f"{name}: has pixels without a colour, the palette holds {held}; write it again as PNG")
    if not opaque:
        raise FileError(f"{name}: has transparent pixels; fill every stitch with a colour")
    return image


def _of_8_bits(image: Image) -> Image:
    """Return an image of 8 bits; greys of 16 bits, which the library would cut off, become the nearest greys."""
    from PIL import Image

    if not image.mode.startswith("I"):
        return image
    greys = np.asarray(image).astype(np.int64)
    if greys.min(initial=0) < 0 or greys.max(initial=0) > 65535:
        raise ValueError("its greys have more than 16 bits")
    grey = Image.fromarray(np.rint(greys / 257).astype(np.uint8))
    clear = image.info.get("transparency")
    if clear is not None and (greys == clear).any():
        grey.putalpha(Image.fromarray(np.where(greys == clear, 0, 255).astype(np.uint8)))
    return grey


def opened_png(name: str, content: bytes) -> Image:
    """Open a PNG image, whose pixels are not yet read.

    Raises:
        FileError: it is not a PNG, or is too large; its size is checked before the library of images sees it.
    """
    from PIL import Image

    # The bytes of a PNG that hold its width and its height, each in four bytes, the highest first
    width, height = (int.from_bytes(content[start : start + 4], "big") for start in (16, 20))
    _check_pixels(name, width if content.startswith(PNG_BEGINS) else 0, height, LARGEST_PICTURE)
    with image_damages(name):
        image = Image.open(BytesIO(content), formats=["PNG"])
    _check_pixels(name, image.width, image.height, LARGEST_PICTURE)  # A damaged file can state two sizes.
    return image


def picture_text(name: str, content: bytes) -> str | None:
    """Return the text of the chart in a picture of ``chart_picture``; None for any other content.

    Raises:
        FileError: the compressed text is very much longer than the file.
    """
    if not content.startswith(PNG_BEGINS):
        return None
    try:
        held = opened_png(name, content).info.get(TEXT_KEY)
    except FileError:
        return None  # the reader of images gives the reason
    if not isinstance(held, str):
        return None
    try:
        check_expansion(130 * len(held), len(content))  # bytes of memory that a character takes while it is read
    except ValueError as error:
        raise FileError(f"{name}: the text of its chart is too long ({error}); write it again") from error
    return held


@contextmanager
def image_damages(name: str, form: str = "PNG") -> Iterator[None]:
    """Turn errors and warnings of the library of images into a ``FileError``."""
    from PIL import Image, UnidentifiedImageError

    warned = UserWarning, Image.DecompressionBombWarning
    try:
        with warnings.catch_warnings():
            for kind in warned:
                warnings.simplefilter("error", kind)
            yield
    except (*PNG_DAMAGES, Image.DecompressionBombError, *warned) as error:
        reason = "the file is not an image" if isinstance(error, UnidentifiedImageError) else error
        raise FileError(f"{name}: is not a whole {form} ({reason}); write it again as PNG") from error


def _check_pixels(name: str, width: int, height: int, most: int) -> None:
    if width * height > most:
        found = f"{width} x {height} pixels"
        raise FileError(f"{name}: has {found}, one for each stitch; expected at most {most}, scale it down")


def number_pixels(pixels: NDArray, colours: NDArray[np.uint8], name: str) -> NDArray[np.int64]:
    """Return the number of the colour of each pixel, shape (rows, columns).

    Args:
        pixels: red, green and blue, 0 to 255, shape (rows, columns, 3), the top row first.
        colours: the colour of each number, shape (C, 3); if two colours are equal, the lower number is used.
        name: the name of the image in messages.

    Raises:
        PatternError: a pixel has none of the colours; the message gives the first such pixel, counted from the lower
            left to the right and upwards.
    """
    known, number = np.unique(_packed(colours), return_index=True)
    packed = _packed(pixels)
    place = np.minimum(np.searchsorted(known, packed), len(known) - 1)
    unknown = (known[place] != packed)[::-1]
    if unknown.any():
        row, column = divmod(int(unknown.argmax()), pixels.shape[1])
        found = "#" + "".join(f"{part:02x}" for part in pixels[::-1][row, column])
        where = f"row {row + 1}, stitch {column + 1} from the left"
        found = f"got colour {found}; expected one of the {len(colours)} colours of the palette"
        raise PatternError(f"{name}: {where}: {found}")
    return np.asarray(number[place], dtype=np.int64)


def colours_in_order_of_use(pixels: NDArray, name: str) -> NDArray[np.uint8]:
    """Return the colours of an image, sorted by their first use from the lower left to the right and upwards.

    Args:
        pixels: red, green and blue, 0 to 255, shape (rows, columns, 3), the top row first.
        name: the name of the image in messages.

    Returns:
        The colours, shape (C, 3).

    Raises:
        PatternError: there are more than 256 colours.
    """
    flat = pixels[::-1].reshape(-1, 3)
    _, first = np.unique(_packed(flat), return_index=True)
    if len(first) > MAX_COLOURS:
        found = f"got {len(first)} colours"
        raise PatternError(f"{name}: {found}; expected {MAX_COLOURS} at most, reduce them to those of the yarns")
    return np.asarray(flat[np.sort(first)], dtype=np.uint8)


def checked_palette(palette: ArrayLike) -> NDArray[np.uint8]:
    """Check a palette from the user and return it with shape (C, 3).

    Raises:
        ParameterError: the palette has a wrong shape, or a colour is not a whole number from 0 to 255.
    """
    try:
        colours = np.asarray(palette, dtype=np.float64)
    except (TypeError, ValueError) as error:
        raise ParameterError(f"palette: got {palette!r}; expected rows of red, green and blue, 0 to 255") from error
    if colours.ndim != 2 or colours.shape[1:] != (3,) or not 1 <= len(colours) <= MAX_COLOURS:
        raise ParameterError(f"palette: got shape {colours.shape}; expected (Y, 3) with 1 to {MAX_COLOURS} yarns")
    if not ((colours >= 0) & (colours <= 255) & (colours == np.round(colours))).all():
        raise ParameterError("palette: got colours beyond 0 to 255, or fractions; expected whole numbers from 0 to 255")
    return colours.astype(np.uint8)


def write_numbers(path: FilePath, numbers: NDArray[np.int64], colours: NDArray[np.uint8]) -> None:
    """Write an image of numbers as a PNG with a palette.

    Args:
        path: the file.
        numbers: the number of the colour of each pixel, shape (rows, columns), the top row first.
        colours: red, green and blue of each number, shape (C, 3).

    Raises:
        FileError: the file cannot be written.
    """
    write_bytes(path, png_of_numbers(numbers, colours))


def png_of_numbers(numbers: NDArray[np.int64], colours: NDArray[np.uint8]) -> bytes:
    """Return the content of a PNG with a palette.

    Args:
        numbers: the number of the colour of each pixel, shape (rows, columns), the top row first.
        colours: red, green and blue of each number, shape (C, 3).
    """
    from PIL import Image

    image = Image.fromarray(numbers.astype(np.uint8), mode="P")
    image.putpalette(colours.tobytes())
    content = BytesIO()
    image.save(content, format="PNG")
    return content.getvalue()


def _packed(colours: NDArray) -> NDArray[np.int64]:
    return np.asarray(colours, dtype=np.int64) @ np.array([65536, 256, 1])
