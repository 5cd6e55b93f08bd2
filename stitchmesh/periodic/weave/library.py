# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The library of weaves that comes with the package, and the reading of weaves from files.

An image of a weave has one pixel for each crossing; the top row of pixels is the first weft. As on the point paper of
weavers, a dark pixel is a warp that passes over the weft, and a light pixel is a weft that passes over the warp.
"""

from __future__ import annotations

from functools import cache
from os import fspath
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from stitchmesh.errors import PatternError
from stitchmesh.io.contents import FilePath, check_path, read_lines
from stitchmesh.patterns.charts.chart_image import CHART_IMAGES, png_of_numbers
from stitchmesh.patterns.charts.colour_chart import read_numbers
from stitchmesh.patterns.library import pattern_folder, unknown_name
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


def read_weave_image(path: FilePath) -> Weave:
    """Read a weave from a PNG of two colours.

    Args:
        path: the file.

    Raises:
        FileError: the file cannot be read, is not a PNG, is too large, or has transparent pixels.
        PatternError: the image does not have exactly two colours, both are equally light, or the weave falls apart.
    """
    numbers, palette = read_numbers(path)
    # a palette can hold one colour several times
    colours, merged = np.unique(palette, axis=0, return_inverse=True)
    colour, light = merged.ravel()[numbers], colours.sum(axis=1)
    first, second = _two_colours(colour, fspath(path))
    if light[first] == light[second]:
        raise PatternError(f"{fspath(path)}: got two colours that are equally light; expected black and white")
    over = colour == (first if light[first] > light[second] else second)
    try:
        return Weave(tuple(map(tuple, over.astype(int).tolist())), name=Path(path).stem.replace('"', "'"))
    except PatternError as error:
        raise PatternError(f"{fspath(path)}: {error}") from None


def weave_image(over: NDArray) -> bytes:
    """Return the content of a PNG from which ``read_weave_image`` reads the same matrix.

    Args:
        over: whether each weft passes over each warp, shape (wefts, warps).
    """
    return png_of_numbers(np.asarray(over, dtype=np.int64), np.array([[0, 0, 0], [255, 255, 255]], dtype=np.uint8))


def _two_colours(colour: np.ndarray, name: str) -> tuple[int, int]:
    """Return the two colour numbers of an image, the number of the upper left pixel first."""
    others = colour.ravel()[colour.ravel() != colour[0, 0]]
    if not len(others):
        raise PatternError(f"{name}: got one colour; expected light pixels (weft over) and dark ones (warp over)")
    third = (colour != colour[0, 0]) & (colour != others[0])
    if third.any():
        row, column = divmod(int(third.argmax()), colour.shape[1])
        where = f"pixel {column + 1} from the left in row {row + 1} from the top"
        raise PatternError(f"{name}: {where}: got a third colour; expected only black and white, without smoothing")
    return int(colour[0, 0]), int(others[0])
