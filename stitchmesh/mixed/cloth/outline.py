# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Closed outlines in the plane: checks, points inside, and distances."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from stitchmesh.errors import ParameterError
from stitchmesh.lattice import LARGEST_LENGTH
from stitchmesh.mesh import FloatArray, IntArray

TOUCHING = 1e-9
"""Distance of two sides, as a part of the extent of the outline, below which they touch."""


def checked_outline(name: str, outline: ArrayLike) -> FloatArray:
    """Return the corners of an outline [cm], shape (n, 2).

    Args:
        name: name of the panel, for messages.
        outline: corners, anticlockwise; the first one is not repeated at the end.

    Raises:
        ParameterError: the outline has holes or fewer than three corners, a corner is not finite, two corners in a row
            coincide, the outline runs clockwise, or it crosses or touches itself (as an outline without an area does).
    """
    where = f"panel {name!r}: outline"
    try:
        corners = np.array(outline, dtype=np.float64)
    except (TypeError, ValueError) as error:
        raise ParameterError(f"{where}: got several rings; expected one list of corners; cut holes open") from error
    if corners.ndim == 3:
        raise ParameterError(f"{where}: got {len(corners)} rings; expected one list of corners; cut holes open")
    if corners.ndim != 2 or corners.shape[1] != 2:
        raise ParameterError(f"{where}: got shape {corners.shape}; expected corners (x, y), shape (n, 2)")
    if len(corners) < 3:
        raise ParameterError(f"{where}: got {len(corners)} corners; expected at least 3")
    usable = (np.abs(corners) <= LARGEST_LENGTH).all(axis=1)
    if not usable.all():
        bad = int(np.flatnonzero(~usable)[0])
        raise ParameterError(f"{where}: corner {bad}: got {corners[bad].tolist()}; expected two finite numbers of cm")
    _check_simple(where, corners)
    return corners


def _check_simple(where: str, corners: FloatArray) -> None:
    following = np.roll(corners, -1, axis=0)
    size = float(np.ptp(corners, axis=0).max())
    bad = np.flatnonzero(np.linalg.norm(following - corners, axis=1) <= TOUCHING * size)
    if len(bad):
        other = (int(bad[0]) + 1) % len(corners)
        raise ParameterError(f"{where}: corners {bad[0]} and {other}: lie at the same place; remove one of them")
    crossing = first_crossing(corners, following)
    if crossing is not None:
        one, other = crossing
        ends = [f"{side}-{(side + 1) % len(corners)}" for side in (one, other)]
        raise ParameterError(f"{where}: sides {ends[0]} and {ends[1]}: cross or touch; expected a simple outline")
    if signed_area(corners) < 0.0:
        raise ParameterError(f"{where}: runs clockwise; expected its corners anticlockwise; reverse their order")


def signed_area(corners: FloatArray) -> float:
    """Return the area of an outline [cm^2], negative if it runs clockwise."""
    x, y = (corners - corners[0]).T
    return float(0.5 * (x * np.roll(y, -1) - np.roll(x, -1) * y).sum())


def first_crossing(start: FloatArray, end: FloatArray) -> tuple[int, int] | None:
    """Return the first pair of segments that cross or touch, other than at a common end; None if there is none.

    Two segments with a common end are a pair only if they overlap.

    Args:
        start: start of each segment, shape (n, 2).
        end: end of each segment, shape (n, 2).
    """
    near = TOUCHING * float(np.ptp(np.concatenate([start, end]), axis=0).max())
    low, high = np.minimum(start, end) - near, np.maximum(start, end) + near
    for part in _parts(len(start), len(start)):
        beside = ((low[part, None] <= high) & (low <= high[part, None])).all(axis=2)  # the bounding boxes overlap
        one, other = np.nonzero(np.triu(beside, part.start + 1))
        one += part.start
        meet = np.flatnonzero(_meet(start[one], end[one], start[other], end[other], near))
        if len(meet):
            return int(one[meet[0]]), int(other[meet[0]])
    return None


def _meet(a: FloatArray, b: FloatArray, c: FloatArray, d: FloatArray, near: float) -> NDArray[np.bool_]:
    """Whether segments a-b and c-d are nearer than ``near`` anywhere but at a common end; the arrays are broadcast."""
    common = [np.linalg.norm(one - other, axis=-1) <= near for one, other in ((a, c), (a, d), (b, c), (b, d))]
    shared = np.logical_or.reduce(common)
    sides = [_turn(c, d, a), _turn(c, d, b), _turn(a, b, c), _turn(a, b, d)]
    proper = (sides[0] * sides[1] < 0.0) & (sides[2] * sides[3] < 0.0)
    touch = np.zeros_like(shared)
    for point, (start, end), at_common in (
        (a, (c, d), common[0] | common[1]), (b, (c, d), common[2] | common[3]),
        (c, (a, b), common[0] | common[2]), (d, (a, b), common[1] | common[3]),
    ):  # fmt: skip
        touch |= ~at_common & (_distance(point, start, end) <= near)
    return (proper & ~shared) | touch


def _turn(a: FloatArray, b: FloatArray, c: FloatArray) -> FloatArray:
    """Twice the signed area of triangles a, b, c."""
    turn: FloatArray = (b[..., 0] - a[..., 0]) * (c[..., 1] - a[..., 1]) - (b[..., 1] - a[..., 1]) * (
        c[..., 0] - a[..., 0]
    )
    return turn


def _distance(point: FloatArray, start: FloatArray, end: FloatArray) -> FloatArray:
    """Distance of points from segments."""
    along = end - start
    part = ((point - start) * along).sum(axis=-1) / np.maximum((along**2).sum(axis=-1), 1e-300)
    nearest = start + np.clip(part, 0.0, 1.0)[..., None] * along
    distance: FloatArray = np.linalg.norm(point - nearest, axis=-1)
    return distance


def inside(points: FloatArray, start: FloatArray, end: FloatArray) -> NDArray[np.bool_]:
    """Whether points lie inside closed outlines: a ray from the point crosses their sides an odd number of times.

    Args:
        points: points, shape (n, 2).
        start: start of each side of all outlines, shape (m, 2).
        end: end of each side, shape (m, 2).
    """
    result = np.zeros(len(points), dtype=np.bool_)
    for part in _parts(len(points), len(start)):
        x, y = points[part, 0, None], points[part, 1, None]
        above = start[:, 1] > y
        crossed = above != (end[:, 1] > y)
        right = (_turn(start[None], end[None], points[part, None]) > 0.0) == (end[:, 1] > start[:, 1])
        result[part] = np.count_nonzero(crossed & right & np.isfinite(x), axis=1) % 2 == 1
    return result


def distance_to_sides(points: FloatArray, start: FloatArray, end: FloatArray) -> FloatArray:
    """Return the distance of points to the nearest side [cm], shape (n,), with the arguments of ``inside``."""
    nearest = np.full(len(points), np.inf)
    for part in _parts(len(points), len(start)):
        nearest[part] = _distance(points[part, None], start[None], end[None]).min(axis=1)
    return nearest


def _parts(points: int, sides: int) -> list[slice]:
    """Parts of points with at most two million pairs of a point and a side each, to bound the memory."""
    rows = max(1, 2_000_000 // max(sides, 1))
    return [slice(first, first + rows) for first in range(0, points, rows)]


def edge_pairs(ring: IntArray) -> IntArray:
    """Return the pairs of neighbours of a ring of vertices, shape (n,) to (n, 2)."""
    return np.stack([ring, np.roll(ring, -1)], axis=1)
