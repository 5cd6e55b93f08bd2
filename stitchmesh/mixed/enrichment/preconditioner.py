# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The preconditioner P = S M + I - S of enriched systems (Casafranca et al. 2020, section 5.2).

For generalized coordinates q = (v, x), with x filtered, P z = r means S M z = r on the filtered vectors. Let
p = B v + F x be the world positions, and f = (f_v, f_p) forces with the filtered form r = (f_v + B' f_p, F f_p). Then
this is

    minimize over all motions with E (v, p) = 0:    1/2 v' Mv v + 1/2 p' Mp p - f_v' v - f_p' p,

    (v, p) = M^-1 (f - E' mu),        mu = Sigma^-1 E M^-1 f,        Sigma = E M^-1 E',

which is the projection of M^-1 f in the metric of the masses. It is the inverse of P by the Sherman-Morrison-Woodbury
formula of equations 13 to 15, after two of its three blocks are eliminated. Casafranca et al. factor a matrix that has
three times as many rows as there are hybrid vertices and is not symmetric; Sigma has one row for each hybrid vertex,
and is symmetric and positive.

The metric may contain stiffness too, D = M / h^2 + K with K from the diagonal of the Hessian. Vertices and nodes then
have blocks of 3 x 3, and Sigma has three rows for each of its vertices. Free nodes with Eulerian coordinates have
blocks of 5 x 5, which couple both. Where the hybrid region has more than ``MOST_BLOCK_ROWS`` vertices, D is one number
there, the mean of the diagonal, and Sigma has one row for each vertex. The D^-1 of fixed coordinates is zero.

The forces f are replaced by f - E' mu. The part of f that E balances then does not grow during an iteration, and does
not round the rest away. This is the filter of the search direction of Ascher and Boxerman (2003): every direction that
is a sum of results satisfies E (v, p) = 0.

*Inverse blocks of D.* Vertices and nodes have blocks of 3 x 3. Free nodes with Eulerian coordinates have a block of 5 x
5, kept as a block of 3 x 3, columns, and the Schur complement of the coordinates. The D^-1 of fixed coordinates is
zero.

In the hybrid region D has one of three forms (``BY_MASSES``, ``ONE_NUMBER``, ``BLOCKS``). Blocks of hybrid vertices and
nodes are nearly singular where yarns resist bending much less than stretch. ``SHARE`` of the mean of their diagonal is
added to them, which keeps their condition number below 300 and costs no iterations.
"""

from __future__ import annotations

from functools import partial
from typing import Any

import numpy as np
import warp as wp
from numpy.typing import NDArray
from scipy.sparse import csr_array

from stitchmesh.compute.captured import CapturedLaunches, Launcher
from stitchmesh.compute.kernel import kernel
from stitchmesh.compute.launch import prepare
from stitchmesh.compute.partial_sums import WIDTH, add_parts, chunk_of, part_count
from stitchmesh.compute.precision import Mat22, Mat33, Scalar, ScalarType, Vec2, Vec3
from stitchmesh.compute.thread_block import THREADS, Slots, sum_over_block
from stitchmesh.mixed.enrichment.projection import Projection
from stitchmesh.mixed.enrichment.region import Embedding, FreeUnknowns, Numbers
from stitchmesh.mixed.enrichment.sigma_on_device import BLOCK
from stitchmesh.mixed.enrichment.solve_record import Advance, next_direction, record_alpha
from stitchmesh.mixed.mixed_vector import BlockArrays, MixedArrays, MixedBlocks, MixedVector

FIXED, FREE, COUPLED = 0, 1, 2
"""Kinds of vertices and nodes: with a prescribed velocity; free, outside the constraint E (v, p) = 0; free, within
it."""
BY_MASSES, ONE_NUMBER, BLOCKS = 0, 1, 2
"""Forms of D in the hybrid region: the masses, the mean of the diagonal of each block, or whole blocks."""
SHARE = 1e-2
"""Part of the mean of its diagonal that is added to the diagonal of a block in the hybrid region."""
LEAST_NODE, LEAST_VERTEX = 1e-6, 1e-5
"""Lower bounds of masses in D. For a node: this part of the mean mass of the nodes. For a vertex: this part of its
diagonal entry of B'MpB, the mass of the nodes on it. A vertex without mass moves with the nodes by the constraint
alone, and its D^-1 would not be finite."""
POSITIVE = wp.constant(1.0e-9)
"""Smallest minor of a block with a unit mean diagonal that is inverted as a block."""


@wp.func
def mean_of_diagonal(block: Any, size: int, smallest: Scalar) -> Any:
    """Mean of a diagonal, at least ``smallest``."""
    total = type(smallest)(0.0)
    for k in range(size):
        total += block[k, k]
    return wp.max(total / type(smallest)(size), smallest)


@wp.func
def scalar_block(block: Any, size: int, value: Scalar) -> Any:
    """A multiple of the identity, of the type of ``block``."""
    result = block - block
    for k in range(size):
        result[k, k] = value
    return result


@wp.func
def inverse_3(block: Mat33, smallest: Scalar) -> Any:
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
def inverse_2(block: Mat22, smallest: Scalar) -> Any:
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
def inverse_where(block: Mat22, free: wp.vec2i, smallest: Scalar) -> Any:
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


@wp.func
def inverse_of_coupled(block: Mat33, form: int, smallest: Scalar, extra: Scalar, of_masses: Scalar) -> Any:
    """Inverse of a block in the hybrid region, which is exactly symmetric."""
    one, half = type(smallest)(1.0), type(smallest)(0.5)
    mean = mean_of_diagonal(block, 3, smallest)
    result = scalar_block(block, 3, of_masses)
    if form == wp.static(ONE_NUMBER):
        result = scalar_block(block, 3, one / wp.max(mean, extra))
    if form == wp.static(BLOCKS):
        added = type(smallest)(wp.static(SHARE)) * mean + extra
        result = inverse_3(block + scalar_block(block, 3, added), smallest)
        result = (result + wp.transpose(result)) * half
    return result


@kernel
def invert_metric(
    # model
    kind: wp.array[wp.int32],
    least_mass: wp.array[Scalar],
    inverse_mass: wp.array[Scalar],
    form: int,
    factor: wp.array[Scalar],
    # state in
    blocks: wp.array[Mat33],
    extra: wp.array[Scalar],
    # state out
    inverse: wp.array[Mat33],
    number: wp.array[Scalar],
) -> None:
    """Inverse blocks of D of positions, zero for what is fixed, and the mean of D of what is coupled."""
    i = wp.tid()
    block, of_mass = blocks[i], factor[0]
    smallest, of_masses = least_mass[i] * of_mass, inverse_mass[i] / of_mass
    result, mean = block - block, of_mass - of_mass
    if kind[i] == wp.static(FREE):
        result = inverse_3(block, smallest)
    if kind[i] == wp.static(COUPLED):
        result = inverse_of_coupled(block, form, smallest, extra[i], of_masses)
        mean = mean_of_diagonal(block, 3, smallest)
    inverse[i] = result
    number[i] = mean


@kernel(tile=BLOCK)
def bound_vertices(
    # model
    start: wp.array[wp.int32],
    node: wp.array[wp.int32],
    square: wp.array[wp.float64],
    # state in
    of_nodes: wp.array[Scalar],
    # state out
    sums: wp.array2d[wp.float64],
    extra: wp.array[Scalar],
) -> None:
    """Lower bounds of D of coupled vertices: a part of what the nodes have on it, the sum of B^2 D.

    One block of threads finds the sum of each vertex.
    """
    i, lane = wp.tid()
    total = Slots()
    for k in range(start[i] + lane, start[i + 1], wp.block_dim()):
        total[0] += square[k] * wp.float64(of_nodes[node[k]])
    sum_over_block(total, sums[i])
    if lane == 0:
        extra[i] = type(extra[i])(wp.float64(wp.static(LEAST_VERTEX)) * sums[i, 0])


@kernel
def invert_sliding_metric(
    # model
    kind: wp.array[wp.int32],
    slides: wp.array[wp.vec2i],
    least_mass: wp.array[Scalar],
    factor: wp.array[Scalar],
    # state in
    node_inverse: wp.array[Mat33],
    blocks: wp.array[Mat22],
    coupling_u: wp.array[Vec3],
    coupling_v: wp.array[Vec3],
    # state out
    inverse: wp.array[Mat22],
    inverse_u: wp.array[Vec3],
    inverse_v: wp.array[Vec3],
) -> None:
    """Inverse blocks of the Schur complement of D for the Eulerian coordinates, and D^-1 times their columns."""
    i = wp.tid()
    by_u, by_v = node_inverse[i] * coupling_u[i], node_inverse[i] * coupling_v[i]
    if kind[i] != wp.static(FREE) or slides[i][0] == 0:
        by_u = by_u - by_u
    if kind[i] != wp.static(FREE) or slides[i][1] == 0:
        by_v = by_v - by_v
    inverse_u[i] = by_u
    inverse_v[i] = by_v
    pair = blocks[i]
    mixed = wp.dot(by_v, coupling_u[i])
    pair[0, 0] = pair[0, 0] - wp.dot(by_u, coupling_u[i])
    pair[1, 1] = pair[1, 1] - wp.dot(by_v, coupling_v[i])
    pair[0, 1] = pair[0, 1] - mixed
    pair[1, 0] = pair[1, 0] - mixed
    inverse[i] = inverse_where(pair, slides[i], least_mass[i] * factor[0])


MOST_BLOCK_ROWS = 400
"""Largest number of independent vertices of the hybrid region for which D has blocks; the inverse of Sigma then takes
0.2 s of one core."""


@wp.func
def node_motion(inverse: BlockArrays, node: int, push: Vec3, slide: Vec2) -> Any:
    """Motion of a node for the force on it and the motion of its Eulerian coordinates."""
    return inverse.nodes[node] * push - inverse.coupling_u[node] * slide[0] - inverse.coupling_v[node] * slide[1]


@wp.func
def slide_of(inverse: BlockArrays, node: int, push: Vec3, slip: Vec2) -> Any:
    """Motion of the Eulerian coordinates of a node for the force on the node and on them."""
    along_u, along_v = wp.dot(inverse.coupling_u[node], push), wp.dot(inverse.coupling_v[node], push)
    return inverse.sliding[node] * type(slip)(slip[0] - along_u, slip[1] - along_v)


@kernel
def times_inverse(
    # model
    inverse: BlockArrays,
    # state in
    force: MixedArrays,
    # state out
    motion: MixedArrays,
) -> None:
    """Multiply by the inverse blocks: z = D^-1 r."""
    i = wp.tid()
    vertex_count = force.vertices.shape[0]
    if i < vertex_count:
        motion.vertices[i] = inverse.vertices[i] * force.vertices[i]
    else:
        j = i - vertex_count
        slide = slide_of(inverse, j, force.nodes[j], force.sliding[j])
        motion.nodes[j] = node_motion(inverse, j, force.nodes[j], slide)
        motion.sliding[j] = slide


@wp.func
def advance_vertex(
    inverse: BlockArrays, alpha: wp.float64, i: int, direction: MixedArrays, product: MixedArrays,
    solution: MixedArrays, force: MixedArrays, motion: MixedArrays
) -> wp.float64:  # fmt: skip
    """Find x + a d, r - a A d and z = D^-1 r of a vertex, and its part of r . z."""
    a = type(force.vertices[i][0])(alpha)
    solution.vertices[i] = solution.vertices[i] + direction.vertices[i] * a
    pull = force.vertices[i] - product.vertices[i] * a
    force.vertices[i] = pull
    moved = inverse.vertices[i] * pull
    motion.vertices[i] = moved
    return wp.float64(wp.dot(pull, moved))


@wp.func
def advance_node(
    inverse: BlockArrays, alpha: wp.float64, j: int, direction: MixedArrays, product: MixedArrays,
    solution: MixedArrays, force: MixedArrays, motion: MixedArrays
) -> wp.float64:  # fmt: skip
    """Find x + a d, r - a A d and z = D^-1 r of a node, and its part of r . z."""
    a = type(force.nodes[j][0])(alpha)
    solution.nodes[j] = solution.nodes[j] + direction.nodes[j] * a
    solution.sliding[j] = solution.sliding[j] + direction.sliding[j] * a
    push, slip = force.nodes[j] - product.nodes[j] * a, force.sliding[j] - product.sliding[j] * a
    force.nodes[j] = push
    force.sliding[j] = slip
    slide = slide_of(inverse, j, push, slip)
    moved = node_motion(inverse, j, push, slide)
    motion.nodes[j] = moved
    motion.sliding[j] = slide
    return wp.float64(wp.dot(push, moved)) + wp.float64(wp.dot(slip, slide))


@kernel(tile=THREADS)
def advance_and_invert(
    # model
    inverse: BlockArrays,
    chunk: int,
    # state in
    record: wp.array[wp.float64],
    curvature: wp.array2d[wp.float64],
    direction: MixedArrays,
    product: MixedArrays,
    # state in and out
    solution: MixedArrays,
    force: MixedArrays,
    # state out
    motion: MixedArrays,
    sums: wp.array2d[wp.float64],
    after: wp.array[wp.float64],
    parts: wp.array2d[wp.float64],
) -> None:
    """Find a, x + a d, r - a A d, z = D^-1 r and the parts of r . z, each chunk of vertices and nodes by one block."""
    block, lane = wp.tid()
    total = add_parts(curvature, 0, curvature.shape[0], lane, sums[block])
    alpha = record_alpha(total, record, block == 0 and lane == 0, after)
    vertex_count, node_count = force.vertices.shape[0], force.nodes.shape[0]
    products = Slots()
    for i in range(block * chunk + lane, wp.min((block + 1) * chunk, vertex_count + node_count), wp.block_dim()):
        if i < vertex_count:
            products[0] += advance_vertex(inverse, alpha, i, direction, product, solution, force, motion)
        else:
            j = i - vertex_count
            products[0] += advance_node(inverse, alpha, j, direction, product, solution, force, motion)
    sum_over_block(products, parts[block])


def least_masses(embedding: Embedding, node_mass: Numbers) -> Numbers:
    """Lower bounds of the masses of vertices and simulated nodes in D [g], shape (V + n,)."""
    on_vertices = embedding.basis.power(2).T @ node_mass[embedding.nodes]
    mean = float(node_mass.mean()) if node_mass.any() else 1.0
    vertices = np.maximum(LEAST_VERTEX * on_vertices, LEAST_NODE * LEAST_VERTEX * mean)
    return np.concatenate([vertices, np.full(len(node_mass), LEAST_NODE * mean)])


class Preconditioner:
    """The inverse of P for an embedding, on a device.

    ``inverse`` holds the blocks of D^-1. Its blocks of Eulerian coordinates are the inverse Schur complement, and its
    columns of coupling are multiplied by the inverse block of their node.
    """

    def __init__(
        self,
        embedding: Embedding,
        free: FreeUnknowns,
        masses: tuple[Numbers, Numbers],
        scalar: ScalarType,
        device: wp.Device,
        *,
        by_masses: bool,
    ) -> None:
        """Allocate; ``set_metric`` must follow.

        Args:
            embedding: how hybrid nodes move with the triangles.
            free: which coordinates are unknown.
            masses: masses of vertices and simulated nodes [g], shapes (V,) and (n,). They give the metric of the
                masses, and a lower bound of D where nothing has mass.
            scalar: Warp's floating-point type.
            device: where the vectors lie.
            by_masses: whether D in the hybrid region consists of the masses alone, instead of the blocks of
                ``set_metric``. Sigma is then computed once.

        Raises:
            ParameterError: the hybrid region has too many vertices.
        """
        self._embedding, self._device, self._by_masses = embedding, device, by_masses
        self._form = BY_MASSES if by_masses else _form_of(embedding)
        counts = embedding.vertex_count, embedding.node_count
        self.inverse = MixedBlocks.zeros(*counts, scalar, device)
        element = wp.mat33d if self._form == BLOCKS else wp.float64
        self._projection = Projection(embedding, self.inverse, element=element, device=device)
        self._factor, self._factor_now = wp.ones(1, dtype=scalar, device=device), 1.0
        self._allocate(free, masses, scalar)
        self._sums = wp.zeros((embedding.vertex_count, WIDTH), dtype=wp.float64, device=device)
        self._captured: tuple[MixedBlocks, CapturedLaunches] | None = None

    def _allocate(self, free: FreeUnknowns, masses: tuple[Numbers, Numbers], scalar: ScalarType) -> None:
        """Send kinds, masses and bounds of vertices and nodes to the device, and find Sigma of the masses."""
        device, halves = self._device, [self._embedding.vertex_count]
        least = least_masses(self._embedding, masses[1])
        of_masses = 1.0 / np.maximum(np.concatenate(masses), least)
        self._least, self._inverse_mass, self._number, self._extra = (
            [wp.array(part, dtype=scalar, device=device) for part in np.split(numbers, halves)]
            for numbers in (least, of_masses, np.zeros_like(least), np.zeros_like(least))
        )
        free_parts = free.vertices, free.nodes
        kinds = [np.where(c, COUPLED, FREE) * f for c, f in zip(self._embedding.coupled, free_parts, strict=True)]
        self._kinds = [self._integers(kind) for kind in kinds]
        self._slides = wp.array(free.sliding.astype(np.int32), dtype=wp.vec2i, device=device)
        self._squares = self._rows_of_squares()
        inverses = [
            np.where(kind == COUPLED, p, 0.0) for kind, p in zip(kinds, np.split(of_masses, halves), strict=True)
        ]
        if self._by_masses:
            self._projection.invert(inverses[0], inverses[1])
        self._on_device = device.is_cuda and not self._by_masses and self._projection.row_count > 0
        # if Sigma is positive for the masses of the moving coordinates, it is positive for any metric
        self._on_device = self._on_device and self._projection.is_regular(inverses[0], inverses[1])

    def _rows_of_squares(self) -> list[wp.array[Any]]:
        """The squares of B for each vertex, as compressed rows of simulated nodes."""
        squares = csr_array(self._embedding.basis.power(2).T)
        rows = squares.indptr, self._embedding.nodes[squares.indices]
        values = wp.array(squares.data, dtype=wp.float64, device=self._device)
        return [*(self._integers(row) for row in rows), values]

    def set_metric(self, metric: MixedBlocks, of_mass: float = 1.0) -> None:
        """Invert the metric D of motions.

        Args:
            metric: diagonal blocks of D.
            of_mass: factor of the masses in D [1/s^2].
        """
        if of_mass != self._factor_now:
            self._factor.assign([of_mass])
            self._factor_now = of_mass
        if self._captured is None or self._captured[0] is not metric:
            launches = self._metric_launches(metric, partial(prepare, device=self._device))
            self._captured = metric, CapturedLaunches(launches, self._device)
        self._captured[1].launch()
        if self._by_masses:
            self._projection.set_scale(of_mass)
        elif self._projection.row_count and not self._on_device:
            self._projection.invert_present()

    def _metric_launches(self, metric: MixedBlocks, launcher: Launcher) -> list[Any]:
        """The launches that invert the blocks of nodes, then the blocks of vertices, and Sigma on a GPU."""
        own, launches = self.inverse, []
        if metric.nodes.shape[0]:
            launches += [
                self._inversion(1, metric.nodes, own.nodes, launcher),
                launcher(invert_sliding_metric, len(own.nodes), *self._sliding_arguments(metric)),
            ]
        if self._projection.row_count and not self._by_masses:
            outputs = [self._sums, self._extra[0]]
            inputs = [*self._squares, self._number[1]]
            launches.append(launcher(bound_vertices, len(own.vertices), inputs, outputs))
        if metric.vertices.shape[0]:
            launches.append(self._inversion(0, metric.vertices, own.vertices, launcher))
        return [*launches, *(self._projection.inverse_launches(launcher) if self._on_device else [])]

    def _inversion(self, part: int, blocks: wp.array[Any], inverse: wp.array[Any], launcher: Launcher) -> Any:
        """The launch that inverts the blocks of vertices (part 0) or nodes (part 1)."""
        model = [self._kinds[part], self._least[part], self._inverse_mass[part], self._form, self._factor]
        inputs, outputs = [*model, blocks, self._extra[part]], [inverse, self._number[part]]
        return launcher(invert_metric, len(blocks), inputs, outputs)

    def _sliding_arguments(self, metric: MixedBlocks) -> tuple[list[Any], list[Any]]:
        """Inputs and outputs of the launch that inverts the blocks of Eulerian coordinates."""
        own = self.inverse
        inputs = [self._kinds[1], self._slides, self._least[1], self._factor, own.nodes]
        inputs += [metric.sliding, metric.coupling_u, metric.coupling_v]
        return inputs, [own.sliding, own.coupling_u, own.coupling_v]

    def launches(self, force: MixedVector, motion: MixedVector, launcher: Launcher) -> list[Any]:
        """The launches that find the motion z of P z = r.

        Args:
            force: forces f on vertices, nodes and Eulerian coordinates; replaced by f - E' mu, which has the same
                filtered form r.
            motion: set to z as (v, p, s), with p = B v + F x.
            launcher: ``launch`` or ``prepare`` with the device bound.
        """
        count = force.vertex_count + force.node_count
        first = launcher(times_inverse, count, [self.inverse.arrays, force.arrays], [motion.arrays])
        return [first, *self._projection.launches(motion, launcher, force=force)]

    def advance_launches(
        self, advance: Advance, force: MixedVector, motion: MixedVector, launcher: Launcher
    ) -> list[Any]:
        """The launches that advance a solution, find the motion of the remaining force, and the next direction.

        Args:
            advance: the records, d and A d of the iteration; d becomes the next direction.
            force: r; becomes r - a A d, and then changes as in ``launches``.
            motion: set to D^-1 r, the value of z before its projection.
            launcher: ``launch`` or ``prepare`` with the device bound.
        """
        count, projection = force.vertex_count + force.node_count, self._projection
        chunk, blocks, turned = chunk_of(count, self._device), part_count(count, self._device), advance.direction.arrays
        vectors = [turned, advance.product.arrays, advance.solution.arrays, force.arrays]
        inputs = [self.inverse.arrays, chunk, advance.record, advance.curvature, *vectors]
        outputs = [motion.arrays, advance.sums, advance.after, advance.parts]
        first = launcher(advance_and_invert, blocks, inputs, outputs)
        inputs = [projection.coupling, self.inverse.arrays, chunk, advance.after, advance.parts]
        inputs += [projection.residual, projection.multiplier, motion.arrays, force.arrays, turned]
        outputs = [advance.sums, advance.record, advance.active]
        found = projection.multiplier_launches(motion, launcher)
        return [first, *found, launcher(next_direction, blocks, inputs, outputs)]

    def project_launches(self, motion: MixedVector, launcher: Launcher) -> list[Any]:
        """The launches that change a motion to the nearest p = B v + F x in the metric D; fixed coordinates stay."""
        return self._projection.launches(motion, launcher)

    def _integers(self, values: NDArray[Any]) -> wp.array[wp.int32]:
        return wp.array(values.astype(np.int32), dtype=wp.int32, device=self._device)


def _form_of(embedding: Embedding) -> int:
    """The form of D in the hybrid region if D contains stiffness."""
    return BLOCKS if embedding.independent.shape[1] <= MOST_BLOCK_ROWS else ONE_NUMBER
