# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Weaves as images: one pixel for each crossing; the top row of pixels is the first weft.

As on the point paper of weavers, a dark pixel is a warp that passes over the weft, and a light pixel is a weft that
passes over the warp.
"""

from __future__ import annotations

from os import fspath
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from stitchmesh.errors import PatternError
from stitchmesh.io.contents import FilePath
from stitchmesh.patterns.charts.chart_image import png_of_numbers
from stitchmesh.patterns.charts.colour_chart import read_numbers
from stitchmesh.periodic.weave.weave import Weave


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
