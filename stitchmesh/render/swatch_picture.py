# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Picture of a periodic fabric: a number of tiles from the front, which fill the whole picture."""

from __future__ import annotations

import numpy as np

from stitchmesh.io.contents import FilePath
from stitchmesh.mesh import FloatArray, IntArray
from stitchmesh.mesh.tube_mesh import tubes_around
from stitchmesh.render.camera import camera_at
from stitchmesh.render.picture import detail_for
from stitchmesh.render.stage import add_tubes, look, picture, shade_hollows
from stitchmesh.yarn import YarnSet
from stitchmesh.yarn.colours import WOOLS
from stitchmesh.yarn.polyline import polylines_of_segments
from stitchmesh.yarn.tiling import tile_yarns

LONGER_SIDE = 1400
"""Pixels along the longer side of a picture."""
DIMMED = 210.0
"""Brightness of white yarn [sRGB]; it is below 255, because the total intensity of the lights is above one."""
SLIMMEST = 0.25
"""Smallest ratio of the shorter to the longer side of a picture."""
BEYOND = 4.0
"""Width of the strip around the visible part in which yarn is drawn as well [yarn radii].

Perspective shifts the near side of the yarn outwards."""


def render_swatch(yarns: YarnSet, path: FilePath, tiles: tuple[int, int], *, longer_side: int = LONGER_SIDE) -> None:
    """Draw tiles of a fabric in the colours of its yarns.

    Args:
        yarns: a set of yarns on a lattice; the front is the side to which the cross product of the periods points.
        path: a ``.png`` file; missing folders are created.
        tiles: number of visible periods along the courses and along the wales.
        longer_side: longer side of the picture [pixels].

    Raises:
        DisplayError: this machine cannot draw pictures.
        FileError: the suffix is not ``.png``, or the file cannot be written.
        ParameterError: a number of tiles is not a positive integer.
        YarnError: the yarns have no lattice.
    """
    around = tile_yarns(yarns, tiles[0] + 2, tiles[1] + 2)
    assert yarns.lattice is not None  # tile_yarns has checked this.
    corner = yarns.lattice.shift(np.array([1, 1]))
    frame, extent = _frame(yarns, tiles)
    middle = corner + 0.5 * yarns.lattice.shift(np.array(tiles)) + _middle(yarns)
    radius = float(yarns.radius.max())
    visible = _visible_segments(around, frame, middle, extent, BEYOND * radius)
    sides, samples = detail_for(len(visible))
    curves = polylines_of_segments(around, visible, samples)
    tubes = tubes_around(curves.points, curves.closed, around.radius[curves.yarn], sides=sides)
    wool = np.round(DIMMED * WOOLS[around.colour % len(WOOLS)]).astype(np.uint8)
    with picture(path, _pixels(extent, longer_side)) as plotter:
        add_tubes(plotter, tubes, wool[around.point_yarn[curves.control_point]][tubes.ring])
        look(plotter, camera_at(middle, frame[2], frame[1], float(extent[1])))
        shade_hollows(plotter, 4 * radius)


def _frame(yarns: YarnSet, tiles: tuple[int, int]) -> tuple[FloatArray, FloatArray]:
    """Directions to the right, upwards and to the front, shape (3, 3), and size of the visible part [cm], (2,)."""
    assert yarns.lattice is not None
    along, up = yarns.lattice.periods
    right = along / np.linalg.norm(along)
    front = np.cross(along, up) / np.linalg.norm(np.cross(along, up))
    frame = np.stack([right, np.cross(front, right), front])
    extent = np.array([tiles[0] * np.linalg.norm(along), tiles[1] * (frame[1] @ up)])
    longest = float(extent.min()) / SLIMMEST
    return frame, np.minimum(extent, longest)


def _middle(yarns: YarnSet) -> FloatArray:
    """Vector from the centre of the cell to the centre of the bounding box of its yarns [cm], shape (3,)."""
    assert yarns.lattice is not None
    return 0.5 * (yarns.points.min(axis=0) + yarns.points.max(axis=0)) - 0.5 * yarns.lattice.shift(np.array([1, 1]))


def _visible_segments(
    yarns: YarnSet, frame: FloatArray, middle: FloatArray, extent: FloatArray, beyond: float
) -> IntArray:
    """Segments inside the visible part or at most ``beyond`` [cm] outside of it."""
    place = (yarns.points[yarns.segment_points].mean(axis=1) - middle) @ frame[:2].T
    return np.flatnonzero((np.abs(place) < 0.5 * extent + beyond).all(axis=1))


def _pixels(extent: FloatArray, longer_side: int) -> tuple[int, int]:
    width, height = np.maximum(1, np.round(longer_side * extent / extent.max())).astype(int).tolist()
    return width, height
