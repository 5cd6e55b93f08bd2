# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Palettes: the colours of the yarns of a fabric.

A palette is an array of sRGB colours, shape (P, 3). Row n is the colour of yarn number n. A number beyond the palette
has a stock colour (``STOCK``), so that an empty palette gives stock colours to all yarns.
"""

from __future__ import annotations

import difflib
from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import ArrayLike, NDArray

from stitchmesh.errors import ParameterError, StitchMeshError
from stitchmesh.mesh.polygon_mesh import frozen_array

Palette = NDArray[np.uint8]

WOOLS = {
    "cream": (236, 226, 206), "denim": (74, 84, 128), "madder": (168, 74, 58), "weld": (196, 134, 62),
    "moss": (134, 140, 82), "woad": (62, 116, 122), "heather": (134, 86, 118),
    "oatmeal": (201, 184, 154), "mustard": (200, 154, 46), "rust": (166, 82, 42), "burgundy": (112, 32, 48),
    "charcoal": (62, 62, 66),
}  # fmt: skip
"""Names of wool colours that are not CSS names, with their sRGB colours; the first seven are the stock colours."""
STOCK = np.array(list(WOOLS.values())[:7], dtype=np.uint8)
"""Colours of yarns that no palette names, by number: undyed wool, then an order of strong contrast, sRGB, (7, 3)."""


LAST_YARN = 255
"""Largest yarn number that can be given a colour; a palette has a colour for every number below it."""
LONGEST_NUMBER = 20
"""Largest number of digits of a yarn number in a text."""


def parse_colour(text: str) -> NDArray[np.uint8]:
    """Return the sRGB colour that a text names, shape (3,).

    Args:
        text: ``#rrggbb``, ``#rgb``, a CSS name, or a name of ``WOOLS``; case and spaces do not matter.

    Raises:
        ParameterError: the text is no colour; the message has the nearest name.
    """
    from PIL import ImageColor

    name = str(text).strip().lower().replace(" ", "")
    if name in WOOLS:
        return np.array(WOOLS[name], dtype=np.uint8)
    if name in ImageColor.colormap or _is_hexadecimal(name):
        return np.array(ImageColor.getrgb(name)[:3], dtype=np.uint8)
    near = difflib.get_close_matches(name, [*WOOLS, *ImageColor.colormap], n=1, cutoff=0.5)
    hint = f"; did you mean {near[0]!r}?" if near else ""
    raise ParameterError(f"colour: got {text!r}; expected #rrggbb or a name such as navy or cream{hint}")


def _is_hexadecimal(name: str) -> bool:
    return name[:1] == "#" and len(name) in (4, 7) and not set(name[1:]) - set("0123456789abcdef")


def make_palette(colours: Sequence[str]) -> Palette:
    """Return the palette of colours that are given as texts, shape (P, 3).

    Raises:
        ParameterError: a text is no colour.
    """
    return np.array([parse_colour(text) for text in colours], dtype=np.uint8).reshape(-1, 3)


def parse_yarn_colours(texts: Sequence[str]) -> dict[int, NDArray[np.uint8]]:
    """Return the colours of some yarn numbers, from texts such as ``0=#aa2233`` and ``1=cream``.

    Raises:
        ParameterError: a text has no number or no colour, or a number is given twice or is above ``LAST_YARN``.
    """
    colours: dict[int, NDArray[np.uint8]] = {}
    for text in texts:
        number, equals, name = text.partition("=")
        if not (equals and number.strip().isdecimal() and len(number.strip()) <= LONGEST_NUMBER):
            expected = "the number of a yarn and its colour, such as 0=navy"
            raise ParameterError(f"colour: got {text[:40]!r}; expected {expected}")
        yarn = check_yarn_number(int(number))
        if yarn in colours:
            raise ParameterError(f"colour: got yarn {yarn} twice; expected each yarn once")
        colours[yarn] = parse_colour(name)
    return colours


def check_yarn_number(yarn: int) -> int:
    """Return the number of a yarn that is given a colour.

    Raises:
        ParameterError: the number is negative or above ``LAST_YARN``.
    """
    if not 0 <= yarn <= LAST_YARN:
        raise ParameterError(f"colour: got yarn {yarn}; expected 0 to {LAST_YARN}")
    return yarn


def recolour_palette(palette: Palette, colours: Mapping[int, NDArray[np.uint8]]) -> Palette:
    """Return a palette with new colours for some yarns; other yarns without a colour keep their stock colours."""
    changed = filled_palette(palette, max(colours, default=-1) + 1)
    for yarn, colour in colours.items():
        changed[yarn] = colour
    return changed


def colour_text(colour: ArrayLike) -> str:
    """Return a colour as ``#rrggbb``."""
    return "#" + "".join(f"{int(value):02x}" for value in np.asarray(colour))


def colours_of(numbers: ArrayLike, palette: Palette) -> NDArray[np.uint8]:
    """Return the sRGB colour of each yarn number, shape (n,) to (n, 3); numbers beyond the palette are stock colours.

    Args:
        numbers: yarn numbers, shape (n,).
        palette: the palette, shape (P, 3).
    """
    index = np.asarray(numbers, dtype=np.int64)
    return filled_palette(palette, int(index.max(initial=-1)) + 1)[index]


def filled_palette(palette: Palette, count: int) -> Palette:
    """Return the palette with stock colours up to at least ``count`` colours, shape (max(P, count), 3)."""
    beyond = np.arange(len(palette), max(count, len(palette)))
    return np.concatenate([palette.reshape(-1, 3), STOCK[beyond % len(STOCK)]])


def linear_colour(srgb: ArrayLike) -> NDArray[np.float64]:
    """Return sRGB colours from 0 to 1 in linear light, any shape (IEC 61966-2-1)."""
    value = np.asarray(srgb, dtype=np.float64)
    return np.where(value <= 0.04045, value / 12.92, ((value + 0.055) / 1.055) ** 2.4)


def srgb_colour(linear: ArrayLike) -> NDArray[np.float64]:
    """Return colours in linear light as sRGB from 0 to 1, any shape; the inverse of ``linear_colour``."""
    value = np.asarray(linear, dtype=np.float64)
    return np.where(value <= 0.0031308, 12.92 * value, 1.055 * np.maximum(value, 1e-9) ** (1 / 2.4) - 0.055)


def empty_palette() -> Palette:
    """Return a palette without colours, shape (0, 3)."""
    return np.zeros((0, 3), dtype=np.uint8)


def checked_palette(values: ArrayLike, error: type[StitchMeshError]) -> Palette:
    """Return a palette as a read-only array of bytes, shape (P, 3).

    Args:
        values: sRGB colours of whole numbers from 0 to 255, shape (P, 3); an empty sequence is an empty palette.
        error: class of the error to raise.

    Raises:
        StitchMeshError: of the class ``error``, if the array has another shape or other values.
    """
    colours = np.asarray(values)
    if colours.size == 0:
        colours = empty_palette()
    if colours.ndim != 2 or colours.shape[1] != 3:
        raise error(f"palette: got shape {colours.shape}; expected (P, 3), red, green and blue of each yarn number")
    if colours.dtype != np.uint8 and not (np.isin(colours, np.arange(256)).all()):
        raise error(f"palette: got values {colours.min()} to {colours.max()}; expected whole numbers from 0 to 255")
    return frozen_array(colours.astype(np.uint8), np.uint8)
