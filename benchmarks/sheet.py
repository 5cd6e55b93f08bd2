# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Sheets of pictures: several of one size beside and below each other, as one file."""

from __future__ import annotations

import tempfile
from collections.abc import Callable, Sequence
from pathlib import Path

from PIL import Image


def drawn(draw: Callable[[Path], object], size: tuple[int, int] | None = None) -> Image.Image:
    """Return what a function draws into a file, in another size if one is given [pixels]."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "picture.png"
        draw(path)
        picture = Image.open(path).convert("RGB")
    return picture if size is None else picture.resize(size, Image.Resampling.LANCZOS)


def joined(pictures: Sequence[Image.Image], columns: int) -> Image.Image:
    """Return pictures of one size beside each other, some in a row."""
    width, height = pictures[0].size
    sheet = Image.new("RGB", (columns * width, -(-len(pictures) // columns) * height), "white")
    for place, picture in enumerate(pictures):
        sheet.paste(picture, (width * (place % columns), height * (place // columns)))
    return sheet
