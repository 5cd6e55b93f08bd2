# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The mass matrix on a device, with the Eulerian coordinates of crossing yarns (Cirio et al. 2014).

A material point of a yarn moves with x' - w u' where the yarn slides with the velocity u', with w = dx/du. With the
masses m_u and m_v of the two yarns that are lumped in a node,

    T = 1/2 m_u |x' - w_u u'|^2 + 1/2 m_v |x' - w_v v'|^2,

    M = [[(m_u + m_v) I, -m_u w_u, -m_v w_v], [., m_u w_u . w_u, 0], [., ., m_v w_v . w_v]]   for (x, u, v).

The directions w are those at the beginning of a time step and stay constant within it. Without directions the Eulerian
coordinates have no mass.
"""

from __future__ import annotations

from typing import Any

import warp as wp

from stitchmesh.compute.captured import Launcher
from stitchmesh.compute.kernel import kernel
from stitchmesh.compute.precision import vector
from stitchmesh.mixed.dynamics.blended_masses import BlendedMasses
from stitchmesh.mixed.mixed_blocks import MixedBlocks
from stitchmesh.mixed.mixed_vector import MixedVector


@kernel
def combine_products(
    # model
    vertex_mass: wp.array[Any],
    yarn_mass: wp.array[Any],
    along_u: wp.array[Any],
    along_v: wp.array[Any],
    factors: wp.array[Any],
    # state in
    vertices: wp.array[Any],
    nodes: wp.array[Any],
    sliding: wp.array[Any],
    # state in and out
    vertex_product: wp.array[Any],
    node_product: wp.array[Any],
    sliding_product: wp.array[Any],
) -> None:
    """Replace H d by factor 1 times H d plus factor 0 times M d."""
    i = wp.tid()
    of_mass, of_stiffness = factors[0][0], factors[0][1]
    if i < vertices.shape[0]:
        vertex_product[i] = vertex_product[i] * of_stiffness + vertices[i] * (vertex_mass[i] * of_mass)
    else:
        j = i - vertices.shape[0]
        slide, mass = sliding[j], yarn_mass[j] * of_mass
        by_u = (nodes[j] - along_u[j] * slide[0]) * mass[0]
        by_v = (nodes[j] - along_v[j] * slide[1]) * mass[1]
        node_product[j] = node_product[j] * of_stiffness + by_u + by_v
        pull = type(slide)(wp.dot(along_u[j], by_u), wp.dot(along_v[j], by_v))
        sliding_product[j] = sliding_product[j] * of_stiffness - pull


@kernel
def combine_blocks(
    # model
    vertex_mass: wp.array[Any],
    yarn_mass: wp.array[Any],
    along_u: wp.array[Any],
    along_v: wp.array[Any],
    factors: wp.array[Any],
    # state in and out
    vertex_blocks: wp.array[Any],
    node_blocks: wp.array[Any],
    sliding_blocks: wp.array[Any],
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
        mass = yarn_mass[j] * of_mass
        node_block, pair = node_blocks[j] * of_stiffness, sliding_blocks[j] * of_stiffness
        for k in range(3):
            node_block[k, k] = node_block[k, k] + mass[0] + mass[1]
        pair[0, 0] = pair[0, 0] + mass[0] * wp.length_sq(along_u[j])
        pair[1, 1] = pair[1, 1] + mass[1] * wp.length_sq(along_v[j])
        node_blocks[j] = node_block
        sliding_blocks[j] = pair


class MassMatrix:
    """Masses on a device."""

    def __init__(self, masses: BlendedMasses, scalar: Any, device: wp.Device) -> None:
        """Send the masses to the device; the directions of yarns are zero."""
        self.total = masses.total
        self.vertices = wp.array(masses.vertices, dtype=scalar, device=device)
        self.yarns = wp.array(masses.yarns, dtype=vector(2, scalar), device=device)
        self.along_u = wp.zeros(len(masses.yarns), dtype=vector(3, scalar), device=device)
        self.along_v = wp.zeros_like(self.along_u)
        self._count = len(masses.vertices) + len(masses.yarns)

    def combine_products(
        self, factors: wp.array[Any], direction: MixedVector, product: MixedVector, launcher: Launcher
    ) -> list[Any]:
        """The launches that replace a product H d by factor 1 times H d plus factor 0 times M d.

        Args:
            factors: factor 0 [1/s^2] and factor 1 as one two-vector on the device, shape (1,).
            direction: d.
            product: H d, replaced.
            launcher: ``launch`` or ``prepare`` with the device bound.
        """
        inputs = [*self._constants(factors), direction.vertices, direction.nodes, direction.sliding]
        outputs = [product.vertices, product.nodes, product.sliding]
        return [launcher(combine_products, self._count, inputs, outputs)]

    def combine_blocks(self, factors: wp.array[Any], blocks: MixedBlocks, launcher: Launcher) -> list[Any]:
        """The launches that replace diagonal blocks of H by factor 1 times the block plus factor 0 times that of M."""
        outputs = [blocks.vertices, blocks.nodes, blocks.sliding]
        return [launcher(combine_blocks, self._count, self._constants(factors), outputs)]

    def _constants(self, factors: wp.array[Any]) -> list[Any]:
        return [self.vertices, self.yarns, self.along_u, self.along_v, factors]
