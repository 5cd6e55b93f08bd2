# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Stitches on twelve surfaces without modelled rows, coloured by stretch, as one picture.

DATA is a folder with MakeHuman's meshes in decimetres, ``makehuman-body.obj``, ``makehuman-helper-tights.obj`` and
``makehuman-helper-skirt.obj``.
"""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

from PIL import ImageDraw

import stitchmesh as sm
from benchmarks.options import Output
from benchmarks.places import MESHES
from benchmarks.scenes.surface_shapes import SHAPES
from benchmarks.scenes.surfaces import Surface, garment, surfaces
from benchmarks.sheet import drawn
from benchmarks.table import Rows
from stitchmesh.mesh import Mesh, StitchMesh
from stitchmesh.render.animation_pictures import joined
from stitchmesh.render.fabric_pictures import render_stretch
from stitchmesh.render.options import PictureOptions
from stitchmesh.run import QUIET

SIZE = (640, 600)
"""Size of each picture [pixels]."""
COLUMNS = 4
"""Pictures in a row of the sheet."""
OF_MAKEHUMAN = {"body": 1.0, "helper-tights": 1.6, "helper-skirt": 1.6}
"""Widths of the stitches on MakeHuman's meshes [cm]."""
SHAPES_SHOWN = ("cardigan", "vest", "trousers", "mitten", "bear", "genus_2")
GARMENTS_SHOWN = ("sweater", "sock", "glove")
VIEWS = {"vest": "50,10", "genus_2": "30,40", "sock": "60,10"}
"""Directions of view, where it is not the front."""


def shown(data: Path) -> Iterator[Surface]:
    """Yield the surfaces of the picture."""
    for name, width in OF_MAKEHUMAN.items():
        yield from surfaces([data / f"makehuman-{name}.obj"], "dm", width)
    yield from (Surface(name, 0.8, SHAPES[name]) for name in SHAPES_SHOWN)
    yield from (garment(MESHES / f"{name}.obj") for name in GARMENTS_SHOWN)


def stitches_on(mesh: Mesh, width: float) -> StitchMesh:
    """Stitches that are evened out on a mesh, with room for their yarns."""
    shaped = sm.shape_fabric(mesh, stitch_width=width, progress=False)
    relaxed = sm.relax_mesh(shaped.fabric, surface=shaped.surface_mesh, run=QUIET)
    return sm.make_room(relaxed.fabric, quality="draft").fabric


def any_mesh_pictures(data: Path, /, *, output: Output) -> Rows:
    """Make the stitches, and draw them."""
    pictures = []
    for surface in shown(data):
        name, fabric = surface.name.removesuffix(".obj"), stitches_on(surface.make(), surface.width)
        options = PictureOptions(size=SIZE, view=VIEWS.get(name, "front"))
        pictures.append(drawn(lambda path, fabric=fabric, options=options: render_stretch(fabric, path, options)))
        words = f"{name}: {fabric.face_count:,} stitches of {surface.width:g} cm"
        ImageDraw.Draw(pictures[-1]).text((12, 10), words, fill="black", font_size=20)
        yield words
    joined(pictures, COLUMNS).save(output, quality=85)
