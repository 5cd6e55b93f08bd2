# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Picture of the natural outline of a fabric: its stitches coloured by stretch, its borders, and its size.

A dashed rectangle has the size of the same number of stitches and rows of plain knit; for a tube, of a round plain
tube.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from stitchmesh.io.contents import FilePath
from stitchmesh.mesh import FloatArray
from stitchmesh.meshrelax.free.free_shape import FreeShape
from stitchmesh.render.colour_scale import DIVERGING, ColourScale
from stitchmesh.render.plots.plot_file import DASHES, INK, PALE_INK, open_frame, plot_file

if TYPE_CHECKING:
    from matplotlib.axes import Axes

SCALE = ColourScale(DIVERGING, 0.7, 1.3)
"""Colours of the mean stretch of a stitch."""


def plot_outline(shape: FreeShape, path: FilePath, title: str = "") -> None:
    """Draw the natural outline of a fabric.

    Args:
        shape: result of ``natural_outline`` or ``relax_mesh_freely``.
        path: a ``.png`` file; missing folders are created.
        title: name of the pattern.

    Raises:
        FileError: the picture cannot be written.
    """
    with plot_file(path, (7.0, 6.4)) as figure:
        draw_outline(figure.subplots(), shape, title)


def draw_outline(axes: Axes, shape: FreeShape, title: str) -> None:
    """Draw the natural outline of a fabric in some axes [cm]; it is seen from the front, against the z axis."""
    from matplotlib.collections import PolyCollection

    polygons, stretch = _front_polygons(shape)
    lines = 0.3 if shape.fabric.face_count < 20_000 else 0.0  # More sides would cover the colours.
    colours = SCALE.of(stretch) / 255.0
    axes.add_collection(PolyCollection(polygons, facecolors=colours, edgecolors=INK, linewidths=lines))
    for border in shape.outline:
        line = np.append(border, border[:1], axis=0)
        axes.plot(line[:, 0], line[:, 1], color=INK, linewidth=1.6)
    _draw_plain_size(axes, shape, np.concatenate(polygons))
    axes.set_aspect("equal")
    axes.tick_params(colors=PALE_INK, labelsize=8)
    open_frame(axes)
    words = [line for line in (title, *summary(shape).split("; ")) if line]
    axes.set_title("\n".join(words), loc="left", fontsize=10, color=INK, parse_math=False)  # A name is no formula


def summary(shape: FreeShape) -> str:
    """Return the size of an outline, and its size over the size of plain knit, on one line."""
    measures = shape.measures()
    plain = f"{100 * measures['width_over_plain']:.0f} % x {100 * measures['height_over_plain']:.0f} % of plain knit"
    slant = f"; its wales lean {abs(shape.slant):.0f}° {'right' if shape.slant > 0 else 'left'}"
    return f"{shape.width:.3g} x {shape.height:.3g} cm, {plain}{slant if abs(shape.slant) >= 0.5 else ''}"


def _front_polygons(shape: FreeShape) -> tuple[list[Any], FloatArray]:
    """Return the polygons of the stitches that face the viewer, and the stretch of these stitches."""
    fabric = shape.fabric
    front = np.flatnonzero(fabric.face_vector_area[:, 2] > 0.0)
    place = fabric.corner_position[:, :2]
    polygons = [place[fabric.face_start[face] : fabric.face_start[face + 1]] for face in front]
    assert fabric.face_stretch is not None  # The relaxation has filled it.
    return polygons, np.nan_to_num(fabric.face_stretch[front], nan=1.0)


def _draw_plain_size(axes: Axes, shape: FreeShape, points: FloatArray) -> None:
    """Draw the rectangle of plain knit with the same numbers of stitches and rows around the middle of the fabric."""
    measures = shape.measures()
    width = shape.width / measures["width_over_plain"] * (2.0 / np.pi if shape.is_tube else 1.0)
    height = shape.height / measures["height_over_plain"]
    middle = 0.5 * (points.min(axis=0) + points.max(axis=0))
    corner = 0.5 * np.array([[-width, -height], [width, -height], [width, height], [-width, height], [-width, -height]])
    axes.plot(*(middle + corner).T, color=PALE_INK, linewidth=1.0, linestyle=DASHES)
