# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Gravity on the vertices: E = - sum of m_i g . x_i [erg], with the lumped masses of ``vertex_mass``."""

from __future__ import annotations

from typing import Any

import numpy as np
import warp as wp
from numpy.typing import ArrayLike

from stitchmesh.compute.captured import Launcher
from stitchmesh.compute.launch import launch
from stitchmesh.compute.precision import vector
from stitchmesh.compute.reduction import ordered_sum
from stitchmesh.errors import ParameterError
from stitchmesh.mixed.mixed_vector import MixedVector
from stitchmesh.mixed.term import Term
from stitchmesh.yarnrelax.energies.gravity import STANDARD, add_weights, weight_energies


class VertexWeight(Term):
    """The weight of the vertices, on a device."""

    name = "weight of triangles"

    def __init__(
        self, mass: ArrayLike, scalar: Any, device: wp.Device, acceleration: tuple[float, float, float] = STANDARD
    ) -> None:
        """Upload the masses.

        Args:
            mass: mass of each vertex [g], shape (V,).
            scalar: Warp's floating-point type.
            device: where the kernels run.
            acceleration: acceleration of gravity [cm / s^2]; y points up.

        Raises:
            ParameterError: a mass is negative or not finite, or the acceleration is not three finite numbers.
        """
        masses = np.asarray(mass, dtype=np.float64)
        bad = np.flatnonzero(~(np.isfinite(masses) & (masses >= 0.0)))
        if masses.ndim != 1 or len(bad):
            found = f"vertex {bad[0]} has {masses.ravel()[bad[0]]:g} g" if len(bad) else f"got shape {masses.shape}"
            raise ParameterError(f"weight of triangles: {found}; expected one mass of at least 0 for each vertex")
        if np.shape(acceleration) != (3,) or not np.isfinite(acceleration).all():
            raise ParameterError(f"weight of triangles: acceleration is {acceleration}; expected three finite numbers")
        self.device = device
        self._mass = wp.array(masses, dtype=scalar, device=device)
        self._acceleration = vector(3, scalar)(*(float(a) for a in acceleration))
        self._energy = wp.zeros(len(masses), dtype=scalar, device=device)

    def energy(self, state: MixedVector) -> float:
        """Potential energy [erg], zero at height 0."""
        inputs = [self._mass, self._acceleration, state.vertices]
        launch(weight_energies, len(self._mass), inputs, [self._energy], self.device)
        return ordered_sum(self._energy)

    def forces(self, state: MixedVector, force: MixedVector, launcher: Launcher) -> list[Any]:
        """The launch that adds the weights."""
        if len(self._mass) == 0:
            return []
        return [launcher(add_weights, len(self._mass), [self._mass, self._acceleration], [force.vertices])]

    def linearize(self, state: MixedVector, launcher: Launcher) -> list[Any]:
        """No launch: the Hessian is zero."""
        return []

    def products(self, direction: MixedVector, product: MixedVector, launcher: Launcher) -> list[Any]:
        """No launch: the Hessian is zero."""
        return []
