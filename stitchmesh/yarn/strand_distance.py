# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Distance of each segment of yarn from the nearest other strand.

A strand is another yarn, or a part of the same yarn that is farther away along the yarn than ``MIN_DETOUR`` times its
distance in space. Strands are searched among points on the curves, and the distance is then measured to the chords
between these points.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from stitchmesh.mesh import FloatArray, IntArray
from stitchmesh.yarn.radius_estimate import MIN_DETOUR
from stitchmesh.yarn.yarn_set import YarnSet, basis

SAMPLES = 2
"""Points on each segment that are searched; chords between them deviate from a knitted loop by 3 % of the radius."""
NEIGHBOURS = 48
"""Number of nearest points that are searched around each segment."""


@dataclass(frozen=True, eq=False)
class _Chords:
    """Chords along yarns, including the chords in the near images of a periodic cell."""

    start: FloatArray
    """Start of each chord [cm], shape (n, 3)."""
    end: FloatArray
    """End of each chord [cm], shape (n, 3)."""
    yarn: IntArray
    """Yarn of each chord, shape (n,)."""
    along: FloatArray
    """Length of the yarn from its start to the start of the chord [cm], shape (n,)."""
    image: IntArray
    """Lattice image of each chord, zeros without a lattice, shape (n, 2)."""


def strand_distance(yarns: YarnSet, *, within: float | None = None) -> FloatArray:
    """Return the gap between the surface of each segment and the surface of the nearest other strand [cm], shape (S,).

    The gap is measured from the middle of the segment. It is negative where the yarns are pressed together, because the
    radius belongs to yarn without pressure.

    Args:
        yarns: the yarns; on a lattice, the strands of the repeats around the cell count too.
        within: largest gap that is searched [cm]; gaps beyond it have this value. By default four times the largest
            radius.
    """
    from scipy.spatial import cKDTree

    reach = 4.0 * float(yarns.radius.max()) if within is None else within
    chords = _chords(yarns, reach)
    places, along = _on_curves(yarns, 0.5)
    search = reach + 2.0 * float(yarns.radius.max()) + float(np.linalg.norm(chords.end - chords.start, axis=1).max())
    tree = cKDTree(chords.start)
    gap = np.full(len(places), reach)
    nearest = min(NEIGHBOURS, len(chords.start))
    across, found = tree.query(places, k=nearest, distance_upper_bound=search, workers=-1)
    across, found = across.reshape(len(places), -1), found.reshape(len(places), -1)
    for rank in range(nearest):  # One rank at a time keeps the arrays as small as the yarns.
        near = np.flatnonzero(np.isfinite(across[:, rank]))
        chord = found[near, rank]
        other = _is_other_strand(yarns, chords, near, along[near], chord, across[near, rank])
        near, chord = near[other], chord[other]
        radii = yarns.radius[yarns.segment_yarn[near]] + yarns.radius[chords.yarn[chord]]
        gap[near] = np.minimum(gap[near], _from_chords(places[near], chords, chord) - radii)
    return gap


def _on_curves(yarns: YarnSet, parameter: float) -> tuple[FloatArray, FloatArray]:
    """Return the point of each segment at a parameter [cm], (S, 3), and the length of its yarn up to it [cm], (S,)."""
    before = np.cumsum(yarns.lengths) - yarns.lengths
    before -= before[yarns.segment_start[:-1]][yarns.segment_yarn]
    return np.einsum("j,sjd->sd", basis(parameter)[0], yarns.corners_of()), before + parameter * yarns.lengths


def _chords(yarns: YarnSet, reach: float) -> _Chords:
    """Return the chords of all segments, in the cell and in the images near it."""
    knots = [_on_curves(yarns, step / SAMPLES) for step in range(SAMPLES + 1)]
    start = np.concatenate([place for place, _ in knots[:-1]])
    end = np.concatenate([place for place, _ in knots[1:]])
    along = np.concatenate([length for _, length in knots[:-1]])
    yarn = np.tile(yarns.segment_yarn, SAMPLES)
    if yarns.lattice is None:
        return _Chords(start, end, yarn, along, np.zeros((len(yarn), 2), dtype=np.int64))
    images = yarns.lattice.near_images(start, reach + 4.0 * float(yarns.radius.max()))
    shift = yarns.lattice.shift(images)[:, None]
    image = np.repeat(images, len(yarn), axis=0)
    moved = [(places + shift).reshape(-1, 3) for places in (start, end)]
    return _Chords(moved[0], moved[1], np.tile(yarn, len(images)), np.tile(along, len(images)), image)


def _is_other_strand(
    yarns: YarnSet, chords: _Chords, segment: IntArray, along: FloatArray, chord: IntArray, across: FloatArray
) -> IntArray:
    """Return whether chords belong to another strand than the segments near them, shape (n,).

    Args:
        yarns: the yarns.
        chords: all chords.
        segment: segments, shape (n,).
        along: length of the yarn up to each segment [cm], shape (n,).
        chord: a chord near each segment, shape (n,).
        across: distance between the two [cm], shape (n,).
    """
    yarn = yarns.segment_yarn[segment]
    whole = np.add.reduceat(yarns.lengths, yarns.segment_start[:-1])[yarn]
    step = np.zeros((len(yarn), 2)) if yarns.lattice_step is None else yarns.lattice_step[yarn]
    detour = np.full(len(yarn), np.inf)
    for turns in (-1, 0, 1):  # The chord may lie one turn further along a closed yarn, in the image of that turn.
        reached = (turns * step == chords.image[chord]).all(axis=1) & (yarns.closed[yarn] | (turns == 0))
        length = np.abs(chords.along[chord] + turns * whole - along)
        detour = np.where(reached, np.minimum(detour, length), detour)
    return (chords.yarn[chord] != yarn) | (detour > MIN_DETOUR * across)


def _from_chords(places: FloatArray, chords: _Chords, chord: IntArray) -> FloatArray:
    """Return the distance from each place to a chord [cm], shape (n,)."""
    start = chords.start[chord]
    step = chords.end[chord] - start
    square = np.maximum(np.einsum("ij,ij->i", step, step), np.finfo(np.float64).tiny)
    share = np.clip(np.einsum("ij,ij->i", places - start, step) / square, 0.0, 1.0)
    return np.linalg.norm(start + share[:, None] * step - places, axis=1)
