# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The preconditioner P = S M + I - S of enriched systems (Casafranca et al. 2020, section 5.2).

For generalized coordinates q = (v, x), with x filtered, P z = r means on the filtered vectors S M z = r. With the world
positions p = B v + F x and forces f = (f_v, f_p) of which r = (f_v + B' f_p, F f_p) is the filtered form, this is

    minimize over all motions with E (v, p) = 0:    1/2 v' Mv v + 1/2 p' Mp p - f_v' v - f_p' p,

    (v, p) = M^-1 (f - E' mu),        mu = Sigma^-1 E M^-1 f,        Sigma = E M^-1 E',

the projection of M^-1 f in the metric of the masses. This is the inverse of P by the Sherman-Morrison-Woodbury formula
of equations 13 to 15, after the elimination of two of its three blocks: Casafranca et al. factor a matrix of three
times the hybrid vertices that is not symmetric, here Sigma of one times these vertices is symmetric and positive.

The metric may contain stiffness too, D = M / h^2 + K with K from the diagonal of the Hessian. Vertices and nodes
outside the hybrid region then have blocks of 3 x 3 and 2 x 2. Free nodes with Eulerian coordinates have one of 5 x 5,
in which both are coupled. In the hybrid region D is one number for each vertex and node, the
mean of its diagonal, so that the three coordinates keep one Sigma. What does not move has a D^-1 of zero.

The forces f are replaced by f - E' mu, so that the part of f that E balances does not grow during an iteration and does
not round the rest away. This is the filter of the search direction of Ascher and Boxerman (2003): every direction that
is a sum of results satisfies E (v, p) = 0.
"""

from __future__ import annotations

from functools import partial
from typing import Any

import numpy as np
import warp as wp
from numpy.typing import NDArray
from scipy.sparse import csr_array

from stitchmesh.compute.captured import CapturedLaunches, CopyArray, Launcher
from stitchmesh.compute.kernel import kernel
from stitchmesh.compute.launch import prepare
from stitchmesh.compute.partial_sums import WIDTH, add_parts, chunk_of, part_count
from stitchmesh.compute.precision import vector
from stitchmesh.compute.thread_block import THREADS, Slots, sum_over_block
from stitchmesh.mixed.enrichment.embedding import Embedding
from stitchmesh.mixed.enrichment.free_unknowns import FreeUnknowns
from stitchmesh.mixed.enrichment.projection import Projection
from stitchmesh.mixed.enrichment.region import Numbers
from stitchmesh.mixed.enrichment.sigma_on_device import BLOCK
from stitchmesh.mixed.enrichment.solve_record import Advance, record_alpha
from stitchmesh.mixed.mixed_blocks import MixedBlocks
from stitchmesh.mixed.mixed_vector import MixedVector

FIXED, FREE, COUPLED = 0, 1, 2
"""Kinds of vertices and nodes: with a prescribed velocity; outside the constraint E (v, p) = 0; within it."""
LEAST_NODE, LEAST_VERTEX = 1e-6, 1e-5
"""Lower bounds of masses in D: of the mean mass of the nodes, and for a vertex of the mass that B'MpB has on it.
Without mass a vertex moves with the nodes, by the constraint alone, and D^-1 would not be finite."""
POSITIVE = wp.constant(1.0e-9)
"""Smallest minor of a block with a unit mean diagonal that is inverted as a block."""


@wp.func
def mean_of_diagonal(block: Any, size: int, smallest: Any) -> Any:
    """Mean of a diagonal, at least ``smallest``."""
    total = type(smallest)(0.0)
    for k in range(size):
        total += block[k, k]
    return wp.max(total / type(smallest)(size), smallest)


@wp.func
def scalar_block(block: Any, size: int, value: Any) -> Any:
    """A multiple of the identity, of the type of ``block``."""
    result = block - block
    for k in range(size):
        result[k, k] = value
    return result


@wp.func
def inverse_3(block: Any, smallest: Any) -> Any:
    """Inverse of a block; of its mean where the block is not positive."""
    one = type(smallest)(1.0)
    mean = mean_of_diagonal(block, 3, smallest)
    unit = block * (one / mean)
    minor = unit[0, 0] * unit[1, 1] - unit[0, 1] * unit[1, 0]
    determinant = wp.determinant(unit)
    least = type(smallest)(POSITIVE)
    result = scalar_block(block, 3, one / mean)
    if unit[0, 0] > least and minor > least and determinant > least:
        result = wp.inverse(unit) * (one / mean)
    return result


@wp.func
def inverse_2(block: Any, smallest: Any) -> Any:
    """Inverse of a block; of its mean where the block is not positive."""
    one = type(smallest)(1.0)
    mean = mean_of_diagonal(block, 2, smallest)
    unit = block * (one / mean)
    least = type(smallest)(POSITIVE)
    result = scalar_block(block, 2, one / mean)
    if unit[0, 0] > least and wp.determinant(unit) > least:
        result = wp.inverse(unit) * (one / mean)
    return result


@wp.func
def inverse_where(block: Any, free: wp.vec2i, smallest: Any) -> Any:
    """Inverse of the rows and columns of the free coordinates; zero for the others."""
    one = type(smallest)(1.0)
    result = block - block
    if free[0] != 0 and free[1] != 0:
        result = inverse_2(block, smallest)
    else:
        for k in range(2):
            if free[k] != 0:
                result[k, k] = one / wp.max(block[k, k], smallest)
    return result


@kernel
def invert_metric(
    # model
    kind: wp.array[wp.int32],
    least_mass: wp.array[Any],
    inverse_mass: wp.array[Any],
    by_masses: int,
    factor: wp.array[Any],
    # state in
    blocks: wp.array[Any],
    # state out
    inverse: wp.array[Any],
    number: wp.array[Any],
) -> None:
    """Inverse blocks of D of positions: zero for what is fixed, a number for what is coupled."""
    i = wp.tid()
    block, of_mass = blocks[i], factor[0]
    smallest, of_masses = least_mass[i] * of_mass, inverse_mass[i] / of_mass
    result = block - block
    if kind[i] == wp.static(FREE):
        result = inverse_3(block, smallest)
    if kind[i] == wp.static(COUPLED):
        of_block = type(of_mass)(1.0) / mean_of_diagonal(block, 3, smallest)
        result = scalar_block(block, 3, wp.where(by_masses != 0, of_masses, of_block))
    inverse[i] = result
    number[i] = wp.where(kind[i] == wp.static(COUPLED), result[0, 0], of_mass - of_mass)


@kernel
def bound_vertex_inverses(
    # model
    start: wp.array[wp.int32],
    node: wp.array[wp.int32],
    square: wp.array[wp.float64],
    # state in
    node_inverse: wp.array[Any],
    # state in and out
    vertex_inverse: wp.array[Any],
    # state out
    blocks: wp.array[Any],
    sums: wp.array2d[wp.float64],
) -> None:
    """Bound D^-1 of coupled vertices: D is at least a part of what the nodes have on it, the sum of B^2 over D^-1.

    One block of threads finds the sum of each vertex.
    """
    i, lane = wp.tid()
    zero = wp.float64(0.0)
    total = Slots()
    for k in range(start[i] + lane, start[i + 1], wp.block_dim()):
        number = wp.float64(node_inverse[node[k]])
        if number > zero:
            total[0] += square[k] / number
    sum_over_block(total, sums[i])
    own = wp.float64(vertex_inverse[i])
    if lane == 0 and own > zero:
        if sums[i, 0] > zero:
            own = wp.min(own, wp.float64(1.0) / (wp.float64(wp.static(LEAST_VERTEX)) * sums[i, 0]))
        bounded = type(vertex_inverse[i])(own)
        vertex_inverse[i] = bounded
        blocks[i] = scalar_block(blocks[i], 3, bounded)


@kernel
def invert_sliding_metric(
    # model
    kind: wp.array[wp.int32],
    slides: wp.array[wp.vec2i],
    least_mass: wp.array[Any],
    factor: wp.array[Any],
    # state in
    node_inverse: wp.array[Any],
    blocks: wp.array[Any],
    coupling_u: wp.array[Any],
    coupling_v: wp.array[Any],
    # state out
    inverse: wp.array[Any],
    across_u: wp.array[Any],
    across_v: wp.array[Any],
) -> None:
    """Inverse blocks of the Schur complement of D for the Eulerian coordinates, and D^-1 times their columns."""
    i = wp.tid()
    by_u, by_v = node_inverse[i] * coupling_u[i], node_inverse[i] * coupling_v[i]
    if kind[i] != wp.static(FREE) or slides[i][0] == 0:
        by_u = by_u - by_u
    if kind[i] != wp.static(FREE) or slides[i][1] == 0:
        by_v = by_v - by_v
    across_u[i] = by_u
    across_v[i] = by_v
    pair = blocks[i]
    mixed = wp.dot(by_v, coupling_u[i])
    pair[0, 0] = pair[0, 0] - wp.dot(by_u, coupling_u[i])
    pair[1, 1] = pair[1, 1] - wp.dot(by_v, coupling_v[i])
    pair[0, 1] = pair[0, 1] - mixed
    pair[1, 0] = pair[1, 0] - mixed
    inverse[i] = inverse_where(pair, slides[i], least_mass[i] * factor[0])


@wp.func
def slide_of(across_u: Any, across_v: Any, inverse: Any, node: Any, force: Any) -> Any:
    """Motion of the Eulerian coordinates for the force on a node and on them."""
    rest = type(force)(force[0] - wp.dot(across_u, node), force[1] - wp.dot(across_v, node))
    return inverse * rest


@kernel
def times_inverse(
    # model
    vertex_inverse: wp.array[Any],
    node_inverse: wp.array[Any],
    sliding_inverse: wp.array[Any],
    across_u: wp.array[Any],
    across_v: wp.array[Any],
    # state in
    vertices: wp.array[Any],
    nodes: wp.array[Any],
    sliding: wp.array[Any],
    # state out
    vertex_result: wp.array[Any],
    node_result: wp.array[Any],
    sliding_result: wp.array[Any],
) -> None:
    """Multiply by the inverse blocks: z = D^-1 r."""
    i = wp.tid()
    vertex_count = vertices.shape[0]
    if i < vertex_count:
        vertex_result[i] = vertex_inverse[i] * vertices[i]
    else:
        j = i - vertex_count
        by_u, by_v = across_u[j], across_v[j]
        slide = slide_of(by_u, by_v, sliding_inverse[j], nodes[j], sliding[j])
        node_result[j] = node_inverse[j] * nodes[j] - by_u * slide[0] - by_v * slide[1]
        sliding_result[j] = slide


@kernel
def advance_and_invert(
    # model
    vertex_inverse: wp.array[Any],
    node_inverse: wp.array[Any],
    sliding_inverse: wp.array[Any],
    across_u: wp.array[Any],
    across_v: wp.array[Any],
    chunk: int,
    # state in
    record: wp.array[wp.float64],
    curvature: wp.array2d[wp.float64],
    d_vertices: wp.array[Any],
    d_nodes: wp.array[Any],
    d_sliding: wp.array[Any],
    of_vertices: wp.array[Any],
    of_nodes: wp.array[Any],
    of_sliding: wp.array[Any],
    # state in and out
    x_vertices: wp.array[Any],
    x_nodes: wp.array[Any],
    x_sliding: wp.array[Any],
    vertices: wp.array[Any],
    nodes: wp.array[Any],
    sliding: wp.array[Any],
    # state out
    vertex_result: wp.array[Any],
    node_result: wp.array[Any],
    sliding_result: wp.array[Any],
    sums: wp.array2d[wp.float64],
    after: wp.array[wp.float64],
    parts: wp.array2d[wp.float64],
) -> None:
    """Find a, x + a d, r - a A d, z = D^-1 r and the parts of r . z, each chunk of vertices and nodes by one block."""
    block, lane = wp.tid()
    total = add_parts(curvature, 0, curvature.shape[0], lane, sums[block])
    alpha = record_alpha(total, record, block == 0 and lane == 0, after)
    vertex_count = vertices.shape[0]
    products = Slots()
    for i in range(block * chunk + lane, wp.min((block + 1) * chunk, vertex_count + nodes.shape[0]), wp.block_dim()):
        if i < vertex_count:
            a = type(vertices[i][0])(alpha)
            x_vertices[i] = x_vertices[i] + d_vertices[i] * a
            pull = vertices[i] - of_vertices[i] * a
            vertices[i] = pull
            motion = vertex_inverse[i] * pull
            vertex_result[i] = motion
            products[0] += wp.float64(wp.dot(pull, motion))
        else:
            j = i - vertex_count
            b = type(nodes[j][0])(alpha)
            x_nodes[j] = x_nodes[j] + d_nodes[j] * b
            x_sliding[j] = x_sliding[j] + d_sliding[j] * b
            push, slip = nodes[j] - of_nodes[j] * b, sliding[j] - of_sliding[j] * b
            nodes[j] = push
            sliding[j] = slip
            by_u, by_v = across_u[j], across_v[j]
            slide = slide_of(by_u, by_v, sliding_inverse[j], push, slip)
            moved = node_inverse[j] * push - by_u * slide[0] - by_v * slide[1]
            node_result[j] = moved
            sliding_result[j] = slide
            products[0] += wp.float64(wp.dot(push, moved)) + wp.float64(wp.dot(slip, slide))
    sum_over_block(products, parts[block])


def least_masses(embedding: Embedding, node_mass: Numbers) -> Numbers:
    """Lower bounds of the masses of vertices and simulated nodes in D [g], shape (V + n,)."""
    on_vertices = embedding.basis.power(2).T @ node_mass[embedding.nodes]
    mean = float(node_mass.mean()) if node_mass.any() else 1.0
    vertices = np.maximum(LEAST_VERTEX * on_vertices, LEAST_NODE * LEAST_VERTEX * mean)
    return np.concatenate([vertices, np.full(len(node_mass), LEAST_NODE * mean)])


class Preconditioner:
    """The inverse of P for an embedding, on a device."""

    def __init__(
        self, embedding: Embedding, free: FreeUnknowns, masses: tuple[Numbers, Numbers], scalar: Any, device: wp.Device
    ) -> None:
        """Allocate; ``set_metric`` must follow.

        Args:
            embedding: how hybrid nodes move with the triangles.
            free: which coordinates are unknown.
            masses: masses of vertices and simulated nodes [g], shapes (V,) and (n,), for the metric of the masses and
                for a lower bound of D where nothing has mass.
            scalar: Warp's floating-point type.
            device: where the vectors lie.

        Raises:
            ParameterError: the hybrid region has too many vertices.
        """
        self._embedding, self._projection = embedding, Projection(embedding, scalar, device)
        self._scalar, self._device = scalar, device
        self._projects_by_masses = False
        self._factor, self._factor_now = wp.ones(1, dtype=scalar, device=device), 1.0
        least = least_masses(embedding, masses[1])
        halves = [embedding.vertex_count]
        self._least = [wp.array(part, dtype=scalar, device=device) for part in np.split(least, halves)]
        self._by_masses = 1.0 / np.maximum(np.concatenate(masses), least)
        self._inverse_mass = [wp.array(part, dtype=scalar, device=device) for part in np.split(self._by_masses, halves)]
        coupled_vertices, coupled_nodes = embedding.coupled
        self._vertex_kind = self._integers(np.where(coupled_vertices, COUPLED, FREE) * free.vertices)
        self._node_kind = self._integers(np.where(coupled_nodes, COUPLED, FREE) * free.nodes)
        self._slides = wp.array(free.sliding.astype(np.int32), dtype=wp.vec2i, device=device)
        self.inverse = MixedBlocks.zeros(embedding.vertex_count, embedding.node_count, scalar, device)
        three = vector(3, scalar)
        self._across = [wp.zeros(embedding.node_count, dtype=three, device=device) for _ in range(2)]
        counts = embedding.vertex_count, embedding.node_count
        self._numbers = [wp.zeros(count, dtype=scalar, device=device) for count in counts]
        self._squares = self._rows_of_squares()
        self._sums = wp.zeros((embedding.vertex_count, WIDTH), dtype=wp.float64, device=device)
        self._captured: dict[tuple[bool, bool], tuple[MixedBlocks, CapturedLaunches]] = {}
        self._on_device = device.is_cuda and self._is_regular()

    def _rows_of_squares(self) -> list[wp.array[Any]]:
        """The squares of B for each vertex, as compressed rows of simulated nodes."""
        squares = csr_array(self._embedding.basis.power(2).T)
        rows = squares.indptr, self._embedding.nodes[squares.indices]
        values = wp.array(squares.data, dtype=wp.float64, device=self._device)
        return [*(self._integers(row) for row in rows), values]

    def _is_regular(self) -> bool:
        """Whether Sigma is positive for the masses of what moves, and so for any metric."""
        vertices, nodes = np.split(self._by_masses, [self._embedding.vertex_count])
        coupled = self._vertex_kind.numpy() == COUPLED, self._node_kind.numpy() == COUPLED
        return self._projection.is_regular(vertices * coupled[0], nodes * coupled[1])

    def set_metric(self, metric: MixedBlocks, of_mass: float = 1.0, *, of_masses: bool = False) -> None:
        """Invert the metric D of motions.

        Args:
            metric: diagonal blocks of D.
            of_mass: factor of the masses in D [1/s^2].
            of_masses: whether D in the hybrid region is ``of_mass`` times the masses alone, instead of the given
                blocks. Sigma is then found once.
        """
        if of_mass != self._factor_now:
            self._factor.assign([of_mass])
            self._factor_now = of_mass
        inverts = self._projection.row_count > 0 and self._on_device and not of_masses
        self._captured_metric(metric, of_masses, inverts).launch()
        if not self._projection.row_count:
            return
        self._projection.set_scale(of_mass if of_masses else 1.0)
        if not (inverts or (of_masses and self._projects_by_masses)):
            self._projection.set_metric(*self._coupled_inverses(of_masses))
        self._projects_by_masses = of_masses

    def _captured_metric(self, metric: MixedBlocks, of_masses: bool, inverts: bool) -> CapturedLaunches:
        """``_metric_launches``, captured for the blocks that were given last."""
        name = of_masses, inverts
        if name not in self._captured or self._captured[name][0] is not metric:
            launches = self._metric_launches(metric, of_masses, inverts, partial(prepare, device=self._device))
            self._captured[name] = metric, CapturedLaunches(launches, self._device)
        return self._captured[name][1]

    def _metric_launches(self, metric: MixedBlocks, of_masses: bool, inverts: bool, launcher: Launcher) -> list[Any]:
        """The launches that invert the blocks, bound those of coupled vertices, and invert Sigma where asked."""
        own, projection, launches = self.inverse, self._projection, []
        numbers = self._numbers
        parts = (metric.vertices, own.vertices), (metric.nodes, own.nodes)
        for k, ((blocks, inverse), kind) in enumerate(zip(parts, (self._vertex_kind, self._node_kind), strict=True)):
            inputs = [kind, self._least[k], self._inverse_mass[k], int(of_masses), self._factor, blocks]
            if len(kind):
                launches.append(launcher(invert_metric, len(kind), inputs, [inverse, numbers[k]]))
        inputs = [self._node_kind, self._slides, self._least[1], self._factor, own.nodes]
        inputs += [metric.sliding, metric.coupling_u, metric.coupling_v]
        if len(self._node_kind):
            outputs = [own.sliding, *self._across]
            launches.append(launcher(invert_sliding_metric, len(self._node_kind), inputs, outputs))
        if projection.row_count and not of_masses:
            inputs, outputs = [*self._squares, numbers[1], numbers[0]], [own.vertices, self._sums]
            launches.append(launcher(bound_vertex_inverses, len(numbers[0]), inputs, outputs, tile=BLOCK))
        if inverts:
            launches += [
                CopyArray(numbers[0], projection.vertex_inverse),
                CopyArray(numbers[1], projection.node_inverse),
            ]
            launches += projection.metric_launches(launcher)
        return launches

    def _coupled_inverses(self, of_masses: bool) -> tuple[Numbers, Numbers]:
        """The inverse of D, or of the masses, of vertices and nodes within the constraint; zero elsewhere."""
        vertices, nodes = (numbers.numpy().astype(np.float64) for numbers in self._numbers)
        if of_masses:
            vertices = np.where(vertices > 0.0, self._by_masses[: len(vertices)], 0.0)
            nodes = np.where(nodes > 0.0, self._by_masses[len(vertices) :], 0.0)
        return vertices, nodes

    def launches(self, force: MixedVector, motion: MixedVector, launcher: Launcher) -> list[Any]:
        """The launches that find the motion z of P z = r.

        Args:
            force: forces f on vertices, nodes and Eulerian coordinates; replaced by f - E' mu, of the same filtered
                form r.
            motion: set to z as (v, p, s), with p = B v + F x.
            launcher: ``launch`` or ``prepare`` with the device bound.
        """
        own = self.inverse
        inputs = [own.vertices, own.nodes, own.sliding, *self._across, force.vertices, force.nodes, force.sliding]
        outputs = [motion.vertices, motion.nodes, motion.sliding]
        first = launcher(times_inverse, force.vertex_count + force.node_count, inputs, outputs)
        return [first, *self._projection.launches(motion, launcher, residual=force)]

    def advance_launches(
        self, advance: Advance, force: MixedVector, motion: MixedVector, parts: wp.array[Any], launcher: Launcher
    ) -> list[Any]:
        """The launches that advance a solution, and then do the same as ``launches``.

        Args:
            advance: a and d of the iteration.
            force: r, changed to r - a A d and then as in ``launches``.
            motion: set to z.
            parts: set to the parts of r . z.
            launcher: ``launch`` or ``prepare`` with the device bound.
        """
        own, given, count = self.inverse, advance, force.vertex_count + force.node_count
        inputs = [own.vertices, own.nodes, own.sliding, *self._across, chunk_of(count, self._device)]
        inputs += [given.record, given.curvature]
        for each in (given.direction, given.product, given.solution, force):
            inputs += [each.vertices, each.nodes, each.sliding]
        outputs = [motion.vertices, motion.nodes, motion.sliding, given.sums, given.after, parts]
        first = launcher(advance_and_invert, part_count(count, self._device), inputs, outputs, tile=THREADS)
        return [first, *self._projection.launches(motion, launcher, residual=force, parts=parts)]

    def project_launches(self, motion: MixedVector, launcher: Launcher) -> list[Any]:
        """The launches that change a motion the least in the metric D so that p = B v + F x; what is fixed stays."""
        return self._projection.launches(motion, launcher)

    def _integers(self, values: NDArray[Any]) -> wp.array[wp.int32]:
        return wp.array(values.astype(np.int32), dtype=wp.int32, device=self._device)
