# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Yarns moved into general position by less than matters, for answers that do not hang on rounding.

Fabric is drawn with symmetry: points lie on edges, edges in one plane, neighbours at equal distances. Which of two
answers is found then would follow from the last bit of a coordinate. So each point counts as moved by a random
displacement, the same at all times, which is small compared with a yarn's radius and large compared with rounding: for
almost all displacements edges that move on straight lines pass through one another one pair at a time and never in a
vertex (Sard's theorem), and a coordinate that changes by its last bit changes no answer.

Displaced coordinates are rounded to whole multiples of a power of two, each point once, and so are periods of a
lattice: sums and differences of them are exact, and a point is in the same place for every edge that ends there.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from stitchmesh.lattice import Lattice
from stitchmesh.mesh import FloatArray

DISPLACEMENT = 1e-6
"""Largest displacement of a point along an axis, over the mean yarn radius."""
BITS = 46
"""Bits of a coordinate; sums with lattice shifts, some times larger, stay below the 53 bits of double precision."""
FEWEST_UNITS = 2**10
"""Smallest largest displacement [units], for yarns that are very thin compared with their fabric."""


def displacements(count: int, largest: float, seed: int = 0) -> FloatArray:
    """Random displacements of points, the same on every machine, shape (count, 3).

    Args:
        count: number of points.
        largest: largest displacement along an axis [cm].
        seed: of the random numbers.
    """
    return np.random.default_rng(seed).uniform(-largest, largest, (count, 3))


@dataclass(frozen=True)
class WholeUnits:
    """Whole multiples of a power of two."""

    unit: float
    """[cm]."""

    @classmethod
    def fitting(cls, extent: float) -> WholeUnits:
        """Such that coordinates up to an extent [cm] have ``BITS`` bits."""
        return cls(2.0 ** (np.frexp(extent)[1] - BITS))

    def rounded(self, values: FloatArray) -> FloatArray:
        """Values [cm] rounded to whole units."""
        whole: FloatArray = np.rint(values / self.unit) * self.unit
        return whole

    def rounded_lattice(self, lattice: Lattice | None) -> Lattice | None:
        """A lattice with its periods rounded."""
        return None if lattice is None else Lattice(self.rounded(lattice.periods))
