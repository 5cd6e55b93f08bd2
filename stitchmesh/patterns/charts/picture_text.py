# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The text of a chart inside a PNG, so that a picture that was drawn to be looked at can be read again."""

from __future__ import annotations

from stitchmesh.errors import FileError
from stitchmesh.patterns.charts.chart_image import PNG_BEGINS, opened_png

TEXT_KEY = "stitchmesh chart"
"""Name under which a picture holds the text of its chart."""


def picture_text(content: bytes) -> str | None:
    """Return the text of the chart that a picture of ``chart_picture`` holds; None for any other content."""
    if not content.startswith(PNG_BEGINS):
        return None
    try:
        held = opened_png("picture", content).info.get(TEXT_KEY)
    except FileError:
        return None  # the reader of images gives the reason
    return held if isinstance(held, str) else None
