# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The pictures of docs/yarn-materials.md: stockinette in each look of a yarn.

    python benchmarks/run.py yarn-looks

The sheet is docs/yarn-looks.jpg.
"""

from __future__ import annotations

import tempfile
from pathlib import Path

import numpy as np
from PIL import Image

import stitchmesh as sm
from benchmarks.places import DOCS
from benchmarks.table import Rows
from stitchmesh.render import PictureOptions, render_swatch

SHEET = DOCS / "yarn-looks.jpg"
COLUMNS, SIDE, GAP = 4, 340, 6
"""Pictures in a row of the sheet, pixels of a picture, and pixels between pictures."""
JPEG_QUALITY = 84
COLOUR = "oatmeal"


def yarn_looks(quality: str = "draft", device: str = "cpu", tiles: int = 5) -> Rows:
    """Draw a swatch of the yarn dk in each look, write the pictures into one sheet, and yield the spread of brightness.

    Args:
        quality: accuracy of the relaxation.
        device: Warp's name of the device.
        tiles: stitches along both sides of a picture.
    """
    yarn = sm.Yarn.named("dk")
    made = sm.swatch(
        "stockinette", relaxation="full", quality=quality, device=device, progress=False,
        material=sm.YarnMaterial.of_yarn(yarn), yarn_radius=yarn.core_radius, drawn_radius=yarn.apparent_radius,
        loop_length=yarn.loop_length,
    )  # fmt: skip
    names = sm.look_names()
    yield "look", "standard deviation of the brightness"
    rows = -(-len(names) // COLUMNS)
    sheet = Image.new("RGB", (COLUMNS * (SIDE + GAP) - GAP, rows * (SIDE + GAP) - GAP), "white")
    with tempfile.TemporaryDirectory() as folder:
        for place, name in enumerate(names):
            file = Path(folder) / f"{name}.png"
            options = PictureOptions(size=(2 * SIDE, 2 * SIDE), look=name, colour=COLOUR)
            render_swatch(made.yarns, file, (tiles, tiles + 1), options)
            with Image.open(file) as drawn:
                picture = drawn.convert("RGB")
            scale = SIDE / min(picture.size)
            picture = picture.resize(tuple(np.ceil(scale * np.array(picture.size)).astype(int).tolist()))
            corner = ((place % COLUMNS) * (SIDE + GAP), (place // COLUMNS) * (SIDE + GAP))
            sheet.paste(picture.crop((0, 0, SIDE, SIDE)), corner)
            spread = np.asarray(picture, dtype=np.float64).mean(axis=2).std() / 255.0
            yield name, round(float(spread), 3)
    sheet.save(SHEET, quality=JPEG_QUALITY)
