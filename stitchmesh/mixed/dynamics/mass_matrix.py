# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The mass matrix on a device, with the Eulerian coordinates of crossing yarns (Cirio et al. 2014).

A material point of a yarn moves with x' - w u' where the yarn slides with the velocity u', with w = dx/du. Let m_u and
m_v be the masses of the two yarns that are lumped in a node. The energy
T = 1/2 m_u |x' - w_u u'|^2 + 1/2 m_v |x' - w_v v'|^2 then belongs to a symmetric block of 5 x 5 for (x, u, v):

    [[m I, c_u, c_v], [c_u', d_u, 0], [c_v', 0, d_v]],    m = m_u + m_v,  c_u = -m_u w_u,  d_u = m_u w_u . w_u.

The blocks are computed at the beginning of a time step and stay constant within it. Each vertex has one mass.

*Blending.* The masses of vertices and nodes come from the masses of yarn segments (Casafranca et al. 2020, section
4.2). Each segment gives the part alpha of its mass to its two nodes, half of it to each, with alpha at the centroid of
the segment. The part 1 - alpha goes to vertices, by barycentric coordinates: to the vertices of the triangle of each
end whose alpha is between 0 and 1. Where a segment leaves the hybrid region for a triangle without yarns, its alpha is
0; half of its mass goes to the vertices, and the density of that triangle contains the other half. Triangles without
yarns, and hybrid triangles that hold no node, get their mass from the density of the cloth, times 1 - alpha, a third
for each vertex.

*Lumping.* The mass matrix is diagonal except for the Eulerian coordinates, the preconditioner inverts it exactly, and a
product with it reads no neighbours. The consistent matrix of a segment (Cirio et al. 2014) differs from it by terms of
the order of the square of the spacing of crossings over the length of a wave.

*Loads.* Gravity acts on vertices and nodes by the same lumped masses as the inertia, so a system in free fall has the
acceleration g everywhere. The Eulerian coordinates have no weight here: the yarn model adds the weight of yarn that
slides up or down.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np
import warp as wp
from numpy.typing import ArrayLike, NDArray

from stitchmesh.compute.captured import Launcher
from stitchmesh.compute.kernel import kernel
from stitchmesh.compute.partial_sums import chunk_of, part_count, parts_for
from stitchmesh.compute.precision import Mat22, Mat33, Scalar, ScalarType, Vec2, Vec3, vector
from stitchmesh.compute.thread_block import THREADS, Slots, sum_over_block
from stitchmesh.errors import ParameterError
from stitchmesh.mixed.enrichment.region import HYBRID, TRIANGLES, Region, numbers_below
from stitchmesh.mixed.mixed_vector import MixedBlocks, MixedVector
from stitchmesh.mixed.term import FULL

Numbers = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class BlendedMasses:
    """Lumped masses [g]; arrays are read-only."""

    vertices: Numbers
    """Mass of each triangle vertex, shape (V,)."""
    yarns: Numbers
    """Mass of the u yarn and of the v yarn at each simulated node, shape (n, 2)."""

    def __post_init__(self) -> None:
        for name, array in (("vertices", self.vertices), ("yarns", self.yarns)):
            if not np.isfinite(array).all() or (array < 0.0).any():
                raise ParameterError(
                    f"masses: {name}: got a mass that is negative or not finite; expected at least 0 g"
                )
            array.flags.writeable = False

    @property
    def nodes(self) -> Numbers:
        """Mass of each simulated node, shape (n,)."""
        return self.yarns.sum(axis=1)

    @property
    def total(self) -> float:
        """Mass of the whole system [g]."""
        return float(self.vertices.sum() + self.yarns.sum())


@dataclass(frozen=True, eq=False)
class FabricPoints:
    """The vertices and nodes of a fabric, on which dead loads act (``simulation.term.LoadedPoints``)."""

    lumped: BlendedMasses
    """Their masses."""
    area: float
    """Area of the whole fabric [cm^2], of which each point has the part of its mass in the whole mass."""
    scalar: ScalarType
    """Warp's floating-point type."""
    device: wp.Device
    """Where the loads lie."""
    unit: float = 1.0
    """Unit of length of the coordinates [cm]."""

    def masses(self) -> list[Numbers]:
        """Masses of the vertices, shape (V,), and of the nodes, shape (n,) [g]."""
        return [self.lumped.vertices, self.lumped.nodes]

    def areas(self) -> list[Numbers]:
        """Areas of the vertices and of the nodes [cm^2], in the shapes of ``masses``."""
        return [mass * (self.area / self.lumped.total) for mass in self.masses()]


def blend_masses(
    region: Region,
    segments: ArrayLike,
    segment_mass: ArrayLike,
    segment_coordinate: ArrayLike,
    triangle_mass: ArrayLike,
    segment_alpha: ArrayLike | None = None,
) -> BlendedMasses:
    """The masses of a region.

    Args:
        region: the region of interest.
        segments: layout numbers of both nodes of each yarn segment, shape (E, 2).
        segment_mass: mass of each segment [g], shape (E,).
        segment_coordinate: 0 where the segment is part of the u yarn of the node, 1 for the v yarn, shape (E, 2).
        triangle_mass: mass of each triangle of the cloth [g], shape (T,).
        segment_alpha: weight of each segment, shape (E,); by default alpha at the centroid of its two nodes.

    Raises:
        ParameterError: shapes do not agree, or a mass is negative or not finite.
    """
    ends = numbers_below("nodes of the segments", segments, len(region.node_triangle)).reshape(-1, 2)
    mass, of_triangles = np.asarray(segment_mass, dtype=np.float64), np.asarray(triangle_mass, dtype=np.float64)
    coordinate = numbers_below("coordinates of the segments", segment_coordinate, 2).reshape(-1, 2)
    shapes = (mass.shape, coordinate.shape, of_triangles.shape)
    if shapes != ((len(ends),), ends.shape, (len(region.triangles),)):
        expected = ((len(ends),), ends.shape, (len(region.triangles),))
        raise ParameterError(f"masses: got segments and triangles of shapes {shapes}; expected {expected}")
    alpha = region.element_alpha(ends) if segment_alpha is None else np.asarray(segment_alpha, dtype=np.float64)
    kind = region.node_kind[ends]
    yarns = np.zeros((len(region.nodes), 2))
    kept = (alpha > 0.0)[:, None] & (kind != TRIANGLES)
    half = np.broadcast_to((mass * alpha / 2.0)[:, None], ends.shape)
    np.add.at(yarns, (region.node_number[ends[kept]], coordinate[kept]), half[kept])
    vertices = _cloth_masses(region, of_triangles)
    # Nodes at alpha = 1 lie on the border of the region with yarns alone, and keep their mass.
    hybrid = (kind == HYBRID) & (region.node_alpha[ends] < FULL)
    # Half of the mass of a segment that leaves the hybrid region for a triangle without yarns is already in that
    # triangle.
    inside = mass * (1.0 - alpha) * np.where((kind == TRIANGLES).any(axis=1), 0.5, 1.0)
    share = np.where(hybrid, (inside / np.maximum(hybrid.sum(axis=1), 1))[:, None], 0.0)
    node = ends[hybrid]
    corners = region.triangles[region.node_triangle[node]]
    # a control point beyond a border of the cloth has a negative coordinate there
    within = np.maximum(region.node_weight[node], 0.0)
    np.add.at(vertices, corners, within * (share[hybrid] / within.sum(axis=1))[:, None])
    return BlendedMasses(vertices, yarns)


def _cloth_masses(region: Region, triangle_mass: Numbers) -> Numbers:
    """Masses of the vertices from the density of the cloth, shape (V,); triangles with the mass of yarns add none."""
    empty = np.ones(len(region.triangles), dtype=bool)
    empty[region.node_triangle] = False
    by_density = (region.triangle_kind == TRIANGLES) | ((region.triangle_kind == HYBRID) & empty)
    share = np.where(by_density, (1.0 - region.triangle_alpha) * triangle_mass / 3.0, 0.0)
    vertices = np.zeros(len(region.vertex_alpha))
    np.add.at(vertices, region.triangles, share[:, None])
    return vertices


@kernel(tile=THREADS)
def combine_products(
    # model
    vertex_mass: wp.array[Scalar],
    node_mass: wp.array[Scalar],
    coupling_u: wp.array[Vec3],
    coupling_v: wp.array[Vec3],
    sliding_mass: wp.array[Vec2],
    factors: wp.array[Vec2],
    chunk: int,
    # state in
    vertices: wp.array[Vec3],
    nodes: wp.array[Vec3],
    sliding: wp.array[Vec2],
    # state in and out
    vertex_product: wp.array[Vec3],
    node_product: wp.array[Vec3],
    sliding_product: wp.array[Vec2],
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
    vertex_mass: wp.array[Scalar],
    node_mass: wp.array[Scalar],
    coupling_u: wp.array[Vec3],
    coupling_v: wp.array[Vec3],
    sliding_mass: wp.array[Vec2],
    factors: wp.array[Vec2],
    # state in and out
    vertex_blocks: wp.array[Mat33],
    node_blocks: wp.array[Mat33],
    sliding_blocks: wp.array[Mat22],
    block_u: wp.array[Vec3],
    block_v: wp.array[Vec3],
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

    def __init__(self, mass: NDArray[np.float64], scalar: ScalarType, device: wp.Device) -> None:
        """Send masses [g], shape (n,), to the device."""
        count = len(mass)
        self.mass = wp.array(mass, dtype=scalar, device=device)
        self.coupling = [wp.zeros(count, dtype=vector(3, scalar), device=device) for _ in range(2)]
        self.sliding_mass = wp.zeros(count, dtype=vector(2, scalar), device=device)

    def update_launches(self, state: MixedVector, launcher: Launcher) -> list[Any]:
        """No launch: the masses are constant."""
        return []


class MassMatrix:
    """Masses on a device."""

    def __init__(
        self, masses: BlendedMasses, scalar: ScalarType, device: wp.Device, nodes: NodeMasses | None = None
    ) -> None:
        """Send masses to the device.

        Args:
            masses: masses of vertices and nodes.
            scalar: Warp's floating-point type.
            device: where the masses lie.
            nodes: blocks of the nodes; by default only their masses, without inertia of the Eulerian coordinates.
        """
        self.lumped = masses
        """The masses on the host."""
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
        return [launcher(combine_products, count, inputs, outputs)]

    def combine_blocks(self, factors: wp.array[Any], blocks: MixedBlocks, launcher: Launcher) -> list[Any]:
        """The launches that replace each block of H by factor 1 times this block plus factor 0 times the block of M."""
        outputs = [blocks.vertices, blocks.nodes, blocks.sliding, blocks.coupling_u, blocks.coupling_v]
        return [launcher(combine_blocks, self._count, self._constants(factors), outputs)]

    def _constants(self, factors: wp.array[Any]) -> list[Any]:
        return [self.vertices, self.nodes.mass, *self.nodes.coupling, self.nodes.sliding_mass, factors]
