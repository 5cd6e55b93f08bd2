# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The sizes of stitches, and the sizes and mass of their yarn, from the name of a yarn, a gauge and single values."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from stitchmesh.errors import ParameterError, check_positive
from stitchmesh.mesh import BORDER, StitchMesh
from stitchmesh.yarn.yarn_presets import GAUGE_LENGTH, WIDTH_OVER_CORE, Gauge, Yarn, parse_gauge
from stitchmesh.yarn.yarn_set import YarnSet


@dataclass(frozen=True, kw_only=True)
class StitchMeasures:
    """Sizes of a stitch and of its yarn [cm], and the mass of the yarn; None where nothing determines a value."""

    stitch_width: float | None = None
    """Wale spacing."""
    stitch_height: float | None = None
    """Course spacing."""
    yarn_radius: float | None = None
    """Radius of the core of the yarn."""
    drawn_radius: float | None = None
    """Radius of the yarn in pictures."""
    loop_length: float | None = None
    """Yarn length of a plain stitch."""
    mass_per_length: float | None = None
    """Mass of a length of the yarn [g/cm]."""


def stitch_size(
    yarn: str | Yarn | None = None, gauge: str | Gauge | None = None, *, stitch_width: float | None = None,
    stitch_height: float | None = None, yarn_radius: float | None = None, drawn_radius: float | None = None,
    loop_length: float | None = None, mass_per_length: float | None = None,
) -> StitchMeasures:  # fmt: skip
    """Return the sizes of a stitch and of its yarn, and the mass of the yarn.

    A given length is returned unchanged. The other sizes follow from the yarn and the gauge; without a given gauge,
    they follow from the usual gauge of the yarn. A stitch width without a gauge replaces the gauge of the yarn, in the
    proportions of stockinette.

    Args:
        yarn: a yarn, or its name (``Yarn.named``).
        gauge: stitches and rows in 10 cm, or a text such as ``22`` or ``22x30``.
        stitch_width: wale spacing [cm].
        stitch_height: course spacing [cm].
        yarn_radius: radius of the core of the yarn [cm].
        drawn_radius: radius of the yarn in pictures [cm].
        loop_length: yarn length of a plain stitch [cm].
        mass_per_length: mass of a length of yarn [g/cm].

    Raises:
        ParameterError: the yarn is unknown, the gauge is malformed, or a gauge and a stitch size are both given.
    """
    known = Yarn.named(yarn) if isinstance(yarn, str) else yarn
    knitted = _gauge(known, parse_gauge(gauge) if isinstance(gauge, str) else gauge, stitch_width, stitch_height)
    if knitted is None:
        return StitchMeasures(
            stitch_width=stitch_width, stitch_height=stitch_height, yarn_radius=yarn_radius,
            drawn_radius=drawn_radius, loop_length=loop_length, mass_per_length=mass_per_length,
        )  # fmt: skip
    if yarn_radius is None:
        yarn_radius = knitted.stitch_width / WIDTH_OVER_CORE if known is None else known.core_radius
    if drawn_radius is None and known is not None:
        drawn_radius = max(known.apparent_radius, yarn_radius)
    if mass_per_length is None and known is not None:
        mass_per_length = known.mass_per_length
    return StitchMeasures(
        stitch_width=knitted.stitch_width,
        stitch_height=knitted.stitch_height if stitch_height is None else stitch_height,
        yarn_radius=yarn_radius,
        drawn_radius=drawn_radius,
        loop_length=knitted.loop_length if loop_length is None else loop_length,
        mass_per_length=mass_per_length,
    )


def _gauge(
    yarn: Yarn | None, gauge: Gauge | None, stitch_width: float | None, stitch_height: float | None
) -> Gauge | None:
    """Return the given gauge, else the gauge of the stitch width, else the gauge of the yarn, else None."""
    if gauge is not None:
        for name, length in {"stitch width": stitch_width, "stitch height": stitch_height}.items():
            if length is not None:
                raise ParameterError(f"{name}: got {length:g} cm and a gauge of {gauge}; give one of the two")
        return gauge
    if yarn is None or stitch_width is None:
        return None if yarn is None else yarn.gauge
    check_positive("stitch width", stitch_width, "cm")
    return Gauge(GAUGE_LENGTH / stitch_width)


def fabric_gauge(fabric: StitchMesh) -> Gauge:
    """Return the gauge of the median stitch of a fabric.

    The wale spacing is the median length of the course sides, the course spacing the median length of the wale sides.
    """
    width, height = (float(np.median(fabric.side_length[sides])) for sides in (~fabric.is_wale, fabric.is_wale))
    return Gauge.of_stitch(width, height)


def yarn_gauge(yarns: YarnSet, fabric: StitchMesh) -> Gauge | None:
    """Return the gauge that yarns have reached, from the median distances between neighbouring stitches.

    The place of a stitch is the middle of its control points. Neighbours in a row share a wale side, neighbours in a
    wale a course side.

    Args:
        yarns: the yarns, for example after their relaxation.
        fabric: the stitches from which the yarns were made.

    Returns:
        The gauge; None if no two neighbours of a row or of a wale have yarn, as in a fabric of one row.
    """
    made = yarns.face >= 0
    count = np.bincount(yarns.face[made], minlength=fabric.face_count)
    sums = [np.bincount(yarns.face[made], yarns.points[made, axis], fabric.face_count) for axis in range(3)]
    middle = np.stack(sums, axis=1) / np.maximum(count, 1)[:, None]
    side = np.flatnonzero(fabric.twin != BORDER)
    first, second = fabric.side_face[side], fabric.side_face[fabric.twin[side]]
    known = (count[first] > 0) & (count[second] > 0)
    distance = np.linalg.norm(middle[first] - middle[second], axis=1)
    in_row, in_wale = (distance[known & (fabric.is_wale[side] == wale)] for wale in (True, False))
    if not len(in_row) or not len(in_wale):
        return None
    return Gauge.of_stitch(float(np.median(in_row)), float(np.median(in_wale)))
