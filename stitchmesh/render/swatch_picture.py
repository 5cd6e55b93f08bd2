# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Picture of a periodic fabric: a number of tiles from the front, which fill the whole picture."""

from __future__ import annotations

import tempfile
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from stitchmesh.io.contents import FilePath
from stitchmesh.mesh import FloatArray, IntArray, StitchMesh
from stitchmesh.render.camera import camera_at
from stitchmesh.render.colouring import colour_yarns
from stitchmesh.render.options import DEFAULTS, PICTURE_SIZE, PictureOptions
from stitchmesh.render.picture import detail_for
from stitchmesh.render.stage import look, picture, shade_hollows
from stitchmesh.render.yarn_drawing import add_yarns, look_of
from stitchmesh.yarn import YarnSet
from stitchmesh.yarn.tiling import check_tiled_memory, tile_yarns

if TYPE_CHECKING:
    from PIL.Image import Image as Picture

LONGER_SIDE = 1400
"""Pixels along the longer side of a picture."""
DEFAULT_TILES = (5, 5)
"""Default number of visible periods along the courses and along the wales."""


def render_swatch(
    yarns: YarnSet, path: FilePath, tiles: tuple[int, int] = DEFAULT_TILES, options: PictureOptions = DEFAULTS
) -> None:
    """Draw tiles of a fabric, which fill the whole picture.

    Args:
        yarns: a set of yarns on a lattice; the front is the side to which the cross product of the periods points.
        path: a ``.png`` file; missing folders are created.
        tiles: number of visible periods along the courses and along the wales.
        options: colours, background and strands. The picture has the shape of the tiles: its longer side is the longer
            side of ``size``, or ``LONGER_SIDE`` by default.

    Raises:
        DisplayError: this machine cannot draw pictures.
        FileError: the suffix is not ``.png``, or the file cannot be written.
        ParameterError: a number of tiles is not a positive integer or too large for the memory, or the colour is
            unknown.
        YarnError: the yarns have no lattice.
    """
    check_tiled_memory(len(yarns.points), *tiles)
    around = tile_yarns(yarns, tiles[0] + 2, tiles[1] + 2)
    assert yarns.lattice is not None  # tile_yarns has checked this.
    corner = yarns.lattice.shift(np.array([1, 1]))
    frame, extent = _frame(yarns, tiles)
    middle = corner + 0.5 * yarns.lattice.shift(np.array(tiles)) + _middle(yarns)
    radius = float(yarns.drawn_radius.max())
    # Perspective shifts the near side of yarn at the border outwards.
    visible = _visible_segments(around, frame, middle, extent, 4.0 * radius)
    coloured = colour_yarns(
        _in_cell(around, options.fabric), options.colour or "yarn", fabric=options.fabric, blend=options.blend
    )
    longer_side = LONGER_SIDE if options.size == PICTURE_SIZE else max(options.size)
    with picture(path, replace(options, size=_pixels(extent, longer_side)), key=coloured.key) as plotter:
        pixels, detail = longer_side / float(extent.max()), detail_for(len(visible))
        own = look_of(yarns, options, coloured)
        add_yarns(plotter, around, visible, detail, coloured, own, pixels)
        look(plotter, camera_at(middle, frame[2], frame[1], float(extent[1])), own.sheen)
        shade_hollows(plotter, 2.5 * radius, options)


def swatch_image(yarns: YarnSet, tiles: tuple[int, int], side: int) -> Picture:
    """Return a picture of tiles of a fabric, at most ``side`` pixels wide and high.

    Args:
        yarns: a set of yarns on a lattice, as for ``render_swatch``.
        tiles: number of visible periods along the courses and along the wales.
        side: largest side [pixels].

    Raises:
        DisplayError, ParameterError, YarnError: as for ``render_swatch``.
    """
    from PIL import Image

    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "swatch.png"
        render_swatch(yarns, file, tiles)
        with Image.open(file) as drawn:
            image = drawn.convert("RGB")
    image.thumbnail((side, side), Image.Resampling.LANCZOS)
    return image


def _in_cell(tiles: YarnSet, fabric: StitchMesh | None) -> YarnSet:
    """Return tiles whose control points have faces of the mesh of one cell; tiles are numbered in turn."""
    if fabric is None:
        return tiles
    return replace(tiles, face=np.where(tiles.face >= 0, tiles.face % fabric.face_count, tiles.face))


def _frame(yarns: YarnSet, tiles: tuple[int, int]) -> tuple[FloatArray, FloatArray]:
    """Return the directions right, up and to the front, shape (3, 3), and the size of the visible part [cm], (2,)."""
    assert yarns.lattice is not None
    along, up = yarns.lattice.periods
    right = along / np.linalg.norm(along)
    front = np.cross(along, up) / np.linalg.norm(np.cross(along, up))
    frame = np.stack([right, np.cross(front, right), front])
    extent = np.array([tiles[0] * np.linalg.norm(along), tiles[1] * (frame[1] @ up)])
    longest = float(extent.min()) / 0.25  # No picture is slimmer than 1 to 4.
    return frame, np.minimum(extent, longest)


def _middle(yarns: YarnSet) -> FloatArray:
    """Return the vector from the centre of the cell to the centre of the bounding box of its yarns [cm], shape (3,)."""
    assert yarns.lattice is not None
    return 0.5 * (yarns.points.min(axis=0) + yarns.points.max(axis=0)) - 0.5 * yarns.lattice.shift(np.array([1, 1]))


def _visible_segments(
    yarns: YarnSet, frame: FloatArray, middle: FloatArray, extent: FloatArray, beyond: float
) -> IntArray:
    """Return the segments inside the visible part, or at most ``beyond`` [cm] outside of it."""
    place = (yarns.points[yarns.segment_points].mean(axis=1) - middle) @ frame[:2].T
    return np.flatnonzero((np.abs(place) < 0.5 * extent + beyond).all(axis=1))


def _pixels(extent: FloatArray, longer_side: int) -> tuple[int, int]:
    width, height = np.maximum(1, np.round(longer_side * extent / extent.max())).astype(int).tolist()
    return width, height
