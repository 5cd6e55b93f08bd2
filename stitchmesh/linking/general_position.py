# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Moving points in general position, by a tiny random displacement and whole units.

Generated fabric is symmetric: points lie on edges, several edges lie in one plane, and neighbours are at equal
distances. Without a displacement, the last bit of a coordinate would select one of two results. Each point therefore
counts as moved by a random displacement, which is the same at all times. The displacement is small compared with the
yarn radius and large compared with rounding. For almost all displacements, edges that move on straight lines cross one
pair at a time and never at a vertex (Sard's theorem). A change of the last bit of a coordinate then changes no result.

The infinitesimal displacement of ``predicate`` cannot replace it. Where two edges touch during their motion, it makes
two crossings whose times differ by less than any number, and no halving of time (``moving_edges``) separates these.

Displaced coordinates are rounded to whole multiples of a power of two, each point once. The periods of a lattice are
rounded in the same manner. Sums and differences of these numbers are exact, so a point has the same position for every
edge that ends there.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from stitchmesh.lattice import Lattice
from stitchmesh.mesh import FloatArray

DISPLACEMENT = 1e-6
"""Largest displacement of a point along an axis, over the mean yarn radius."""
BITS = 46
"""Number of bits of a coordinate. Sums with lattice shifts are some times larger and stay below the 53 bits of double
precision."""
FEWEST_UNITS = 2**10
"""Lower bound of the largest displacement [units], for yarns that are very thin compared with their fabric."""


def displacements(count: int, largest: float, seed: int = 0) -> FloatArray:
    """Random displacements of points [cm], the same on every machine, shape (count, 3).

    Args:
        count: number of points.
        largest: largest displacement along an axis [cm].
        seed: seed of the random numbers.
    """
    return np.random.default_rng(seed).uniform(-largest, largest, (count, 3))


@dataclass(frozen=True)
class WholeUnits:
    """Rounding of lengths to whole multiples of a unit, which is a power of two."""

    unit: float
    """The unit [cm]."""

    @classmethod
    def fitting(cls, extent: float) -> WholeUnits:
        """The unit for which coordinates up to ``extent`` [cm] have ``BITS`` bits."""
        return cls(2.0 ** (np.frexp(extent)[1] - BITS))

    def rounded(self, values: FloatArray) -> FloatArray:
        """Lengths [cm] rounded to whole multiples of the unit."""
        whole: FloatArray = np.rint(values / self.unit) * self.unit
        return whole

    def rounded_lattice(self, lattice: Lattice | None) -> Lattice | None:
        """A lattice with rounded periods; None for None."""
        return None if lattice is None else Lattice(self.rounded(lattice.periods))
