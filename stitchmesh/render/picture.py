# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Picture of yarns: the whole object from the front, and a close-up of some stitches of the front."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from stitchmesh.io.contents import FilePath
from stitchmesh.mesh import FloatArray, IntArray
from stitchmesh.mesh.tube_mesh import tubes_around
from stitchmesh.render.camera import Camera, camera_around, camera_at, front_directions, front_patch
from stitchmesh.render.layout import ALONE, layout_for
from stitchmesh.render.stage import DUSK, add_tubes, look, picture, shade_hollows
from stitchmesh.yarn import YarnSet
from stitchmesh.yarn.colours import yarn_colours
from stitchmesh.yarn.polyline import polylines_of_segments

if TYPE_CHECKING:
    import pyvista

CLOSE_UP_SIDES, CLOSE_UP_SAMPLES = 16, 4
"""Sides of a tube and samples per segment in the close-up."""

DETAIL = ((40_000, 10, 3), (120_000, 8, 2), (400_000, 6, 1))
"""Levels of detail: largest number of segments, sides of a tube and samples per segment."""
COARSEST = (4, 1)
"""Sides of a tube and samples per segment for more segments than any level of ``DETAIL`` allows."""


def render_yarns(yarns: YarnSet, path: FilePath, *, size: tuple[int, int] = (1600, 1000)) -> None:
    """Draw yarns as tubes of their radius, coloured by yarn if there are several colours, else by row.

    Args:
        yarns: the yarns, with y upwards; the front is the wide side (``camera.front_directions``).
        path: a ``.png`` file; missing folders are created.
        size: width and height [pixels].

    Raises:
        DisplayError: this machine cannot draw pictures.
        FileError: the suffix is not ``.png``, or the file cannot be written.
    """
    towards, up = front_directions(yarns.points)
    radius = float(np.median(yarns.radius))
    colours = yarn_colours(yarns.row, yarns.colour[yarns.point_yarn])
    layout = layout_for(yarns.points, towards, up, radius)
    with picture(path, size, panels=layout.panels) as plotter:
        plotter.subplot(0, 0)
        _draw(plotter, yarns, np.arange(len(yarns.segment_points)), detail_for(len(yarns.segment_points)), colours)
        aspect = size[0] / size[1]
        look(plotter, camera_around(yarns.points, towards, up, aspect, part=layout.part, clearance=radius))
        plotter.camera.SetWindowCenter(*layout.centre)
        shade_hollows(plotter, 6 * radius)
        if layout is not ALONE:
            plotter.subplot(0, 1)
            plotter.set_background(DUSK, all_renderers=False)
            height = layout.close_up_height(size, radius)
            camera, segments = _close_up(yarns, towards, up, height, layout.close_up_aspect(size))
            _draw(plotter, yarns, segments, (CLOSE_UP_SIDES, CLOSE_UP_SAMPLES), colours)
            look(plotter, camera)
            shade_hollows(plotter, 3 * radius)


def detail_for(count: int) -> tuple[int, int]:
    """Return the sides of a tube and the samples per segment for a number of segments."""
    return next(((sides, samples) for most, sides, samples in DETAIL if count <= most), COARSEST)


def _close_up(
    yarns: YarnSet, towards: FloatArray, up: FloatArray, height: float, aspect: float
) -> tuple[Camera, IntArray]:
    """A camera opposite to the middle of the front, and the segments in its picture."""
    extent = height * max(aspect, 1.0)
    focus, normal = front_patch(yarns.points, towards, up, 0.5 * height * min(aspect, 1.0))
    offset = yarns.points[yarns.segment_points].mean(axis=1) - focus
    near = (np.linalg.norm(offset, axis=1) < extent) & (np.abs(offset @ normal) < 0.5 * height)
    return camera_at(focus, normal, up, height), np.flatnonzero(near)


def _draw(
    plotter: pyvista.Plotter, yarns: YarnSet, segments: IntArray, detail: tuple[int, int], colours: NDArray[np.uint8]
) -> None:
    sides, samples = detail
    curves = polylines_of_segments(yarns, segments, samples)
    tubes = tubes_around(curves.points, curves.closed, yarns.radius[curves.yarn], sides=sides)
    add_tubes(plotter, tubes, colours[curves.control_point][tubes.ring])
