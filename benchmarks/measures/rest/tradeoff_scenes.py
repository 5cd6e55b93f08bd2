# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The scenes of the trade-off: plain knit and rib as tubes and as periodic cells, a published glove, a published skirt.

A plain loop is (t + 1.5 sin 2t, 4 cos t, cos 2t) with t from -pi to pi and a course spacing of 4.5 (Crane 2023). A purl
loop is its mirror image in z. Between a knit and a purl loop the feet pass through the fabric: there z is multiplied by
sin(pi d / 2 w), where d, at most w, is the distance of t from the border of the loop.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import partial
from itertools import pairwise

import numpy as np
from scipy.sparse import csr_matrix
from scipy.spatial import cKDTree

import stitchmesh as sm
from benchmarks.scenes.garments import Garment
from benchmarks.scenes.stockinette import FORMULA_RADIUS, ROW_HEIGHT, STITCH_WIDTH
from stitchmesh.errors import ParameterError
from stitchmesh.lattice import Lattice
from stitchmesh.mesh import FloatArray, IntArray, StitchMesh
from stitchmesh.quality import quality_named
from stitchmesh.yarn import YarnSet, segment_lengths, segment_points
from stitchmesh.yarnrelax.state_difference import AdjacentLoops, Freedom, Places, loops_of_fabric, loops_of_faces

RADIUS = 0.125
"""Yarn radius of the scenes that the formula generates [cm]."""
PASSING = 0.5
"""Range w of the parameter in which a foot passes through the fabric."""
PLAIN, RIB = (1,), (1, 1, -1, -1)
"""Loops of a repeat: 1 is knit, -1 is purl."""
FAR = 2.0
"""Distance of the periodic images of a tube, divided by its circumference, so that images do not touch."""
LONGEST_LOOP = 40
"""Number of control points of the longest loop that is searched in a yarn file."""


@dataclass(frozen=True, eq=False)
class Scene:
    """A scene that is relaxed, and the data with which its states are compared."""

    name: str
    make: Callable[[int], YarnSet]
    """Function that generates yarns with a given number of control points for each stitch."""
    gauge: Callable[[Places], AdjacentLoops]
    """Adjacent loops, determined from the positions at the start."""
    freedom: Freedom
    per_run: int
    """Number of positions in each run of control points."""
    fabric: StitchMesh | None = None
    """Fabric whose shape the relaxation keeps."""
    given: tuple[str, ...] = ()
    """Errors that are zero because the lattice prescribes the spacing."""
    generated: bool = True
    """Whether the number of control points of a stitch can be chosen."""


def tube(name: str, pattern: Sequence[int], rows: int, stitches: int) -> Scene:
    """Closed rows around the y axis, an endless tube that finds its own wale spacing; its course spacing is given.

    A tube with ends would come undone: its rows are not linked, and nothing but friction would hold the last.
    """
    _check_whole_repeats(pattern, stitches)
    scale = RADIUS / FORMULA_RADIUS
    height = scale * rows * ROW_HEIGHT
    lattice = Lattice([[scale * FAR * stitches * STITCH_WIDTH, 0.0, 0.0], [0.0, height, 0.0]])

    def make(points_per_stitch: int) -> YarnSet:
        """Return rings of the loops of the formula, one above another."""
        flat = formula_row(pattern, stitches, points_per_stitch)
        around = stitches * STITCH_WIDTH / (2 * np.pi)
        angle, out = flat[:, 0] / around, around + flat[:, 2]
        ring = _control_points(np.stack([out * np.sin(angle), flat[:, 1], out * np.cos(angle)], axis=1))
        curves = [scale * (ring + np.array([0.0, ROW_HEIGHT * row, 0.0])) for row in range(rows)]
        yarns = YarnSet.from_curves(curves, closed=[True] * rows, radius=RADIUS)
        face = np.arange(len(yarns.points)) // points_per_stitch
        return replace(yarns, face=face, lattice=lattice, lattice_step=np.zeros((rows, 2)))

    def gauge(places: Places) -> AdjacentLoops:
        loop = np.arange(rows * stitches).reshape(rows, stitches)
        wale = np.stack([loop, np.roll(loop, -len(pattern), axis=1)], axis=-1).reshape(-1, 2)
        course = np.stack([loop, np.roll(loop, -1, axis=0)], axis=-1).reshape(-1, 2)
        around = np.zeros((rows, stitches, 3))
        around[-1] = lattice.shift([0, 1])
        return loops_of_faces(places, wale, course, course_shift=around.reshape(-1, 3))

    return Scene(name, make, gauge, "rigid", per_run=64, given=("course_error",))


def cell(name: str, pattern: Sequence[int], rows: int, stitches: int) -> Scene:
    """Return a periodic cell with a prescribed gauge, in which the shape of the loops relaxes."""
    _check_whole_repeats(pattern, stitches)
    scale = RADIUS / FORMULA_RADIUS
    lattice = Lattice(scale * np.array([[stitches * STITCH_WIDTH, 0.0, 0.0], [0.0, rows * ROW_HEIGHT, 0.0]]))

    def make(points_per_stitch: int) -> YarnSet:
        """Return rows of the loops of the formula that continue periodically beyond the cell."""
        row = formula_row(pattern, stitches, points_per_stitch)
        trend = np.arange(len(row))[:, None] / len(row) * [stitches * STITCH_WIDTH, 0.0, 0.0]
        row = _control_points(row - trend) + trend  # a spline whose control points lie on a line follows it
        points = scale * np.concatenate([row + np.array([0.0, ROW_HEIGHT * number, 0.0]) for number in range(rows)])
        start = np.arange(rows + 1) * len(row)
        closed = np.ones(rows, dtype=bool)
        number = np.arange(len(points))
        yarns = YarnSet(
            points=points, start=start, closed=closed, radius=np.full(rows, RADIUS), row=number // len(row),
            rest_length=segment_lengths(points, segment_points(start, closed)), face=number // points_per_stitch,
            part=np.zeros(len(points)), lattice=lattice, lattice_step=np.tile([1, 0], (rows, 1)),
        )  # fmt: skip
        return replace(yarns, rest_length=yarns.lengths)

    def gauge(places: Places) -> AdjacentLoops:
        loop = np.arange(rows * stitches).reshape(rows, stitches)
        column, row = np.meshgrid(np.arange(stitches) + len(pattern), np.arange(rows) + 1)
        wale = np.stack([loop, loop[row - 1, column % stitches]], axis=-1).reshape(-1, 2)
        course = np.stack([loop, loop[row % rows, column - len(pattern)]], axis=-1).reshape(-1, 2)
        around, up = (column // stitches).ravel(), (row // rows).ravel()
        shifts = lattice.shift(np.stack([around, 0 * up], axis=1)), lattice.shift(np.stack([0 * up, up], axis=1))
        return loops_of_faces(places, wale, course, wale_shift=shifts[0], course_shift=shifts[1])

    return Scene(name, make, gauge, "shift", per_run=64, given=("wale_error", "course_error"))


def garment(name: str, path: str, unit: str, stitch_width: float, device: str | None) -> Scene:
    """Return the scene of a knitted mesh, whose yarns keep the shape of the mesh."""
    fabric = Garment(path, stitch_width, unit).evened(device)

    def make(points_per_stitch: int) -> YarnSet:
        quality = replace(quality_named("standard"), control_points_per_stitch=points_per_stitch)
        return sm.generate_yarns(fabric, quality=quality)

    return Scene(name, make, partial(loops_of_fabric, fabric), "none", per_run=16, fabric=fabric)


def yarn_file(name: str, path: str) -> Scene:
    """Return the scene of free yarns from a file; loops are found from the period of the directions of a yarn."""
    read = sm.read_yarns(path)
    yarns = replace(read, face=np.arange(len(read.points)))
    return Scene(name, lambda _: yarns, _loops_of_periods, "rigid", per_run=1, generated=False)


def formula_row(pattern: Sequence[int], stitches: int, points_per_stitch: int) -> FloatArray:
    """Return points of a row at equal arc lengths in each loop, half a step from its borders [units of the formula]."""
    t = np.linspace(-np.pi, np.pi, 4001)
    loops = []
    for number in range(stitches):
        before, side, after = (pattern[(number + step) % len(pattern)] for step in (-1, 0, 1))
        height = side * np.cos(2 * t)
        height[t < 0] *= 1.0 if before == side else np.sin(np.pi / 2 * np.minimum((t[t < 0] + np.pi) / PASSING, 1.0))
        height[t >= 0] *= 1.0 if after == side else np.sin(np.pi / 2 * np.minimum((np.pi - t[t >= 0]) / PASSING, 1.0))
        curve = np.stack([t + 1.5 * np.sin(2 * t) + number * STITCH_WIDTH, 4 * np.cos(t), height], axis=1)
        arc = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(curve, axis=0), axis=1))])
        places = (np.arange(points_per_stitch) + 0.5) / points_per_stitch * arc[-1]
        loops.append(np.stack([np.interp(places, arc, axis) for axis in curve.T], axis=1))
    return np.concatenate(loops)


def _check_whole_repeats(pattern: Sequence[int], stitches: int) -> None:
    if stitches % len(pattern) != 0:
        raise ParameterError(f"stitches: got {stitches}; expected a multiple of {len(pattern)}, the pattern's repeat")


def _control_points(curve: FloatArray) -> FloatArray:
    """Return the control points of the closed spline whose knots are the points."""
    wave = 2 * np.pi * np.fft.fftfreq(len(curve))
    return np.fft.ifft(np.fft.fft(curve, axis=0) / ((4 + 2 * np.cos(wave)) / 6)[:, None], axis=0).real


def _loops_of_periods(places: Places) -> AdjacentLoops:
    """Return the loops of yarns without stitches; a loop has as many control points as the period of the directions.

    Every place begins a loop. Neighbours along a row are one loop apart; a loop's neighbour in another row is the
    loop of another yarn whose centre is nearest, where it is no further than two loops of its own row are.
    """
    first = np.searchsorted(places.yarn, np.arange(places.yarn.max() + 2))
    ends = list(pairwise(first))
    size = [_loop_size(places.points[a:b]) for a, b in ends]
    member = np.concatenate([a + (np.arange(b - a)[:, None] + np.arange(n)) % (b - a) for (a, b), n in
                             zip(ends, size, strict=True)], axis=None)  # fmt: skip
    loop_size = np.repeat(size, np.diff(first))
    row = np.repeat(np.arange(len(loop_size)), loop_size)
    centre = csr_matrix((1.0 / loop_size[row], (row, member)), shape=(len(loop_size), len(loop_size)))
    begin = [np.arange(a, b - n, n) for (a, b), n in zip(ends, size, strict=True)]
    wale = np.concatenate([np.stack([one, one + n], axis=1) for one, n in zip(begin, size, strict=True)])
    course = _nearest_of_other_yarns(centre @ places.points, places.yarn, wale)
    return AdjacentLoops(centre, wale, np.zeros((len(wale), 3)), course, np.zeros((len(course), 3)))


def _loop_size(points: FloatArray) -> int:
    """Return the number of control points after which the directions of a closed yarn repeat best."""
    step = np.roll(points, -1, axis=0) - points
    direction = step / np.linalg.norm(step, axis=1, keepdims=True)
    lags = np.arange(4, min(LONGEST_LOOP, len(points) // 2))
    return int(lags[np.argmax([np.mean(direction * np.roll(direction, -lag, axis=0)) for lag in lags])])


def _nearest_of_other_yarns(centre: FloatArray, yarn: IntArray, wale: IntArray) -> IntArray:
    """Return pairs of a loop and the nearest loop of another yarn."""
    reach = 2.0 * float(np.linalg.norm(centre[wale[:, 1]] - centre[wale[:, 0]], axis=1).mean())
    asking = np.unique(wale[:, 0])
    distance, found = cKDTree(centre).query(centre[asking], k=64, distance_upper_bound=reach)
    there = np.isfinite(distance)
    other = there & (yarn[np.where(there, found, 0)] != yarn[asking][:, None])
    nearest = other.argmax(axis=1)
    has = other.any(axis=1)
    return np.stack([asking[has], found[np.arange(len(asking)), nearest][has]], axis=1)
