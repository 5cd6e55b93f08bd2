# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Projections onto the motions p = B v + F x, for a metric of the vertices and nodes.

The motions are those with E (v, p) = B_C' p - G_C v = 0 (``embedding``). For a diagonal metric D, with one positive
number for each vertex and node, the same for the three coordinates, the nearest motion to u = (v, p) is

    u <- u - D^-1 E' mu,     mu = Sigma^-1 E u,     Sigma = E D^-1 E' = B_C' Dp^-1 B_C + G_C Dv^-1 G_C'.

The filter F of Casafranca et al. (2020, equation 3) is the projection of x = p alone in the metric of the identity, and
their preconditioner is the projection in the metric of the masses (``filter``, ``preconditioner``).

Sigma has the size of C, the independent vertices of the hybrid region, some hundreds. Its inverse is stored as a dense
matrix of float64 on the device, also on a CPU: a product with it then is one launch among the captured ones, without a
copy to the host, and for 1,000 vertices costs less than the product with B of 100,000 nodes. E u is one sum for each
row, by a block of threads in a fixed order. The inverse of a metric that changes is found by launches on a GPU
(``sigma_on_device``), and by LAPACK on the host otherwise and where Sigma is singular.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import warp as wp
from numpy.typing import NDArray
from scipy.linalg import LinAlgError, cho_factor, cho_solve, eigh
from scipy.sparse import csr_array

from stitchmesh.compute.captured import Launcher
from stitchmesh.compute.kernel import kernel
from stitchmesh.compute.partial_sums import chunk_of, part_count, parts_for
from stitchmesh.compute.thread_block import THREADS, Slots, sum_over_block
from stitchmesh.errors import ParameterError
from stitchmesh.mixed.enrichment.embedding import Embedding
from stitchmesh.mixed.enrichment.region import Numbers
from stitchmesh.mixed.enrichment.sigma_on_device import BLOCK, SigmaOnDevice
from stitchmesh.mixed.mixed_vector import MixedVector

LONG = 512
"""Threads of a block on a GPU that sums a row of E, which has hundreds to thousands of nodes."""
MOST_COLUMNS = 16_384
"""Largest number of independent vertices; their inverse takes 2 GiB."""
SINGULAR = 1e-13
"""Eigenvalue of Sigma with unit diagonal below which its motion is already fixed."""


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
def add_scaled(total: Slots, value: Any, weight: wp.float64) -> Slots:
    """Add a weighted vector to the first three sums."""
    result = total
    for axis in range(3):
        result[axis] = total[axis] + weight * wp.float64(value[axis])
    return result


@wp.func
def in_precision(value: wp.vec3d, zero: Any) -> Any:
    """A vector in the precision of ``zero``."""
    return type(zero)(type(zero[0])(value[0]), type(zero[0])(value[1]), type(zero[0])(value[2]))


@kernel
def constraint_rows(
    # model
    coupling: CouplingArrays,
    # state in
    vertices: wp.array[Any],
    nodes: wp.array[Any],
    # state out
    residual: wp.array2d[wp.float64],
) -> None:
    """E (v, p), one row for each block."""
    row, lane = wp.tid()
    total = Slots()
    for k in range(coupling.node_start[row] + lane, coupling.node_start[row + 1], wp.block_dim()):
        total = add_scaled(total, nodes[coupling.node[k]], coupling.node_weight[k])
    for k in range(coupling.vertex_start[row] + lane, coupling.vertex_start[row + 1], wp.block_dim()):
        total = add_scaled(total, vertices[coupling.vertex[k]], -coupling.vertex_weight[k])
    sum_over_block(total, residual[row])


@kernel
def multiplier_rows(
    # model
    inverse: wp.array2d[wp.float64],
    # state in
    residual: wp.array2d[wp.float64],
    # state out
    multiplier: wp.array2d[wp.float64],
) -> None:
    """The multipliers mu = Sigma^-1 E u, one row for each block."""
    row, lane = wp.tid()
    total = Slots()
    for k in range(lane, inverse.shape[1], wp.block_dim()):
        for axis in range(3):
            total[axis] += inverse[row, k] * residual[k, axis]
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


@kernel
def subtract_multipliers(
    # model
    coupling: CouplingArrays,
    vertex_inverse: wp.array[Any],
    node_inverse: wp.array[Any],
    scale: wp.array[Any],
    changes_residual: int,
    chunk: int,
    # state in
    multiplier: wp.array2d[wp.float64],
    sliding_residual: wp.array[Any],
    sliding: wp.array[Any],
    # state in and out
    vertex_residual: wp.array[Any],
    node_residual: wp.array[Any],
    vertices: wp.array[Any],
    nodes: wp.array[Any],
    # state out
    parts: wp.array2d[wp.float64],
) -> None:
    """Find u - D^-1 E' mu, r - scale E' mu where ``changes_residual``, and the parts of r . u."""
    block, lane = wp.tid()
    vertex_count = vertices.shape[0]
    sums = Slots()
    for i in range(block * chunk + lane, wp.min((block + 1) * chunk, vertex_count + nodes.shape[0]), wp.block_dim()):
        if i < vertex_count:
            total = column_sum(coupling.of_vertex_start, coupling.of_vertex, coupling.of_vertex_weight, multiplier, i)
            change = in_precision(total, vertices[i])
            vertices[i] = vertices[i] + change * vertex_inverse[i]
            if changes_residual != 0:
                vertex_residual[i] = vertex_residual[i] + change * scale[0]
            sums[0] += wp.float64(wp.dot(vertex_residual[i], vertices[i]))
        else:
            j = i - vertex_count
            of_rows = column_sum(coupling.of_node_start, coupling.of_node, coupling.of_node_weight, multiplier, j)
            push = in_precision(of_rows, nodes[j])
            nodes[j] = nodes[j] - push * node_inverse[j]
            if changes_residual != 0:
                node_residual[j] = node_residual[j] - push * scale[0]
            sums[0] += wp.float64(wp.dot(node_residual[j], nodes[j]))
            sums[0] += wp.float64(wp.dot(sliding_residual[j], sliding[j]))
    sum_over_block(sums, parts[block])


class Projection:
    """The projection of an embedding for a metric, on a device."""

    def __init__(self, embedding: Embedding, scalar: Any, device: wp.Device) -> None:
        """Send E to the device; ``set_metric`` must follow.

        Raises:
            ParameterError: the hybrid region has too many vertices for a dense inverse.
        """
        self.row_count = embedding.independent.shape[1]
        if self.row_count > MOST_COLUMNS:
            found = f"got {self.row_count} vertices in the hybrid region"
            raise ParameterError(f"region: {found}; expected at most {MOST_COLUMNS}: take fewer rings")
        self._scalar, self._device = scalar, device
        self._independent, self._gram = embedding.independent, embedding.gram
        self._hybrid = embedding.nodes
        self._entities = embedding.vertex_count + embedding.node_count
        self._places, self._sigma_of = _sigma_maps(self._independent, self._gram)
        hybrid = len(embedding.nodes)
        entries = np.ones(hybrid), (np.arange(hybrid), embedding.nodes)
        self._to_all = csr_array(entries, shape=(hybrid, embedding.node_count))
        self.coupling = self._coupling(embedding)
        self.vertex_inverse = wp.zeros(embedding.vertex_count, dtype=scalar, device=device)
        self.node_inverse = wp.zeros(embedding.node_count, dtype=scalar, device=device)
        self._scale, self._scale_now = wp.full(1, value=scalar(1.0), dtype=scalar, device=device), 1.0
        shape = (self.row_count, self.row_count)
        self._inverse = wp.zeros(shape, dtype=wp.float64, device=device)
        self._residual = wp.zeros((self.row_count, 7), dtype=wp.float64, device=device)
        self._multiplier = wp.zeros_like(self._residual)
        self._parts = parts_for(self._entities, device)
        self._on_device: SigmaOnDevice | None = None

    def set_metric(self, vertex_inverse: Numbers, node_inverse: Numbers) -> None:
        """Invert Sigma for a metric.

        Args:
            vertex_inverse: D^-1 of the vertices, shape (V,); 0 for a vertex that does not move.
            node_inverse: D^-1 of the simulated nodes, shape (n,); 0 for a node that does not move.
        """
        self.vertex_inverse.assign(vertex_inverse)
        self.node_inverse.assign(node_inverse)
        if self.row_count:
            kind = np.float32 if self._scalar is wp.float32 else np.float64
            rounded = (numbers.astype(kind).astype(np.float64) for numbers in (vertex_inverse, node_inverse))
            self._inverse.assign(symmetric_inverse(self.sigma(*rounded)))

    def is_regular(self, vertex_inverse: Numbers, node_inverse: Numbers) -> bool:
        """Whether Sigma of a metric is positive beyond rounding; arguments as for ``set_metric``."""
        return positive_inverse(self.sigma(vertex_inverse, node_inverse)) is not None

    def metric_launches(self, launcher: Launcher) -> list[Any]:
        """The launches that invert Sigma for ``vertex_inverse`` and ``node_inverse``, where it is positive."""
        if self._on_device is None:
            of_nodes, of_vertices = self._sigma_of
            of_all = csr_array(of_nodes @ self._to_all)
            self._on_device = SigmaOnDevice(self._places, of_all, of_vertices, self._inverse, self._device)
        return self._on_device.launches(self.vertex_inverse, self.node_inverse, launcher)

    def set_scale(self, scale: float) -> None:
        """Multiply the metric by a number: the projection stays, and E' mu of a force is multiplied."""
        if scale != self._scale_now:
            self._scale.fill_(self._scalar(scale))
            self._scale_now = scale

    def sigma(self, vertex_inverse: Numbers, node_inverse: Numbers) -> Numbers:
        """Sigma = E D^-1 E', shape (C, C); arguments as for ``set_metric``."""
        of_nodes, of_vertices = self._sigma_of
        total = np.zeros(self.row_count**2)
        total[self._places] = of_nodes @ node_inverse[self._hybrid] + of_vertices @ vertex_inverse
        return total.reshape(self.row_count, self.row_count)

    def launches(
        self,
        motion: MixedVector,
        launcher: Launcher,
        *,
        residual: MixedVector | None = None,
        parts: wp.array[Any] | None = None,
    ) -> list[Any]:
        """The launches that project a motion; none without hybrid nodes.

        Args:
            motion: u, projected.
            launcher: ``launch`` or ``prepare`` with the device bound.
            residual: r, from which E' mu is subtracted.
            parts: set to the parts of the dot product of the residual and the motion, over vertices and nodes.
        """
        if self.row_count == 0:
            return []
        forces = motion if residual is None else residual
        metric = [self.vertex_inverse, self.node_inverse, self._scale]
        chunk = chunk_of(self._entities, self._device)
        inputs = [self.coupling, *metric, int(residual is not None), chunk, self._multiplier]
        inputs += [forces.sliding, motion.sliding, forces.vertices, forces.nodes, motion.vertices, motion.nodes]
        outputs = [self._parts if parts is None else parts]
        rows, motions = self.row_count, [self.coupling, motion.vertices, motion.nodes]
        return [
            launcher(constraint_rows, rows, motions, [self._residual], tile=LONG),
            launcher(multiplier_rows, rows, [self._inverse, self._residual], [self._multiplier], tile=BLOCK),
            launcher(subtract_multipliers, part_count(self._entities, self._device), inputs, outputs, tile=THREADS),
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
    """Each product of two entries of one node: its place in a matrix (C, C), the hybrid node, the product."""
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

    The matrices are those of the hybrid nodes and of the vertices.
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
    """A matrix with rows and columns scaled to a unit diagonal, because masses differ by many orders; the scale."""
    diagonal = matrix.diagonal()
    scale = 1.0 / np.sqrt(np.where(diagonal > 0.0, diagonal, 1.0))
    return matrix * np.outer(scale, scale), scale


def _scaled_back(inverse: Numbers, scale: Numbers) -> Numbers:
    """The inverse of a matrix from that of the scaled one, made symmetric."""
    result: Numbers = (inverse + inverse.T) * 0.5 * np.outer(scale, scale)
    return result
