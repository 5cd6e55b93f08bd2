# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The picture of a fabric that repeats: some tiles of it from the front, which fill the picture to its borders."""

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
"""Wool of all light [sRGB]; the lamps together are brighter than one."""
SLIMMEST = 0.25
"""Least width over height of a picture, or height over width."""
BEYOND = 4.0
"""How far beyond the picture's border yarn is drawn [radii]; perspective moves the near side outwards."""


def render_swatch(yarns: YarnSet, path: FilePath, tiles: tuple[int, int], *, longer_side: int = LONGER_SIDE) -> None:
    """Draw tiles of a fabric in the colours of its yarns.

    Args:
        yarns: a set on a lattice; the front is the side that the product of its periods points to.
        path: a ``.png`` file; missing folders are made.
        tiles: periods along the courses and along the wales that are to be seen.
        longer_side: of the picture [pixels].

    Raises:
        DisplayError: this machine cannot draw.
        FileError: the suffix is not ``.png``, or the file cannot be written.
        ParameterError: a number of tiles is not a whole number from 1.
        YarnError: the yarns do not repeat.
    """
    around = tile_yarns(yarns, tiles[0] + 2, tiles[1] + 2)
    assert yarns.lattice is not None  # or they could not be tiled
    corner = yarns.lattice.shift(np.array([1, 1]))
    frame, extent = _frame(yarns, tiles)
    middle = corner + 0.5 * yarns.lattice.shift(np.array(tiles)) + _middle(yarns)
    radius = float(yarns.radius.max())
    seen = _seen(around, frame, middle, extent, BEYOND * radius)
    sides, samples = detail_for(len(seen))
    curves = polylines_of_segments(around, seen, samples)
    tubes = tubes_around(curves.points, curves.closed, around.radius[curves.yarn], sides=sides)
    wool = np.round(DIMMED * WOOLS[around.colour % len(WOOLS)]).astype(np.uint8)
    with picture(path, _pixels(extent, longer_side)) as plotter:
        add_tubes(plotter, tubes, wool[around.point_yarn[curves.control_point]][tubes.ring])
        look(plotter, camera_at(middle, frame[2], frame[1], float(extent[1])))
        shade_hollows(plotter, 4 * radius)


def _frame(yarns: YarnSet, tiles: tuple[int, int]) -> tuple[FloatArray, FloatArray]:
    """Directions to the right, upright and to the front, shape (3, 3), and what is seen [cm], shape (2,)."""
    assert yarns.lattice is not None
    along, up = yarns.lattice.periods
    right = along / np.linalg.norm(along)
    front = np.cross(along, up) / np.linalg.norm(np.cross(along, up))
    frame = np.stack([right, np.cross(front, right), front])
    extent = np.array([tiles[0] * np.linalg.norm(along), tiles[1] * (frame[1] @ up)])
    longest = float(extent.min()) / SLIMMEST
    return frame, np.minimum(extent, longest)


def _middle(yarns: YarnSet) -> FloatArray:
    """From where the periods count to the yarns of the cell, in depth and in the plane [cm]."""
    assert yarns.lattice is not None
    return 0.5 * (yarns.points.min(axis=0) + yarns.points.max(axis=0)) - 0.5 * yarns.lattice.shift(np.array([1, 1]))


def _seen(
    yarns: YarnSet, frame: FloatArray, middle: FloatArray, extent: FloatArray, beyond: float
) -> IntArray:
    """Segments inside the picture's border."""
    place = (yarns.points[yarns.segment_points].mean(axis=1) - middle) @ frame[:2].T
    return np.flatnonzero((np.abs(place) < 0.5 * extent + beyond).all(axis=1))


def _pixels(extent: FloatArray, longer_side: int) -> tuple[int, int]:
    width, height = np.maximum(1, np.round(longer_side * extent / extent.max())).astype(int).tolist()
    return width, height
