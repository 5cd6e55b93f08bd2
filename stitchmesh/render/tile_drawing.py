# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The drawing of a periodic fabric as data: tubes around the yarns of one repeat, and the positions of its copies.

A viewer draws the tubes once for each copy. Because the copies are not part of the data, a moving fabric of many
repeats costs as much as one repeat. The tubes of neighbouring copies join without a seam (``repeating_tubes``). A part
of a drawing holds all tubes of one colour, because viewers give a repeated object one colour only.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from stitchmesh.errors import ParameterError, YarnError, check_kind
from stitchmesh.lattice import Lattice
from stitchmesh.mesh import FloatArray, IntArray
from stitchmesh.mesh.palette import colours_of
from stitchmesh.mesh.tube_mesh import TubeMesh, repeating_tubes
from stitchmesh.yarn import YarnSet

DETAILS = ((8, 4), (8, 3), (6, 3), (6, 2), (5, 2), (4, 2), (4, 1), (3, 1))
"""Sides of a tube and samples per segment, from the finest to the coarsest."""
MOST_TRIANGLES = 600_000
"""Largest number of triangles of all copies together, if a detail with so few exists."""
MOST_VERTICES = 120_000
"""Largest number of vertices of one repeat, if a detail with so few exists; every frame sends them."""
MOST_COPIES = 10_000
"""Largest number of copies of a repeat."""
MOST_PARTS = 24
"""Largest number of parts; a larger number of colours, for example from a continuous scale, is rounded to fewer."""


@dataclass(frozen=True, eq=False)
class TilePart:
    """The tubes of one colour of a repeat."""

    colour: tuple[int, int, int]
    """Colour (sRGB)."""
    vertices: NDArray[np.float32]
    """Positions of the vertices [cm], shape (V, 3)."""
    triangles: NDArray[np.uint32]
    """Vertices of each triangle, counter-clockwise when seen from outside, shape (T, 3)."""
    taken: IntArray
    """Number of each vertex among the vertices of all tubes of the repeat, shape (V,)."""


@dataclass(frozen=True, eq=False)
class TileDrawing:
    """Tubes of one repeat and the positions of its copies."""

    parts: tuple[TilePart, ...]
    """The tubes, by colour."""
    offsets: NDArray[np.float32]
    """Position of each copy [cm], shape (n, 3); the middle of all copies together lies at the origin."""
    low: FloatArray
    """Smallest coordinates of all copies [cm], shape (3,)."""
    high: FloatArray
    """Largest coordinates of all copies [cm], shape (3,)."""
    detail: tuple[int, int]
    """Sides of a tube and samples per segment."""
    control_point: IntArray
    """Control point of each vertex of all tubes of the repeat."""
    segments: IntArray
    """Control points of each segment of the yarns, shape (S, 4); drawings with equal segments have equal triangles."""


def draw_tiles(
    yarns: YarnSet,
    tiles: tuple[int, int],
    *,
    colours: NDArray[np.uint8] | None = None,
    before: TileDrawing | None = None,
) -> TileDrawing:
    """Return the drawing of copies of a repeat, centred at the origin.

    Args:
        yarns: a set of yarns on a lattice.
        tiles: numbers of copies along the courses and along the wales.
        colours: colour of each control point (sRGB), shape (N, 3); the colours of the yarns by default. More than
            ``MOST_PARTS`` colours are rounded.
        before: the drawing of an earlier frame. If the same yarns have only moved, the new drawing takes the triangle
            arrays of the earlier one, so that only positions need to be sent.

    Raises:
        ParameterError: a number of tiles is not positive, or there are more than ``MOST_COPIES``.
        YarnError: the yarns have no lattice, or a yarn ends inside of the repeat.
    """
    lattice = _checked_lattice(yarns, tiles)
    detail = detail_of_tiles(len(yarns.rest_length), tiles[0] * tiles[1])
    tubes = _tubes(yarns, detail)
    own = _few(colours_of(yarns.colour, yarns.palette)[yarns.point_yarn] if colours is None else colours)
    if before is not None and before.detail == detail and np.array_equal(before.segments, yarns.segment_points):
        control_point, parts = before.control_point, _moved(before, tubes, own)
    else:
        control_point = _control_points(yarns, detail[1])[tubes.ring]
        parts = _parts_of(tubes, own[control_point])
    offsets, low, high = _copies(lattice, tiles, tubes.vertices)
    return TileDrawing(parts, offsets, low, high, detail, control_point, yarns.segment_points)


def detail_of_tiles(segments: int, copies: int) -> tuple[int, int]:
    """Return the sides of a tube and the samples per segment, as fine as the bounds of this module allow.

    Args:
        segments: number of segments of one repeat.
        copies: number of copies.
    """
    for sides, samples in DETAILS:
        vertices = sides * samples * segments
        if vertices <= MOST_VERTICES and 2 * vertices * copies <= MOST_TRIANGLES:
            return sides, samples
    return DETAILS[-1]


def _checked_lattice(yarns: YarnSet, tiles: tuple[int, int]) -> Lattice:
    """Return the lattice of the yarns.

    Raises:
        ParameterError, YarnError: an error of ``draw_tiles``.
    """
    check_kind("draw_tiles", yarns, YarnSet)
    if min(tiles) < 1 or tiles[0] * tiles[1] > MOST_COPIES:
        raise ParameterError(f"tiles: got {tiles[0]} x {tiles[1]}; expected 1 to {MOST_COPIES} copies in all")
    if yarns.lattice is None:
        raise YarnError("draw_tiles: the yarns have no lattice; expected one repeat of a periodic fabric")
    if not yarns.closed.all():
        number = int(np.flatnonzero(~yarns.closed)[0])
        raise YarnError(f"draw_tiles: yarn {number} ends inside of the repeat; expected yarns that all continue")
    return yarns.lattice


def _few(colours: NDArray[np.uint8]) -> NDArray[np.uint8]:
    """Return colours with at most ``MOST_PARTS`` different values: the middles of equal intervals of each channel."""
    step, few = 8, colours
    while len(np.unique(_codes(few))) > MOST_PARTS:
        few = (colours // step * step + step // 2).astype(np.uint8)
        step *= 2
    return few


def _tubes(yarns: YarnSet, detail: tuple[int, int]) -> TubeMesh:
    """Return the tubes of one repeat, of the apparent radius."""
    assert yarns.lattice is not None and yarns.lattice_step is not None
    sides, samples = detail
    shift = yarns.lattice.shift(yarns.lattice_step)
    return repeating_tubes(yarns.sampled(samples), shift, yarns.drawn_radius, sides=sides)


def _control_points(yarns: YarnSet, samples: int) -> IntArray:
    """Return the nearest control point of each sample of the yarns, shape (samples S,)."""
    place = np.where(np.arange(samples) / samples < 0.5, 1, 2)
    return yarns.segment_points[:, place].ravel()


def _parts_of(tubes: TubeMesh, colours: NDArray[np.uint8]) -> tuple[TilePart, ...]:
    """Divide tubes by the colours of their vertices; a triangle has the colour of its first vertex."""
    code, number = np.unique(_codes(colours), return_inverse=True)
    of_triangle = number[tubes.triangles[:, 0]]
    return tuple(
        _part_of(tubes, of_triangle == index if len(code) > 1 else None, (one >> 16, one >> 8 & 255, one & 255))
        for index, one in enumerate(code.tolist())
        if len(code) == 1 or (of_triangle == index).any()
    )


def _part_of(tubes: TubeMesh, chosen: NDArray[np.bool_] | None, colour: tuple[int, int, int]) -> TilePart:
    """Return the part of some triangles, or of all if none are chosen."""
    if chosen is None:
        taken, corners = np.arange(len(tubes.vertices)), tubes.triangles
    else:
        taken, found = np.unique(tubes.triangles[chosen], return_inverse=True)
        corners = found.reshape(-1, 3)
    return TilePart(colour, tubes.vertices[taken].astype(np.float32), corners.astype(np.uint32), taken)


def _codes(colours: NDArray[np.uint8]) -> IntArray:
    """Return one number for each colour, shape (n, 3) to (n,)."""
    return colours.astype(np.int64) @ np.array([1 << 16, 1 << 8, 1])


def _moved(before: TileDrawing, tubes: TubeMesh, colours: NDArray[np.uint8]) -> tuple[TilePart, ...]:
    """Return the parts of an earlier drawing at their new positions; new parts for another division by colour."""
    own = colours[before.control_point]
    moved = []
    for part in before.parts:
        first = own[part.taken[part.triangles[:, 0]]]
        if (first != first[0]).any():
            return _parts_of(tubes, own)
        red, green, blue = first[0].tolist()
        vertices = tubes.vertices[part.taken].astype(np.float32)
        moved.append(replace(part, colour=(red, green, blue), vertices=vertices))
    if len({part.colour for part in moved}) < len(moved):
        return _parts_of(tubes, own)
    return tuple(moved)


def _copies(
    lattice: Lattice, tiles: tuple[int, int], vertices: FloatArray
) -> tuple[NDArray[np.float32], FloatArray, FloatArray]:
    """Return the positions of the copies, and the bounds of all of them [cm]."""
    column, row = np.meshgrid(np.arange(tiles[0]), np.arange(tiles[1]))
    corners = lattice.shift(np.stack([column.ravel(), row.ravel()], axis=1))
    own = np.stack([vertices.min(axis=0), vertices.max(axis=0)])
    low, high = corners.min(axis=0) + own[0], corners.max(axis=0) + own[1]
    middle = 0.5 * (low + high)
    return (corners - middle).astype(np.float32), low - middle, high - middle
