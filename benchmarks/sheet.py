# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Pictures of sheets, which are joined to one file (``stitchmesh.render.animation_pictures``)."""

from __future__ import annotations

import tempfile
from collections.abc import Callable
from pathlib import Path

from PIL import Image


def drawn(draw: Callable[[Path], object], size: tuple[int, int] | None = None) -> Image.Image:
    """Return what a function draws into a file, in another size if one is given [pixels]."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "picture.png"
        draw(path)
        picture = Image.open(path).convert("RGB")
    return picture if size is None else picture.resize(size, Image.Resampling.LANCZOS)
