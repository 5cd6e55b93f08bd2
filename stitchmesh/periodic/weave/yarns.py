# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Yarns of a weave: wefts along x and warps along y, which pass over and under one another as the matrix says.

At each crossing the yarns have the heights of taut strings whose distance is the sum of the two radii. Between
crossings a yarn changes from one height to the next monotonically (Fritsch and Carlson 1980). The spline interpolates
these curves.

The heights minimise the energy of the strings, half the sum of (change of height)^2 / distance over neighbouring
crossings. The condition is that at each crossing the two yarns have the distance that their radii need. Layers separate
as a result, and floats are straight. Each height occurs in one condition only, so the projection onto the conditions
has a closed form, and an accelerated projected gradient method converges (FISTA, Beck and Teboulle 2009, restarted as
by O'Donoghue and Candes 2015 when the momentum points against the descent).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import PchipInterpolator

from stitchmesh.errors import check_kind, check_positive
from stitchmesh.lattice import Lattice
from stitchmesh.mesh import FloatArray
from stitchmesh.periodic.swatch_options import SPACING
from stitchmesh.periodic.weave.weave import Thread, Weave
from stitchmesh.quality import DEFAULT_QUALITY, Quality, quality_named
from stitchmesh.yarn import UNKNOWN_FACE, YarnSet


def weave_yarns(
    weave: Weave,
    *,
    yarn_radius: float,
    spacing: float | tuple[float, float] | None = None,
    quality: str | Quality = DEFAULT_QUALITY,
) -> YarnSet:
    """Generate the yarns of one period of a woven fabric in the plane z = 0, with its front towards +z.

    The wefts come first, from the top (the largest y) downwards, then the warps from the left. A weft continues in its
    image (1, 0), and a warp in its image (0, 1).

    Args:
        weave: the weave.
        yarn_radius: radius of a yarn of factor 1 [cm].
        spacing: distance between the centres of adjacent yarns of factor 1 [cm], or the distances between warps and
            between wefts; by default ``SPACING`` yarn diameters.
        quality: a preset or a ``Quality``.

    Returns:
        Closed yarns on a lattice; the rest length of a yarn is its generated length times its length factor.

    Raises:
        ParameterError: the radius or a spacing is not a positive number, or the quality is unknown.
    """
    check_kind("weave_yarns", weave, Weave)
    check_positive("yarn radius", yarn_radius, "cm")
    between = _spacings(2 * SPACING * yarn_radius if spacing is None else spacing)
    # A crossing has a third of the control points of a knitted stitch, and at least 4: it is half a wave of a plain
    # weave.
    per_crossing = max(4, quality_named(quality).control_points_per_stitch // 3)
    x, width = _places(weave.warps, between[0])
    below, height = _places(weave.wefts[::-1], between[1])
    y = below[::-1]
    weft_radius, warp_radius = (_factors(threads, "radius") * yarn_radius for threads in (weave.wefts, weave.warps))
    weft_z, warp_z = taut_heights(weave.over, weft_radius[:, None] + warp_radius, _steps(x, width), -_steps(y, -height))
    wefts = [_control_points(x, width, z, aside, per_crossing) for z, aside in zip(weft_z, y, strict=True)]
    warps = [_control_points(below, height, z[::-1], aside, per_crossing) for z, aside in zip(warp_z.T, x, strict=True)]
    curves = [*wefts, *(points[:, [1, 0, 2]] for points in warps)]
    lattice = Lattice(np.array([[width, 0.0, 0.0], [0.0, height, 0.0]]))
    return _yarn_set(weave, curves, lattice, np.concatenate([weft_radius, warp_radius]))


def _yarn_set(weave: Weave, curves: Sequence[FloatArray], lattice: Lattice, radius: FloatArray) -> YarnSet:
    counts = [len(curve) for curve in curves]
    points = np.concatenate(curves)
    threads = [*weave.wefts, *weave.warps]
    drawn = YarnSet(
        points=points,
        start=np.concatenate([[0], np.cumsum(counts)]),
        closed=np.ones(len(curves), dtype=np.bool_),
        radius=radius,
        rest_length=np.ones(len(points)),
        row=np.repeat(np.arange(len(curves)), counts),
        face=np.full(len(points), UNKNOWN_FACE),
        part=np.zeros(len(points), dtype=np.int64),
        colour=np.array([thread.colour for thread in threads]),
        lattice=lattice,
        lattice_step=np.repeat([[1, 0], [0, 1]], [len(weave.wefts), len(weave.warps)], axis=0),
        palette=np.array(weave.palette, dtype=np.uint8),
    )
    return replace(drawn, rest_length=drawn.lengths * np.repeat(_factors(threads, "length"), counts))


def _factors(threads: Sequence[Thread], attribute: str) -> FloatArray:
    return np.array([getattr(thread, attribute) for thread in threads], dtype=np.float64)


def _places(threads: Sequence[Thread], spacing: float) -> tuple[FloatArray, float]:
    """Return the position of each yarn, in the middle of its strip, and the period [cm]."""
    width = _factors(threads, "spacing") * spacing
    return np.cumsum(width) - width / 2, float(width.sum())


def _steps(place: FloatArray, period: float) -> FloatArray:
    """Return the distance from each position to the next; the last leads to the first of the next period."""
    return np.diff(place, append=place[0] + period)


def _control_points(
    place: FloatArray, period: float, height: FloatArray, aside: float, per_crossing: int
) -> FloatArray:
    """Return the control points of a spline through a yarn: position along it, position across it, height [cm].

    Args:
        place: positions of the crossings along the yarn [cm], ascending within the period.
        period: length of the period along the yarn [cm].
        height: height of the yarn at each crossing [cm].
        aside: position of the yarn across its direction [cm].
        per_crossing: number of control points from one crossing to the next.

    Returns:
        Control points, shape (n, 3).
    """
    around = np.concatenate([place - period, place, place + period])
    curve = PchipInterpolator(around, np.tile(height, 3))
    parts = np.arange(per_crossing) / per_crossing
    along = (place[:, None] + parts * _steps(place, period)[:, None]).ravel()
    even = np.arange(len(along)) / len(along) * period
    points = [even + _interpolating(along - even), np.full(len(along), aside), _interpolating(curve(along))]
    return np.stack(points, axis=1)


def _interpolating(values: FloatArray) -> FloatArray:
    """Return the control values of the closed uniform cubic B-spline with the given values at its knots."""
    angle = 2 * np.pi * np.arange(len(values) // 2 + 1) / len(values)
    return np.fft.irfft(np.fft.rfft(values) / ((2 + np.cos(angle)) / 3), len(values))


def _spacings(spacing: float | tuple[float, float]) -> tuple[float, float]:
    """Check the spacings, and return the spacing of the warps and the spacing of the wefts [cm]."""
    both = spacing if isinstance(spacing, tuple) else (spacing, spacing)
    for name, value in zip(("warp", "weft"), both, strict=True):
        check_positive(f"{name} spacing", value, "cm")
    return both


def taut_heights(
    over: NDArray[np.bool_], apart: FloatArray, along_wefts: FloatArray, along_warps: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Return the heights [cm] of wefts and of warps at their crossings, shape (wefts, warps) each; their mean is 0.

    Args:
        over: whether each weft passes over each warp, shape (wefts, warps).
        apart: smallest height difference of the weft and the warp at each crossing [cm], shape (wefts, warps).
        along_wefts: distance from each warp to the next warp [cm], shape (warps,); the last entry is the distance to
            the first warp of the next period.
        along_warps: distance from each weft to the next weft [cm], shape (wefts,), with the same last entry.
    """
    shortest = min(along_wefts.min(), along_warps.min())
    tension = (shortest / along_wefts[None, :], shortest / along_warps[:, None])
    sign = np.where(over, 1.0, -1.0)
    heights = ahead = _separate(np.zeros((2, *over.shape)), sign, apart)
    momentum = 1.0
    for _ in range(2000):
        moved = _separate(ahead - _pulls(ahead, tension) / 4, sign, apart)  # 4 bounds the curvature of the energy
        change = moved - heights
        # Largest change of a height in the last iteration, relative to the largest distance between crossing yarns
        if np.abs(change).max() <= 1e-4 * apart.max() and momentum > 1.0:
            break
        if ((ahead - moved) * change).sum() > 0.0:
            momentum = 1.0
        following = (1 + np.sqrt(1 + 4 * momentum**2)) / 2
        ahead = moved + (momentum - 1) / following * change
        heights, momentum = moved, following
    heights = heights - (heights.max() + heights.min()) / 2
    return heights[0], heights[1]


def _pulls(heights: FloatArray, tension: tuple[FloatArray, FloatArray]) -> FloatArray:
    """Return the derivative of the energy by each height, shape (2, wefts, warps)."""
    slopes = []
    for height, tight, axis in zip(heights, tension, (1, 0), strict=True):
        pull = tight * (np.roll(height, -1, axis) - height)
        slopes.append(np.roll(pull, 1, axis) - pull)
    return np.stack(slopes)


def _separate(heights: FloatArray, sign: FloatArray, apart: FloatArray) -> FloatArray:
    """Return the nearest heights that satisfy the condition at every crossing, shape (2, wefts, warps)."""
    missing = sign * np.maximum(apart - sign * (heights[0] - heights[1]), 0.0) / 2
    return np.stack([heights[0] + missing, heights[1] - missing])
