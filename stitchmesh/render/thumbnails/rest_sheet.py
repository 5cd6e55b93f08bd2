# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""A sheet with a picture of each state of rest of a swatch, and its figures."""

from __future__ import annotations

from stitchmesh.io.atomic import atomic_path
from stitchmesh.io.contents import FilePath
from stitchmesh.periodic.explore import Exploration, Rest
from stitchmesh.render.lettering import INK
from stitchmesh.render.swatch_picture import swatch_image

COLUMNS = 4
"""Largest number of pictures in a row."""
SIDE, GAP = 420, 12
"""Largest side of a picture, and the space between pictures [pixels]."""
LETTERS = 18
"""Height of the letters [pixels]."""
LINES = 3
"""Lines of text over a picture."""
STITCHES = 10
"""Number of stitches along a side of a picture; at least one repeat is shown."""


def draw_rests(exploration: Exploration, path: FilePath) -> None:
    """Draw the states of rest in ascending order of energy.

    Args:
        exploration: the states, at least one.
        path: a ``.png`` file; missing folders are created.

    Raises:
        DisplayError: this machine cannot draw pictures.
        FileError: the picture cannot be written.
    """
    from PIL import Image, ImageDraw, ImageFont

    pictures = [swatch_image(rest.swatch.yarns, _tiles(rest), SIDE) for rest in exploration.rests]
    rows = [pictures[first : first + COLUMNS] for first in range(0, len(pictures), COLUMNS)]
    text, widest = LINES * (LETTERS + 4), max(map(len, rows))
    heights = [text + GAP + max(picture.height for picture in row) for row in rows]
    sheet = Image.new("RGB", (widest * (SIDE + GAP) + GAP, sum(heights) + GAP), "white")
    draw, font = ImageDraw.Draw(sheet), ImageFont.load_default(LETTERS)
    for number, (rest, picture) in enumerate(zip(exploration.rests, pictures, strict=True)):
        row, column = divmod(number, COLUMNS)
        x, y = GAP + column * (SIDE + GAP), GAP + sum(heights[:row])
        draw.multiline_text((x, y), caption(number, rest, exploration.starts), fill=INK, font=font)
        sheet.paste(picture, (x, y + text))
    with atomic_path(path) as temporary:
        sheet.save(temporary, format="PNG")


def caption(number: int, rest: Rest, starts: int) -> str:
    """Return the figures of a state in ``LINES`` lines."""
    row = rest.row()
    return (
        f"{number + 1}: {rest.count} of {starts} starts, {row['energy_per_stitch']:.1f} erg a stitch\n"
        f"{row['wale_spacing']:.3f} x {row['course_spacing']:.3f} cm, {row['thickness']:.2f} cm thick\n"
        f"{row['shape']}, {row['posture']} ({row['lean']:+.2f})"
    )


def _tiles(rest: Rest) -> tuple[int, int]:
    report = rest.swatch.report
    return max(STITCHES // int(report["wales"]), 1), max(STITCHES // int(report["courses"]), 1)
