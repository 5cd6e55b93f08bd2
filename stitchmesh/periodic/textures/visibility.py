# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The uppermost piece of yarn at each pixel of a plan.

Consider a straight piece from a to a + l t. Its unit vector t has the part t_x along the plan and the part t_z at right
angles to the plan. The top of the balls is a concave function of the length l. Let x and y be the position of the pixel
along and across the piece in the plan, and w = sqrt(r^2 - y^2). The top is highest at

    l = (x + w t_z) / t_x, limited to the ends of the piece,    z = a_z + t_z l + sqrt(w^2 - (t_x l - x)^2)

The visible part of a piece of the curve lies above a rectangle in the plan: from y = -r to y = r, and in x beyond the
ends of the piece by r |t_z| at its lower end, and by r times the sine of the angle to the adjacent pieces. The pixels
of each rectangle are processed row by row. Columns and rows wrap around, so the image repeats.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, fields

import numpy as np
from numpy.typing import NDArray

from stitchmesh.mesh import FloatArray, IntArray
from stitchmesh.periodic.textures.tubes import PixelGrid, Tubes

PAIRS_AT_ONCE = 1 << 19
"""Number of pairs of piece and pixel that are processed together; this limits the memory."""
SMALLEST_DIVISOR = 1e-12
"""Lower bound of lengths and of components of unit vectors that are used as divisors."""


@dataclass(frozen=True)
class Visible:
    """The uppermost segment at each pixel, bottom row first."""

    segment: NDArray[np.int32]
    """Number of the segment, -1 where there is none, shape (height, width)."""
    parameter: NDArray[np.float32]
    """Parameter on the segment, with the error of the straight pieces, shape (height, width)."""
    image: NDArray[np.int16]
    """Lattice image of the pixel above which the stored segment lies, shape (height, width, 2)."""


@dataclass(frozen=True)
class _Pieces:
    """Straight pieces in the coordinates of the plan; all arrays have shape (n,)."""

    number: IntArray
    """Number of the piece among all pieces."""
    x: FloatArray
    y: FloatArray
    z: FloatArray
    """Coordinates of the start of the piece [cm]."""
    length: FloatArray
    """Length of the piece in space [cm]."""
    along_x: FloatArray
    along_y: FloatArray
    """Unit vector along the piece in the plan."""
    level: FloatArray
    """t_x, the component of the direction in the plan."""
    climb: FloatArray
    """t_z, the component of the direction at right angles to the plan."""
    radius: FloatArray
    """Radius of the tube [cm]."""
    behind: FloatArray
    ahead: FloatArray
    """Ends of the rectangle of the piece, measured along the piece [cm]."""

    def select(self, which: IntArray | slice) -> _Pieces:
        return _Pieces(*(getattr(self, field.name)[which] for field in fields(self)))


def visible_pieces(tubes: Tubes, plan: PixelGrid) -> Visible:
    """Find the uppermost piece at each pixel."""
    count = plan.width * plan.height
    top = np.full(count, -np.inf)
    segment, parameter = np.full(count, -1, dtype=np.int32), np.zeros(count, dtype=np.float32)
    image = np.zeros((count, 2), dtype=np.int16)
    for pieces, column, row in _pairs(_pieces(tubes), plan):
        z, fraction = _tops(pieces, *plan.places(column, row))
        pixel = row % plan.height * plan.width + column % plan.width
        np.maximum.at(top, pixel, z)
        best = np.flatnonzero((z == top[pixel]) & (z > -np.inf))
        place = pixel[best]
        number = pieces.number[best]
        segment[place] = number // tubes.pieces
        parameter[place] = (number % tubes.pieces + fraction[best]) / tubes.pieces
        image[place] = np.stack([column[best] // plan.width, row[best] // plan.height], axis=1)
    shape = (plan.height, plan.width)
    return Visible(segment.reshape(shape), parameter.reshape(shape), image.reshape(*shape, 2))


def _pieces(tubes: Tubes) -> _Pieces:
    ends = tubes.ends
    start, vector = ends[:, :-1].reshape(-1, 3), np.diff(ends, axis=1)
    length = np.linalg.norm(vector, axis=2)
    direction = vector / np.maximum(length, SMALLEST_DIVISOR)[:, :, None]
    margin = (np.sin(_bend_angles(direction)) * tubes.radius[:, None]).ravel()
    radius = np.repeat(tubes.radius, tubes.pieces)
    length, direction = length.ravel(), direction.reshape(-1, 3)
    level = np.maximum(np.hypot(direction[:, 0], direction[:, 1]), SMALLEST_DIVISOR)
    along = direction[:, :2] / level[:, None]
    along[np.hypot(along[:, 0], along[:, 1]) < 0.5] = [1.0, 0.0]  # an upright piece has no direction in the plan
    climb = direction[:, 2]
    return _Pieces(
        number=np.arange(len(start)),
        x=start[:, 0],
        y=start[:, 1],
        z=start[:, 2],
        length=length,
        along_x=along[:, 0],
        along_y=along[:, 1],
        level=level,
        climb=climb,
        radius=radius,
        behind=-radius * np.maximum(climb, 0.0) - margin,
        ahead=length * level + radius * np.maximum(-climb, 0.0) + margin,
    )


def _bend_angles(direction: FloatArray) -> FloatArray:
    """Return an upper bound of the angle between each piece and its neighbours, shape (S, pieces).

    It is the larger of the angles to the previous and to the next piece. At an end of a segment, twice the angle inside
    the segment is used for the angle to the neighbour in the next segment.
    """
    cosine = np.einsum("skd,skd->sk", direction[:, 1:], direction[:, :-1])
    angle = np.arccos(np.clip(cosine, -1.0, 1.0))
    if angle.shape[1] == 0:
        return np.full(direction.shape[:2], np.pi / 2)
    padded = np.concatenate([2 * angle[:, :1], angle, 2 * angle[:, -1:]], axis=1)
    return np.minimum(np.maximum(padded[:, 1:], padded[:, :-1]) + 1e-3, np.pi / 2)


def _pairs(pieces: _Pieces, plan: PixelGrid) -> Iterator[tuple[_Pieces, IntArray, IntArray]]:
    """Yield pieces, columns and rows of all pixels in the rectangles of the pieces: one entry for each pair."""
    low, high = _reach(pieces.along_y, pieces.along_x, pieces)
    first = np.ceil((pieces.y + low) / plan.pixel[1, 1] - 0.5).astype(np.int64)
    last = np.floor((pieces.y + high) / plan.pixel[1, 1] - 0.5).astype(np.int64)
    across = np.maximum(last - first + 1, 0)
    extent = np.concatenate([[0], np.cumsum(across * (1 + np.ceil(2 * pieces.radius / plan.pixel[0, 0])))])
    cuts = np.searchsorted(extent, np.arange(PAIRS_AT_ONCE, extent[-1] + PAIRS_AT_ONCE, PAIRS_AT_ONCE))
    begin = 0
    for cut in np.unique(np.minimum(cuts, len(across))).tolist():
        chunk = np.arange(begin, cut)
        begin = cut
        owner = np.repeat(chunk, across[chunk])
        row = first[owner] + _ranges(across[chunk])
        left, right = _columns(pieces.select(owner), row, plan)
        number = np.maximum(right - left + 1, 0)
        column = np.repeat(left, number) + _ranges(number)
        if len(column):
            yield pieces.select(np.repeat(owner, number)), column, np.repeat(row, number)


def _reach(along: FloatArray, across: FloatArray, pieces: _Pieces) -> tuple[FloatArray, FloatArray]:
    """Return the lowest and highest coordinate of the rectangles on an axis, relative to the start of the piece [cm].

    Args:
        along: components on this axis of the unit vectors along the pieces, shape (n,).
        across: components on this axis of the unit vectors across the pieces, shape (n,).
        pieces: the pieces.
    """
    ends = np.stack([pieces.behind * along, pieces.ahead * along])
    aside = pieces.radius * np.abs(across)
    return ends.min(axis=0) - aside, ends.max(axis=0) + aside


def _columns(pieces: _Pieces, row: IntArray, plan: PixelGrid) -> tuple[IntArray, IntArray]:
    """Return the first and last column of each rectangle in a row of pixels."""
    shift, y = plan.places(-0.5, row)
    up = y - pieces.y
    low, high = _reach(pieces.along_x, pieces.along_y, pieces)
    bounds = [(low, high)]
    for component, start, end in (
        (pieces.along_x, pieces.behind - pieces.along_y * up, pieces.ahead - pieces.along_y * up),
        (pieces.along_y, pieces.along_x * up - pieces.radius, pieces.along_x * up + pieces.radius),
    ):
        slanted = np.abs(component) > SMALLEST_DIVISOR
        with np.errstate(divide="ignore", invalid="ignore"):
            one, other = start / component, end / component
        bounds.append((
            np.where(slanted, np.minimum(one, other), -np.inf), np.where(slanted, np.maximum(one, other), np.inf)
        ))  # fmt: skip
    left = np.max([bound[0] for bound in bounds], axis=0) + pieces.x - shift
    right = np.min([bound[1] for bound in bounds], axis=0) + pieces.x - shift
    step = plan.pixel[0, 0]
    return np.ceil(left / step - 0.5).astype(np.int64), np.floor(right / step - 0.5).astype(np.int64)


def _ranges(counts: IntArray) -> IntArray:
    """Return the numbers 0, 1, 2 ... up to each count minus one, concatenated."""
    ends = np.cumsum(counts)
    return np.arange(ends[-1] if len(ends) else 0) - np.repeat(ends - counts, counts)


def _tops(pieces: _Pieces, x: FloatArray, y: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return the height of each piece above its pixel [cm], and the fraction of the piece before the highest ball.

    The height is -inf where the piece does not cover the pixel.
    """
    aside, ahead = x - pieces.x, y - pieces.y
    along = pieces.along_x * aside + pieces.along_y * ahead
    across = pieces.along_x * ahead - pieces.along_y * aside
    half = np.sqrt(np.maximum(pieces.radius**2 - across**2, 0.0))
    place = np.clip((along + half * pieces.climb) / pieces.level, 0.0, pieces.length)
    under = half**2 - (pieces.level * place - along) ** 2
    z = pieces.z + pieces.climb * place + np.sqrt(np.maximum(under, 0.0))
    return np.where(under > 0.0, z, -np.inf), place / np.maximum(pieces.length, SMALLEST_DIVISOR)
