# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Yarns of a weave: wefts along x and warps along y, over and under each other as its matrix says.

At each crossing the yarns lie at the heights of taut strings, one radius and the other apart; between crossings a yarn
goes from one height to the next without overshooting (Fritsch and Carlson 1980). The spline interpolates these curves.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from scipy.interpolate import PchipInterpolator

from stitchmesh.errors import ParameterError
from stitchmesh.lattice import Lattice
from stitchmesh.mesh import FloatArray
from stitchmesh.periodic.swatch_options import SPACING
from stitchmesh.periodic.weave.heights import taut_heights
from stitchmesh.periodic.weave.weave import Thread, Weave
from stitchmesh.quality import DEFAULT_QUALITY, Quality, quality_named
from stitchmesh.yarn import UNKNOWN_FACE, YarnSet

CROSSINGS_PER_STITCH = 3
"""A crossing takes a third of the control points of a knitted stitch, 4 for a draft: half a wave of a plain weave."""


def weave_yarns(
    weave: Weave,
    *,
    yarn_radius: float,
    spacing: float | tuple[float, float] | None = None,
    quality: str | Quality = DEFAULT_QUALITY,
) -> YarnSet:
    """One period of a woven fabric in the plane z = 0, its front towards +z.

    The wefts come first, from the top (the largest y) down, then the warps from the left; a weft goes on in its image
    (1, 0) and a warp in (0, 1).

    Args:
        weave: which yarn lies over which, and what is particular to each.
        yarn_radius: radius of a yarn of factor 1 [cm].
        spacing: distance from centre to centre [cm] of neighbouring yarns of factor 1; or of warps and of wefts.
            ``SPACING`` yarn diameters where not given.
        quality: a preset or a ``Quality``.

    Returns:
        Closed yarns on a lattice, as long at rest as they are drawn times each one's factor.

    Raises:
        ParameterError: the radius or a spacing is not a positive number, or an unknown quality.
    """
    _check_positive("yarn radius", yarn_radius)
    between = _spacings(2 * SPACING * yarn_radius if spacing is None else spacing)
    per_crossing = max(4, quality_named(quality).control_points_per_stitch // CROSSINGS_PER_STITCH)
    x, width = _places(weave.warps, between[0])
    below, height = _places(weave.wefts[::-1], between[1])
    y = below[::-1]
    weft_radius, warp_radius = (_of(threads, "radius") * yarn_radius for threads in (weave.wefts, weave.warps))
    weft_z, warp_z = taut_heights(
        weave.over, weft_radius[:, None] + warp_radius, _steps(x, width), -_steps(y, -height)
    )
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
    )
    return replace(drawn, rest_length=drawn.lengths * np.repeat(_of(threads, "length"), counts))


def _of(threads: Sequence[Thread], what: str) -> FloatArray:
    return np.array([getattr(thread, what) for thread in threads], dtype=np.float64)


def _places(threads: Sequence[Thread], spacing: float) -> tuple[FloatArray, float]:
    """Where each yarn lies, in the middle of its room, and the period [cm]."""
    room = _of(threads, "spacing") * spacing
    return np.cumsum(room) - room / 2, float(room.sum())


def _steps(place: FloatArray, period: float) -> FloatArray:
    """Distance from each place to the next one, from the last to the first of the next period."""
    return np.diff(place, append=place[0] + period)


def _control_points(
    place: FloatArray, period: float, height: FloatArray, aside: float, per_crossing: int
) -> FloatArray:
    """Control points of a spline through a yarn: place along it, place across, height [cm], shape (n, 3).

    Args:
        place: where the yarn crosses others [cm], ascending within the period.
        period: how far it is to the next image of it [cm].
        height: its height there [cm].
        aside: where it lies across [cm].
        per_crossing: control points from one crossing to the next.
    """
    around = np.concatenate([place - period, place, place + period])
    curve = PchipInterpolator(around, np.tile(height, 3))
    parts = np.arange(per_crossing) / per_crossing
    along = (place[:, None] + parts * _steps(place, period)[:, None]).ravel()
    even = np.arange(len(along)) / len(along) * period
    points = [even + _interpolating(along - even), np.full(len(along), aside), _interpolating(curve(along))]
    return np.stack(points, axis=1)


def _interpolating(values: FloatArray) -> FloatArray:
    """Control values of the closed uniform cubic B-spline that has these values where its segments meet."""
    angle = 2 * np.pi * np.arange(len(values) // 2 + 1) / len(values)
    return np.fft.irfft(np.fft.rfft(values) / ((2 + np.cos(angle)) / 3), len(values))


def _spacings(spacing: float | tuple[float, float]) -> tuple[float, float]:
    """Of warps and of wefts."""
    both = spacing if isinstance(spacing, tuple) else (spacing, spacing)
    for name, value in zip(("warp", "weft"), both, strict=True):
        _check_positive(f"{name} spacing", value)
    return both


def _check_positive(name: str, value: float) -> None:
    if not (math.isfinite(value) and value > 0.0):
        raise ParameterError(f"{name}: got {value}; expected a positive number of cm")
