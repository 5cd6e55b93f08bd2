# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""A box with sides along the axes; everything outside it is hidden."""

from __future__ import annotations

import itertools
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from stitchmesh.app.scene.drawing import Lines
from stitchmesh.mesh import FloatArray

SIDES: Mapping[str, tuple[int, float]] = {
    "Left": (0, 0.0), "Right": (0, 100.0), "Bottom": (1, 0.0), "Top": (1, 100.0), "Back": (2, 0.0), "Front": (2, 100.0),
}  # fmt: skip
"""Axis of each side of the box, and the place of the side where it hides nothing [% of the thing]."""


@dataclass(frozen=True)
class ClipBox:
    """A box."""

    low: tuple[float, float, float]
    """Smallest coordinates [cm]."""
    high: tuple[float, float, float]
    """Largest coordinates [cm]."""

    def inside(self, points: FloatArray) -> NDArray[np.bool_]:
        """Return whether points lie in the box, shape (n, 3) to (n,)."""
        return np.all((points >= self.low) & (points <= self.high), axis=1)

    def edges(self) -> Lines:
        """Return the twelve edges."""
        ends = np.array([self.low, self.high])
        corners = np.array([[ends[i, 0], ends[j, 1], ends[k, 2]] for i, j, k in itertools.product((0, 1), repeat=3)])
        pairs = [(a, b) for a, b in itertools.combinations(range(8), 2) if (a ^ b) in (1, 2, 4)]
        return Lines(corners[np.array(pairs)], (224, 138, 30), 2.0)


def box_of_shares(low: FloatArray, high: FloatArray, shares: Mapping[str, float]) -> ClipBox:
    """Return the box between given shares of the bounds of a thing.

    Args:
        low: smallest coordinates of the thing [cm], shape (3,).
        high: largest coordinates of the thing [cm], shape (3,).
        shares: place of each side of ``SIDES`` [% from low to high]; opposite sides in the wrong order are exchanged.
    """
    ends = np.zeros((2, 3))
    for side, (axis, far) in SIDES.items():
        share = shares.get(side, far)
        ends[int(far > 0.0), axis] = low[axis] + 0.01 * share * (high[axis] - low[axis])
    # Rounding of coordinates must not hide the outermost points.
    slack = 1e-9 * (1.0 + np.abs(ends).max())
    least, most = ends.min(axis=0) - slack, ends.max(axis=0) + slack
    return ClipBox(tuple(least.tolist()), tuple(most.tolist()))
