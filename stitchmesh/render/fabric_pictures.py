# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Pictures of the meshes of the pipeline: polygons, labeled rows, stitches and stretch."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from stitchmesh.errors import ParameterError
from stitchmesh.hand_knitting.words import stitch_name
from stitchmesh.io.contents import FilePath
from stitchmesh.mesh import Mesh, StitchMesh
from stitchmesh.mesh.palette import colours_of
from stitchmesh.mesh.stitch import Stitch
from stitchmesh.render.camera import Camera, camera_around, camera_at
from stitchmesh.render.close_up import CloseUpPoints, CloseUpTarget, close_up_patch
from stitchmesh.render.colouring import blend_colours, one_colour
from stitchmesh.render.lettering import INK, Colour
from stitchmesh.render.options import DEFAULTS, PictureOptions
from stitchmesh.render.palette import stitch_colour, stitch_colours
from stitchmesh.render.stage import KEY_LEFT, add_body, look, picture
from stitchmesh.render.surface import (
    MOST_LINES,
    add_arrowheads,
    add_edges,
    add_faces,
    add_lines,
    polygon_surface,
    wale_arrowheads,
)
from stitchmesh.render.view import FRONT, view_directions
from stitchmesh.yarn.colours import row_colours

if TYPE_CHECKING:
    import pyvista

CLOSE_UP_EXTENT = 16.0
"""Default width of the region of a close-up, over the median length of a side."""


def render_mesh(mesh: Mesh, path: FilePath, options: PictureOptions = DEFAULTS) -> None:
    """Draw a polygon mesh and its edges.

    Raises:
        DisplayError: this machine cannot draw pictures.
        FileError: the suffix is not ``.png``, or the file cannot be written.
    """
    caption = f"{mesh.face_count} faces, {len(mesh.boundary_loops)} borders"
    colours = np.tile(np.array(stitch_colour(Stitch.KNIT), dtype=np.uint8), (mesh.face_count, 1))
    with _picture_of_faces(mesh, path, options, colours, caption=caption) as plotter:
        add_edges(plotter, mesh, 2.0, 0.6)


def render_rows(fabric: StitchMesh, path: FilePath, options: PictureOptions = DEFAULTS) -> None:
    """Draw a labeled mesh coloured by row, with thick course edges and an arrow along the wale in each face.

    Raises:
        DisplayError: this machine cannot draw pictures.
        FileError: the suffix is not ``.png``, or the file cannot be written.
    """
    caption = f"{len(np.unique(fabric.row))} rows, {fabric.face_count} faces; arrows point along the wales"
    colours = blend_colours(colours_of(fabric.yarn, fabric.palette), row_colours(fabric.row), options.blend)
    with _picture_of_faces(fabric, path, options, colours, caption=caption) as plotter:
        if fabric.face_count <= MOST_LINES:
            wales = fabric.is_wale[fabric.edge_side]
            add_lines(plotter, fabric, fabric.edge_side[wales], INK, 1.5, 0.35)
            add_lines(plotter, fabric, fabric.edge_side[~wales], INK, 4.0, 0.9)
            add_arrowheads(plotter, wale_arrowheads(fabric), 0.8)


def render_stitches(fabric: StitchMesh, path: FilePath, options: PictureOptions = DEFAULTS) -> None:
    """Draw a stitch mesh coloured by stitch type; the legend states the count of each type, and odd rows are darker.

    Raises:
        DisplayError: this machine cannot draw pictures.
        FileError: the suffix is not ``.png``, or the file cannot be written.
    """
    codes, counts = np.unique(fabric.stitch, return_counts=True)
    key = [
        (f"{stitch_name(fabric.stitch_type(code))}  {count}", stitch_colour(code))
        for code, count in zip(codes.tolist(), counts.tolist(), strict=True)
    ]
    caption = f"{fabric.face_count} stitches in {len(np.unique(fabric.row))} rows"
    own = colours_of(fabric.yarn, fabric.palette)
    colours = blend_colours(own, stitch_colours(fabric.stitch, fabric.row), options.blend)
    with _picture_of_faces(fabric, path, options, colours, caption=caption, key=key) as plotter:
        add_edges(plotter, fabric, 1.0, 0.35)


def render_stretch(fabric: StitchMesh, path: FilePath, options: PictureOptions = DEFAULTS) -> None:
    """Draw the stretch of each face as a heat map centred at 1.

    Raises:
        ParameterError: the mesh has no stretch.
        DisplayError: this machine cannot draw pictures.
        FileError: the suffix is not ``.png``, or the file cannot be written.
    """
    if fabric.face_stretch is None:
        raise ParameterError("stretch: the stitch mesh has none; relax the mesh first")
    # Outliers do not stretch the scale; with a smaller range, rounding would look like stretch.
    spread = max(float(np.quantile(np.abs(fabric.face_stretch - 1.0), 0.99)), 0.05)
    caption = f"stretch of faces from {fabric.face_stretch.min():.3f} to {fabric.face_stretch.max():.3f}"
    surface = polygon_surface(fabric)
    bar = {
        "title": "length / rest length\n", "vertical": True, "position_x": KEY_LEFT + 0.05, "position_y": 0.2,
        "height": 0.6, "width": 0.05, "color": INK, "n_labels": 5, "fmt": "%.2f",
        "title_font_size": 36, "label_font_size": 36,
    }  # fmt: skip
    with picture(path, options, caption=caption) as plotter:
        plotter.add_mesh(
            surface, scalars=fabric.face_stretch, cmap="RdBu_r", clim=(1.0 - spread, 1.0 + spread), scalar_bar_args=bar,
            smooth_shading=True, ambient=0.35, diffuse=0.5, specular=0.0,
        )  # fmt: skip
        add_edges(plotter, fabric, 1.0, 0.25)
        look_at_mesh(plotter, fabric, options, 1 - KEY_LEFT)


def render_faces(fabric: Mesh, path: FilePath, options: PictureOptions = DEFAULTS) -> None:
    """Draw the faces in the colours of their yarns, or in one colour.

    Raises:
        ParameterError: the colour is unknown.
        DisplayError: this machine cannot draw pictures.
        FileError: the suffix is not ``.png``, or the file cannot be written.
    """
    colour = options.colour or "yarn"
    if colour == "yarn" and isinstance(fabric, StitchMesh):
        colours = colours_of(fabric.yarn, fabric.palette)
    else:
        colours = np.tile(one_colour(colour), (fabric.face_count, 1))
    with _picture_of_faces(fabric, path, options, colours) as plotter:
        add_edges(plotter, fabric, 1.0, 0.35)


@contextmanager
def _picture_of_faces(
    mesh: Mesh, path: FilePath, options: PictureOptions, colours: NDArray[np.uint8], *, caption: str = "",
    key: Sequence[tuple[str, Colour]] = (),
) -> Iterator[pyvista.Plotter]:  # fmt: skip
    """Open a picture of faces in their colours, to which lines may be added; a legend takes the room on the right."""
    with picture(path, options, caption=caption, key=key) as plotter:
        add_faces(plotter, mesh, colours)
        yield plotter
        look_at_mesh(plotter, mesh, options, 1 - KEY_LEFT if key else 0.0)


def look_at_mesh(plotter: pyvista.Plotter, mesh: Mesh, options: PictureOptions, kept_free: float) -> None:
    """Show the whole mesh, or a place of it, and leave the part ``kept_free`` of the width free on the right."""
    points = mesh.corner_position
    towards, up = view_directions(points, options.view or FRONT)
    if options.body is not None:
        add_body(plotter, options.body)
        points = np.concatenate([points, options.body.vertices])
    camera = camera_around(points, towards, up, options.aspect, part=(1 - kept_free, 1.0))
    if options.place is not None:
        camera = _close_up_camera(mesh, options, camera, options.place, kept_free)
    look(plotter, camera)
    plotter.camera.SetWindowCenter(kept_free, 0.0)


def _close_up_camera(
    mesh: Mesh, options: PictureOptions, whole: Camera, place: CloseUpTarget, kept_free: float
) -> Camera:
    """Return the camera for a close-up of some faces."""
    side = float(np.median(mesh.side_length))
    width = options.extent or CLOSE_UP_EXTENT * side
    row = mesh.row if isinstance(mesh, StitchMesh) else np.full(mesh.face_count, -1)
    faces = np.arange(mesh.face_count)
    counts = np.diff(mesh.face_start)
    centre = np.add.reduceat(mesh.corner_position, mesh.face_start[:-1]) / counts[:, None]
    surface = CloseUpPoints(centre, faces, row)
    middle, patch = close_up_patch(surface, place, whole, options.aspect, width)
    towards = mesh.face_vector_area[patch].sum(axis=0) if len(patch) else mesh.face_vector_area[middle]
    if options.view is not None:
        towards = view_directions(mesh.corner_position, options.view)[0]
    focus = surface.points[patch].mean(axis=0) if len(patch) > 2 else surface.points[middle]
    return camera_at(focus, towards, whole.up, width / options.aspect / (1 - kept_free))
