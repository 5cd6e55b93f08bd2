# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The text of a chart inside a PNG, so that the picture of a chart can be read as a chart again."""

from __future__ import annotations

from stitchmesh.errors import FileError
from stitchmesh.io.contents import check_expansion
from stitchmesh.patterns.charts.chart_image import PNG_BEGINS, opened_png

TEXT_KEY = "stitchmesh chart"
"""Name under which a picture holds the text of its chart."""


def picture_text(name: str, content: bytes) -> str | None:
    """Return the text of the chart in a picture of ``chart_picture``; None for any other content.

    Raises:
        FileError: the compressed text is very much longer than the file.
    """
    if not content.startswith(PNG_BEGINS):
        return None
    try:
        held = opened_png(name, content).info.get(TEXT_KEY)
    except FileError:
        return None  # the reader of images gives the reason
    if not isinstance(held, str):
        return None
    try:
        # Memory that a character takes while the text is read [bytes]
        check_expansion(130 * len(held), len(content))
    except ValueError as error:
        raise FileError(f"{name}: the text of its chart is too long ({error}); write it again") from error
    return held
