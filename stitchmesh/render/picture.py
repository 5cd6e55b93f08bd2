# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Picture of yarns: the whole object, with a close-up of some stitches of its front, or a close-up of a place."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from stitchmesh.io.contents import FilePath
from stitchmesh.mesh import FloatArray
from stitchmesh.render.camera import Camera, camera_around, camera_at, front_patch, picture_axes
from stitchmesh.render.close_up import CloseUpPoints, CloseUpTarget, close_up_patch, outward_normal
from stitchmesh.render.colouring import Coloured, colour_yarns
from stitchmesh.render.options import DEFAULTS, PictureOptions
from stitchmesh.render.stage import (
    KEY_LEFT,
    WHOLE,
    Viewport,
    add_body,
    look,
    picture,
    shade_hollows,
)
from stitchmesh.render.view import FRONT, view_directions
from stitchmesh.render.yarn_drawing import add_yarns, look_of, pixels_at
from stitchmesh.yarn import YarnSet

if TYPE_CHECKING:
    import pyvista

CLOSE_UP_AREA = 7600.0
"""Area of the close-up in squared yarn radii: about 150 plain stitches of about 8 by 6 yarn radii each."""
WIDE = 2.0
"""From this ratio of width to height, the close-up stands below the object instead of beside it."""
CLOSE_UP_SIDES, CLOSE_UP_SAMPLES = 16, 4
"""Sides of a tube and samples per segment in the close-up."""
CLOSE_UP_EXTENT = 60.0
"""Default width of the region of a close-up, over the apparent yarn radius: about twelve stitches."""
DETAIL = ((12_000, 16, 4), (40_000, 10, 3), (120_000, 8, 2), (400_000, 6, 1))
"""Levels of detail: largest number of segments, sides of a tube and samples per segment."""


@dataclass(frozen=True)
class Layout:
    """The panels of a picture."""

    panels: tuple[Viewport, ...]
    """The panel of the whole object and, if there is one, the panel of the close-up, which covers a part of the
    first."""
    part: tuple[float, float]
    """Part of the width and of the height that remains for the whole object."""
    centre: tuple[float, float]
    """Centre of the window relative to the centre of that part, in units of half a window."""

    def close_up_aspect(self, size: tuple[int, int]) -> float:
        """Return the width of the close-up divided by its height, for a picture of ``size`` [pixels]."""
        left, low, right, high = self.panels[1]
        return (right - left) * size[0] / ((high - low) * size[1])

    def close_up_height(self, size: tuple[int, int], radius: float) -> float:
        """Return the height of the region that the close-up shows [cm].

        Args:
            size: width and height of the picture [pixels].
            radius: yarn radius [cm].
        """
        return radius * float(np.sqrt(CLOSE_UP_AREA / self.close_up_aspect(size)))


BESIDE_PARTS = (0.61, 0.76)
"""Bounds of the part of the width that remains for an object beside its close-up; a wide object gets more."""
BELOW = Layout((WHOLE, (0.02, 0.03, 0.98, 0.41)), (1.0, 0.57), (0.0, -0.43))
ALONE = Layout((WHOLE,), (1.0, 1.0), (0.0, 0.0))


def beside(part: float) -> Layout:
    """Return the layout of an object beside its close-up, for the part of the width that remains for the object."""
    return Layout((WHOLE, (part, 0.03, 0.98, 0.97)), (part, 1.0), (1.0 - part, 0.0))


def layout_for(points: FloatArray, towards: FloatArray, up: FloatArray, radius: float, aspect: float) -> Layout:
    """Choose the layout for yarns; an object that is not larger than a close-up has no close-up.

    Args:
        points: control points of the yarns [cm], shape (n, 3).
        towards: direction from the yarns to the camera, shape (3,).
        up: direction that is vertical in the picture, shape (3,).
        radius: yarn radius [cm].
        aspect: width of the picture over its height.
    """
    width, height, _ = np.ptp(points @ picture_axes(towards, up), axis=0)
    if width * height < CLOSE_UP_AREA * radius**2:
        return ALONE
    return BELOW if width > WIDE * height else beside(float(np.clip(width / height / aspect, *BESIDE_PARTS)))


def render_yarns(yarns: YarnSet, path: FilePath, options: PictureOptions = DEFAULTS) -> None:
    """Draw yarns with their look and their apparent radius.

    Args:
        yarns: the yarns, with y upwards.
        path: a ``.png`` file; missing folders are created.
        options: camera, colours, size and other choices.

    Raises:
        ParameterError: an option does not fit the yarns.
        DisplayError: this machine cannot draw pictures.
        FileError: the suffix is not ``.png``, or the file cannot be written.
    """
    place = options.place
    coloured = colour_yarns(
        yarns, options.colour or "yarn", fabric=options.fabric, body=options.body, blend=options.blend
    )
    if place is not None:
        _render_place(yarns, path, options, coloured, place)
    else:
        _render_whole(yarns, path, options, coloured)


def _render_whole(yarns: YarnSet, path: FilePath, options: PictureOptions, coloured: Coloured) -> None:
    """Draw all yarns and, beside a view from the front, a close-up of the middle of the front."""
    radius = float(np.median(yarns.drawn_radius))
    towards, up = view_directions(yarns.points if options.framed is None else options.framed, options.view or FRONT)
    layout = _layout(yarns, towards, up, options)
    part = (layout.part[0] * (KEY_LEFT if coloured.key else 1.0), layout.part[1])
    with picture(path, options, panels=layout.panels, key=coloured.key) as plotter:
        plotter.subplot(0, 0)
        everything = np.arange(len(yarns.segment_points))
        framed = yarns.points
        if options.body is not None:
            add_body(plotter, options.body)
            framed = np.concatenate([framed, options.body.vertices])
        if options.framed is not None:
            framed = options.framed
        camera = camera_around(framed, towards, up, options.aspect, part=part, clearance=radius)
        detail, pixels = detail_for(len(everything)), pixels_at(camera, options.size[1])
        own = look_of(yarns, options, coloured)
        add_yarns(plotter, yarns, everything, detail, coloured, own, pixels)
        look(plotter, camera, own.sheen)
        plotter.camera.SetWindowCenter(*_centre(layout, part))
        shade_hollows(plotter, 4 * radius, options)
        if layout is not ALONE:
            plotter.subplot(0, 1)
            height = layout.close_up_height(options.size, float(np.median(yarns.radius)))
            focus, normal = front_patch(
                yarns.points, towards, up, 0.5 * height * min(layout.close_up_aspect(options.size), 1.0)
            )
            extent = (height * layout.close_up_aspect(options.size), height)
            _draw_region(plotter, yarns, coloured, options, camera_at(focus, normal, up, height), extent)


def _render_place(
    yarns: YarnSet, path: FilePath, options: PictureOptions, coloured: Coloured, place: CloseUpTarget
) -> None:
    """Draw the yarns around one place."""
    radius = float(np.median(yarns.drawn_radius))
    width = options.extent or CLOSE_UP_EXTENT * radius
    towards, up = view_directions(yarns.points, options.view or FRONT)
    whole = camera_around(yarns.points, towards, up, options.aspect, clearance=radius)
    surface = CloseUpPoints(yarns.points, yarns.face, yarns.row)
    middle, patch = close_up_patch(surface, place, whole, options.aspect, width)
    normal = towards if options.view is not None else outward_normal(yarns.points, patch, towards)
    focus = yarns.points[patch].mean(axis=0) if len(patch) > 2 else yarns.points[middle]
    height = width / options.aspect
    with picture(path, options, key=coloured.key) as plotter:
        if options.body is not None:
            add_body(plotter, options.body)
        _draw_region(plotter, yarns, coloured, options, camera_at(focus, normal, up, height), (width, height))


def _layout(yarns: YarnSet, towards: FloatArray, up: FloatArray, options: PictureOptions) -> Layout:
    """Choose the layout; only a picture from the front, with room beside the object, has a close-up."""
    if not options.inset or options.view not in (None, FRONT) or options.body is not None:
        return ALONE
    return layout_for(yarns.points, towards, up, float(np.median(yarns.radius)), options.aspect)


def _centre(layout: Layout, part: tuple[float, float]) -> tuple[float, float]:
    """Return the centre of the window for a part of the picture; a legend leaves less room on the right."""
    return (layout.centre[0] + layout.part[0] - part[0], layout.centre[1])


def detail_for(count: int) -> tuple[int, int]:
    """Return the sides of a tube and the samples per segment for a number of segments."""
    return next(((sides, samples) for most, sides, samples in DETAIL if count <= most), (4, 1))


def _draw_region(
    plotter: pyvista.Plotter, yarns: YarnSet, coloured: Coloured, options: PictureOptions, camera: Camera,
    extent: tuple[float, float],
) -> None:  # fmt: skip
    """Draw the segments in the picture of a close-up, without the surfaces before and behind the region.

    Args:
        plotter: the plotter.
        yarns: the yarns.
        coloured: colours of the control points.
        options: options of the picture.
        camera: the camera of the close-up.
        extent: width and height of the region [cm].
    """
    depth = camera.position - camera.focus
    offset = yarns.points[yarns.segment_points].mean(axis=1) - camera.focus
    near = np.linalg.norm(offset, axis=1) < max(extent)
    near &= np.abs(offset @ (depth / np.linalg.norm(depth))) < 0.5 * extent[1]
    own = look_of(yarns, options, coloured)
    if near.any():
        detail, pixels = (CLOSE_UP_SIDES, CLOSE_UP_SAMPLES), options.size[1] / extent[1]
        add_yarns(plotter, yarns, np.flatnonzero(near), detail, coloured, own, pixels)
    look(plotter, camera, own.sheen)
    shade_hollows(plotter, 2 * float(np.median(yarns.drawn_radius)), options)
