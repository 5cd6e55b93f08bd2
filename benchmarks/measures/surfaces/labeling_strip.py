# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The labeling of the sweater step by step, as a strip of pictures.

Each picture shows the steps up to its own.
"""

from __future__ import annotations

from functools import partial

from PIL import ImageDraw, ImageFont

from benchmarks.sheet import drawn
from benchmarks.table import Rows
from stitchmesh.io import read_mesh
from stitchmesh.labeling import PartialLabeling, start_labeling
from stitchmesh.render.animation_pictures import joined
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
    pictures = []
    for number, (text, labeling) in enumerate(steps()):
        picture = drawn(partial(render_labeling, labeling, size=SIZE, back=False))
        picture = picture.crop((0, 0, round(KEY_LEFT * SIZE[0]), SIZE[1]))
        ImageDraw.Draw(picture).text((10, 8), f"{number}  {text}", fill=INK, font=ImageFont.load_default(20))
        pictures.append(picture)
    joined(pictures, COLUMNS).save(output, quality=85)
    yield output
