# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Colours of wool.

Several yarns have a colour each. One yarn shows its rows, which alternate between two tones while the hue drifts along
the garment.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

DYES = np.array([[168, 74, 58], [196, 134, 62], [134, 140, 82], [62, 116, 122], [74, 84, 128], [134, 86, 118]]) / 255
"""Madder, weld, moss, woad, indigo, heather: the first row takes the first, the last row the last, sRGB."""
UNDYED = np.array([236, 226, 206]) / 255
"""Every second row is the dye let down with this, sRGB."""
SHARE_UNDYED = 0.42
WOOLS = np.array([UNDYED, *DYES[[4, 0, 1, 2, 3, 5]]])
"""Colours of yarns by their number: undyed wool first, then those that differ most, sRGB."""


def row_colours(row: ArrayLike) -> NDArray[np.uint8]:
    """Colour (sRGB) of each row number, shape (n,) to (n, 3); gaps between the numbers do not count."""
    rows, rank = np.unique(np.asarray(row, dtype=np.int64), return_inverse=True)
    place = np.arange(len(rows)) / max(len(rows) - 1, 1) * (len(DYES) - 1)
    linear = DYES**2.2  # mixed as light, for an sRGB mean of two hues is dull
    dye = np.stack([np.interp(place, np.arange(len(DYES)), linear[:, k]) for k in range(3)], axis=-1)
    pale = (1 - SHARE_UNDYED) * dye + SHARE_UNDYED * UNDYED**2.2
    striped = np.where((np.arange(len(rows)) % 2 == 0)[:, None], dye, pale)
    return np.round(255 * striped ** (1 / 2.2)).astype(np.uint8)[rank]


def yarn_colours(row: ArrayLike, colour: ArrayLike) -> NDArray[np.uint8]:
    """Colour (sRGB) by the number of the colour where there are several numbers, else by row, shape (n,) to (n, 3)."""
    numbers = np.asarray(colour, dtype=np.int64)
    if numbers.size == 0 or (numbers == numbers[0]).all():
        return row_colours(row)
    return np.round(255 * WOOLS).astype(np.uint8)[numbers % len(WOOLS)]
