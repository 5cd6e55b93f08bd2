# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The mass matrix on a device, with the Eulerian coordinates of crossing yarns (Cirio et al. 2014).

A material point of a yarn moves with x' - w u' where the yarn slides with the velocity u', with w = dx/du. With the
masses m_u and m_v of the two yarns that are lumped in a node, T = 1/2 m_u |x' - w_u u'|^2 + 1/2 m_v |x' - w_v v'|^2 is
the energy of a symmetric block of 5 x 5 for (x, u, v):

    [[m I, c_u, c_v], [c_u', d_u, 0], [c_v', 0, d_v]],    m = m_u + m_v,  c_u = -m_u w_u,  d_u = m_u w_u . w_u.

The blocks are those at the beginning of a time step and stay constant within it. Vertices have a mass each.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, Protocol

import numpy as np
import warp as wp
from numpy.typing import NDArray

from stitchmesh.compute.captured import Launcher
from stitchmesh.compute.kernel import kernel
from stitchmesh.compute.partial_sums import chunk_of, part_count, parts_for
from stitchmesh.compute.precision import vector
from stitchmesh.compute.thread_block import THREADS, Slots, sum_over_block
from stitchmesh.mixed.dynamics.blended_masses import BlendedMasses
from stitchmesh.mixed.mixed_blocks import MixedBlocks
from stitchmesh.mixed.mixed_vector import MixedVector


@kernel
def combine_products(
    # model
    vertex_mass: wp.array[Any],
    node_mass: wp.array[Any],
    coupling_u: wp.array[Any],
    coupling_v: wp.array[Any],
    sliding_mass: wp.array[Any],
    factors: wp.array[Any],
    chunk: int,
    # state in
    vertices: wp.array[Any],
    nodes: wp.array[Any],
    sliding: wp.array[Any],
    # state in and out
    vertex_product: wp.array[Any],
    node_product: wp.array[Any],
    sliding_product: wp.array[Any],
    # state out
    parts: wp.array2d[wp.float64],
) -> None:
    """Replace H d by A d, factor 1 times H d plus factor 0 times M d; and find the parts of d . A d."""
    block, lane = wp.tid()
    of_mass, of_stiffness = factors[0][0], factors[0][1]
    vertex_count = vertices.shape[0]
    sums = Slots()
    for i in range(block * chunk + lane, wp.min((block + 1) * chunk, vertex_count + nodes.shape[0]), wp.block_dim()):
        if i < vertex_count:
            force = vertex_product[i] * of_stiffness + vertices[i] * (vertex_mass[i] * of_mass)
            vertex_product[i] = force
            sums[0] += wp.float64(wp.dot(force, vertices[i]))
        else:
            j = i - vertex_count
            x, slide = nodes[j] * of_mass, sliding[j] * of_mass
            push = x * node_mass[j] + coupling_u[j] * slide[0] + coupling_v[j] * slide[1]
            pull = type(slide)(wp.dot(coupling_u[j], x), wp.dot(coupling_v[j], x)) + wp.cw_mul(sliding_mass[j], slide)
            push += node_product[j] * of_stiffness
            pull += sliding_product[j] * of_stiffness
            node_product[j] = push
            sliding_product[j] = pull
            sums[0] += wp.float64(wp.dot(push, nodes[j])) + wp.float64(wp.dot(pull, sliding[j]))
    sum_over_block(sums, parts[block])


@kernel
def combine_blocks(
    # model
    vertex_mass: wp.array[Any],
    node_mass: wp.array[Any],
    coupling_u: wp.array[Any],
    coupling_v: wp.array[Any],
    sliding_mass: wp.array[Any],
    factors: wp.array[Any],
    # state in and out
    vertex_blocks: wp.array[Any],
    node_blocks: wp.array[Any],
    sliding_blocks: wp.array[Any],
    block_u: wp.array[Any],
    block_v: wp.array[Any],
) -> None:
    """Replace diagonal blocks of H by factor 1 times the block plus factor 0 times that of M."""
    i = wp.tid()
    of_mass, of_stiffness = factors[0][0], factors[0][1]
    if i < vertex_blocks.shape[0]:
        block = vertex_blocks[i] * of_stiffness
        for k in range(3):
            block[k, k] = block[k, k] + vertex_mass[i] * of_mass
        vertex_blocks[i] = block
    else:
        j = i - vertex_blocks.shape[0]
        node_block, pair = node_blocks[j] * of_stiffness, sliding_blocks[j] * of_stiffness
        for k in range(3):
            node_block[k, k] = node_block[k, k] + node_mass[j] * of_mass
        for k in range(2):
            pair[k, k] = pair[k, k] + sliding_mass[j][k] * of_mass
        node_blocks[j] = node_block
        sliding_blocks[j] = pair
        block_u[j] = block_u[j] * of_stiffness + coupling_u[j] * of_mass
        block_v[j] = block_v[j] * of_stiffness + coupling_v[j] * of_mass


class NodeMasses(Protocol):
    """Blocks of the mass matrix at the nodes, on a device."""

    @property
    def mass(self) -> wp.array[Any]:
        """The mass m of each node [g], shape (n,)."""

    @property
    def coupling(self) -> Sequence[wp.array[Any]]:
        """The couplings c_u and c_v of each node [g], shape (n,) each."""

    @property
    def sliding_mass(self) -> wp.array[Any]:
        """The masses d_u and d_v of each node [g], two-vectors; shape (n,)."""

    def update_launches(self, state: MixedVector, launcher: Launcher) -> list[Any]:
        """The launches that find the blocks at a state."""


class ConstantNodeMasses:
    """Masses of nodes without Eulerian coordinates."""

    def __init__(self, mass: NDArray[np.float64], scalar: Any, device: wp.Device) -> None:
        """Send masses [g], shape (n,), to the device."""
        count = len(mass)
        self.mass = wp.array(mass, dtype=scalar, device=device)
        self.coupling = [wp.zeros(count, dtype=vector(3, scalar), device=device) for _ in range(2)]
        self.sliding_mass = wp.zeros(count, dtype=vector(2, scalar), device=device)

    def update_launches(self, state: MixedVector, launcher: Launcher) -> list[Any]:
        """Nothing: the masses are constant."""
        return []


class MassMatrix:
    """Masses on a device."""

    def __init__(self, masses: BlendedMasses, scalar: Any, device: wp.Device, nodes: NodeMasses | None = None) -> None:
        """Send masses to the device.

        Args:
            masses: masses of vertices and nodes.
            scalar: Warp's floating-point type.
            device: where the masses lie.
            nodes: blocks of the nodes; by default their masses, without inertia of the Eulerian coordinates.
        """
        self.total = masses.total
        self.vertices = wp.array(masses.vertices, dtype=scalar, device=device)
        self.nodes: NodeMasses = nodes or ConstantNodeMasses(masses.nodes, scalar, device)
        self._count, self._device = len(self.vertices) + len(self.nodes.mass), device
        self._parts = parts_for(self._count, device)

    def combine_products(
        self,
        factors: wp.array[Any],
        direction: MixedVector,
        product: MixedVector,
        launcher: Launcher,
        parts: wp.array[Any] | None = None,
    ) -> list[Any]:
        """The launches that replace a product H d by factor 1 times H d plus factor 0 times M d.

        Args:
            factors: factor 0 [1/s^2] and factor 1 as one two-vector on the device, shape (1,).
            direction: d.
            product: H d, replaced.
            launcher: ``launch`` or ``prepare`` with the device bound.
            parts: set to the parts of the dot product of the direction and the result.
        """
        chunk = chunk_of(self._count, self._device)
        inputs = [*self._constants(factors), chunk, direction.vertices, direction.nodes, direction.sliding]
        outputs = [product.vertices, product.nodes, product.sliding, self._parts if parts is None else parts]
        count = part_count(self._count, self._device)
        return [launcher(combine_products, count, inputs, outputs, tile=THREADS)]

    def combine_blocks(self, factors: wp.array[Any], blocks: MixedBlocks, launcher: Launcher) -> list[Any]:
        """The launches that replace diagonal blocks of H by factor 1 times the block plus factor 0 times that of M."""
        outputs = [blocks.vertices, blocks.nodes, blocks.sliding, blocks.coupling_u, blocks.coupling_v]
        return [launcher(combine_blocks, self._count, self._constants(factors), outputs)]

    def _constants(self, factors: wp.array[Any]) -> list[Any]:
        return [self.vertices, self.nodes.mass, *self.nodes.coupling, self.nodes.sliding_mass, factors]
