# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Gravity: the weight of the yarns, a dead load on their control points (L, appendix B).

The weight acts along the curve, and the masses of the control points (``material``) contain all of it:

    E = - sum over segments of  m l int g . y(s) ds = - sum over control points of  m_j g . q_j        [erg]

Heights are relative to the middle of the given yarns. The y axis points up.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import warp as wp
from numpy.typing import NDArray

from stitchmesh.compute.captured import Launcher
from stitchmesh.compute.kernel import kernel
from stitchmesh.compute.precision import vector
from stitchmesh.compute.reduction import ordered_sum
from stitchmesh.errors import ParameterError
from stitchmesh.yarnrelax.collision.narrow_phase import Candidates
from stitchmesh.yarnrelax.energies.term import Term, TermChoice
from stitchmesh.yarnrelax.model.constants import Model
from stitchmesh.yarnrelax.model.material import point_masses
from stitchmesh.yarnrelax.model.state import State

STANDARD = (0.0, -981.0, 0.0)
"""Acceleration on Earth [cm / s^2]; y points up."""
MOST_ACCELERATION = 1e6
"""Largest acceleration along an axis [cm / s^2], a thousand times the one on Earth; more makes time steps tiny."""


@kernel
def add_weights(
    # model
    mass: wp.array[Any],
    acceleration: Any,
    # state out
    external_force: wp.array[Any],
) -> None:
    """Add the weight of each control point [erg / unit]."""
    i = wp.tid()
    external_force[i] += acceleration * mass[i]


@kernel
def weight_energies(
    # model
    mass: wp.array[Any],
    acceleration: Any,
    # state in
    points: wp.array[Any],
    # state out
    point_energy: wp.array[Any],
) -> None:
    """Potential energy [erg] of each control point."""
    i = wp.tid()
    point_energy[i] = -mass[i] * wp.dot(acceleration, points[i])


@dataclass(frozen=True)
class Gravity(TermChoice):
    """The weight of the yarns, from ``point_masses``; on a lattice the weight of one cell.

    Raises:
        ParameterError: the acceleration is not three numbers, or one is above ``MOST_ACCELERATION``.
    """

    reads_mass = True

    acceleration: tuple[float, float, float] = STANDARD
    """Acceleration [cm / s^2]; y points up."""

    def __post_init__(self) -> None:
        if np.shape(self.acceleration) != (3,) or not (np.abs(self.acceleration) <= MOST_ACCELERATION).all():
            found = f"gravity: got acceleration {self.acceleration}"
            raise ParameterError(f"{found}; expected three numbers of at most {MOST_ACCELERATION:g} cm/s^2")

    def on(self, model: Model) -> Term:
        """Return the weight of a model's yarns.

        Raises:
            ParameterError: a yarn has no mass.
        """
        return _Weight(model, self.acceleration)


class _Weight(Term):
    """Gravity on a device."""

    name = "gravity"
    gives_hessian = True

    def __init__(self, model: Model, acceleration: tuple[float, float, float]) -> None:
        self.model = model
        self.mass = model.upload(point_masses(model))
        # the acceleration in cm of height becomes one in units: mass times this is a force [erg / unit]
        self.acceleration = vector(3, model.scalar)(*(float(a) * model.unit for a in acceleration))

    def forces(self, state: State, candidates: Candidates, launcher: Launcher) -> list[Any]:
        """Return the launch that adds the weights to ``state.external_force``."""
        return [launcher(add_weights, self.model.point_count, [self.mass, self.acceleration], [state.external_force])]

    def energy(self, state: State, candidates: Candidates) -> float:
        """Potential energy [erg] relative to the middle of the given yarns."""
        energy = self.model.empty(self.model.point_count)
        inputs = [self.mass, self.acceleration, state.points]
        self.model.launch(weight_energies, self.model.point_count, inputs, [energy])
        return ordered_sum(energy)

    def stiffness(self) -> NDArray[np.float64]:
        """Zero, because the force does not depend on the position."""
        return np.zeros(self.model.point_count)
