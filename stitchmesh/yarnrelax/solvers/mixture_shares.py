# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Where the exact Hessian is mixed with the Gauss-Newton matrix, and with which share of that matrix.

If the Hessian H has negative eigenvalues, its mixture with a share s of the Gauss-Newton matrix replaces it
(``segment_hessian``, ``contact_hessian``); the Gauss-Newton matrix is never negative. The first share is s = 1. After
each step s becomes a third, until H itself is taken again below ``LEAST_SHARE``. If the mixture has negative
eigenvalues too, s grows by ``SLOWER`` at once. If H becomes negative again, the first share is the last one that was
sufficient.

The cell of a swatch has one share. The eigenvectors of a large piece, such as a garment, are a few stitches wide, and
among thousands of stitches there are always some that slide. Each of its steps begins with the exact Hessian, and its
segments have shares of their own, which grow within ``REACH`` of the control points whose pivots are negative. The
factorization meets negative pivots at places where the matrix is negative, because the eigenvalues of its leading
minors interlace (Cauchy). If all shares within reach are 1, the reach is doubled, so that at last the whole matrix is
the Gauss-Newton matrix.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from stitchmesh.mesh import FloatArray
from stitchmesh.yarnrelax.model.constants import Model

FASTER, SLOWER = 1.0 / 3.0, 8.0
"""Factors of a share: after a step, and where the mixture has negative eigenvalues."""
LEAST_SHARE = 0.002
"""Below this share the Gauss-Newton matrix is left out."""
DISTRUSTED = 0.16
"""Smallest share after a step that was refused."""
REACH = 12.0
"""Distance from a negative pivot within which shares grow [mean radii]; a stitch is about eight radii wide."""


class MixtureShares:
    """The share of the Gauss-Newton matrix in each segment."""

    def __init__(self, model: Model, *, local: bool) -> None:
        """Begin with the exact Hessian everywhere; ``local`` says whether segments have shares of their own."""
        self.model, self.local = model, local
        self.of_segments = np.zeros(model.segment_count)
        """The shares, shape (S,)."""
        self._sufficient = np.ones(model.segment_count)
        """Share of each segment at which the matrix last had no negative eigenvalues, shape (S,)."""
        self._segment_points = np.asarray(model.yarns.segment_points)

    @property
    def largest(self) -> NDArray[np.float64]:
        """Largest share of each cell, shape (C,)."""
        return np.maximum.reduceat(self.of_segments, self.model.segment_start[:-1])

    @property
    def least(self) -> NDArray[np.float64]:
        """Least share of each cell, shape (C,)."""
        return np.minimum.reduceat(self.of_segments, self.model.segment_start[:-1])

    @property
    def part(self) -> NDArray[np.float64]:
        """Part of the segments of each cell that have a share above 0, shape (C,)."""
        mixed = np.add.reduceat((self.of_segments > 0.0).astype(np.float64), self.model.segment_start[:-1])
        return np.asarray(mixed / np.diff(self.model.segment_start))

    @property
    def sufficient(self) -> NDArray[np.float64]:
        """Largest share of each cell at which its matrix last had no negative eigenvalues, shape (C,)."""
        return np.maximum.reduceat(self._sufficient, self.model.segment_start[:-1])

    @sufficient.setter
    def sufficient(self, shares: NDArray[np.float64]) -> None:
        self._sufficient = np.repeat(shares, np.diff(self.model.segment_start))

    def set_largest(self, shares: NDArray[np.float64]) -> None:
        """Give all segments of each cell the same share, shape (C,)."""
        self.of_segments = np.repeat(shares, np.diff(self.model.segment_start))

    @property
    def is_exact(self) -> NDArray[np.bool_]:
        """Whether the exact Hessian of each cell is taken, shape (C,)."""
        return self.largest == 0.0

    def shrink(self, cells: NDArray[np.bool_]) -> None:
        """Take smaller shares after steps of some cells, shape (C,); in a large piece, take the exact Hessian again."""
        chosen = self._segments_of(cells)
        self._sufficient = np.where(chosen & (self.of_segments > 0.0), self.of_segments, self._sufficient)
        lower = self.of_segments * FASTER
        lower = np.where((lower > LEAST_SHARE) & (not self.local), lower, 0.0)
        self.of_segments = np.where(chosen, lower, self.of_segments)

    def clear(self, cells: NDArray[np.bool_]) -> None:
        """Take the exact Hessians of some cells, shape (C,)."""
        self.of_segments = np.where(self._segments_of(cells), 0.0, self.of_segments)

    def grow(self, cells: NDArray[np.bool_]) -> None:
        """Take larger shares in some cells whose mixtures have negative eigenvalues, shape (C,)."""
        self._grow(self._segments_of(cells), self._sufficient)

    def grow_near(self, pivots: NDArray[np.int64], points: FloatArray) -> None:
        """Take larger shares of a large piece near its negative pivots.

        Args:
            pivots: the coordinates whose pivots are negative.
            points: the control points [mean radii], shape (N, 3).
        """
        negative, reach = np.unique(pivots // 3), REACH
        away = cKDTree(points[negative]).query(points)[0][self._segment_points].min(axis=1)
        near = away < reach
        while (self.of_segments[near] >= 1.0).all() and not near.all():
            reach *= 2.0
            near = away < reach
        self._grow(near, np.ones(len(near)))

    def _grow(self, chosen: NDArray[np.bool_], first: NDArray[np.float64]) -> None:
        """Take larger shares in some segments, shape (S,); ``first`` where the share was 0."""
        grown = np.where(self.of_segments > 0.0, np.minimum(self.of_segments * SLOWER, 1.0), first)
        self.of_segments = np.where(chosen, grown, self.of_segments)

    def distrust(self, cells: NDArray[np.bool_]) -> None:
        """Take larger shares in the next steps of some cells, whose last steps were refused.

        The steps of a large piece only become shorter.
        """
        chosen = self._segments_of(cells & (not self.local))
        grown = np.clip(self.of_segments * SLOWER, DISTRUSTED, 1.0)
        self.of_segments = np.where(chosen, grown, self.of_segments)

    def _segments_of(self, cells: NDArray[np.bool_]) -> NDArray[np.bool_]:
        """Whether each segment belongs to one of some cells, shape (S,)."""
        return np.repeat(cells, np.diff(self.model.segment_start))
