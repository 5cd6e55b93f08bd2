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

from dataclasses import dataclass, fields, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from stitchmesh.mesh import FloatArray
from stitchmesh.yarnrelax.hessian.cell_matrices import CellFactors, CellMatrices
from stitchmesh.yarnrelax.model.cell_entries import CellEntries

SIGNIFICANT = 5e-6
"""Smallest magnitude of an eigenvalue that counts, over the median of the diagonal. In knits the median of all
eigenvalues is about a tenth of the median of the diagonal, and the softest motions have 3e-4 of the former."""
SHIFTED = 8.0
"""Factor by which t grows until a matrix with negligible negative eigenvalues has none."""


@dataclass(frozen=True, eq=False)
class NewtonSteps:
    """The steps of the cells of a batch from their states; cells whose steps are not known have zeros or old steps."""

    motion: FloatArray
    """Motion of the control points, and then of the strains, of all cells [units], shape (n / 3, 3)."""
    work: FloatArray
    """Work of the forces in the step of each cell [erg], shape (C,)."""
    exact: NDArray[np.bool_]
    """Whether each step leads to the minimum of the energy to second order, shape (C,)."""
    known: NDArray[np.bool_]
    """Whether the step of each cell is known, shape (C,)."""
    leaves_balance: NDArray[np.bool_]
    """Whether each step leaves a balance; no force belongs to such a step, shape (C,)."""

    @classmethod
    def unknown(cls, entries: int, cells: int) -> NewtonSteps:
        """Return the steps of cells of which nothing is known."""
        no = np.zeros(cells, dtype=bool)
        return cls(np.zeros((entries, 3)), np.zeros(cells), no, no, no)

    def forgotten(self, cells: NDArray[np.bool_]) -> NewtonSteps:
        """Return these steps without those of some cells, shape (C,)."""
        return replace(self, known=self.known & ~cells)

    def replaced(self, own: CellEntries, others: NewtonSteps) -> NewtonSteps:
        """Return these steps, with those of ``others`` in the cells of some entries."""
        found = {each.name: getattr(self, each.name).copy() for each in fields(self)}
        for name, values in found.items():
            chosen = own.number if name == "motion" else own.cells
            values[chosen] = getattr(others, name)[chosen]
        return NewtonSteps(**found)


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
        return NewtonSteps(found.reshape(-1, 3), work, cells & exact, cells, np.zeros_like(cells))

    def steps_by(self, force: FloatArray, cells: NDArray[np.bool_], exact: NDArray[np.bool_]) -> NewtonSteps:
        """Return the steps of some cells with other forces, shape (n,), without removing the effect of t."""
        found, work = self.factors.refined(force, cells, np.zeros_like(cells), self.shift)
        return NewtonSteps(found.reshape(-1, 3), work, cells & exact, cells, np.zeros_like(cells))

    def ways_down(self, cells: NDArray[np.bool_], lengths: FloatArray) -> FloatArray:
        """Return motions of some cells along which the energy has a negative second derivative, shape (n / 3, 3).

        A motion is the part of a random vector in the negative directions of the matrix. It is scaled so that the
        control point that moves farthest moves by the length of its cell, shape (C,) [units].
        """
        owners, motion = self.matrices.owners, np.zeros(len(self.force))
        for cell, down in self.factors.negative_directions(np.flatnonzero(cells).tolist()).items():
            own = owners.coordinates[cell]
            along = down @ (down.T @ np.random.default_rng(0).normal(size=len(own)))
            farthest = np.sqrt(np.bincount(own // 3 - own[0] // 3, along**2).max())
            motion[own] = along * (lengths[cell] / farthest)
        return motion.reshape(-1, 3)

    def without_negative_eigenvalues(self, cells: NDArray[np.bool_]) -> NewtonSystems:
        """Return the systems of some cells, with shifts so large that no matrix has negative eigenvalues."""
        found = replace(self, matrices=self.matrices.only(cells))
        while (negative := found.negative_count > 0).any():
            found = replace(found, shifted=np.where(negative, SHIFTED, 1.0) * found.shifted)
        return found

