# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Differences of two relaxations of one fabric: distances of corresponding positions, spacings of loops, and energy.

A position is a point of a yarn that is the same material point in every discretisation. Successive control points with
the same stitch face and part form a run. The border between two runs is between their control points and divides the
distance in the ratio of their spacings. A run of rest length L that starts at the arc length s has the positions
s + (j + 1/2) L / m, j = 0 .. m - 1. The first and the last run of an open yarn have no positions, because a spline ends
one spacing of control points before the end of its tail.

The two relaxations may have other control points, and cells of other sizes. A position in a cell of another size is
compared at the same fractions of the periods, and with the nearest of the images of its counterpart: the distance then
says how the loops differ, and the spacings say how the sizes do.

Spacings are mean distances between the centres of adjacent loops, along a row and between rows. The centre of a loop is
the mean of its positions. The errors of spacings and of energy are relative to the reference.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_matrix

from stitchmesh.errors import YarnError
from stitchmesh.lattice import Lattice
from stitchmesh.mesh import FloatArray, IntArray, StitchMesh
from stitchmesh.yarn import YarnSet, basis
from stitchmesh.yarnrelax.evaluate import yarn_energies
from stitchmesh.yarnrelax.model.material import YarnMaterial

Freedom = Literal["rigid", "shift", "none"]
"""Rigid motions of a fabric without a force: rotation and translation, translation on its lattice, or none."""
SHIFT_STEPS = np.array(sorted(range(-16, 17), key=abs)) / 16.0
"""Shifts of a yarn along itself that are tried, the smallest first, in spacings of control points."""
SAMPLES = 11
"""Gauss points and contact samples of a segment for energies that are compared."""


@dataclass(frozen=True, eq=False)
class Places:
    """Corresponding positions on the yarns of a fabric."""

    points: FloatArray
    """Coordinates [cm], shape (P, 3)."""
    face: IntArray
    """Stitch face of each position, shape (P,)."""
    yarn: IntArray
    """Yarn of each position, shape (P,)."""
    lattice: Lattice | None
    """Lattice of the yarns."""


@dataclass(frozen=True, eq=False)
class AdjacentLoops:
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


def places_of(yarns: YarnSet, per_run: int) -> Places:
    """Return the positions on yarns, ``per_run`` in each run."""
    found = [_places_of_yarn(yarns, yarn, per_run) for yarn in range(yarns.yarn_count)]
    points, faces = (np.concatenate(arrays) for arrays in zip(*found, strict=True))
    yarn = np.repeat(np.arange(len(found)), [len(faces) for _, faces in found])
    return Places(points, faces, yarn, yarns.lattice)


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
    return _points_at(yarns, yarn, arc), np.repeat(yarns.face[run_owner], per_run)


def _points_at(yarns: YarnSet, yarn: int, arc: FloatArray) -> FloatArray:
    """Return the points of a yarn at arc lengths from its first knot [cm of rest length]."""
    segments = np.arange(yarns.segment_start[yarn], yarns.segment_start[yarn + 1])
    closed = bool(yarns.closed[yarn])
    segments = np.roll(segments, 1) if closed else segments
    interval = yarns.rest_length[segments]
    knot = np.concatenate([[0.0], np.cumsum(interval)])
    turn = np.floor(arc / knot[-1]) if closed else np.zeros(len(arc))
    arc = arc - turn * knot[-1]
    number = np.clip(np.searchsorted(knot, arc, side="right") - 1, 0, len(interval) - 1)
    corners = yarns.points[yarns.segment_points[segments[number]]]
    if yarns.lattice is not None and yarns.lattice_step is not None and yarns.point_shift is not None:
        images = (turn - (number == 0))[:, None] * yarns.lattice_step[yarn]
        corners = corners + yarns.point_shift[segments[number]] + yarns.lattice.shift(images)[:, None, :]
    return np.einsum("pj,pjd->pd", basis((arc - knot[number]) / interval[number]), corners)


def cell_distances(yarns: YarnSet, reference: YarnSet, per_point: int) -> tuple[float, float]:
    """Return the root mean square and the largest distance of a cell of closed yarns from another, in yarn radii.

    The control points of a cell are spaced evenly, so that runs have no exact borders. Positions correspond if they
    are at the same fraction of the rest length of their yarn, from a place that is found for each yarn, within one
    spacing of control points: a yarn that slides along itself keeps its shape.

    Args:
        yarns: the yarns of a cell.
        reference: the same yarns with other control points, in a cell of any size.
        per_point: number of positions for each control point of the reference.

    Raises:
        YarnError: the two have other numbers of yarns, or a yarn is open.
    """
    closed = yarns.closed.all() and reference.closed.all()
    if yarns.yarn_count != reference.yarn_count or not closed or yarns.lattice is None or reference.lattice is None:
        found = f"{yarns.yarn_count} yarns and {reference.yarn_count} of the reference"
        raise YarnError(f"cells: got {found}; expected as many, all closed, on lattices")
    counts = per_point * np.diff(reference.start)
    there = _places_along(reference, counts, np.zeros(len(counts)))
    shift, spacing = np.zeros(len(counts)), 1.0 / np.minimum(np.diff(yarns.start), np.diff(reference.start))
    for part in (1.0, 1.0 / 16.0):  # the second time around the best of the first
        tried = shift + part * spacing * SHIFT_STEPS[:, None]
        apart = np.stack([_apart(_places_along(yarns, counts, each), there, "shift") for each in tried])
        best = [_nearest(apart[:, there.yarn == yarn]) for yarn in range(len(counts))]
        shift = tried[best, np.arange(len(counts))]
    return distances(_places_along(yarns, counts, shift), there, "shift", float(reference.radius.mean()))


def _nearest(apart: FloatArray) -> int:
    """Return the number of the shift with the smallest spread of the vectors, shape (shifts, P, 3)."""
    return int(np.argmin(((apart - apart.mean(axis=1, keepdims=True)) ** 2).sum(axis=(1, 2))))


def _places_along(yarns: YarnSet, counts: IntArray, shift: FloatArray) -> Places:
    """Return positions at equal distances of rest length, ``counts`` on each yarn, from a fraction of its length."""
    points = []
    for yarn, count in enumerate(counts):
        length = yarns.rest_length[yarns.segment_start[yarn] : yarns.segment_start[yarn + 1]].sum()
        points.append(_points_at(yarns, yarn, ((np.arange(count) + 0.5) / count + shift[yarn]) * length))
    yarn_of = np.repeat(np.arange(len(counts)), counts)
    return Places(np.concatenate(points), yarn_of, yarn_of, yarns.lattice)


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


def loops_of_fabric(fabric: StitchMesh, places: Places) -> AdjacentLoops:
    """Return the loops of the yarns of a stitch mesh; its edges join adjacent loops."""
    side = np.flatnonzero(fabric.twin > np.arange(len(fabric.twin)))
    pairs = np.stack([fabric.side_face[side], fabric.side_face[fabric.twin[side]]], axis=1)
    along = fabric.is_wale[side]
    return loops_of_faces(places, pairs[along], pairs[~along])


def loops_of_faces(
    places: Places, wale: IntArray, course: IntArray, *, wale_shift: FloatArray | None = None,
    course_shift: FloatArray | None = None,
) -> AdjacentLoops:  # fmt: skip
    """Return the loops of yarns with stitch faces; each face is a loop."""
    count = np.bincount(places.face)
    rows = (1.0 / count[places.face], (places.face, np.arange(len(places.face))))
    full = (count > 0).astype(bool)
    size = len(full)
    keep_wale, keep_course = _both_there(wale, full), _both_there(course, full)
    return AdjacentLoops(
        csr_matrix(rows, shape=(size, len(places.face))),
        wale[keep_wale],
        np.zeros((int(keep_wale.sum()), 3)) if wale_shift is None else wale_shift[keep_wale],
        course[keep_course],
        np.zeros((int(keep_course.sum()), 3)) if course_shift is None else course_shift[keep_course],
    )


def _both_there(pairs: IntArray, there: NDArray[np.bool_]) -> NDArray[np.bool_]:
    known = (pairs < len(there)).all(axis=1)
    return np.asarray(known & there[np.minimum(pairs, len(there) - 1)].all(axis=1), dtype=np.bool_)


def spacings(loops: AdjacentLoops, points: FloatArray) -> tuple[float, float]:
    """Return wale and course spacing [cm], up to a factor that is equal for all states of a scene."""
    centre = loops.centre @ points

    def mean(pairs: IntArray, shift: FloatArray) -> float:
        return float(np.linalg.norm(centre[pairs[:, 1]] + shift - centre[pairs[:, 0]], axis=1).mean())

    return mean(loops.wale, loops.wale_shift), mean(loops.course, loops.course_shift)


def distances(places: Places, reference: Places, freedom: Freedom, radius: float) -> tuple[float, float]:
    """Return the root mean square and the largest distance of positions from those of the reference, in yarn radii.

    Raises:
        YarnError: the two are not places of one fabric.
    """
    if not np.array_equal(places.face, reference.face):
        raise YarnError(
            f"places: got {len(places.face)} of other stitches than the reference's {len(reference.face)}; "
            "expected two discretisations of one fabric"
        )
    apart = _apart(places, reference, freedom)
    distance = np.linalg.norm(apart, axis=1) / radius
    return float(np.sqrt(np.mean(distance**2))), float(distance.max())


def _apart(places: Places, reference: Places, freedom: Freedom) -> FloatArray:
    """Return the vectors from the positions of the reference [cm], shape (P, 3)."""
    here, there = places.lattice, reference.lattice
    if freedom != "shift" or here is None or there is None:
        return aligned(places.points, reference.points, freedom) - reference.points
    points = places.points + here.fractions(places.points) @ (there.periods - here.periods)
    apart = points - reference.points
    apart = apart - there.shift(np.round(there.fractions(apart - apart[0])))
    return apart - apart.mean(axis=0)


def energy_of(yarns: YarnSet, material: YarnMaterial, device: str | None) -> float:
    """Return the energy of yarns with the same fine sampling for all states [erg]."""
    energies = yarn_energies(
        yarns, material, quadrature_points=SAMPLES, contact_samples=SAMPLES, device=device
    )  # fmt: skip
    return sum(energies.values())
