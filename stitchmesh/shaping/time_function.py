# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The time at which each place of a surface is knitted, counted in courses.

The first time is that of a steady flow: rain falls evenly on the surface and runs off at the root,

    -laplace(u) = 1,    u = 0 at the root,

so that every closed limb has one summit at its tip, every other end of rows is one level, and saddles appear only where
limbs meet. Then the slope of the time is made even. With X the unit vector along the gradient, the time minimises

    integral of w |grad(t) - X|^2,

and X is renewed from t; w is larger where the slope is above 1, because a row may be too high, and short rows fill it,
but never too low. The ends of rows then move to whole numbers of courses.

Sources: the alternation of a unit field and a Poisson equation follows Crane, Weischedel and Wardetzky, *Geodesics in
heat* (2013). A time whose level lines are rows: Narayanan, Albaugh, Hodgins, Coros and McCann, *Automatic machine
knitting of 3D meshes* (2018).
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from stitchmesh.mesh import FloatArray, IntArray
from stitchmesh.shaping.ends import Ends
from stitchmesh.shaping.summits import lasting_extrema, smooth_out
from stitchmesh.shaping.triangle_surface import TriangleSurface

if TYPE_CHECKING:
    from scipy.sparse import csr_array

ROUNDS = 8
"""How often the direction of the gradient is renewed."""
STEEP_WEIGHT = 8.0
"""Weight of places where rows would be lower than a course, over that of places where they are higher."""
FLAT_SLOPE = 0.15
"""Slope of the first flow, over its median, below which the direction of the gradient counts less."""
TIP_HEIGHT = 0.05
"""Height of a summit of the first flow above its saddle, over the range of the flow, that makes a slit a tip."""
LOWEST_SUMMIT = 3.0
"""Height of a summit above its saddle, in courses, below which it is smoothed out."""


@dataclass(frozen=True, eq=False)
class Knots:
    """Vertices that share one value: the vertices of an end are one unknown, each other vertex is its own."""

    unknown: IntArray
    """Unknown of each vertex, shape (V,); 0 is the root."""
    count: int
    """Number of unknowns."""

    def matrix(self, full: csr_array) -> csr_array:
        """Return the matrix of the unknowns from that of the vertices."""
        from scipy.sparse import coo_array

        entries = full.tocoo()
        place = (self.unknown[entries.row], self.unknown[entries.col])
        return coo_array((entries.data, place), shape=(self.count, self.count)).tocsr()

    def total(self, values: FloatArray) -> FloatArray:
        """Return the sum over the vertices of each unknown, shape (count,)."""
        return np.bincount(self.unknown, values, self.count)


def knots(surface: TriangleSurface, ends: Ends) -> Knots:
    """Return the unknowns of a time on a surface: the root first, then the other ends, then all other vertices."""
    unknown = np.full(len(surface.vertices), -1)
    for number, vertices in enumerate([ends.root, *ends.rows]):
        unknown[vertices] = number
    free = unknown < 0
    first = 1 + len(ends.rows)
    unknown[free] = first + np.arange(free.sum())
    return Knots(unknown, first + int(free.sum()))


def first_flow(surface: TriangleSurface, ends: Ends) -> FloatArray:
    """Return the height of a steady flow to the root, shape (V,): 0 at the root and positive everywhere else."""
    parts = knots(surface, ends)
    matrix = parts.matrix(surface.stiffness())
    source = parts.total(surface.vertex_area)
    mean = float(np.sqrt(surface.area.sum()))
    for number, vertices in enumerate(ends.rows, start=1):
        points = surface.vertices[vertices]
        source[number] += float(np.linalg.norm(np.diff(points, axis=0), axis=1).sum()) * 0.25 * mean
    return _solved(matrix, source, np.zeros(1))[parts.unknown]


def _solved(matrix: csr_array, right: FloatArray, known: FloatArray) -> FloatArray:
    """Solve for all unknowns but the first ones, whose values are known; shape (count,)."""
    from scipy.sparse.linalg import splu

    first = len(known)
    inner = matrix[first:, first:].tocsc()
    load = right[first:] - matrix[first:, :first] @ known
    solve = splu(inner, permc_spec="COLAMD", diag_pivot_thresh=0.0, options={"SymmetricMode": True})
    return np.concatenate([known, solve.solve(load)])


def even_slope(surface: TriangleSurface, time: FloatArray, ends: Ends, rounds: int = ROUNDS) -> FloatArray:
    """Return a time [cm] whose slope is near 1, from one whose gradient has the right directions, shape (V,)."""
    parts = knots(surface, ends)
    weight = np.ones(len(surface.triangles))
    for _ in range(rounds):
        gradient = surface.gradient(time)
        slope = np.linalg.norm(gradient, axis=1)
        least = FLAT_SLOPE * float(np.median(slope))
        direction = gradient / np.maximum(slope, least)[:, None]
        right = parts.total(surface.divergence(direction, weight))
        time = _solved(parts.matrix(surface.stiffness(weight)), right, np.zeros(1))[parts.unknown]
        slope = np.linalg.norm(surface.gradient(time), axis=1)
        weight = 1.0 + (STEEP_WEIGHT - 1.0) / (1.0 + np.exp(-20.0 * (slope - 1.0)))
    return time


def whole_rows(surface: TriangleSurface, time: FloatArray, ends: Ends) -> FloatArray:
    """Move the times of all ends to whole numbers; elsewhere the gradient changes as little as possible.

    Args:
        surface: the surface.
        time: time in courses, shape (V,).
        ends: the ends.
    """
    parts = knots(surface, ends)
    known = np.array([0.0, *(max(1.0, np.rint(time[vertices].mean())) for vertices in ends.rows)])
    right = parts.total(surface.divergence(surface.gradient(time)))
    return _solved(parts.matrix(surface.stiffness()), right, known)[parts.unknown]


def knitting_time(surface: TriangleSurface, ends: Ends, course_height: float) -> tuple[FloatArray, Ends]:
    """Return the time of each vertex in courses, shape (V,), and the ends; the time begins with 0.

    Slits in which the flow has a summit, such as the open toe of a sock, become ends.

    Args:
        surface: a connected surface.
        ends: the ends.
        course_height: height of a course [cm].
    """
    flow = first_flow(surface, ends)
    lasting = lasting_extrema(surface, flow, TIP_HEIGHT * float(np.ptp(flow)))
    tips = [border for border in surface.borders
            if np.isin(lasting, border).any() and not any(np.isin(border, end).any() for end in [ends.root, *ends.rows])]  # fmt: skip
    if tips:
        ends = replace(ends, rows=(*ends.rows, *tips))
        flow = first_flow(surface, ends)
    time = even_slope(surface, flow, ends)
    time = smooth_out(surface, time / course_height, LOWEST_SUMMIT, ends) * course_height
    time = even_slope(surface, time, ends, 3)
    time = whole_rows(surface, time / course_height, ends)
    time = smooth_out(surface, time, LOWEST_SUMMIT, ends)
    return (time if ends.begins else -time), ends
