# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Scales from numbers to colours, with the marks of their legends. Colour-blind people can read both scales."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from stitchmesh.mesh import FloatArray
from stitchmesh.render.lettering import Colour

DIVERGING = np.array([[49, 92, 146], [146, 176, 202], [236, 232, 222], [222, 150, 120], [164, 48, 42]])
"""Colours from the most negative number to the most positive one, evenly spaced, sRGB: blue, pale, red."""
SEQUENTIAL = np.array(
    [[68, 1, 84], [71, 44, 122], [59, 81, 139], [44, 113, 142], [33, 144, 141], [39, 173, 129], [92, 200, 99],
     [170, 220, 50], [253, 231, 37]]
)  # fmt: skip
"""Colours from the smallest number to the largest one, evenly spaced, sRGB: dark violet to bright yellow (viridis)."""
QUANTILE = 0.99
"""Quantile of the numbers at which a scale ends, so that single outliers do not stretch it."""


@dataclass(frozen=True, eq=False)
class ColourScale:
    """Colours of the numbers from ``low`` to ``high``; numbers beyond take the colour of the nearer end."""

    colours: NDArray[np.int64]
    """Colours at even distances from ``low`` to ``high``, sRGB, shape (n, 3)."""
    low: float
    """Number of the first colour."""
    high: float
    """Number of the last colour."""

    def of(self, values: FloatArray) -> NDArray[np.uint8]:
        """Return the colours of some numbers (sRGB), shape (n,) to (n, 3)."""
        return self.table(256)[np.round(255 * self.share(values)).astype(np.int64)]

    def share(self, values: FloatArray) -> FloatArray:
        """Return the place of some numbers on the scale, from 0 to 1, shape (n,)."""
        return np.clip((np.asarray(values) - self.low) / (self.high - self.low), 0.0, 1.0)

    def table(self, count: int) -> NDArray[np.uint8]:
        """Return colours at even distances from ``low`` to ``high`` (sRGB), shape (count, 3)."""
        place, places = np.linspace(0.0, 1.0, count), np.linspace(0.0, 1.0, len(self.colours))
        channels = [np.interp(place, places, channel) for channel in self.colours.T]
        return np.stack(channels, axis=1).round().astype(np.uint8)

    def key(self, text: Callable[[float], str]) -> tuple[tuple[str, Colour], ...]:
        """Return the marks of a legend from ``high`` to ``low``: the text of each number, and its colour."""
        marks = np.linspace(self.high, self.low, 5)
        return tuple((text(mark), _rgb(colour)) for mark, colour in zip(marks, self.of(marks), strict=True))


def diverging_scale(values: FloatArray, least: float) -> ColourScale:
    """Return the scale around zero for some numbers.

    Args:
        values: the numbers, shape (n,).
        least: the smallest number that may have the last colour; with a smaller one, rounding would look like a
            difference.
    """
    most = max(float(np.quantile(np.abs(values), QUANTILE)) if len(values) else 0.0, least)
    return ColourScale(DIVERGING, -most, most)


def sequential_scale(values: FloatArray, least: float, low: float | None = None) -> ColourScale:
    """Return the scale from the smallest to the largest of some numbers, without outliers.

    Args:
        values: the numbers, shape (n,).
        least: smallest range of the scale.
        low: number of the first colour, if it is fixed.
    """
    ends = np.quantile(values, [1.0 - QUANTILE, QUANTILE]) if len(values) else np.zeros(2)
    first = float(ends[0]) if low is None else low
    return ColourScale(SEQUENTIAL, first, max(float(ends[1]), first + least))


def _rgb(colour: NDArray[np.uint8]) -> Colour:
    red, green, blue = colour.tolist()
    return red, green, blue
