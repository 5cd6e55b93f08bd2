# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The labeling of the sweater step by step, as a strip of pictures.

Each picture shows the steps up to its own.
"""

from __future__ import annotations

import tempfile
from pathlib import Path

from PIL import Image, ImageDraw, ImageFont

from benchmarks.table import Rows
from stitchmesh.io import read_mesh
from stitchmesh.labeling import PartialLabeling, start_labeling
from stitchmesh.render.labeling_picture import render_labeling
from stitchmesh.render.lettering import INK
from stitchmesh.render.stage import KEY_LEFT

HEM = (0, 1)
"""An edge of the hem of the sweater."""
BODY_FACE = 105
"""A face of a row of the body."""
COLUMNS = 3
"""Pictures beside each other."""
SIZE = (800, 400)
"""Size of one picture, with the space of its legend [pixels]."""


def steps() -> list[tuple[str, PartialLabeling]]:
    """The steps, each with its command in Python."""
    labeling = start_labeling(read_mesh("assets/meshes/sweater.obj"))
    found = [("start_labeling(mesh)", labeling)]
    for text, step in [
        ("start_at_border((0, 1))", lambda value: value.start_at_border(HEM)),
        ("label_rows(6)", lambda value: value.label_rows(6)),
        ("label_rows(6)", lambda value: value.label_rows(6)),
        ("label_all()", lambda value: value.label_all()),
        (f"flip_row({BODY_FACE})", lambda value: value.flip_row(BODY_FACE)),
    ]:
        labeling = step(labeling)
        found.append((text, labeling))
    return found


def labeling_strip(output: str, /) -> Rows:
    """Draw the steps and join the pictures.

    Args:
        output: JPG file
    """
    done = steps()
    width, height = round(KEY_LEFT * SIZE[0]), SIZE[1]
    strip = Image.new("RGB", (COLUMNS * width, -(-len(done) // COLUMNS) * height))
    with tempfile.TemporaryDirectory() as folder:
        for number, (text, labeling) in enumerate(done):
            path = Path(folder) / f"{number}.png"
            render_labeling(labeling, path, size=SIZE, back=False)
            picture = Image.open(path).convert("RGB").crop((0, 0, width, height))
            font = ImageFont.load_default(20)
            ImageDraw.Draw(picture).text((10, 8), f"{number}  {text}", fill=INK, font=font)
            strip.paste(picture, (number % COLUMNS * width, number // COLUMNS * height))
    strip.save(output, quality=85)
    yield output
