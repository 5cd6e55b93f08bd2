# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Differences of two relaxations of one scene: distances of corresponding positions, spacings of loops, and energy.

A position is a point of a yarn that is the same material point in every discretisation. Successive control points with
the same stitch face and part form a run. The border between two runs is between their control points and divides the
distance in the ratio of their spacings. A run of rest length L that starts at the arc length s has the positions
s + (j + 1/2) L / m, j = 0 .. m - 1. The first and the last run of an open yarn have no positions, because a spline ends
one spacing of control points before the end of its tail.

Spacings are mean distances between the centres of adjacent loops, along a row and between rows. The centre of a loop is
the mean of its positions. The errors of spacings and of energy are relative to the reference.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_matrix

import stitchmesh as sm
from stitchmesh.errors import YarnError
from stitchmesh.mesh import FloatArray, IntArray
from stitchmesh.yarn import YarnSet, basis
from stitchmesh.yarnrelax.model.material import YarnMaterial

Freedom = Literal["rigid", "shift", "none"]
"""Rigid motions of a scene without a force: rotation and translation, translation on its lattice, or none."""


@dataclass(frozen=True, eq=False)
class Places:
    """Corresponding positions on the yarns of a scene."""

    points: FloatArray
    """Coordinates [cm], shape (P, 3)."""
    face: IntArray
    """Stitch face of each position, shape (P,)."""
    yarn: IntArray
    """Yarn of each position, shape (P,)."""


@dataclass(frozen=True, eq=False)
class Gauge:
    """Loops and the pairs of adjacent loops."""

    centre: csr_matrix
    """Matrix from positions to the centres of loops, shape (loops, P)."""
    wale: IntArray
    """Adjacent loops along a row, shape (W, 2)."""
    wale_shift: FloatArray
    """Lattice shift of the second of each pair [cm], shape (W, 3)."""
    course: IntArray
    """Adjacent loops of two rows, shape (C, 2)."""
    course_shift: FloatArray
    """Lattice shift of the second of each pair [cm], shape (C, 3)."""


@dataclass(frozen=True)
class Difference:
    """Difference of a relaxation from the reference."""

    rms: float
    """Root mean square distance of corresponding positions, in yarn radii."""
    largest: float
    """Largest distance of corresponding positions, in yarn radii."""
    wale_error: float
    """Relative error of the wale spacing."""
    course_error: float
    """Relative error of the course spacing."""


def places_of(yarns: YarnSet, per_run: int) -> Places:
    """Return the positions on yarns, ``per_run`` in each run."""
    found = [_places_of_yarn(yarns, yarn, per_run) for yarn in range(yarns.yarn_count)]
    points, faces = (np.concatenate(arrays) for arrays in zip(*found, strict=True))
    return Places(points, faces, np.repeat(np.arange(len(found)), [len(faces) for _, faces in found]))


def _places_of_yarn(yarns: YarnSet, yarn: int, per_run: int) -> tuple[FloatArray, IntArray]:
    """Return the positions on one yarn and their stitch faces."""
    first, last = yarns.start[yarn], yarns.start[yarn + 1]
    segments = np.arange(yarns.segment_start[yarn], yarns.segment_start[yarn + 1])
    closed = bool(yarns.closed[yarn])
    # interval k runs from knot k to knot k + 1; a knot belongs to the control point it lies next to
    segments = np.roll(segments, 1) if closed else segments
    owner = np.arange(first, last) if closed else np.arange(first + 1, last - 1)
    interval = yarns.rest_length[segments]
    knot = np.concatenate([[0.0], np.cumsum(interval)])
    border, run_owner = _runs(yarns, owner, interval, knot, closed)
    share = (np.arange(per_run) + 0.5) / per_run
    arc = (border[:-1, None] + share * np.diff(border)[:, None]).ravel()
    turn = np.floor(arc / knot[-1]) if closed else np.zeros(len(arc))
    arc = arc - turn * knot[-1]
    number = np.clip(np.searchsorted(knot, arc, side="right") - 1, 0, len(interval) - 1)
    corners = yarns.points[yarns.segment_points[segments[number]]]
    if yarns.lattice is not None and yarns.lattice_step is not None and yarns.point_shift is not None:
        images = (turn - (number == 0))[:, None] * yarns.lattice_step[yarn]
        corners = corners + yarns.point_shift[segments[number]] + yarns.lattice.shift(images)[:, None, :]
    points = np.einsum("pj,pjd->pd", basis((arc - knot[number]) / interval[number]), corners)
    return points, np.repeat(yarns.face[run_owner], per_run)


def _runs(
    yarns: YarnSet, owner: IntArray, interval: FloatArray, knot: FloatArray, closed: bool
) -> tuple[FloatArray, IntArray]:
    """Borders of the runs of a yarn [cm of rest length], and the first control point of each."""
    face, part = yarns.face[owner], yarns.part[owner]
    change = (face[1:] != face[:-1]) | (part[1:] != part[:-1])
    start = np.concatenate([[0], np.flatnonzero(change) + 1])
    end = np.concatenate([start[1:], [len(owner)]]) - 1
    long = end > start
    spacing = (knot[end] - knot[start]) / np.maximum(end - start, 1)
    both = spacing + np.roll(spacing, -1)
    share = np.where(long & np.roll(long, -1), spacing / np.where(both > 0.0, both, 1.0), 0.5)
    border = knot[end] + share * interval[np.minimum(end, len(interval) - 1)]
    if closed:
        return np.concatenate([[border[-1] - knot[-1]], border]), owner[start]
    return border[:-1], owner[start[1:-1]]


def aligned(points: FloatArray, onto: FloatArray, freedom: Freedom) -> FloatArray:
    """Return the points after the rigid motion that minimises the distances (Kabsch 1976)."""
    if freedom == "none":
        return points
    middle, target = points.mean(axis=0), onto.mean(axis=0)
    if freedom == "shift":
        return points - middle + target
    left, _, right = np.linalg.svd((points - middle).T @ (onto - target))
    flip = np.diag([1.0, 1.0, np.sign(np.linalg.det(left @ right))])
    return (points - middle) @ (left @ flip @ right) + target


def gauge_of_faces(
    places: Places, wale: IntArray, course: IntArray, *, wale_shift: FloatArray | None = None,
    course_shift: FloatArray | None = None,
) -> Gauge:  # fmt: skip
    """Return the loops of yarns with stitch faces; each face is a loop."""
    count = np.bincount(places.face)
    rows = (1.0 / count[places.face], (places.face, np.arange(len(places.face))))
    full = (count > 0).astype(bool)
    size = len(full)
    keep_wale, keep_course = _both_there(wale, full), _both_there(course, full)
    return Gauge(
        csr_matrix(rows, shape=(size, len(places.face))),
        wale[keep_wale],
        np.zeros((int(keep_wale.sum()), 3)) if wale_shift is None else wale_shift[keep_wale],
        course[keep_course],
        np.zeros((int(keep_course.sum()), 3)) if course_shift is None else course_shift[keep_course],
    )


def _both_there(pairs: IntArray, there: NDArray[np.bool_]) -> NDArray[np.bool_]:
    known = (pairs < len(there)).all(axis=1)
    return known & there[np.minimum(pairs, len(there) - 1)].all(axis=1)


def spacings(gauge: Gauge, points: FloatArray) -> tuple[float, float]:
    """Return wale and course spacing [cm], up to a factor that is equal for all states of a scene."""
    centre = gauge.centre @ points

    def mean(pairs: IntArray, shift: FloatArray) -> float:
        return float(np.linalg.norm(centre[pairs[:, 1]] + shift - centre[pairs[:, 0]], axis=1).mean())

    return mean(gauge.wale, gauge.wale_shift), mean(gauge.course, gauge.course_shift)


def difference(places: Places, reference: Places, gauge: Gauge, freedom: Freedom, radius: float) -> Difference:
    """Return the differences of positions from those of the reference.

    Raises:
        YarnError: the two are not places of one scene.
    """
    if not np.array_equal(places.face, reference.face):
        raise YarnError(
            f"places: got {len(places.face)} of other stitches than the reference's {len(reference.face)}; "
            "expected two discretisations of one scene"
        )
    moved = aligned(places.points, reference.points, freedom)
    distance = np.linalg.norm(moved - reference.points, axis=1) / radius
    here, there = spacings(gauge, places.points), spacings(gauge, reference.points)
    errors = [abs(one / other - 1.0) for one, other in zip(here, there, strict=True)]
    return Difference(float(np.sqrt(np.mean(distance**2))), float(distance.max()), *errors)


def energy_of(yarns: YarnSet, material: YarnMaterial, device: str | None) -> float:
    """Return the energy of yarns with the sampling of the reference [erg]."""
    return sum(sm.yarn_energies(yarns, material, quadrature_points=11, contact_samples=11, device=device).values())
