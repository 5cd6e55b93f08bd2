# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Weight of the mixed system: a dead load on vertices and nodes, from the same lumped masses as the inertia.

    E = - sum over vertices m_i g . v_i - sum over nodes m_j g . p_j        [erg]

Masses are already blended (``mass_matrix``), so a system in free fall has the acceleration g everywhere. The Eulerian
coordinates have no weight here: the yarn model adds the weight of yarn that slides up or down.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import warp as wp
from numpy.typing import ArrayLike

from stitchmesh.compute.captured import Launcher
from stitchmesh.compute.kernel import kernel
from stitchmesh.compute.precision import vector
from stitchmesh.errors import ParameterError
from stitchmesh.mixed.dynamics.mass_matrix import MassMatrix
from stitchmesh.mixed.mixed_vector import MixedVector
from stitchmesh.mixed.term import EARTH, MixedTerm


@kernel
def add_weights(
    # model
    vertex_mass: wp.array[Any],
    node_mass: wp.array[Any],
    acceleration: Any,
    # state in and out
    vertices: wp.array[Any],
    nodes: wp.array[Any],
) -> None:
    """Add the weight of each vertex and node [dyn]."""
    i = wp.tid()
    if i < vertices.shape[0]:
        vertices[i] = vertices[i] + acceleration * vertex_mass[i]
    else:
        j = i - vertices.shape[0]
        nodes[j] = nodes[j] + acceleration * node_mass[j]


@kernel
def weight_energies(
    # model
    vertex_mass: wp.array[Any],
    node_mass: wp.array[Any],
    acceleration: Any,
    # state in
    vertices: wp.array[Any],
    nodes: wp.array[Any],
    # state out
    energy: wp.array[Any],
) -> None:
    """Potential energy [erg] of each vertex and node."""
    i = wp.tid()
    if i < vertices.shape[0]:
        energy[i] = -vertex_mass[i] * wp.dot(acceleration, vertices[i])
    else:
        j = i - vertices.shape[0]
        energy[i] = -node_mass[j] * wp.dot(acceleration, nodes[j])


class Weight(MixedTerm):
    """The weight of all masses."""

    name = "weight"

    def __init__(self, mass: MassMatrix, acceleration: ArrayLike = EARTH) -> None:
        """Weight for an acceleration [cm/s^2], shape (3,); the y axis points up.

        Raises:
            ParameterError: the acceleration is not three finite numbers.
        """
        given = np.asarray(acceleration, dtype=np.float64)
        if given.shape != (3,) or not np.isfinite(given).all():
            raise ParameterError(f"weight: got the acceleration {acceleration!r}; expected three finite numbers")
        scalar = mass.vertices.dtype
        self._constants = [mass.vertices, mass.nodes.mass, vector(3, scalar)(*given.tolist())]
        self._energy = wp.zeros(len(mass.vertices) + len(mass.nodes.mass), dtype=scalar, device=mass.vertices.device)

    def element_energies(self, state: MixedVector, launcher: Launcher) -> tuple[list[Any], wp.array[Any]]:
        """The launch that finds the energy of each vertex and node, and the array of the energies."""
        inputs = [*self._constants, state.vertices, state.nodes]
        return [launcher(weight_energies, len(self._energy), inputs, [self._energy])], self._energy

    def forces(self, state: MixedVector, force: MixedVector, launcher: Launcher) -> list[Any]:
        """The launch that adds the weights."""
        return [launcher(add_weights, len(self._energy), self._constants, [force.vertices, force.nodes])]

    def linearize(self, state: MixedVector, launcher: Launcher) -> list[Any]:
        """No launch: the force is constant."""
        return []

    def products(self, direction: MixedVector, product: MixedVector, launcher: Launcher) -> list[Any]:
        """No launch: the Hessian is zero."""
        return []
