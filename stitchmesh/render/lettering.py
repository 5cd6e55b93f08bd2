# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Text on pictures: a caption in the corner and a legend of colours."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from PIL.Image import Image

INK = "#3a3632"
"""Colour of letters, edges and arrows."""

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


def _letter_height(image: Image) -> float:
    return max(0.018 * image.height, 9.0)  # Smaller letters are not legible.
