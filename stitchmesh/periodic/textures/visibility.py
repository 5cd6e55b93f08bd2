# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Which piece of yarn is on top at each pixel of a plan.

Over a straight piece from a to a + l t with its unit vector split into (t_x, t_z), along and across the plan, the top
of the balls is concave in the length l. With x and y the place along and across the piece, and w = sqrt(r^2 - y^2), it
is highest at

    l = (x + w t_z) / t_x, brought between the ends,    z = a_z + t_z l + sqrt(w^2 - (t_x l - x)^2)

What a piece of the curve shows lies above its rectangle in the plan: between y = -r and r, and in x beyond its ends by
r |t_z| against the way it climbs and by r times the sine of the angle to its neighbours. Rectangles are walked row by
row; columns and rows wrap around, which makes the picture repeat.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, fields

import numpy as np
from numpy.typing import NDArray

from stitchmesh.mesh import FloatArray, IntArray
from stitchmesh.periodic.textures.plan import Plan
from stitchmesh.periodic.textures.tubes import Tubes

AT_ONCE = 1 << 19
"""Pairs of piece and pixel that are looked at together."""
LEVEL = 1e-12
"""Smallest share of a direction that is divided by."""


@dataclass(frozen=True)
class Visible:
    """What is on top at each pixel, bottom row first."""

    segment: NDArray[np.int32]
    """Segment, -1 where there is none, shape (height, width)."""
    parameter: NDArray[np.float32]
    """Parameter on the segment, to what its pieces are short of the curve, shape (height, width)."""
    image: NDArray[np.int16]
    """Image of the pixel that the segment as it is stored lies above, shape (height, width, 2)."""


@dataclass(frozen=True)
class _Pieces:
    """Straight pieces in the plan, an array entry each."""

    number: IntArray
    """Number among all pieces."""
    x: FloatArray
    y: FloatArray
    z: FloatArray
    """Where it begins [cm]."""
    length: FloatArray
    """In space [cm]."""
    along_x: FloatArray
    along_y: FloatArray
    """Unit vector along it in the plan."""
    level: FloatArray
    """t_x, how much of a length is along the plan."""
    climb: FloatArray
    """t_z, how much of it is up."""
    radius: FloatArray
    """Of the tube [cm]."""
    behind: FloatArray
    ahead: FloatArray
    """Ends of its rectangle along it [cm]."""

    def taken(self, which: IntArray | slice) -> _Pieces:
        return _Pieces(*(getattr(self, field.name)[which] for field in fields(self)))


def visible_pieces(tubes: Tubes, plan: Plan) -> Visible:
    """The piece that is highest at each pixel."""
    count = plan.width * plan.height
    top = np.full(count, -np.inf)
    segment, parameter = np.full(count, -1, dtype=np.int32), np.zeros(count, dtype=np.float32)
    image = np.zeros((count, 2), dtype=np.int16)
    for pieces, column, row in _pairs(_pieces(tubes), plan):
        z, share = _tops(pieces, *plan.places(column, row))
        pixel = row % plan.height * plan.width + column % plan.width
        np.maximum.at(top, pixel, z)
        best = np.flatnonzero((z == top[pixel]) & (z > -np.inf))
        place = pixel[best]
        number = pieces.number[best]
        segment[place] = number // tubes.pieces
        parameter[place] = (number % tubes.pieces + share[best]) / tubes.pieces
        image[place] = np.stack([column[best] // plan.width, row[best] // plan.height], axis=1)
    shape = (plan.height, plan.width)
    return Visible(segment.reshape(shape), parameter.reshape(shape), image.reshape(*shape, 2))


def _pieces(tubes: Tubes) -> _Pieces:
    ends = tubes.ends
    start, way = ends[:, :-1].reshape(-1, 3), np.diff(ends, axis=1)
    length = np.linalg.norm(way, axis=2)
    direction = way / np.maximum(length, LEVEL)[:, :, None]
    margin = (np.sin(_turns(direction)) * tubes.radius[:, None]).ravel()
    radius = np.repeat(tubes.radius, tubes.pieces)
    length, direction = length.ravel(), direction.reshape(-1, 3)
    level = np.maximum(np.hypot(direction[:, 0], direction[:, 1]), LEVEL)
    along = direction[:, :2] / level[:, None]
    along[np.hypot(along[:, 0], along[:, 1]) < 0.5] = [1.0, 0.0]  # an upright piece points nowhere in the plan
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


def _turns(direction: FloatArray) -> FloatArray:
    """The larger angle to the pieces before and after, shape (S, pieces); at ends of segments twice the inner one."""
    cosine = np.einsum("skd,skd->sk", direction[:, 1:], direction[:, :-1])
    angle = np.arccos(np.clip(cosine, -1.0, 1.0))
    if angle.shape[1] == 0:
        return np.full(direction.shape[:2], np.pi / 2)
    padded = np.concatenate([2 * angle[:, :1], angle, 2 * angle[:, -1:]], axis=1)
    return np.minimum(np.maximum(padded[:, 1:], padded[:, :-1]) + 1e-3, np.pi / 2)


def _pairs(pieces: _Pieces, plan: Plan) -> Iterator[tuple[_Pieces, IntArray, IntArray]]:
    """Pieces, columns and rows of all pixels in the pieces' rectangles, an entry for each pair, a good many at once."""
    low, high = _reach(pieces.along_y, pieces.along_x, pieces)
    first = np.ceil((pieces.y + low) / plan.pixel[1, 1] - 0.5).astype(np.int64)
    last = np.floor((pieces.y + high) / plan.pixel[1, 1] - 0.5).astype(np.int64)
    across = np.maximum(last - first + 1, 0)
    extent = np.concatenate([[0], np.cumsum(across * (1 + np.ceil(2 * pieces.radius / plan.pixel[0, 0])))])
    cuts = np.searchsorted(extent, np.arange(AT_ONCE, extent[-1] + AT_ONCE, AT_ONCE))
    begin = 0
    for cut in np.unique(np.minimum(cuts, len(across))).tolist():
        chunk = np.arange(begin, cut)
        begin = cut
        owner = np.repeat(chunk, across[chunk])
        row = first[owner] + _counted(across[chunk])
        left, right = _columns(pieces.taken(owner), row, plan)
        number = np.maximum(right - left + 1, 0)
        column = np.repeat(left, number) + _counted(number)
        if len(column):
            yield pieces.taken(np.repeat(owner, number)), column, np.repeat(row, number)


def _reach(along: FloatArray, across: FloatArray, pieces: _Pieces) -> tuple[FloatArray, FloatArray]:
    """How far rectangles reach in an axis, given the shares of their two directions in it [cm]."""
    ends = np.stack([pieces.behind * along, pieces.ahead * along])
    aside = pieces.radius * np.abs(across)
    return ends.min(axis=0) - aside, ends.max(axis=0) + aside


def _columns(pieces: _Pieces, row: IntArray, plan: Plan) -> tuple[IntArray, IntArray]:
    """First and last column of each rectangle in a row of pixels."""
    shift, y = plan.places(-0.5, row)
    up = y - pieces.y
    low, high = _reach(pieces.along_x, pieces.along_y, pieces)
    bounds = [(low, high)]
    for share, start, end in (
        (pieces.along_x, pieces.behind - pieces.along_y * up, pieces.ahead - pieces.along_y * up),
        (pieces.along_y, pieces.along_x * up - pieces.radius, pieces.along_x * up + pieces.radius),
    ):
        slanted = np.abs(share) > LEVEL
        with np.errstate(divide="ignore", invalid="ignore"):
            one, other = start / share, end / share
        bounds.append((
            np.where(slanted, np.minimum(one, other), -np.inf), np.where(slanted, np.maximum(one, other), np.inf)
        ))  # fmt: skip
    left = np.max([bound[0] for bound in bounds], axis=0) + pieces.x - shift
    right = np.min([bound[1] for bound in bounds], axis=0) + pieces.x - shift
    step = plan.pixel[0, 0]
    return np.ceil(left / step - 0.5).astype(np.int64), np.floor(right / step - 0.5).astype(np.int64)


def _counted(counts: IntArray) -> IntArray:
    """0, 1, 2 ... up to each count, one after another."""
    ends = np.cumsum(counts)
    return np.arange(ends[-1] if len(ends) else 0) - np.repeat(ends - counts, counts)


def _tops(pieces: _Pieces, x: FloatArray, y: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Height of each piece above its place [cm], -inf beside it, and how much of the piece lies before that."""
    aside, ahead = x - pieces.x, y - pieces.y
    along = pieces.along_x * aside + pieces.along_y * ahead
    across = pieces.along_x * ahead - pieces.along_y * aside
    half = np.sqrt(np.maximum(pieces.radius**2 - across**2, 0.0))
    place = np.clip((along + half * pieces.climb) / pieces.level, 0.0, pieces.length)
    under = half**2 - (pieces.level * place - along) ** 2
    z = pieces.z + pieces.climb * place + np.sqrt(np.maximum(under, 0.0))
    return np.where(under > 0.0, z, -np.inf), place / np.maximum(pieces.length, LEVEL)
