# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Text on pictures: a caption in the corner and a legend of colours."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from PIL.Image import Image

INK = "#3a3632"
"""Colour of letters, edges and arrows."""
PLATE = "#f4f1eb"
"""Colour below a scale bar, which may stand on fabric of any colour."""

Colour = tuple[int, int, int]
"""sRGB colour, 0 to 255."""


def write_caption(image: Image, text: str) -> None:
    """Write a line of text into the lower left corner of a picture."""
    from PIL import ImageDraw, ImageFont

    height = _letter_height(image)
    font = ImageFont.load_default(height)
    ImageDraw.Draw(image).text((height, image.height - height), text, fill=INK, font=font, anchor="lb")


def draw_key(image: Image, entries: Sequence[tuple[str, Colour]], left: float) -> None:
    """Draw a legend: a vertically centred column of coloured squares with their names.

    Args:
        image: the picture that is drawn into.
        entries: name and sRGB colour of each square.
        left: left border of the column, divided by the width of the picture.
    """
    from PIL import ImageDraw, ImageFont

    height = _letter_height(image)
    font = ImageFont.load_default(height)
    draw = ImageDraw.Draw(image)
    x, y = left * image.width, (image.height - 2 * height * len(entries)) / 2
    for text, colour in entries:
        draw.rectangle((x, y, x + 1.2 * height, y + 1.2 * height), fill=colour, outline=INK)
        draw.text((x + 2 * height, y + 0.6 * height), text, fill=INK, font=font, anchor="lm")
        y += 2 * height


def scale_length(width: float, pixels: float) -> float:
    """Return the largest length of 1, 2 or 5 times a power of ten that takes at most a fifth of a width [cm].

    Args:
        width: the width [pixels].
        pixels: number of pixels in a centimetre.
    """
    longest = 0.2 * width / pixels
    power = 10.0 ** math.floor(math.log10(longest))
    return next(step * power for step in (5.0, 2.0, 1.0) if step * power <= longest or step == 1.0)


def draw_scale_bar(
    image: Image, corner: tuple[float, float], width: float, pixels: float, *, lifted: bool = False
) -> None:
    """Draw a bar of a round length with the length [cm] over it, on a pale plate, if the panel has room for it.

    Args:
        image: the picture that is drawn into.
        corner: lower left corner of the panel, from the lower left corner of the picture [pixels].
        width: width of the panel [pixels].
        pixels: number of pixels in a centimetre at the middle of the object.
        lifted: whether a caption stands below the bar.
    """
    from PIL import ImageDraw, ImageFont

    letter = _letter_height(image)
    length = scale_length(width, pixels)
    bar, text = length * pixels, f"{length:g} cm"
    font = ImageFont.load_default(letter)
    plate = max(bar, font.getlength(text)) + letter
    if plate > 0.5 * width:
        return
    draw = ImageDraw.Draw(image)
    left = corner[0] + 0.8 * letter
    low = image.height - corner[1] - (2.8 if lifted else 0.8) * letter
    draw.rounded_rectangle((left, low - 2.1 * letter, left + plate, low), 0.3 * letter, fill=PLATE)
    middle, line = left + plate / 2, low - 0.5 * letter
    draw.text((middle, line - 0.4 * letter), text, fill=INK, font=font, anchor="mb")
    draw.rectangle((middle - bar / 2, line - 0.08 * letter, middle + bar / 2, line + 0.08 * letter), fill=INK)


def _letter_height(image: Image) -> float:
    return max(0.018 * image.height, 9.0)  # Smaller letters are not legible.
