# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Yarns as round tubes above a plan: a grid of pixels over one period of a fabric, seen from its right side.

A tube is the volume swept by a ball that moves along the centre line c(s). Above a point p of the plan, the top of the
ball at parameter s has the height

    f(s) = c_z(s) + sqrt(r^2 - |p - c_xy(s)|^2)

and the surface lies at the maximum of f. Each centre line is divided into short straight pieces to find the uppermost
piece (``visibility``); then s is improved on the curve (``textures.surface_at``).

In a plan of w by h pixels, column i and row j lie at ((i + 1/2) / w) u + ((j + 1/2) / h) v. The image therefore repeats
whether or not the periods u and v are at right angles. In the coordinates of the plan, x runs along u, y runs at right
angles to u in the plane of the fabric, and z points to the right side.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike

from stitchmesh.lattice import Lattice
from stitchmesh.mesh import FloatArray, IntArray
from stitchmesh.yarn import YarnSet


@dataclass(frozen=True)
class PixelGrid:
    """A grid of pixels over one period."""

    lattice: Lattice
    """The periods of the fabric."""
    width: int
    """Number of pixels along u."""
    height: int
    """Number of pixels along v."""

    @cached_property
    def axes(self) -> FloatArray:
        """Directions of x, y and z of the plan in space, shape (3, 3)."""
        u, v = self.lattice.periods
        along, out = u / np.linalg.norm(u), np.cross(u, v)
        out = out / np.linalg.norm(out)
        return np.stack([along, np.cross(out, along), out])

    @cached_property
    def periods(self) -> FloatArray:
        """The periods in coordinates of the plan [cm], shape (2, 2); the y of the first is 0."""
        inside: FloatArray = self.lattice.periods @ self.axes[:2].T
        return np.array([[inside[0, 0], 0.0], inside[1]])

    @cached_property
    def pixel(self) -> FloatArray:
        """Vectors from one pixel to the next along u and along v [cm], shape (2, 2)."""
        return self.periods / [[self.width], [self.height]]

    def places(self, column: ArrayLike, row: ArrayLike) -> tuple[FloatArray, FloatArray]:
        """Return x and y of pixels [cm]; columns and rows outside the plan give the coordinates of its images."""
        i, j = np.asarray(column) + 0.5, np.asarray(row) + 0.5
        return i * self.pixel[0, 0] + j * self.pixel[1, 0], j * self.pixel[1, 1]


POWERS = np.array([[1, 4, 1, 0], [-3, 0, 3, 0], [3, -6, 3, 0], [-1, 3, -3, 1]]) / 6
"""Matrix from the control points of a segment to the coefficients of 1, s, s^2, s^3."""
SHORTEST, LONGEST = 1 / 8, 1 / 2
"""Smallest and largest length of a piece in yarn radii; between these limits a piece is as long as a pixel."""


@dataclass(frozen=True)
class Tubes:
    """The segments of yarns in the coordinates of a plan."""

    coefficients: FloatArray
    """c(s) of each segment in the plan's coordinates [cm], shape (S, 4, 3)."""
    radius: FloatArray
    """Apparent radius of each segment [cm], shape (S,)."""
    yarn: IntArray
    """Yarn of each segment, shape (S,)."""
    pieces: int
    """Number of pieces of each segment."""

    @property
    def ends(self) -> FloatArray:
        """Ends of the pieces of each segment [cm], shape (S, pieces + 1, 3)."""
        powers = (np.arange(self.pieces + 1) / self.pieces)[:, None] ** np.arange(4)
        return np.einsum("kp,spd->skd", powers, self.coefficients)

    @property
    def depth(self) -> tuple[float, float]:
        """Lowest and highest z of the tubes [cm], with the error of the straight pieces."""
        z = self.ends[:, :, 2]
        return float((z - self.radius[:, None]).min()), float((z + self.radius[:, None]).max())


def tubes_above(yarns: YarnSet, plan: PixelGrid) -> Tubes:
    """Return the tubes of yarns that have the periods of the plan."""
    corners = yarns.points[yarns.segment_points]
    if yarns.point_shift is not None:
        corners = corners + yarns.point_shift
    radius = yarns.drawn_radius[yarns.segment_yarn]
    finest = float(np.linalg.norm(plan.pixel, axis=1).min())
    piece = np.clip(finest, SHORTEST * radius, LONGEST * radius)
    return Tubes(
        coefficients=np.einsum("pj,sjd->spd", POWERS, corners @ plan.axes.T),
        radius=radius,
        yarn=yarns.segment_yarn,
        pieces=int(np.ceil((yarns.lengths / piece).max())),
    )
