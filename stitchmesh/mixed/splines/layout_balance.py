# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Loads that keep the yarns of the hybrid region in the balance in which they were laid out.

A loop at rest is bent, and the loops that it holds and is held by keep it so. In the hybrid region the weights of these
energies differ from loop to loop, and at its outer border loops miss the yarn beyond. Without more, such loops would
open. Each node i therefore bears the load

    c_i = alpha_i f_i - g_i        [dyn]

where f_i is the force of all yarns at full weight on the node at the layout, zero for yarns at rest, and g_i that of the
blended energy there. Such dead loads are known from couplings of atoms and continua (Shenoy et al. 1999, *An adaptive
finite element approach to atomic-scale mechanics*, section 3.2). A load turns with a triangle of the hybrid region, the
node's own or the nearest one, so that a cloth that turns stays in balance. Within an iteration of the solver loads are
constant, and have the energy

    E = - sum over i of  c_i . p_i        [erg]

The frame of a triangle is its first side, its normal, and what is perpendicular to both.
"""

from __future__ import annotations

from functools import partial
from typing import Any

import numpy as np
import warp as wp
from numpy.typing import NDArray

from stitchmesh.compute.captured import Launcher
from stitchmesh.compute.kernel import kernel
from stitchmesh.compute.launch import launch
from stitchmesh.compute.precision import vector
from stitchmesh.compute.reduction import ordered_sum
from stitchmesh.mixed.mixed_vector import MixedVector
from stitchmesh.mixed.splines.spline_kernels import add_to_nodes
from stitchmesh.mixed.term import Term

Numbers = NDArray[np.float64]
Integers = NDArray[np.int64]


@kernel
def turn_loads(
    # model
    corners: wp.array[wp.vec3i],
    local: wp.array[Any],
    # state in
    vertices: wp.array[Any],
    # state out
    load: wp.array[Any],
) -> None:
    """The load of each node, turned with its triangle."""
    k = wp.tid()
    corner = corners[k]
    side, other = vertices[corner[1]] - vertices[corner[0]], vertices[corner[2]] - vertices[corner[0]]
    along, normal = wp.normalize(side), wp.normalize(wp.cross(side, other))
    c = local[k]
    load[k] = along * c[0] + wp.cross(normal, along) * c[1] + normal * c[2]


@kernel
def load_energies(
    # model
    node: wp.array[wp.int32],
    # state in
    load: wp.array[Any],
    nodes: wp.array[Any],
    # state out
    energy: wp.array[Any],
) -> None:
    """Energy of each load [erg]."""
    k = wp.tid()
    energy[k] = -wp.dot(load[k], nodes[node[k]])


class LayoutBalance(Term):
    """The loads of some nodes, on a device."""

    name = "balance"

    def __init__(
        self, node: Integers, corners: Integers, load: Numbers, vertices: Numbers, scalar: Any, device: wp.Device
    ) -> None:
        """Store the loads in the frames of their triangles.

        Args:
            node: the simulated nodes with a load, shape (n,); none occurs twice.
            corners: vertices of the triangle with which each load turns, shape (n, 3).
            load: loads at the layout [dyn], shape (n, 3).
            vertices: positions of the vertices at the layout [cm], shape (V, 3).
            scalar: Warp's floating-point type.
            device: where the kernels run.
        """
        kind = vector(3, scalar)
        local = np.einsum("nij,nj->ni", triangle_frames(vertices[corners]), load)
        self._node = wp.array(node, dtype=wp.int32, device=device)
        self._corners = wp.array(corners.astype(np.int32), dtype=wp.vec3i, device=device)
        self._local, self._load = wp.array(local, dtype=kind, device=device), wp.array(load, dtype=kind, device=device)
        self._energy = wp.zeros(len(node), dtype=scalar, device=device)
        self._one, self._launch = scalar(1.0), partial(launch, device=device)

    def energy(self, state: MixedVector) -> float:
        """Energy of the loads as they are since the last ``begin_step`` [erg]."""
        self._launch(load_energies, len(self._node), [self._node, self._load, state.nodes], [self._energy])
        return ordered_sum(self._energy)

    def forces(self, state: MixedVector, force: MixedVector, launcher: Launcher) -> list[Any]:
        """The launch that adds the loads."""
        return [launcher(add_to_nodes, len(self._node), [self._node, self._one, self._load], [force.nodes])]

    def linearize(self, state: MixedVector, launcher: Launcher) -> list[Any]:
        """Nothing: the loads are constant."""
        return []

    def products(self, direction: MixedVector, product: MixedVector, launcher: Launcher) -> list[Any]:
        """Nothing: the Hessian is zero."""
        return []

    def begin_step(self, state: MixedVector, time: float, time_step: float) -> None:
        """Turn the loads with their triangles."""
        self._launch(turn_loads, len(self._node), [self._corners, self._local, state.vertices], [self._load])


def triangle_frames(corners: Numbers) -> Numbers:
    """Return the frame of each triangle, rows along its first side, across it and along the normal, shape (n, 3, 3).

    Args:
        corners: positions of the corners [cm], shape (n, 3, 3).
    """
    side, other = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    normal = np.cross(side, other)
    along = side / np.linalg.norm(side, axis=1, keepdims=True)
    normal = normal / np.linalg.norm(normal, axis=1, keepdims=True)
    return np.stack([along, np.cross(normal, along), normal], axis=1)
