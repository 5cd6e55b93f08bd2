# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Stockinette by a formula (Crane 2023): rows (t + 1.5 sin 2t, 4 cos t, cos 2t), 4.5 apart, with yarn radius 0.78."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import CubicSpline

from stitchmesh.lattice import Lattice
from stitchmesh.mesh import Mesh, StitchMesh
from stitchmesh.mesh.stitch import Stitch
from stitchmesh.yarn import YarnSet

FORMULA_RADIUS = 0.78
ROW_HEIGHT = 4.5
STITCH_WIDTH = 2 * np.pi


def loop_curve(stitches: int, points_per_stitch: int) -> NDArray[np.float64]:
    """Points at equal arc length along one row of the formula, shape (stitches * points_per_stitch, 3)."""
    t = np.linspace(0.0, 2 * np.pi, 2001)
    curve = np.stack([t + 1.5 * np.sin(2 * t), 4 * np.cos(t), np.cos(2 * t)], axis=1)
    arc = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(curve, axis=0), axis=1))])
    one = CubicSpline(arc, curve)(np.arange(points_per_stitch) / points_per_stitch * arc[-1])
    rows = [one + np.array([stitch * STITCH_WIDTH, 0.0, 0.0]) for stitch in range(stitches)]
    return np.concatenate(rows)


def control_points(curve: NDArray[np.float64], wraps: bool) -> NDArray[np.float64]:
    """B-spline control points p - p''/6; their curve passes through the points p with an error of fourth order."""
    padded = np.concatenate([curve[-1:], curve, curve[:1]]) if wraps else np.pad(curve, ((1, 1), (0, 0)), mode="edge")
    return curve - np.diff(padded, 2, axis=0) / 6


def flat_patch(rows: int, stitches: int, points_per_stitch: int = 12, radius: float = 0.125) -> YarnSet:
    """A swatch of open rows; stitch faces are numbered row by row."""
    scale = radius / FORMULA_RADIUS
    row = control_points(loop_curve(stitches, points_per_stitch), wraps=False)
    curves = [scale * (row + np.array([0.0, ROW_HEIGHT * index, 0.0])) for index in range(rows)]
    yarns = YarnSet.from_curves(curves, closed=[False] * rows, radius=radius)
    return with_faces(yarns, points_per_stitch)


def tube(rows: int, stitches: int, points_per_stitch: int = 12, radius: float = 0.125) -> YarnSet:
    """A tube of closed rows around the y axis, knit side out."""
    scale = radius / FORMULA_RADIUS
    flat = loop_curve(stitches, points_per_stitch)
    around = stitches * STITCH_WIDTH / (2 * np.pi)
    curves = []
    for index in range(rows):
        angle, height, out = flat[:, 0] / around, flat[:, 1] + ROW_HEIGHT * index, around + flat[:, 2]
        ring = np.stack([out * np.sin(angle), height, out * np.cos(angle)], axis=1)
        curves.append(scale * control_points(ring, wraps=True))
    return with_faces(YarnSet.from_curves(curves, closed=[True] * rows, radius=radius), points_per_stitch)


def hopf_link(shrink: float, radius: float = 0.125) -> YarnSet:
    """Two linked rings whose rest lengths pull them against each other."""
    angle = np.arange(24) / 24 * 2 * np.pi
    first = np.stack([np.cos(angle), np.sin(angle), 0 * angle], axis=1)
    second = np.stack([1 + np.cos(angle), 0 * angle, np.sin(angle)], axis=1)
    yarns = YarnSet.from_curves([first, second], closed=[True, True], radius=radius)
    return replace(yarns, rest_length=shrink * yarns.rest_length)


def periodic_patch(rows: int, stitches: int, points_per_stitch: int = 12, radius: float = 0.125) -> YarnSet:
    """A cell of an infinite swatch: each row continues in its own periodic image. The smallest cell is one stitch."""
    scale = radius / FORMULA_RADIUS
    width = np.array([stitches * STITCH_WIDTH, 0.0, 0.0])
    row = loop_curve(stitches, points_per_stitch)
    padded = np.concatenate([row[-1:] - width, row, row[:1] + width])
    row = row - np.diff(padded, 2, axis=0) / 6
    curves = [scale * (row + np.array([0.0, ROW_HEIGHT * index, 0.0])) for index in range(rows)]
    lattice = Lattice(scale * np.array([width, [0.0, rows * ROW_HEIGHT, 0.0]]))
    number, start = np.arange(rows * len(row)), np.arange(rows + 1) * len(row)
    step = np.tile([1, 0], (rows, 1))
    face, part = number // points_per_stitch, number % points_per_stitch
    return periodic_set(np.concatenate(curves), start, step, lattice, radius, face, part)


def woven_cell(radius: float = 0.125) -> YarnSet:
    """A cell of plain weave: two wefts along x and two warps along y, with crossings every three radii.

    At the crossings, the yarns overlap a little.
    """
    spacing = 3.0 * radius
    along = np.arange(8) / 8 * 2 * spacing
    curves = []
    for turn in (False, True):
        for index in range(2):
            wave = np.where((index == 1) ^ turn, -0.9, 0.9) * radius * np.cos(np.pi * along / spacing)
            aside = np.full(8, index * spacing)
            place = [aside, along] if turn else [along, aside]
            curves.append(np.stack([*place, wave], axis=1))
    start = np.arange(5) * 8
    step = np.array([[1, 0], [1, 0], [0, 1], [0, 1]])
    lattice = Lattice(2 * spacing * np.eye(3)[:2])
    number = np.arange(32)
    return periodic_set(np.concatenate(curves), start, step, lattice, radius, number // 8, number % 8)


def periodic_set(
    points: NDArray[np.float64],
    start: NDArray[np.int64],
    step: NDArray[np.int64],
    lattice: Lattice,
    radius: float,
    face: NDArray[np.int64],
    part: NDArray[np.int64],
) -> YarnSet:
    """Yarns that continue in their periodic images; their rest lengths are their lengths."""
    count = len(start) - 1
    yarns = YarnSet(
        points=points,
        start=start,
        closed=np.ones(count, dtype=bool),
        radius=np.full(count, radius),
        rest_length=np.ones(len(points)),
        row=np.repeat(np.arange(count), np.diff(start)),
        face=face,
        part=part,
        lattice=lattice,
        lattice_step=step,
    )
    return replace(yarns, rest_length=yarns.lengths)


def with_faces(yarns: YarnSet, points_per_stitch: int) -> YarnSet:
    """The same yarns with stitch faces numbered along them, each of ``points_per_stitch`` control points."""
    number = np.arange(len(yarns.points))
    return replace(yarns, face=number // points_per_stitch, part=number % points_per_stitch)


def fabric_of(rows: int, stitches: int, radius: float = 0.125, *, closed: bool) -> StitchMesh:
    """The stitch mesh of ``flat_patch`` or of ``tube``, with the face numbers that the control points refer to."""
    scale = radius / FORMULA_RADIUS
    columns = stitches if closed else stitches + 1
    across, up = np.meshgrid(np.arange(columns), np.arange(rows + 1))
    around = stitches * STITCH_WIDTH / (2 * np.pi)
    height = (up.ravel() - 0.5) * ROW_HEIGHT
    if closed:
        angle = across.ravel() * STITCH_WIDTH / around
        vertices = scale * np.stack([around * np.sin(angle), height, around * np.cos(angle)], axis=1)
    else:
        vertices = scale * np.stack([across.ravel() * STITCH_WIDTH, height, 0 * height], axis=1)
    faces = []
    for row in range(rows):
        for stitch in range(stitches):
            left, right = row * columns + stitch, row * columns + (stitch + 1) % columns
            faces.append([left, right, right + columns, left + columns])
    mesh = Mesh.from_polygons(vertices, faces)
    ones = np.ones(mesh.face_count, dtype=np.int64)
    return StitchMesh(
        vertices=mesh.vertices,
        face_start=mesh.face_start,
        face_vertex=mesh.face_vertex,
        twin=mesh.twin,
        n_bottom=ones,
        n_top=ones,
        stitch=ones * Stitch.KNIT,
        row=np.arange(mesh.face_count) // stitches,
    )


def shaken(yarns: YarnSet, rest: float = 0.95) -> YarnSet:
    """The yarns out of balance, with rest lengths that stretch or compress them."""
    noise = np.random.default_rng(7).normal(scale=0.01, size=yarns.points.shape)
    return replace(yarns, points=yarns.points + noise, rest_length=rest * yarns.rest_length)
