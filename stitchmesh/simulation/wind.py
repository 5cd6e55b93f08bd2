# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Wind: the pressure of moving air on yarns, and on a cloth with yarns.

The air is still faster than the fabric, so the force does not depend on the motion of the fabric. A point with the
area A across the wind w feels the drag

    f = 1/2 rho C A |w| w        [dyn],    rho the density of air, C the coefficient of drag

Of yarns, A is the diameter times the length that the point carries. A straight cylinder across the wind has C between
1.0 and 1.2 at Reynolds numbers from 100 to 10,000, that is, yarn of 2 mm in winds from 1 to 70 m/s. Of a cloth, A is
the area of its triangles and nodes. The area does not turn with the fabric, and what lies in the lee of something else
is not sheltered. The force is therefore an upper bound: a dead load (``dead_load``).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from stitchmesh.errors import ParameterError
from stitchmesh.simulation.dead_load import DeadLoad
from stitchmesh.simulation.term import LoadedPoints, TermChoice

AIR = 1.2e-3
"""Density of air [g / cm^3] at 20 degrees and the pressure at sea level."""
DRAG = 1.1
"""Coefficient of drag of a cylinder across the wind."""
MOST_SPEED = 1e4
"""Largest speed along an axis [cm / s], above that of any storm; from a third of the speed of sound, air compresses."""


@dataclass(frozen=True)
class Wind(TermChoice[LoadedPoints]):
    """A wind that is the same everywhere and at all times.

    Raises:
        ParameterError: the velocity is not three numbers, or one is above ``MOST_SPEED``.
    """

    on_any_points = True

    velocity: tuple[float, float, float]
    """Velocity of the air [cm / s]."""

    def __post_init__(self) -> None:
        if np.shape(self.velocity) != (3,) or not (np.abs(self.velocity) <= MOST_SPEED).all():
            expected = f"expected three numbers of at most {MOST_SPEED:g} cm/s"
            raise ParameterError(f"wind: got velocity {self.velocity}; {expected}")

    @property
    def pressure(self) -> np.ndarray:
        """Force per area [dyn / cm^2], shape (3,)."""
        velocity = np.asarray(self.velocity, dtype=np.float64)
        return 0.5 * AIR * DRAG * float(np.linalg.norm(velocity)) * velocity

    def on(self, points: LoadedPoints) -> DeadLoad:
        """Return the wind on the points."""
        return DeadLoad("wind", points, self.pressure, points.areas())
