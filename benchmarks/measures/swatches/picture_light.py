# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The light of pictures of yarns, how far their object fills them, and how long they take.

- ``colours``: a swatch of stockinette in yarns of several colours. The luminance is the relative luminance of
  IEC 61966-2-1, 0 to 1, of the pixels that show yarn. A pixel is clipped if one of its channels is at its end.
- ``framing``: previews of files of yarns. The object is what is seen to the left of the close-up; its box is compared
  with the smaller side of the picture.
"""

from __future__ import annotations

import tempfile
import time
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from PIL import Image

import stitchmesh as sm
from benchmarks.table import Rows
from stitchmesh.mesh.palette import linear_colour
from stitchmesh.render import render

COLOURS = ("white", "cream", "red", "navy", "black")
LUMINANCE = np.array([0.2126, 0.7152, 0.0722])
"""Parts of red, green and blue in the luminance."""
RUNS = 3
"""Pictures of which the shortest time is taken, after one that loads the libraries."""


def colours(*, quality: str = "draft", device: str | None = None) -> Rows:
    """Draw stockinette in several colours, and yield the luminance of each."""
    yarns = sm.swatch("stockinette", quality=quality, device=device, progress=False).yarns
    yield "yarn", "mean luminance", "standard deviation", "darkest 1 %", "lightest 1 %", "clipped pixels"
    for colour in COLOURS:
        picture, is_yarn = _drawn(yarns, colour)
        shown = picture[is_yarn]
        luminance = linear_colour(shown / 255.0) @ LUMINANCE
        low, high = np.quantile(luminance, [0.01, 0.99])
        clipped = ((shown == 255).any(axis=1) & (shown.min(axis=1) > 240)) | (shown == 0).all(axis=1)
        yield (
            colour, f"{luminance.mean():.3f}", f"{luminance.std():.3f}", f"{low:.4f}", f"{high:.3f}",
            f"{100.0 * clipped.mean():.2f} %",
        )  # fmt: skip


def _drawn(yarns: sm.YarnSet, colour: str) -> tuple[NDArray[np.uint8], NDArray[np.bool_]]:
    """Return a picture of tiles, and its pixels that show nothing but yarn."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "swatch.png"
        render(yarns, path, colour=colour, scale_bar=False, background="transparent")
        picture = np.asarray(Image.open(path))
    return picture[..., :3], picture[..., 3] == 255


def framing(files: tuple[Path, ...], /) -> Rows:
    """Draw previews, and yield the box of each object and the time of its picture."""
    yield "yarns", "picture", "width of the object", "height of the object", "processor seconds"
    for file in files:
        yarns = sm.read_yarns(file)
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder) / "preview.png"
            render(yarns, path, background="transparent", scale_bar=False)
            seen = np.asarray(Image.open(path))[..., 3] > 0
            seconds = min(_seconds(yarns, path) for _ in range(RUNS))
        height, width = seen.shape
        columns = np.flatnonzero(seen.any(axis=0))
        ends = np.flatnonzero(np.diff(columns, append=2 * width) > 1)
        own = slice(columns[0], columns[ends[0]] + 1)
        rows = np.flatnonzero(seen[:, own].any(axis=1))
        box = own.stop - own.start, rows[-1] + 1 - rows[0]
        yield (
            str(file), f"{width} x {height}", *(f"{100.0 * side / min(width, height):.0f} %" for side in box),
            f"{seconds:.1f}",
        )  # fmt: skip


def _seconds(yarns: sm.YarnSet, path: Path) -> float:
    """Return the time of all cores for a preview with the default options [s]."""
    began = time.process_time()
    render(yarns, path)
    return time.process_time() - began


ACTIONS = (colours, framing)
