# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The linear systems of the Newton steps of the cells of a batch, or of the only piece.

Let M be the matrix of a cell, either the exact Hessian or one that is never negative, and F the forces. The step of the
cell is A^-1 F with

    A = M + t I,    t = SIGNIFICANT * median of the diagonal of M

Eigenvalues between -t and t come from the roughness of sampled contacts, from rounding, and from motions of the fabric
as a whole. If M is the exact Hessian H and A has no negative eigenvalue, some conjugate gradients with A as their
preconditioner remove the effect of t (``cell_matrices``). Then x = H^-1 F is the remaining motion to the minimum, up to
its square.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from stitchmesh.mesh import FloatArray
from stitchmesh.yarnrelax.hessian.cell_matrices import CellFactors, CellMatrices

SIGNIFICANT = 5e-6
"""Smallest magnitude of an eigenvalue that counts, over the median of the diagonal. In knits the median of all
eigenvalues is about a tenth of the median of the diagonal, and the softest motions have 3e-4 of the former."""
SHIFTED = 8.0
"""Factor by which t grows until a matrix with negligible negative eigenvalues has none."""


@dataclass(frozen=True, eq=False)
class NewtonStep:
    """The step of one cell from its current state."""

    motion: FloatArray
    """Motion of the control points, and then of the strains [units], shape (n, 3)."""
    exact: bool
    """Whether the step leads to the minimum of the energy to second order."""
    work: float
    """Work of the forces in the step [erg]."""
    leaves_balance: bool = False
    """Whether the step leaves a balance; no force belongs to such a step."""


@dataclass(frozen=True, eq=False)
class NewtonSystems:
    """The linear systems of some cells of a batch.

    Vectors and motions have all coordinates of all cells, and are zero at coordinates that are left out.
    """

    matrices: CellMatrices
    """The matrices [erg / unit^2]."""
    force: FloatArray
    """The forces [erg / unit], shape (n,)."""
    shifted: FloatArray | float = 1.0
    """Factor of t: one for all cells, or one for each cell, shape (C,)."""

    @cached_property
    def shift(self) -> FloatArray:
        """The multiple t of the identity that is added to each cell's matrix, shape (C,)."""
        return np.asarray(self.shifted * SIGNIFICANT * self.matrices.medians())

    @cached_property
    def factors(self) -> CellFactors:
        """The factors of the shifted matrices.

        Raises:
            SolverError: a matrix has no factors.
        """
        return self.matrices.factored(self.shift)

    @property
    def negative_count(self) -> NDArray[np.int64]:
        """Number of negative eigenvalues of the shifted matrix of each cell, shape (C,)."""
        return self.factors.negative_count

    def steps(self, cells: NDArray[np.bool_], exact: NDArray[np.bool_]) -> NewtonSteps:
        """Return the steps of cells without negative eigenvalues; ``exact``: whether a matrix is the exact Hessian."""
        found, work = self.factors.refined(self.force, cells, exact, self.shift)
        return NewtonSteps(found.reshape(-1, 3), work)

    def steps_by(self, force: FloatArray, cells: NDArray[np.bool_]) -> NewtonSteps:
        """Return the steps of some cells with other forces, shape (n,), without removing the effect of t."""
        found = self.factors.solve(force, cells)
        return NewtonSteps(found.reshape(-1, 3), self.matrices.owners.sums(force * found))

    def ways_down(self, lengths: Mapping[int, float]) -> dict[int, FloatArray]:
        """Return motions of some cells along which the energy has a negative second derivative, shape (n / 3, 3).

        A motion is the part of a random vector in the negative directions of the matrix. It is scaled so that the
        control point that moves farthest moves by the given length [units].
        """
        owners, found = self.matrices.owners, dict[int, FloatArray]()
        for cell, down in self.factors.negative_directions(list(lengths)).items():
            motion, own = np.zeros(len(self.force)), owners.coordinates[cell]
            along = down @ (down.T @ np.random.default_rng(0).normal(size=len(own)))
            farthest = np.sqrt(np.bincount(own // 3 - own[0] // 3, along**2).max())
            motion[own] = along * (lengths[cell] / farthest)
            found[cell] = motion.reshape(-1, 3)
        return found

    def without_negative_eigenvalues(self, cells: NDArray[np.bool_]) -> NewtonSystems:
        """Return the systems of some cells, with shifts so large that no matrix has negative eigenvalues."""
        found = replace(self, matrices=self.matrices.only(cells))
        while (negative := found.negative_count > 0).any():
            found = replace(found, shifted=np.where(negative, SHIFTED, 1.0) * found.shifted)
        return found


@dataclass(frozen=True, eq=False)
class NewtonSteps:
    """The steps of some cells; zero for all others."""

    motion: FloatArray
    """Motion of the control points, and then of the strains, of all cells [units], shape (n / 3, 3)."""
    work: FloatArray
    """Work of the forces in the step of each cell [erg], shape (C,)."""

    def of(self, cell: int, entries: NDArray[np.int64], *, exact: bool) -> NewtonStep:
        """Return the step of a cell whose control points and strains have the numbers ``entries``."""
        return NewtonStep(self.motion[entries], exact, float(self.work[cell]))
