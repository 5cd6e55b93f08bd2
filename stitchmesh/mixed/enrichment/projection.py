# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Projections onto the motions p = B v + F x, for a metric of the vertices and nodes.

The motions satisfy E (v, p) = B_C' p - G_C v = 0 (``embedding``). For a metric D with one positive block of 3 x 3 for
each vertex and node, the nearest motion to u = (v, p) is

    u <- u - D^-1 E' mu,     mu = Sigma^-1 E u,     Sigma = E D^-1 E' = B_C' Dp^-1 B_C + G_C Dv^-1 G_C'.

An element of Sigma is a block of 3 x 3 too. Where all blocks of D are multiples of the identity, one number is enough.

The filter F of Casafranca et al. (2020, equation 3) is the projection of x = p alone in the metric of the identity, and
their preconditioner is the projection in the metric of the masses (``preconditioner``).

Sigma has one row for each independent vertex of the hybrid region (C), which are some hundreds. Its inverse is stored
on the device as a dense matrix in float64, also on a CPU: a product with it is then one launch among the captured ones,
without a copy to the host. A row of 1,000 numbers costs less than the product with B of 100,000 nodes. One block of
threads computes each row of E u in a fixed order. On a GPU, launches invert Sigma for a metric that changes
(``sigma_on_device``); otherwise, and where Sigma is singular, LAPACK inverts it on the host.

``make_consistent`` changes positions at the beginning to the form p = B v + F x. Nodes that stand out of their
triangles do not have this form: the mean of their heights around a vertex is not zero. The vertices and hybrid nodes
change by the smallest sum of squares that gives them this form. Several nodes lie around a vertex, so mainly the
vertices move, to the middle of the yarns, and the yarns keep their shape. Fixed coordinates stay. The equation
E (v, p) = 0 is linear and homogeneous, so it then also holds for a cloth that is turned.
"""

from __future__ import annotations

from functools import partial
from typing import Any

import numpy as np
import warp as wp
from numpy.typing import NDArray
from scipy.linalg import LinAlgError, cho_factor, cho_solve, eigh
from scipy.sparse import csr_array

from stitchmesh.compute.captured import Launcher
from stitchmesh.compute.kernel import kernel
from stitchmesh.compute.launch import launch
from stitchmesh.compute.partial_sums import WIDTH
from stitchmesh.compute.precision import Vec3
from stitchmesh.compute.thread_block import Slots, sum_over_block
from stitchmesh.errors import ParameterError
from stitchmesh.mixed.enrichment.region import Embedding, FreeUnknowns, Numbers
from stitchmesh.mixed.enrichment.sigma_on_device import BLOCK, SigmaElement, SigmaOnDevice
from stitchmesh.mixed.mixed_vector import BlockArrays, MixedArrays, MixedBlocks, MixedVector

LONG = 512
"""Threads of a block on a GPU that sums a row of E; a row has hundreds to thousands of nodes."""
MOST_COLUMNS = 16_384
"""Largest number of independent vertices; the inverse then takes 2 GiB if its elements are numbers."""
SINGULAR = 1e-13
"""Eigenvalue of Sigma with unit diagonal below which the motion of its eigenvector is already fixed."""


@wp.struct
class CouplingArrays:
    """E on a device: rows of B_C' and of G_C, and columns of both; row ``c`` belongs to the c-th independent vertex."""

    node_start: wp.array[wp.int32]
    node: wp.array[wp.int32]
    node_weight: wp.array[wp.float64]
    vertex_start: wp.array[wp.int32]
    vertex: wp.array[wp.int32]
    vertex_weight: wp.array[wp.float64]
    of_vertex_start: wp.array[wp.int32]
    of_vertex: wp.array[wp.int32]
    of_vertex_weight: wp.array[wp.float64]
    of_node_start: wp.array[wp.int32]
    of_node: wp.array[wp.int32]
    of_node_weight: wp.array[wp.float64]


@wp.func
def add_scaled(total: Slots, value: Vec3, weight: wp.float64) -> Slots:
    """Add a weighted vector to the first three sums."""
    result = total
    for axis in range(3):
        result[axis] = total[axis] + weight * wp.float64(value[axis])
    return result


@wp.func
def in_precision(value: wp.vec3d, zero: Vec3) -> Any:
    """A vector in the precision of ``zero``."""
    return type(zero)(type(zero[0])(value[0]), type(zero[0])(value[1]), type(zero[0])(value[2]))


@kernel(tile=LONG)
def constraint_rows(
    # model
    coupling: CouplingArrays,
    # state in
    motion: MixedArrays,
    # state out
    residual: wp.array2d[wp.float64],
) -> None:
    """E (v, p), one row for each block."""
    row, lane = wp.tid()
    total = Slots()
    for k in range(coupling.node_start[row] + lane, coupling.node_start[row + 1], wp.block_dim()):
        total = add_scaled(total, motion.nodes[coupling.node[k]], coupling.node_weight[k])
    for k in range(coupling.vertex_start[row] + lane, coupling.vertex_start[row + 1], wp.block_dim()):
        total = add_scaled(total, motion.vertices[coupling.vertex[k]], -coupling.vertex_weight[k])
    sum_over_block(total, residual[row])


@kernel(tile=BLOCK)
def multiplier_rows(
    # model
    inverse: wp.array2d[SigmaElement],
    scale: wp.array[wp.float64],
    # state in
    residual: wp.array2d[wp.float64],
    # state out
    multiplier: wp.array2d[wp.float64],
) -> None:
    """The multipliers mu = scale Sigma^-1 E u, one row for each block."""
    row, lane = wp.tid()
    total = Slots()
    for k in range(lane, inverse.shape[1], wp.block_dim()):
        of_row = inverse[row, k] * wp.vec3d(residual[k, 0], residual[k, 1], residual[k, 2])
        total = add_scaled(total, of_row, scale[0])
    sum_over_block(total, multiplier[row])


@wp.func
def column_sum(
    start: wp.array[wp.int32],
    row: wp.array[wp.int32],
    weight: wp.array[wp.float64],
    multiplier: wp.array2d[wp.float64],
    i: int,
) -> wp.vec3d:
    """Sum over the rows of E that contain a vertex or node."""
    total = wp.vec3d()
    for k in range(start[i], start[i + 1]):
        c = row[k]
        total += wp.vec3d(multiplier[c, 0], multiplier[c, 1], multiplier[c, 2]) * weight[k]
    return total


@wp.func
def change_of_vertex(coupling: CouplingArrays, multiplier: wp.array2d[wp.float64], i: int, zero: Vec3) -> Any:
    """-E' mu of a vertex, in the precision of ``zero``."""
    rows = column_sum(coupling.of_vertex_start, coupling.of_vertex, coupling.of_vertex_weight, multiplier, i)
    return in_precision(rows, zero)


@wp.func
def change_of_node(coupling: CouplingArrays, multiplier: wp.array2d[wp.float64], j: int, zero: Vec3) -> Any:
    """-E' mu of a node, in the precision of ``zero``."""
    return -in_precision(
        column_sum(coupling.of_node_start, coupling.of_node, coupling.of_node_weight, multiplier, j), zero
    )


@kernel
def subtract_multipliers(
    # model
    coupling: CouplingArrays,
    inverse: BlockArrays,
    changes_force: int,
    # state in
    multiplier: wp.array2d[wp.float64],
    # state in and out
    force: MixedArrays,
    motion: MixedArrays,
) -> None:
    """Find u - D^-1 E' mu, and r - E' mu where ``changes_force``."""
    i = wp.tid()
    vertex_count = motion.vertices.shape[0]
    if i < vertex_count:
        change = change_of_vertex(coupling, multiplier, i, motion.vertices[i])
        motion.vertices[i] = motion.vertices[i] + inverse.vertices[i] * change
        if changes_force != 0:
            force.vertices[i] = force.vertices[i] + change
    else:
        j = i - vertex_count
        pull = change_of_node(coupling, multiplier, j, motion.nodes[j])
        motion.nodes[j] = motion.nodes[j] + inverse.nodes[j] * pull
        if changes_force != 0:
            force.nodes[j] = force.nodes[j] + pull


class Projection:
    """The projection of an embedding for a metric, on a device."""

    def __init__(self, embedding: Embedding, inverse: MixedBlocks, *, element: Any, device: wp.Device) -> None:
        """Send E to the device; ``invert`` or the launches of ``inverse_launches`` must follow.

        Args:
            embedding: how hybrid nodes move with the triangles.
            inverse: the blocks of D^-1, which the launches read; only blocks of vertices and nodes within E count.
            element: Warp's type of the elements of Sigma, ``wp.float64`` or ``wp.mat33d``; with numbers, all blocks of
                D must be multiples of the identity.
            device: where the launches run.

        Raises:
            ParameterError: the hybrid region has too many vertices for a dense inverse.
        """
        self.row_count = embedding.independent.shape[1]
        if self.row_count > MOST_COLUMNS:
            found = f"got {self.row_count} vertices in the hybrid region"
            raise ParameterError(f"region: {found}; expected at most {MOST_COLUMNS}: take fewer rings")
        self._device, self._element = device, element
        self._independent, self._gram = embedding.independent, embedding.gram
        self._hybrid = embedding.nodes
        self._entities = embedding.vertex_count + embedding.node_count
        self._places, self._sigma_of = _sigma_maps(self._independent, self._gram)
        hybrid = len(embedding.nodes)
        entries = np.ones(hybrid), (np.arange(hybrid), embedding.nodes)
        self._to_all = csr_array(entries, shape=(hybrid, embedding.node_count))
        self.coupling = self._coupling(embedding)
        self.metric = inverse
        """The blocks of D^-1."""
        self._scale, self._scale_now = wp.ones(1, dtype=wp.float64, device=device), 1.0
        self._inverse = wp.zeros((self.row_count, self.row_count), dtype=element, device=device)
        self.residual = wp.zeros((self.row_count, WIDTH), dtype=wp.float64, device=device)
        """E u of the last ``multiplier_launches``, shape (C, 3), and unused columns."""
        self.multiplier = wp.zeros_like(self.residual)
        """mu = Sigma^-1 E u, with the shape of ``residual``."""

    def invert(self, vertex_inverse: Numbers, node_inverse: Numbers) -> None:
        """Invert Sigma on the host.

        Args:
            vertex_inverse: D^-1 of the vertices, shape (V, 3, 3), or (V,) where the elements of Sigma are numbers; zero
                for a vertex that does not move.
            node_inverse: D^-1 of the simulated nodes, shape (n, 3, 3) or (n,); zero for a node that does not move.
        """
        if self.row_count:
            rows, width = self.row_count, 3 if vertex_inverse.ndim == 3 else 1
            inverse = symmetric_inverse(self.sigma(vertex_inverse, node_inverse))
            blocks = inverse.reshape(rows, width, rows, width).swapaxes(1, 2)
            self._inverse.assign(np.ascontiguousarray(blocks if width == 3 else inverse))

    def invert_present(self) -> None:
        """Invert Sigma on the host for the present blocks of D^-1."""
        vertices, nodes = (part.numpy().astype(np.float64) for part in (self.metric.vertices, self.metric.nodes))
        if self._element is wp.float64:
            vertices, nodes = vertices[:, 0, 0], nodes[:, 0, 0]
        self.invert(vertices, nodes)

    def is_regular(self, vertex_inverse: Numbers, node_inverse: Numbers) -> bool:
        """Whether Sigma of a metric is positive beyond rounding, with the arguments of ``invert``."""
        return positive_inverse(self.sigma(vertex_inverse, node_inverse)) is not None

    def inverse_launches(self, launcher: Launcher) -> list[Any]:
        """The launches that invert Sigma for the present blocks of D^-1, where it is positive."""
        of_nodes, of_vertices = self._sigma_of
        of_all = csr_array(of_nodes @ self._to_all)
        on_device = SigmaOnDevice(self._places, of_all, of_vertices, self._inverse, self._device)
        return on_device.launches(self.metric.vertices, self.metric.nodes, launcher)

    def set_scale(self, scale: float) -> None:
        """Declare that the present blocks of D are a multiple of the inverted ones, by this number."""
        if scale != self._scale_now:
            self._scale.fill_(scale)
            self._scale_now = scale

    def sigma(self, vertex_inverse: Numbers, node_inverse: Numbers) -> Numbers:
        """Sigma = E D^-1 E', shape (C, C), or (3 C, 3 C) for blocks, with the arguments of ``invert``."""
        rows, shape = self.row_count, vertex_inverse.shape[1:]
        of_nodes, of_vertices = self._sigma_of
        size = int(np.prod(shape, dtype=int))
        flat = node_inverse[self._hybrid].reshape(-1, size), vertex_inverse.reshape(-1, size)
        total = np.zeros((rows**2, size))
        total[self._places] = of_nodes @ flat[0] + of_vertices @ flat[1]
        width = shape[0] if shape else 1
        matrix: Numbers = total.reshape(rows, rows, width, width).swapaxes(1, 2).reshape(rows * width, rows * width)
        return matrix

    def launches(self, motion: MixedVector, launcher: Launcher, *, force: MixedVector | None = None) -> list[Any]:
        """The launches that project a motion; none without hybrid nodes.

        Args:
            motion: u; becomes its projection.
            launcher: ``launch`` or ``prepare`` with the device bound.
            force: r, from which E' mu is subtracted.
        """
        if self.row_count == 0:
            return []
        inputs = [self.coupling, self.metric.arrays, int(force is not None), self.multiplier, (force or motion).arrays]
        found = self.multiplier_launches(motion, launcher)
        return [*found, launcher(subtract_multipliers, self._entities, inputs, [motion.arrays])]

    def multiplier_launches(self, motion: MixedVector, launcher: Launcher) -> list[Any]:
        """The launches that find ``residual`` and ``multiplier`` of a motion; none without hybrid nodes."""
        if self.row_count == 0:
            return []
        inputs = [self._inverse, self._scale, self.residual]
        return [
            launcher(constraint_rows, self.row_count, [self.coupling, motion.arrays], [self.residual]),
            launcher(multiplier_rows, self.row_count, inputs, [self.multiplier]),
        ]

    def _coupling(self, embedding: Embedding) -> Any:
        """The rows and columns of E on the device."""
        coupling = CouplingArrays()
        of_nodes = csr_array(self._independent.T @ self._to_all)
        tables = {
            ("node_start", "node", "node_weight"): of_nodes,
            ("vertex_start", "vertex", "vertex_weight"): self._gram,
            ("of_vertex_start", "of_vertex", "of_vertex_weight"): csr_array(self._gram.T),
            ("of_node_start", "of_node", "of_node_weight"): csr_array(of_nodes.T),
        }
        for names, table in tables.items():
            table.sort_indices()
            for name, values in zip(names, (table.indptr, table.indices, table.data), strict=True):
                kind = wp.float64 if name.endswith("weight") else wp.int32
                setattr(coupling, name, wp.array(values, dtype=kind, device=self._device))
        return coupling


def _pairs_of_rows(independent: csr_array) -> tuple[NDArray[np.int64], NDArray[np.int64], Numbers]:
    """For each product of two entries of one node: its place in a matrix (C, C), the hybrid node, and the product."""
    matrix = independent.tocoo()
    count = np.bincount(matrix.row, minlength=independent.shape[0])
    start = np.concatenate([[0], np.cumsum(count)])
    repeats = count[matrix.row]
    left = np.repeat(np.arange(matrix.nnz), repeats)
    offset = np.arange(len(left)) - np.repeat(np.cumsum(repeats) - repeats, repeats)
    right = start[matrix.row[left]] + offset
    place = matrix.col[left].astype(np.int64) * independent.shape[1] + matrix.col[right]
    return place, matrix.row[left].astype(np.int64), matrix.data[left] * matrix.data[right]


def _sigma_maps(independent: csr_array, gram: csr_array) -> tuple[NDArray[np.int64], tuple[csr_array, csr_array]]:
    """The places of Sigma, as a matrix (C, C), that are not zero, and the matrices from D^-1 to the numbers there.

    One matrix belongs to the hybrid nodes, the other to the vertices.
    """
    tables = [_pairs_of_rows(independent), _pairs_of_rows(csr_array(gram.T))]
    places = np.unique(np.concatenate([place for place, _row, _weight in tables]))
    counts = independent.shape[0], gram.shape[1]
    of_nodes, of_vertices = (
        csr_array((weight, (np.searchsorted(places, place), row)), shape=(len(places), count))
        for (place, row, weight), count in zip(tables, counts, strict=True)
    )
    return places, (of_nodes, of_vertices)


def symmetric_inverse(matrix: Numbers) -> Numbers:
    """The inverse of a symmetric matrix that is never negative; the pseudo-inverse where it is singular."""
    inverse = positive_inverse(matrix)
    if inverse is not None:
        return inverse
    scaled, scale = _unit_diagonal(matrix)
    values, vectors = eigh(scaled)
    kept = values > SINGULAR * max(float(values.max(initial=0.0)), 1.0)
    return _scaled_back((vectors[:, kept] / values[kept]) @ vectors[:, kept].T, scale)


def positive_inverse(matrix: Numbers) -> Numbers | None:
    """The inverse of a symmetric matrix; None where it is not positive beyond rounding."""
    scaled, scale = _unit_diagonal(matrix)
    try:
        inverse = cho_solve(cho_factor(scaled), np.eye(len(scaled)))
    except LinAlgError:
        return None
    return None if np.abs(inverse).max(initial=0.0) * SINGULAR > 1.0 else _scaled_back(inverse, scale)


def _unit_diagonal(matrix: Numbers) -> tuple[Numbers, Numbers]:
    """Scale rows and columns of a matrix to a unit diagonal, as masses differ by many orders; return also the scale."""
    diagonal = matrix.diagonal()
    scale = 1.0 / np.sqrt(np.where(diagonal > 0.0, diagonal, 1.0))
    return matrix * np.outer(scale, scale), scale


def _scaled_back(inverse: Numbers, scale: Numbers) -> Numbers:
    """The inverse of a matrix from the inverse of the scaled matrix, made symmetric."""
    result: Numbers = (inverse + inverse.T) * 0.5 * np.outer(scale, scale)
    return result


def make_consistent(embedding: Embedding, free: FreeUnknowns, positions: MixedVector) -> None:
    """Change positions to the nearest ones with p = B v + F x.

    Args:
        embedding: the base motion of the hybrid nodes.
        free: which coordinates move.
        positions: positions at the beginning; changed.
    """
    numbers = free.vertices.astype(np.float64), free.nodes.astype(np.float64)
    metric = MixedBlocks.of_numbers(*numbers, positions.scalar, positions.device)
    projection = Projection(embedding, metric, element=wp.float64, device=positions.device)
    projection.invert(*numbers)
    projection.launches(positions, partial(launch, device=positions.device))
