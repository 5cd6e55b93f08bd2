# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The plan of a periodic fabric: a grid of pixels over one period, seen from the right side.

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
from stitchmesh.mesh import FloatArray


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
