# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The weight of crossing yarns (Cirio et al. 2014, section 4.1).

A segment between two nodes holds yarn of the rest length D = u1 - u0 and the mass rho D:

    E = - rho D g . (x0 + x1) / 2

Yarn that slides to another segment changes its height, so gravity also acts on the coordinates: a yarn that hangs over
a crossing runs to its heavier side. The Hessian couples D with the positions and is not positive; the matrix that is
never negative is zero. The coupling rho g is about 20 dyn/cm, against 1e5 dyn/cm of stretch, and products leave it out.
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
from stitchmesh.mixed.crossings.crossing_elements import CrossingElements
from stitchmesh.mixed.crossings.star.star import coordinate_of, leg_vector
from stitchmesh.mixed.mixed_vector import MixedVector
from stitchmesh.mixed.term import EARTH, MixedTerm


@wp.func
def density_of(link: int, k: int, i: int, density: wp.array2d[Any]) -> Any:
    """Linear density [g/cm] of the segment of leg k of node i, positive after the node and negative before it."""
    result = density[i, k // 2]
    if k % 2 == 1:
        result = -density[link // 2, link % 2]
    return result


@kernel
def find_weight_energies(
    # model
    link: wp.array2d[wp.int32],
    density: wp.array2d[Any],
    acceleration: Any,
    # state in
    nodes: wp.array[Any],
    sliding: wp.array[Any],
    # state out
    energy: wp.array[wp.float64],
) -> None:
    """Potential energy [erg] of the segments after each node."""
    i = wp.tid()
    total = wp.float64(0.0)
    for c in range(2):
        after = link[i, 2 * c]
        if after >= 0:
            own = sliding[i][c]
            mass = density[i, c] * (coordinate_of(after, sliding, own) - own)
            middle = nodes[i] + leg_vector(after, nodes, nodes[i]) * type(own)(0.5)
            total -= wp.float64(mass * wp.dot(acceleration, middle))
    energy[i] = total


@kernel
def add_yarn_weights(
    # model
    link: wp.array2d[wp.int32],
    slides: wp.array[Any],
    density: wp.array2d[Any],
    acceleration: Any,
    # state in
    nodes: wp.array[Any],
    sliding: wp.array[Any],
    # state out
    on_nodes: wp.array[Any],
    on_sliding: wp.array[Any],
) -> None:
    """Add the weight of the yarn around each node, on its position and its coordinates."""
    i = wp.tid()
    half = type(sliding[i][0])(0.5)
    on_coordinates = type(slides[i])()
    mass = half - half
    n = int(4)
    for k in range(n):
        if link[i, k] >= 0:
            own = sliding[i][k // 2]
            signed = density_of(link[i, k], k, i, density)
            mass += half * signed * (coordinate_of(link[i, k], sliding, own) - own)
            middle = nodes[i] + leg_vector(link[i, k], nodes, nodes[i]) * half
            on_coordinates[k // 2] -= signed * wp.dot(acceleration, middle)
    on_nodes[i] += acceleration * mass
    on_sliding[i] += wp.cw_mul(on_coordinates, slides[i])


class YarnGravity(MixedTerm):
    """The weight of crossing yarns on a device; the energy is relative to the origin."""

    name = "weight of crossing yarns"
    acts_on = "nodes"

    def __init__(
        self,
        elements: CrossingElements,
        scalar: Any,
        device: wp.Device,
        acceleration: ArrayLike = EARTH,
    ) -> None:
        """Put the densities on a device.

        Args:
            elements: the yarns.
            scalar: Warp's floating-point type.
            device: where the term lies.
            acceleration: acceleration by gravity [cm/s^2], shape (3,).

        Raises:
            ParameterError: the acceleration is not three finite numbers.
        """
        pull = np.asarray(acceleration, dtype=np.float64)
        if pull.shape != (3,) or not np.isfinite(pull).all():
            raise ParameterError(f"gravity: got the acceleration {pull.tolist()}; expected three finite numbers")
        self.count, self.device = elements.count, device
        self._link = wp.array(elements.link.astype(np.int32), dtype=wp.int32, device=device)
        self._slides = wp.array(elements.slides.astype(np.float64), dtype=vector(2, scalar), device=device)
        self._density = wp.array(elements.density, dtype=scalar, device=device)
        self._acceleration = vector(3, scalar)(*pull)
        self._energy = wp.zeros(self.count, dtype=wp.float64, device=device)

    def element_energies(self, state: MixedVector, launcher: Launcher) -> tuple[list[Any], wp.array[Any]]:
        """The launch that finds the energy of the segments of each node, and the array of the energies."""
        if self.count == 0:
            return [], self._energy
        inputs = [self._link, self._density, self._acceleration, state.nodes, state.sliding]
        return [launcher(find_weight_energies, self.count, inputs, [self._energy])], self._energy

    def forces(self, state: MixedVector, force: MixedVector, launcher: Launcher) -> list[Any]:
        """The launch that adds the weights."""
        if self.count == 0:
            return []
        inputs = [self._link, self._slides, self._density, self._acceleration, state.nodes, state.sliding]
        return [launcher(add_yarn_weights, self.count, inputs, [force.nodes, force.sliding])]

    def linearize(self, state: MixedVector, launcher: Launcher) -> list[Any]:
        """No launch: the Hessian is left out."""
        return []

    def products(self, direction: MixedVector, product: MixedVector, launcher: Launcher) -> list[Any]:
        """No launch: the products are zero."""
        return []
