# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The plan of a periodic fabric: pixels over one period, seen from the right side.

Column i and row j of w by h pixels stand at ((i + 1/2) / w) u + ((j + 1/2) / h) v, so that the picture repeats whether
the periods u and v are at right angles or not. Coordinates in the plan are x along u, y across it in the fabric's
plane, and z to its right side.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike

from stitchmesh.lattice import Lattice
from stitchmesh.mesh import FloatArray


@dataclass(frozen=True)
class Plan:
    """Pixels over one period."""

    lattice: Lattice
    """The periods."""
    width: int
    """Pixels along u."""
    height: int
    """Pixels along v."""

    @cached_property
    def axes(self) -> FloatArray:
        """Directions of x, y and z in space, shape (3, 3)."""
        u, v = self.lattice.periods
        along, out = u / np.linalg.norm(u), np.cross(u, v)
        out = out / np.linalg.norm(out)
        return np.stack([along, np.cross(out, along), out])

    @cached_property
    def periods(self) -> FloatArray:
        """The periods in the plan [cm], shape (2, 2); the first has no y."""
        inside: FloatArray = self.lattice.periods @ self.axes[:2].T
        return np.array([[inside[0, 0], 0.0], inside[1]])

    @cached_property
    def pixel(self) -> FloatArray:
        """From one pixel to the next along u and along v [cm], shape (2, 2)."""
        return self.periods / [[self.width], [self.height]]

    def places(self, column: ArrayLike, row: ArrayLike) -> tuple[FloatArray, FloatArray]:
        """Coordinates x and y of pixels [cm]; columns and rows beyond the plan are those of its images."""
        i, j = np.asarray(column) + 0.5, np.asarray(row) + 0.5
        return i * self.pixel[0, 0] + j * self.pixel[1, 0], j * self.pixel[1, 1]
