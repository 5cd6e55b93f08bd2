# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Colours of stitches by their type; those of rows stand in ``dyes.py``."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from stitchmesh.stitch import Stitch

STITCH_COLOURS: dict[Stitch, tuple[int, int, int]] = {
    Stitch.PANEL: (214, 208, 196),
    Stitch.KNIT: (226, 214, 190),
    Stitch.PURL: (150, 168, 186),
    Stitch.CAST_ON: (122, 150, 104),
    Stitch.BIND_OFF: (96, 110, 148),
    Stitch.DRAW_THROUGH: (150, 120, 96),
    Stitch.KY: (222, 142, 74),
    Stitch.YK: (240, 186, 84),
    Stitch.KYK: (198, 96, 60),
    Stitch.D12K: (92, 140, 150),
    Stitch.D21K: (128, 108, 158),
    Stitch.D213K: (164, 72, 98),
}
"""Plain stitches are pale and the shaping ones strong: increases warm, decreases cool, sRGB 0 to 255."""
UNNAMED_STITCH = (90, 90, 90)
ODD_ROW = 0.9
"""Brightness of every second row in the picture of stitches."""


def stitch_colours(stitch: ArrayLike, row: ArrayLike) -> NDArray[np.uint8]:
    """Colour (sRGB) of each stitch face, shape (n,) to (n, 3); odd rows are a little darker."""
    codes = np.asarray(stitch, dtype=np.int64)
    table = np.array([stitch_colour(code) for code in range(max(Stitch) + 1)], dtype=np.float64)
    shade = np.where(np.asarray(row) % 2 == 1, ODD_ROW, 1.0)
    return np.round(table[codes] * shade[..., None]).astype(np.uint8)


def stitch_colour(code: int) -> tuple[int, int, int]:
    """Colour (sRGB) of a stitch type, 0 to 255."""
    return STITCH_COLOURS.get(Stitch(code), UNNAMED_STITCH)
