# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Stitches on twelve surfaces without modelled rows, coloured by stretch, as one picture.

DATA is a folder with MakeHuman's meshes in decimetres, ``makehuman-body.obj``, ``makehuman-helper-tights.obj`` and
``makehuman-helper-skirt.obj``.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from pathlib import Path

from PIL import ImageDraw

import stitchmesh as sm
from benchmarks.measures.surfaces.any_surface import width_of
from benchmarks.options import Output
from benchmarks.places import MESHES
from benchmarks.sheet import drawn, joined
from benchmarks.surface_shapes import SHAPES, triangulated
from benchmarks.table import Rows
from stitchmesh.io.meshes import read_repaired_mesh
from stitchmesh.mesh import Mesh, StitchMesh
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


def surfaces(data: Path) -> Iterator[tuple[str, float, Callable[[], Mesh]]]:
    """Name, width of a stitch [cm], and the function that makes the mesh."""
    for name, width in OF_MAKEHUMAN.items():
        yield name, width, lambda path=data / f"makehuman-{name}.obj": read_repaired_mesh(path, unit="dm").mesh
    for name in SHAPES_SHOWN:
        yield name, 0.8, SHAPES[name]
    for path in (MESHES / f"{name}.obj" for name in GARMENTS_SHOWN):
        yield path.stem, width_of(path), lambda path=path: triangulated(sm.read_mesh(path))


def stitches_on(mesh: Mesh, width: float) -> StitchMesh:
    """Stitches that are evened out on a mesh, with room for their yarns."""
    shaped = sm.shape_fabric(mesh, stitch_width=width, progress=False)
    return sm.make_room(sm.relax_mesh(shaped.fabric, surface=shaped.surface_mesh, run=QUIET).fabric, quality="draft")


def any_mesh_pictures(data: Path, /, *, output: Output) -> Rows:
    """Make the stitches, and draw them."""
    pictures = []
    for name, width, make in surfaces(data):
        fabric = stitches_on(make(), width)
        options = PictureOptions(size=SIZE, view=VIEWS.get(name, "front"))
        pictures.append(drawn(lambda path, fabric=fabric, options=options: render_stretch(fabric, path, options)))
        words = f"{name}: {fabric.face_count:,} stitches of {width:g} cm"
        ImageDraw.Draw(pictures[-1]).text((12, 10), words, fill="black", font_size=20)
        yield words
    joined(pictures, COLUMNS).save(output, quality=85)
