# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Picking: the place of a yarn at which a ray points, and lengths along a yarn."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from stitchmesh.mesh import FloatArray
from stitchmesh.yarn.yarn_set import YarnSet, basis


@dataclass(frozen=True, eq=False)
class YarnPickingTable:
    """Yarns with the chords of their segments, made once by ``yarn_picking_table`` for many rays."""

    yarns: YarnSet
    """The yarns."""
    start: FloatArray
    """Start of each segment [cm], shape (S, 3)."""
    end: FloatArray
    """End of each segment [cm], shape (S, 3)."""


@dataclass(frozen=True, eq=False)
class PickedYarn:
    """The place at which a ray meets a yarn first."""

    yarn: int
    """The yarn."""
    segment: int
    """The segment."""
    point: FloatArray
    """The point on the surface of the yarn [cm], shape (3,)."""
    depth: float
    """Distance of the point from the origin of the ray [cm]."""
    along: float
    """Length of the yarn from its start to the place [cm]."""


def yarn_picking_table(yarns: YarnSet) -> YarnPickingTable:
    """Prepare yarns for picking; the segments of periodic yarns are picked at their stored positions."""
    corners = yarns.corners_of()
    start, end = (np.einsum("j,sjd->sd", basis(parameter)[0], corners) for parameter in (0.0, 1.0))
    return YarnPickingTable(yarns, start, end)


def pick_yarn(table: YarnPickingTable, origin: ArrayLike, direction: ArrayLike) -> PickedYarn | None:
    """Return the place at which a ray meets a yarn of apparent radius first; None if it meets none.

    A segment counts as a cylinder around its chord.

    Args:
        table: the prepared yarns.
        origin: start of the ray [cm], shape (3,).
        direction: direction of the ray, of any length, shape (3,).
    """
    begin = np.asarray(origin, dtype=np.float64)
    ray = np.asarray(direction, dtype=np.float64) / np.linalg.norm(direction)
    from_start, chord = table.start - begin, table.end - table.start
    depth, step = from_start @ ray, chord @ ray
    # Only the distance across the ray counts.
    across, leaning = from_start - depth[:, None] * ray, chord - step[:, None] * ray
    square = np.maximum(np.einsum("ij,ij->i", leaning, leaning), np.finfo(np.float64).tiny)
    share = np.clip(-np.einsum("ij,ij->i", across, leaning) / square, 0.0, 1.0)
    apart = across + share[:, None] * leaning
    radius = table.yarns.drawn_radius[table.yarns.segment_yarn]
    inside = radius**2 - np.einsum("ij,ij->i", apart, apart)
    surface = depth + share * step - np.sqrt(np.maximum(inside, 0.0))
    met = np.flatnonzero((inside >= 0.0) & (surface > 0.0))
    if not len(met):
        return None
    segment = int(met[surface[met].argmin()])
    yarn = int(table.yarns.segment_yarn[segment])
    lengths = table.yarns.lengths
    along = float(lengths[table.yarns.segment_start[yarn] : segment].sum() + share[segment] * lengths[segment])
    return PickedYarn(yarn, segment, begin + surface[segment] * ray, float(surface[segment]), along)


def length_between(yarns: YarnSet, first: PickedYarn, second: PickedYarn) -> float | None:
    """Return the length of yarn between two places [cm], the shorter way if it is closed; None for two yarns."""
    if first.yarn != second.yarn:
        return None
    length = abs(second.along - first.along)
    if not yarns.closed[first.yarn]:
        return length
    begin, end = yarns.segment_start[first.yarn], yarns.segment_start[first.yarn + 1]
    return min(length, float(yarns.lengths[begin:end].sum()) - length)
