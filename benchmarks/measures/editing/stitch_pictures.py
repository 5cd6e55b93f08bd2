# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""A picture of every stitch in plain knitting, a sheet of all pictures, and the table of docs/stitches.md.

The yarn of the stitch's row is red; the loops on which the stitch is worked are blue, green and yellow from the left.
Distances are the smallest distances between the axes of the generated yarns, in yarn radii; the distance of touching
yarns is 2.
"""

from __future__ import annotations

import itertools

import numpy as np
from PIL import Image, ImageDraw

from benchmarks.places import DOCS
from benchmarks.table import Rows
from stitchmesh.mesh import StitchMesh
from stitchmesh.mesh.stitch import CODES, VOCABULARY, Stitch
from stitchmesh.mesh.tube_mesh import tubes_around
from stitchmesh.render.camera import camera_at
from stitchmesh.render.lettering import INK
from stitchmesh.render.options import PictureOptions
from stitchmesh.render.stage import add_tubes, look, picture, shade_hollows
from stitchmesh.yarn import YarnSet
from stitchmesh.yarn.polyline import polylines_of_segments
from stitchmesh.yarngen import generate_yarns
from stitchmesh.yarngen.clearance import smallest_distance
from stitchmesh.yarngen.templates.own_checks import surround_stitch
from stitchmesh.yarngen.templates.table import template
from stitchmesh.yarngen.templates.template import RADIUS_OVER_WIDTH, STITCH_HEIGHT

PICTURES = DOCS / "stitches"
SIZE, COLUMNS, GAP, LETTERING = 200, 8, 4, 16
"""Pixels of a picture, pictures in a row of the sheet, pixels between them, and pixels for the code below."""
BELOW = 0
"""Number of the row below the stitch."""
JPEG_QUALITY = 82
REST, OWN = (198, 188, 170), (150, 40, 34)
WORKED = ((44, 78, 130), (58, 110, 66), (176, 130, 40))
"""Colours (sRGB) of the loops on which the stitch is worked, from left to right; lights brighten them."""
NARROWEST, BESIDE = 1.6, 0.4
"""Smallest width of a stitch in the picture, and visible width beside the stitch [stitch widths]."""
WITHIN = 3 * RADIUS_OVER_WIDTH
"""Largest distance between yarns that is searched [stitch widths]."""


def colours_of(fabric: StitchMesh, centre: int, yarns: YarnSet) -> np.ndarray:
    """Colour of each control point, shape (n, 3)."""
    made = VOCABULARY[Stitch(fabric.stitch[centre])].made
    n_bottom, n_top = int(fabric.n_bottom[centre]), int(fabric.n_top[centre])
    first = fabric.face_start[centre]
    colours = np.tile(REST, (len(yarns.points), 1))

    def paint(face: int, part_numbers: list[int], row: int, colour: tuple[int, int, int]) -> None:
        # The row distinguishes the loops of the stitch from those above, because the bind-off has the same faces.
        colours[(yarns.face == face) & np.isin(yarns.part, part_numbers) & (yarns.row == row)] = colour

    for loop in range(n_bottom):
        below = fabric.side_face[fabric.twin[first + loop]]
        paint(below, _parts(fabric, below, is_head=False), BELOW, WORKED[loop])
    for loop, kind in enumerate(made):
        above = fabric.side_face[fabric.twin[first + n_bottom + n_top - loop]]
        row, colour = (BELOW, WORKED[0]) if kind == "s" else (BELOW + 1, OWN)
        paint(above, _parts(fabric, above, is_head=True), row, colour)
    paint(centre, _parts(fabric, centre, is_head=False), BELOW + 1, OWN)
    for number, part in enumerate(template(Stitch(fabric.stitch[centre]), n_bottom, n_top).parts):
        if part.is_head:
            paint(centre, [number], BELOW, WORKED[part.start.place])
    return colours.astype(np.uint8)


def _parts(fabric: StitchMesh, face: int, *, is_head: bool) -> list[int]:
    """Return the numbers of the parts of a face that are heads, or that are not heads."""
    shape = template(Stitch(fabric.stitch[face]), int(fabric.n_bottom[face]), int(fabric.n_top[face]))
    return [number for number, part in enumerate(shape.parts) if part.is_head == is_head]


def take_picture(stitch: Stitch) -> None:
    """Draw one stitch and the stitches around it."""
    path = PICTURES / f"{VOCABULARY[stitch].code}.png"
    fabric, centre = surround_stitch(stitch)
    yarns = generate_yarns(fabric, yarn_radius=RADIUS_OVER_WIDTH)
    curves = polylines_of_segments(yarns, np.arange(len(yarns.segment_points)), 4)
    tubes = tubes_around(curves.points, curves.closed, yarns.radius[curves.yarn], sides=14)
    colours = colours_of(fabric, centre, yarns)[curves.control_point][tubes.ring]
    widest = max(VOCABULARY[stitch].n_bottom, VOCABULARY[stitch].n_top, 1)
    focus, height = np.array([widest / 2, STITCH_HEIGHT / 2, 0.0]), max(widest, NARROWEST) + BESIDE
    options = PictureOptions(size=(SIZE, SIZE), scale_bar=False)  # the unit is a stitch width
    with picture(path, options) as plotter:
        add_tubes(plotter, tubes, colours)
        look(plotter, camera_at(focus, np.array([0.0, 0.0, 1.0]), np.array([0.0, 1.0, 0.0]), height))
        shade_hollows(plotter, 3 * RADIUS_OVER_WIDTH, options)
    Image.open(path).convert("RGB").save(path.with_suffix(".jpg"), quality=JPEG_QUALITY, optimize=True)
    path.unlink()


def sheet() -> None:
    """Draw all pictures in one sheet, with the codes of the stitches."""
    rows = -(-len(VOCABULARY) // COLUMNS)
    whole = Image.new("RGB", (COLUMNS * (SIZE + GAP) - GAP, rows * (SIZE + LETTERING)), "white")
    draw = ImageDraw.Draw(whole)
    for number, making in enumerate(VOCABULARY.values()):
        x, y = number % COLUMNS * (SIZE + GAP), number // COLUMNS * (SIZE + LETTERING)
        whole.paste(Image.open(PICTURES / f"{making.code}.jpg"), (x, y))
        draw.text((x + SIZE // 2, y + SIZE + 1), making.code, fill=INK, anchor="mt")
    whole.save(PICTURES / "all.jpg", quality=JPEG_QUALITY, optimize=True)


def distance(stitch: Stitch, twists: tuple[int, ...]) -> float:
    """Return the smallest distances among knit and among purl stitches [radii]."""
    found = []
    for plain in (Stitch.KNIT, Stitch.PURL):
        yarns = generate_yarns(surround_stitch(stitch, twists, plain)[0], yarn_radius=RADIUS_OVER_WIDTH)
        found.append(smallest_distance(yarns, WITHIN)[0])
    return min(found) / RADIUS_OVER_WIDTH


def row_of(stitch: Stitch) -> tuple[object, ...]:
    """Return the row of a stitch in the table of docs/stitches.md."""
    making = VOCABULARY[stitch]
    turns = [each for each in itertools.product((-1, 0, 1), repeat=making.n_top) if any(each)]
    plain, turned = distance(stitch, ()), min(distance(stitch, each) for each in turns)
    picture = f"![{making.code}](stitches/{making.code}.jpg)"
    order = ", ".join(map(str, making.order)) or "none"
    made = f"`{making.code}`", order, f"`{making.made}`", making.instruction
    return picture, *made, f"{plain:.2f}", f"{turned:.2f}"


def stitch_pictures(codes: tuple[str, ...] = (), /) -> Rows:
    """Draw the pictures and yield the table; if no codes are given, also draw the sheet of all pictures.

    Args:
        codes: codes of the stitches to draw (default: all)
    """
    yield "", "code", "loops below, from the front", "loops above", "what a knitter does", "distance", "twisted"
    for code in codes or CODES:
        take_picture(CODES[code])
        yield row_of(CODES[code])
    if not codes:
        sheet()
