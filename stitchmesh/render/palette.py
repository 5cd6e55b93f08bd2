# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Colours of stitches by their type; ``yarn/colours.py`` contains the colours of rows and yarns."""

from __future__ import annotations

from colorsys import hsv_to_rgb

import numpy as np
from numpy.typing import ArrayLike, NDArray

from stitchmesh.mesh.own_stitch import FIRST_OWN
from stitchmesh.mesh.stitch import CODES, Stitch

_PLAIN = {
    Stitch.PANEL: (214, 208, 196),
    Stitch.KNIT: (226, 214, 190),
    Stitch.PURL: (150, 168, 186),
    Stitch.CAST_ON: (122, 150, 104),
    Stitch.BIND_OFF: (96, 110, 148),
    Stitch.DRAW_THROUGH: (150, 120, 96),
}
_FAMILIES = (
    ("ky yk py yp kp pk", (52.0, 26.0), 0.70),
    ("kyk pyp yky ypy kpk pkp kpy ykp pky ypk", (22.0, -14.0), 0.66),
    ("d12k d21k d12p d21p", (172.0, 202.0), 0.46),
    ("d123k d132k d213k d231k d312k d321k d123p d132p d213p d231p d312p d321p", (212.0, 296.0), 0.44),
    ("b f x", (84.0, 112.0), 0.58),
    ("sk ks sp ps sy ys", (128.0, 158.0), 0.50),
)
"""Families of stitches: their codes, the hues of the first and of the last stitch [degrees], and the saturation."""
_BRIGHTNESS = (0.88, 0.70)
"""Brightness of alternating stitches of a family, so that stitches of similar hue can be distinguished."""


def _colours() -> dict[Stitch, tuple[int, int, int]]:
    colours = {**_PLAIN, Stitch.YARN_OVER: (250, 236, 140)}
    for codes, (first, last), saturation in _FAMILIES:
        hues = np.linspace(first, last, len(codes.split()))
        for number, (code, hue) in enumerate(zip(codes.split(), hues, strict=True)):
            red, green, blue = hsv_to_rgb(hue / 360.0 % 1.0, saturation, _BRIGHTNESS[number % 2])
            colours[CODES[code]] = round(255 * red), round(255 * green), round(255 * blue)
    return colours


STITCH_COLOURS = _colours()
"""Colour of each stitch, sRGB 0 to 255: plain stitches are pale, increases warm, decreases cool and slips green."""
ODD_ROW = 0.9
"""Relative brightness of odd rows in the picture of stitches."""


def stitch_colours(stitch: ArrayLike, row: ArrayLike) -> NDArray[np.uint8]:
    """Return the colour (sRGB, 0 to 255) of each stitch face, shape (n,) to (n, 3); odd rows are slightly darker."""
    codes, place = np.unique(np.asarray(stitch, dtype=np.int64), return_inverse=True)
    table = np.array([stitch_colour(code) for code in codes.tolist()], dtype=np.float64).reshape(-1, 3)
    shade = np.where(np.asarray(row) % 2 == 1, ODD_ROW, 1.0)
    return np.round(table[place] * shade[..., None]).astype(np.uint8)


def stitch_colour(code: int) -> tuple[int, int, int]:
    """Return the colour (sRGB, 0 to 255) of a stitch type; the user's own stitches have hues far from each other."""
    if code in STITCH_COLOURS:
        return STITCH_COLOURS[Stitch(code)]
    # Steps of the golden section keep hues apart.
    red, green, blue = hsv_to_rgb(0.618 * (code - FIRST_OWN + 1) % 1.0, 0.55, 0.85)
    return round(255 * red), round(255 * green), round(255 * blue)
