# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""A tube of bands that starts as the fabric that its swatches found, and is relaxed with nothing around it.

The free yarns of ``finished-garment`` begin on a surface, where a rib is 70 % too wide, and long waves draw in slowly.
Here each band of a tube has the girth and the row height of its swatch at the start, and the yarn of each stitch lies
as in the swatch. The same generator makes both, so that control points correspond stitch by stitch. A control point of
the relaxed swatch is written as columns, rows and height over the middle plane of the cell, and is put at this place of
the surface of the tube. The cast-on row and the last row of each band stay as generated, because stitches of two
patterns meet there.

The swatches are let go ``wet`` with friction, between planes; the tube then has the friction of that state and no
planes. Sizes are measured as by ``finished-garment``, in the middle rows of each band.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.interpolate import PchipInterpolator

import stitchmesh as sm
from benchmarks.measures.garments.finished_garment import sizes_of_rows
from benchmarks.table import Rows, note
from stitchmesh.linking.certificate import changed_pairs, doubled_linking
from stitchmesh.mesh import FloatArray, IntArray, StitchMesh
from stitchmesh.patterns import read_pattern
from stitchmesh.patterns.placement.apply import lay_pattern
from stitchmesh.periodic.relaxation.off_needles import Release, let_go, needle_size
from stitchmesh.periodic.repeat.drawn_swatch import even_rest_lengths
from stitchmesh.periodic.repeat.torus import torus_mesh
from stitchmesh.quality import PRESETS, Quality
from stitchmesh.run import Run
from stitchmesh.yarn import YarnSet
from stitchmesh.yarn.rest_length import RestLengths, apply_rest_lengths
from stitchmesh.yarn.yarn_presets import Yarn
from stitchmesh.yarngen import generate_yarns
from stitchmesh.yarngen.clearance import smallest_distance
from stitchmesh.yarngen.generate import control_point_images, trace_yarn_routes
from stitchmesh.yarnrelax import RelaxCell, YarnMaterial
from stitchmesh.yarnrelax.energies.confinement import Confinement
from tests.patterns.fabrics import tube

BANDS = {"rib2x2": 1.14, "eyelet-lace": 0.521, "stockinette": 0.437}
"""Patterns of the bands from below, and the distance of the planes between which each swatch lies [cm]."""
TALL = 0.77
"""Height of a generated stitch over its width."""
FRICTION, LEFT_WHEN_WET = 0.2, 0.37
"""Coefficient of friction between dry yarns, and the part of it that a wash leaves."""
PASSAGE = 3
"""How often the girths of neighbouring rows are averaged, so that bands pass into one another."""
MIDDLE = 2
"""Rows at the ends of a band that are not measured."""
LONGEST = 1500
"""Largest number of iterations of each relaxation of the tube."""


@dataclass(frozen=True, eq=False)
class Laid:
    """The relaxed swatch of a band, as places of its control points."""

    fabric: StitchMesh
    yarns: YarnSet
    place: FloatArray
    """Columns and rows from the corner of the cell, and height over its middle plane [cm], shape (n, 3)."""
    width: float
    """Width of a wale [cm]."""
    height: float
    """Height of a course [cm]."""
    columns: int
    rows: int

    def stitch(self, row: int, column: int) -> int:
        """Return the stitch in a row, counted from the left."""
        return self.order[row % self.rows][column % self.columns]

    @property
    def order(self) -> list[list[int]]:
        """The stitches of each row from the left."""
        return [in_order(self.fabric, row, middles(self.fabric)[:, 0]) for row in range(self.rows)]


def tube_of_swatches(
    around: int = 32, rows: int = 8, yarn: str = "super-bulky", tolerances: str = "0.01,0.003", wider: float = 0.0
) -> Rows:  # fmt: skip
    """Relax a tube of rib, lace and stockinette free, from the state of its swatches.

    Args:
        around: stitches of a round, a multiple of 4.
        rows: rows of each band.
        yarn: name of the yarn.
        tolerances: tolerances of the relaxations, one after another.
        wider: part by which the tube is wider at the start than its swatches; friction holds a fabric within a range.
    """
    used = Yarn.named(yarn)
    material = YarnMaterial.of_yarn(used)
    quality = replace(
        PRESETS["draft"], control_points_per_stitch=16, refinement=1.0, contact_samples=5, tolerance=0.002,
        max_iterations=20_000,
    )  # fmt: skip
    laid = {name: swatch_of(name, used, material, quality) for name in BANDS}
    note("the swatches are relaxed")
    fabric, bands = banded_tube(around, rows)
    line = meridian(laid, around, bands, int(fabric.row.max()) + 1, 1.0 + wider)
    flat = generated(on_surface(fabric, line), used, quality)
    start = placed(fabric, flat, laid, bands, line, around)
    moved = changed_pairs(doubled_linking(flat, device="cpu"), doubled_linking(start, device="cpu"))
    nearest = smallest_distance(start, 2.0 * used.core_radius)[0] / used.core_radius
    yield f"{len(moved)} pairs of yarns are linked in another way; the nearest ones are {nearest:.2f} radii apart."
    yield "relaxed", "iterations", "at rest", *(f"{name}: girth, height of a row" for name in BANDS)
    yield "the start", "0", "", *errors(start, fabric, laid, bands, around)
    for tolerance in map(float, tolerances.split(",")):
        relaxed = sm.relax_yarns(
            start, material=material, device="cpu", terms=[sm.Friction(FRICTION * LEFT_WHEN_WET)], run=Run(False),
            quality=replace(quality, tolerance=tolerance, max_iterations=LONGEST, precision="float64"),
        )  # fmt: skip
        start, report = relaxed.yarns, relaxed.report
        own = errors(start, fabric, laid, bands, around)
        yield f"tolerance {tolerance:g}", str(report["iterations"]), "yes" if report["converged"] else "no", *own


def swatch_of(name: str, yarn: Yarn, material: YarnMaterial, quality: Quality) -> Laid:
    """Let a swatch go wet, with friction."""
    wide = yarn.stitch_width
    fabric = torus_mesh(read_pattern(name), stitch_width=wide, stitch_height=TALL * wide)
    drawn = generate_yarns(fabric, yarn_radius=yarn.core_radius, quality=quality)
    images = control_point_images(trace_yarn_routes(fabric, yarn.core_radius, quality.control_points_per_stitch))
    lengths = RestLengths(loop_length=yarn.loop_length)
    yarns = even_rest_lengths(apply_rest_lengths(drawn, lengths, fabric=fabric), fabric)
    relaxed = let_go(
        yarns, needle_size(fabric, yarn.loop_length), Release("wet", FRICTION, RelaxCell(shear=False)), material,
        replace(quality, contact_samples=9, largest_change=0.002), "cpu", [Confinement(half_thickness=BANDS[name] / 2)],
        Run(False),
    ).yarns  # fmt: skip
    assert drawn.lattice is not None and relaxed.lattice is not None and fabric.lattice is not None
    columns, rows = (round(fabric.lattice.periods[axis, axis] / side) for axis, side in ((0, wide), (1, TALL * wide)))
    before = drawn.points - drawn.lattice.shift(images)
    after = relaxed.points - relaxed.lattice.shift(images)
    course, wale = relaxed.lattice.periods[0, :2] / columns, relaxed.lattice.periods[1, :2] / rows
    cells = np.linalg.solve(np.stack([course, wale]).T, after[:, :2].T).T
    cells += (before[:, :2] / [wide, TALL * wide] - cells).mean(axis=0)
    place = np.column_stack([cells, after[:, 2] - after[:, 2].mean()])
    return Laid(fabric, relaxed, place, float(np.linalg.norm(course)), float(np.linalg.norm(wale)), columns, rows)


def banded_tube(around: int, rows: int) -> tuple[StitchMesh, dict[str, range]]:
    """Return a tube on a cast-on row, and the rows of each band."""
    fabric, bands = tube(around, 1 + rows * len(BANDS)), dict[str, range]()
    for number, name in enumerate(BANDS):
        bands[name] = range(1 + number * rows, 1 + (number + 1) * rows)
        fabric = lay_pattern(fabric, name, faces=np.flatnonzero(np.isin(fabric.row, bands[name]))).fabric
    return fabric, bands


@dataclass(frozen=True, eq=False)
class Meridian:
    """The surface of a tube: its radius and its height [cm] by the rows from below."""

    radius: PchipInterpolator
    height: PchipInterpolator
    rows: int

    def at(self, columns: FloatArray, rows: FloatArray, out: FloatArray, around: int) -> FloatArray:
        """Return places on the surface, and ``out`` outside of it [cm], shape (n, 3)."""
        rows, angle = np.clip(rows, 0.0, self.rows), 2.0 * np.pi * columns / around
        along = np.stack([self.radius(rows, 1), self.height(rows, 1)])
        along /= np.linalg.norm(along, axis=0)
        radius = self.radius(rows) + out * along[1]
        return np.stack(
            [radius * np.cos(angle), radius * np.sin(angle), self.height(rows) - out * along[0]], axis=1
        )  # fmt: skip


def meridian(laid: dict[str, Laid], around: int, bands: dict[str, range], rows: int, factor: float) -> Meridian:
    """Return the surface on which each band has the row height of its swatch, and its girth times a factor."""
    girth, tall = np.zeros(rows), np.zeros(rows)
    for name, own in bands.items():
        girth[own], tall[own] = factor * around * laid[name].width, laid[name].height
    girth[0], tall[0] = girth[1], tall[1]
    radius = girth / (2.0 * np.pi)
    for _ in range(PASSAGE):
        beside = np.pad(radius, 1, mode="edge")
        radius = (beside[:-2] + 2.0 * beside[1:-1] + beside[2:]) / 4.0
    lines = np.concatenate([radius[:1], (radius[1:] + radius[:-1]) / 2.0, radius[-1:]])
    up = np.sqrt(np.maximum(tall**2 - np.diff(lines) ** 2, (0.3 * tall) ** 2))
    places = np.arange(rows + 1.0)
    return Meridian(
        PchipInterpolator(places, lines), PchipInterpolator(places, np.concatenate([[0.0], np.cumsum(up)])), rows
    )


def on_surface(fabric: StitchMesh, line: Meridian) -> StitchMesh:
    """Return a tube, of rows that are 1 cm high, on a surface."""
    across, up, rows = fabric.vertices.T
    angle = np.arctan2(up, across) / (2.0 * np.pi)
    return replace(fabric, vertices=line.at(angle, rows, np.zeros_like(rows), 1))


def generated(fabric: StitchMesh, yarn: Yarn, quality: Quality) -> YarnSet:
    """Return generated yarns with the loop length of a yarn, sampled evenly."""
    yarns = generate_yarns(fabric, yarn_radius=yarn.core_radius, quality=quality)
    return sm.sample_evenly(apply_rest_lengths(yarns, RestLengths(loop_length=yarn.loop_length), fabric=fabric))


def placed(
    fabric: StitchMesh, yarns: YarnSet, laid: dict[str, Laid], bands: dict[str, range], line: Meridian, around: int
) -> YarnSet:
    """Return the yarns of a tube with each stitch as in the swatch of its band, but for the ends of the bands."""
    points, rest = yarns.points.copy(), yarns.rest_length.copy()
    own, angle = places_in_stitches(yarns), np.arctan2(*middles(fabric)[:, 1::-1].T) % (2.0 * np.pi)
    segment = {int(point): number for number, point in enumerate(yarns.segment_points[:, 1])}
    for name, rows in bands.items():
        swatch = laid[name]
        theirs = places_in_stitches(swatch.yarns)
        lengths = dict(zip(swatch.yarns.segment_points[:, 1].tolist(), swatch.yarns.rest_length.tolist(), strict=True))
        rounds = {row: in_order(fabric, row, angle) for row in rows}
        turn = turned(fabric, swatch, rounds)
        for row in rows[:-1]:
            for column, face in enumerate(rounds[row]):
                like = swatch.stitch(row - rows[0], column + turn)
                if [part for part, _ in own[face]] != [part for part, _ in theirs[like]]:
                    continue
                here, there = ([point for _, point in each] for each in (own[face], theirs[like]))
                columns, tall, out = swatch.place[there].T
                columns = columns + column - (column + turn) % swatch.columns
                tall = tall + row - (row - rows[0]) % swatch.rows
                points[here] = line.at(columns, tall, out, around)
                for point, other in zip(here, there, strict=True):
                    if point in segment and other in lengths:
                        rest[segment[point]] = lengths[other]
    return replace(yarns, points=points, rest_length=rest)


def turned(fabric: StitchMesh, swatch: Laid, rounds: dict[int, list[int]]) -> int:
    """Return by how many columns the pattern of a band is turned: the first stitches then are those of the chart."""

    def differences(turn: int) -> int:
        return sum(
            int(fabric.stitch[face] != swatch.fabric.stitch[swatch.stitch(number, column + turn)])
            for number, row in enumerate(rounds.values()) for column, face in enumerate(row)
        )  # fmt: skip

    return min(range(swatch.columns), key=differences)


def places_in_stitches(yarns: YarnSet) -> dict[int, list[tuple[int, int]]]:
    """Return for each stitch its control points in the order of the yarn, each with the part of the stitch."""
    found: dict[int, list[tuple[int, int]]] = {}
    for point, (face, part) in enumerate(zip(yarns.face.tolist(), yarns.part.tolist(), strict=True)):
        found.setdefault(face, []).append((part, point))
    return {face: sorted(points, key=lambda each: each[0]) for face, points in found.items()}


def middles(fabric: StitchMesh) -> FloatArray:
    """Return the middle of each stitch, shape (F, 3)."""
    sums = np.add.reduceat(fabric.corner_position, fabric.face_start[:-1])
    return np.asarray(sums / np.diff(fabric.face_start)[:, None])


def in_order(fabric: StitchMesh, row: int, along: FloatArray) -> list[int]:
    """Return the stitches of a row in the order of their places along it."""
    faces: IntArray = np.flatnonzero(fabric.row == row)
    return [int(face) for face in faces[np.argsort(along[faces])]]


def errors(
    yarns: YarnSet, fabric: StitchMesh, laid: dict[str, Laid], bands: dict[str, range], around: int
) -> Sequence[str]:
    """Return by how much the girth and the height of a row differ from those of the swatch of each band."""
    girth, step = sizes_of_rows(yarns, fabric)
    texts = []
    for name, own in bands.items():
        rows, swatch = list(own[MIDDLE:-MIDDLE]), laid[name]
        wide = girth[rows].mean() / (around * swatch.width) - 1.0
        tall = step[np.isin(fabric.row, rows)].mean() / swatch.height - 1.0
        texts.append(f"{wide:+.1%}, {tall:+.1%}")
    return texts
