# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The lattice of a periodic fabric: two period vectors and integer images.

A neighbour across the cell border is always ``x_j + a*u + b*v - x_i`` with a stored integer image (a, b). The
nearest-image rule is never used: a one-stitch cell is smaller than twice the contact range.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from stitchmesh.errors import MeshError


@dataclass(frozen=True, eq=False)
class Lattice:
    """Two period vectors of a fabric that repeats.

    Raises:
        MeshError: the periods are not finite or do not span a plane.
    """

    periods: NDArray[np.float64]
    """Period along the courses and period along the wales [cm], shape (2, 3)."""

    def __post_init__(self) -> None:
        periods = np.array(self.periods, dtype=np.float64)
        if periods.shape != (2, 3) or not np.isfinite(periods).all():
            raise MeshError(f"lattice: got periods {periods.tolist()}; expected two finite vectors of three numbers")
        if np.linalg.norm(np.cross(periods[0], periods[1])) == 0.0:
            raise MeshError(f"lattice: the periods {periods.tolist()} are parallel; expected two that span a plane")
        periods.setflags(write=False)
        object.__setattr__(self, "periods", periods)

    def shift(self, image: ArrayLike) -> NDArray[np.float64]:
        """Displacement ``a*u + b*v`` [cm] of integer images, shape (..., 2) to (..., 3)."""
        return np.asarray(image, dtype=np.float64) @ self.periods
