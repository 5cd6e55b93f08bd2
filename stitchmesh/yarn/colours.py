# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Colours of rows in pictures.

Rows alternate between two tones, and the hue changes gradually along the garment. Yarns have the colours of their
palette (``mesh.palette``).
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

DYES = np.array([[168, 74, 58], [196, 134, 62], [134, 140, 82], [62, 116, 122], [74, 84, 128], [134, 86, 118]]) / 255
"""Colours along a garment (madder, weld, moss, woad, indigo, heather) from its first row to its last, sRGB, (6, 3)."""
SHARE_UNDYED = 0.42
"""Share of undyed wool in every second row."""


def row_colours(row: ArrayLike) -> NDArray[np.uint8]:
    """Return the colour (sRGB) of each row number, shape (n,) to (n, 3); gaps between the numbers are ignored."""
    rows, rank = np.unique(np.asarray(row, dtype=np.int64), return_inverse=True)
    place = np.arange(len(rows)) / max(len(rows) - 1, 1) * (len(DYES) - 1)
    linear = DYES**2.2  # Colours are mixed in linear light, because the sRGB mean of two hues looks dull.
    dye = np.stack([np.interp(place, np.arange(len(DYES)), linear[:, k]) for k in range(3)], axis=-1)
    undyed = np.array([236, 226, 206]) / 255  # Wool, in sRGB.
    pale = (1 - SHARE_UNDYED) * dye + SHARE_UNDYED * undyed**2.2
    striped = np.where((np.arange(len(rows)) % 2 == 0)[:, None], dye, pale)
    return np.round(255 * striped ** (1 / 2.2)).astype(np.uint8)[rank]
