# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Stiffnesses that couple many coordinates of a piece, as further rows and columns of its sparse matrix.

The stiffness of a patch of stitches is V^T C^-1 V, with rows V that sum the coordinates x of the piece, and a
compliance C. As a matrix it would be dense. With one more unknown y = C^-1 V x for each row, the matrix

    | H + t I   V^T |
    |    V       -C |

is sparse. It gives the solutions of H + t I + V^T C^-1 V, and has one negative eigenvalue more for each row. If H + t I
has no negative eigenvalue, there are factors L D L^T for any order of rows and columns (Vanderbei 1995, "Symmetric
quasidefinite matrices"). A constraint V x = 0 is a row with the compliance of a spring that is ``RIGID`` times as stiff
as the diagonal.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import block_diag, csc_array, csr_array, eye_array, triu, vstack
from scipy.sparse.linalg import splu

from stitchmesh.mesh import FloatArray
from stitchmesh.yarnrelax.energies.term import Coupling

RIGID = 1e6
"""Stiffness of a constraint over the median of the diagonal of the matrix: the constraint holds to six digits, and the
rounding of float64 leaves ten digits of the solution."""


@dataclass(frozen=True, eq=False)
class CouplingRows:
    """The part of the couplings of a piece that does not change while the piece relaxes."""

    first: Sequence[Coupling]
    """The couplings in the first state."""

    @cached_property
    def rows(self) -> csr_array:
        """V of all couplings, one below another, shape (m, n)."""
        return csr_array(vstack([each.rows for each in self.first]))

    @cached_property
    def columns(self) -> csr_array:
        """V^T, shape (n, m)."""
        found = csr_array(self.rows.T)
        found.sort_indices()
        return found

    def are_of(self, couplings: Sequence[Coupling]) -> bool:
        """Whether the given couplings have these rows."""
        own = [each.rows for each in self.first]
        return len(own) == len(couplings) and all(a is b.rows for a, b in zip(own, couplings, strict=True))

    def after(self, heights: NDArray[np.int64]) -> tuple[NDArray[np.int64], NDArray[np.int64], NDArray[np.int64]]:
        """Find the places of V^T behind the rows of the upper triangle of a matrix, and of -C below them.

        Args:
            heights: number of entries of each row of the upper triangle of the matrix, shape (n,).

        Returns:
            The place at which each row then starts, shape (n + m + 1,), and the places and columns of the further
            entries, in the order of ``Couplings.upper_values``.
        """
        if not self.first:
            return np.concatenate([[0], np.cumsum(heights)]), np.zeros(0, dtype=np.int64), np.zeros(0, dtype=np.int64)
        n, corner = len(heights), upper(compliance(self.first, 1.0))
        further = np.concatenate([np.diff(self.columns.indptr), np.diff(corner.indptr)])
        own = np.concatenate([heights, np.zeros(corner.shape[0], dtype=np.int64)])
        start = np.concatenate([[0], np.cumsum(own + further)])
        number = np.arange(further.sum()) - np.repeat(np.cumsum(further) - further, further)
        columns = np.concatenate([self.columns.indices, corner.indices])
        return start, np.repeat(start[:-1] + own, further) + number, n + columns


@dataclass(frozen=True, eq=False)
class Couplings:
    """The couplings of a piece in its current state."""

    of: CouplingRows
    compliance: csc_array
    """C, shape (m, m)."""

    def product(self, vector: FloatArray) -> FloatArray:
        """Return the product of V^T C^-1 V with a vector, both of shape (n,)."""
        return np.asarray(self.of.columns @ self._give.solve(self.of.rows @ vector))

    @cached_property
    def _give(self) -> Any:
        """The factors of C, whose blocks are small."""
        return splu(self.compliance)

    @property
    def upper_values(self) -> FloatArray:
        """The entries of V^T, and of the upper triangle of -C, row by row."""
        return np.concatenate([self.of.columns.data, -upper(self.compliance).data])


def joined(couplings: Sequence[Coupling], of: CouplingRows, diagonal: FloatArray) -> Couplings | None:
    """Return the couplings of a piece in its current state; None if it has none.

    Args:
        couplings: the couplings.
        of: their rows.
        diagonal: the diagonal of the matrix of the piece, shape (n,); the stiffness of constraints follows from it.
    """
    return Couplings(of, compliance(couplings, RIGID * float(np.median(diagonal)))) if couplings else None


def compliance(couplings: Sequence[Coupling], rigid: float) -> csc_array:
    """Return the compliance of some couplings, shape (m, m); constraints have the stiffness ``rigid``."""
    return csc_array(block_diag([
        eye_array(each.rows.shape[0]) / rigid if each.compliance is None else each.compliance for each in couplings
    ]))  # fmt: skip


def upper(matrix: csc_array) -> csr_array:
    """Return the upper triangle of a symmetric matrix, with ascending columns in each row."""
    found = csr_array(triu(matrix))
    found.sort_indices()
    return found
