# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Pictures of the meshes of the pipeline: polygons, labeled rows, stitches and stretch."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from stitchmesh.errors import ParameterError
from stitchmesh.io.contents import FilePath
from stitchmesh.mesh import Mesh, StitchMesh
from stitchmesh.mesh.stitch import Stitch
from stitchmesh.render.camera import camera_around, front_directions
from stitchmesh.render.lettering import INK
from stitchmesh.render.palette import stitch_colour, stitch_colours
from stitchmesh.render.stage import KEY_LEFT, look, picture
from stitchmesh.render.surface import add_edges, add_faces, add_wale_arrows, polygon_surface
from stitchmesh.yarn.colours import row_colours

if TYPE_CHECKING:
    import pyvista

MOST_LINES = 12_000
"""Largest number of faces for which edges and arrows are drawn; more of them would cover the surface."""
LEAST_SPREAD = 0.05
"""Smallest half range of the scale of a heat map around 1; with a smaller range, rounding would look like stretch."""
SPREAD_QUANTILE = 0.99
"""Quantile of |stretch - 1| that is the half range of the scale."""

Size = tuple[int, int]
"""Width and height [pixels]."""
PICTURE_SIZE: Size = (1600, 1000)
"""Default size of a picture."""


def render_mesh(mesh: Mesh, path: FilePath, *, size: Size = PICTURE_SIZE) -> None:
    """Draw a polygon mesh and its edges.

    Raises:
        DisplayError: this machine cannot draw pictures.
        FileError: the suffix is not ``.png``, or the file cannot be written.
    """
    caption = f"{mesh.face_count} faces, {len(mesh.boundary_loops)} borders"
    with picture(path, size, caption=caption) as plotter:
        add_faces(plotter, mesh, np.tile(np.array(stitch_colour(Stitch.KNIT), dtype=np.uint8), (mesh.face_count, 1)))
        if mesh.face_count <= MOST_LINES:
            add_edges(plotter, mesh, np.ones(mesh.side_count, dtype=bool), 2.0, 0.6)
        _look_at_front(plotter, mesh, size, 0.0)


def render_rows(fabric: StitchMesh, path: FilePath, *, size: Size = PICTURE_SIZE) -> None:
    """Draw a labeled mesh coloured by row, with thick course edges and an arrow along the wale in each face.

    Raises:
        DisplayError: this machine cannot draw pictures.
        FileError: the suffix is not ``.png``, or the file cannot be written.
    """
    caption = f"{len(np.unique(fabric.row))} rows, {fabric.face_count} faces; arrows point along the wales"
    with picture(path, size, caption=caption) as plotter:
        add_faces(plotter, fabric, row_colours(fabric.row))
        if fabric.face_count <= MOST_LINES:
            add_edges(plotter, fabric, fabric.is_wale, 1.5, 0.35)
            add_edges(plotter, fabric, ~fabric.is_wale, 4.0, 0.9)
            add_wale_arrows(plotter, fabric)
        _look_at_front(plotter, fabric, size, 0.0)


def render_stitches(fabric: StitchMesh, path: FilePath, *, size: Size = PICTURE_SIZE) -> None:
    """Draw a stitch mesh coloured by stitch type; the legend states the count of each type, and odd rows are darker.

    Raises:
        DisplayError: this machine cannot draw pictures.
        FileError: the suffix is not ``.png``, or the file cannot be written.
    """
    codes, counts = np.unique(fabric.stitch, return_counts=True)
    key = [
        (f"{Stitch(code).name.lower().replace('_', ' ')}  {count}", stitch_colour(code))
        for code, count in zip(codes.tolist(), counts.tolist(), strict=True)
    ]
    caption = f"{fabric.face_count} stitches in {len(np.unique(fabric.row))} rows"
    with picture(path, size, caption=caption, key=key) as plotter:
        add_faces(plotter, fabric, stitch_colours(fabric.stitch, fabric.row))
        if fabric.face_count <= MOST_LINES:
            add_edges(plotter, fabric, np.ones(fabric.side_count, dtype=bool), 1.0, 0.35)
        _look_at_front(plotter, fabric, size, 1 - KEY_LEFT)


def render_stretch(fabric: StitchMesh, path: FilePath, *, size: Size = PICTURE_SIZE) -> None:
    """Draw the stretch of each face as a heat map centred at 1.

    Raises:
        ParameterError: the mesh has no stretch.
        DisplayError: this machine cannot draw pictures.
        FileError: the suffix is not ``.png``, or the file cannot be written.
    """
    if fabric.face_stretch is None:
        raise ParameterError("stretch: the stitch mesh has none; relax the mesh first")
    spread = max(float(np.quantile(np.abs(fabric.face_stretch - 1.0), SPREAD_QUANTILE)), LEAST_SPREAD)
    caption = f"stretch of faces from {fabric.face_stretch.min():.3f} to {fabric.face_stretch.max():.3f}"
    surface = polygon_surface(fabric)
    bar = {
        "title": "length / rest length\n", "vertical": True, "position_x": KEY_LEFT + 0.05, "position_y": 0.2,
        "height": 0.6, "width": 0.05, "color": INK, "n_labels": 5, "fmt": "%.2f",
        "title_font_size": 36, "label_font_size": 36,
    }  # fmt: skip
    with picture(path, size, caption=caption) as plotter:
        plotter.add_mesh(
            surface, scalars=fabric.face_stretch, cmap="RdBu_r", clim=(1.0 - spread, 1.0 + spread), scalar_bar_args=bar,
            smooth_shading=True, ambient=0.35, diffuse=0.5, specular=0.0,
        )  # fmt: skip
        if fabric.face_count <= MOST_LINES:
            add_edges(plotter, fabric, np.ones(fabric.side_count, dtype=bool), 1.0, 0.25)
        _look_at_front(plotter, fabric, size, 1 - KEY_LEFT)


def _look_at_front(plotter: pyvista.Plotter, mesh: Mesh, size: Size, kept_free: float) -> None:
    """Show the whole mesh from the front, and leave the part ``kept_free`` of the width free on the right."""
    towards, up = front_directions(mesh.corner_position)
    look(plotter, camera_around(mesh.corner_position, towards, up, size[0] / size[1], part=(1 - kept_free, 1.0)))
    plotter.camera.SetWindowCenter(kept_free, 0.0)
