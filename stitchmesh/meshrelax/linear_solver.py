# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The net forces and the linear system of a step: conjugate gradients with constraints, and their preconditioner.

The matrix is A = D - W^T B W with a block D of each vertex and a Jacobian B of each element (``assembly``). A product
A x is computed element by element, on the device: first B (W x), then D x - W^T of it.

Each vertex may move only in its allowed directions: the tangent plane, the tangent of a border, or no direction. The
solution contains only allowed directions, and only the residual in these directions must vanish (Baraff and Witkin
1998, section 5.3). The filter that removes all other directions is part of the preconditioner. The algorithm uses the
residual only after preconditioning, so that no separate filter is needed.

The inverse of the diagonal block A_v of each vertex reduces errors between neighbours fast, but it carries a motion of
the whole garment on by only one stitch per iteration. A coarse space solves for such motions directly. The fabric is
divided into patches of about thirty stitches, and each patch may shift in its plane (additive Schwarz with a coarse
space; Nicolaides 1987):

    M^-1 = P A_v^-1 P + Z (Z^T A Z)^-1 Z^T

P is the projector onto the allowed directions, and the columns of Z are also allowed directions. An element adds the
block - (sum_i w_i Z_i)^T B (sum_j w_j Z_j) to each pair of patches that it touches, with its vertices i in the one
patch and j in the other. The matrix Z^T A Z of the patches is factored as a sparse matrix on the host, because dense
factorizations become very slow if their threads share few cores.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np
import warp as wp
from scipy.sparse import bsr_array, coo_array, diags_array
from scipy.sparse.linalg import splu

from stitchmesh.compute.captured import CapturedLaunches, CopyArray
from stitchmesh.compute.host_copy import HostCopy
from stitchmesh.compute.kernel import kernel
from stitchmesh.compute.kernel_variants import KernelForm, kernel_factory
from stitchmesh.compute.launch import launch, prepare
from stitchmesh.compute.partial_sums import add_parts, chunk_of, dot_parts, part_count, parts_for
from stitchmesh.compute.thread_block import THREADS
from stitchmesh.mesh import FloatArray, IntArray
from stitchmesh.mesh.arrays import unit_vectors
from stitchmesh.meshrelax.assembly import Assembly
from stitchmesh.meshrelax.forces import Symmetric, whole_matrix

PATCH_VERTICES, MOST_PATCHES = 30, 4000
"""Approximate number of vertices per patch, which is larger in fabrics with more than this number of patches. Larger
patches need more iterations; smaller ones need larger factors."""
REGULARIZATION = 1e-6
"""This part of its diagonal is added to the matrix of the patches. Without it the matrix is singular for a patch of
border vertices, because the two motions of such a patch are linearly dependent."""
NO_MOTION = 1e-12
"""If the diagonal entry of a motion, divided by the largest entry, is below this, it is only rounding error, because
the vertices of the patch may not make this motion."""


@dataclass(frozen=True, eq=False)
class Patches:
    """The patches of a fabric and their motions."""

    patch: IntArray
    """Patch of each vertex, shape (V,)."""
    count: int
    """Number of patches."""
    motions: FloatArray
    """Displacement of each vertex in the two motions of its patch, shape (V, 3, 2)."""


def patches(position: FloatArray, normal: FloatArray, area: float) -> Patches:
    """Divide a fabric into patches; a patch consists of the vertices in one grid cell whose normals are in one octant.

    Args:
        position: positions of the vertices [cm], shape (V, 3).
        normal: unit normal of the surface at each vertex, shape (V, 3).
        area: area of the surface [cm^2].
    """
    size = np.sqrt(area * max(PATCH_VERTICES / len(position), 1.0 / MOST_PATCHES))
    cell = np.floor((position - position.mean(axis=0)) / size).astype(np.int64)
    cell -= cell.min(axis=0)
    octant = (normal > 0.0) @ np.array([4, 2, 1])
    extent = cell.max(axis=0) + 1
    key = ((cell[:, 0] * extent[1] + cell[:, 1]) * extent[2] + cell[:, 2]) * 8 + octant
    patch = np.unique(key, return_inverse=True)[1].ravel()
    count = int(patch.max()) + 1
    total: FloatArray = np.stack([np.bincount(patch, normal[:, k], count) for k in range(3)], axis=1)
    return Patches(patch, count, _tangent_frames(total)[patch])


def _tangent_frames(normal: FloatArray) -> FloatArray:
    """Two orthogonal unit vectors perpendicular to each normal, shape (n, 3, 2)."""
    axis = np.eye(3)[np.abs(normal).argmin(axis=1)]
    first = np.cross(normal, axis)
    second = np.cross(normal, first)
    return unit_vectors(np.stack([first, second], axis=2), axis=1)


@wp.func
def motion_products(first: wp.vec3d, second: wp.vec3d, first_image: wp.vec3d, second_image: wp.vec3d) -> wp.mat22d:
    """Products of two motions with the images of two others."""
    return wp.mat22d(
        wp.dot(first, first_image), wp.dot(first, second_image),
        wp.dot(second, first_image), wp.dot(second, second_image),
    )  # fmt: skip


def _slots_of_elements(form: KernelForm) -> list[tuple[int]]:
    """Return the largest numbers of vertices of an element: three, and the periods of a lattice."""
    return [(3,), (4,), (5,)] if form.on_lattice else [(3,)]


@kernel_factory(_slots_of_elements)
def multiply_elements(slots: int) -> wp.Kernel:
    """Return the kernel for elements of at most ``slots`` vertices; a loop of fixed length takes half the time."""

    @kernel
    def multiply_elements(
        # model
        vertices: wp.array2d[wp.int32],
        weights: wp.array2d[wp.float64],
        # state in
        jacobian: wp.array[Symmetric],
        vector: wp.array[wp.vec3d],
        # state out
        product: wp.array[wp.vec3d],
    ) -> None:
        """B W x of each element."""
        e = wp.tid()
        total = wp.vec3d()
        for k in range(slots):
            total += weights[e, k] * vector[vertices[e, k]]
        product[e] = whole_matrix(jacobian[e]) * total

    return multiply_elements


@kernel
def gather_forces(
    # model
    start: wp.array[wp.int32],
    element: wp.array[wp.int32],
    weight: wp.array[wp.float64],
    # state in
    force: wp.array[wp.vec3d],
    # state out
    total: wp.array[wp.vec3d],
) -> None:
    """W^T g of each vertex."""
    v = wp.tid()
    own = wp.vec3d()
    for k in range(start[v], start[v + 1]):
        own += weight[k] * force[element[k]]
    total[v] = own


@kernel
def gather_products(
    # model
    start: wp.array[wp.int32],
    element: wp.array[wp.int32],
    weight: wp.array[wp.float64],
    # state in
    blocks: wp.array[wp.mat33d],
    vector: wp.array[wp.vec3d],
    product: wp.array[wp.vec3d],
    # state out
    image: wp.array[wp.vec3d],
) -> None:
    """A x of each vertex: D x minus the products of its elements."""
    v = wp.tid()
    total = blocks[v] * vector[v]
    for k in range(start[v], start[v + 1]):
        total -= weight[k] * product[element[k]]
    image[v] = total


@kernel
def constrain_vertices(
    # model
    start: wp.array[wp.int32],
    element: wp.array[wp.int32],
    weight: wp.array[wp.float64],
    motions: wp.array2d[wp.vec3d],
    # state in
    jacobian: wp.array[Symmetric],
    blocks: wp.array[wp.mat33d],
    projector: wp.array[wp.mat33d],
    # state out
    inverse: wp.array[wp.mat33d],
    allowed: wp.array2d[wp.vec3d],
) -> None:
    """P A_v^-1 P of each vertex within its allowed directions, and the allowed part of the motions of its patch."""
    v = wp.tid()
    diagonal = blocks[v]
    for k in range(start[v], start[v + 1]):
        diagonal -= (weight[k] * weight[k]) * whole_matrix(jacobian[element[k]])
    own = projector[v]
    one = wp.identity(n=3, dtype=wp.float64)
    inverse[v] = own * wp.inverse(own * diagonal * own + (one - own)) * own
    for k in range(2):
        allowed[v, k] = own * motions[v, k]


@kernel_factory(_slots_of_elements)
def multiply_patches(slots: int) -> wp.Kernel:
    """Return the kernel for elements of at most ``slots`` vertices."""

    @kernel
    def multiply_patches(
        # model
        vertices: wp.array2d[wp.int32],
        weights: wp.array2d[wp.float64],
        patch_of: wp.array[wp.int32],
        patch_start: wp.array[wp.int32],
        patch_vertex: wp.array[wp.int32],
        pair: wp.array2d[wp.int32],
        pair_start: wp.array[wp.int32],
        pair_element: wp.array[wp.int32],
        # state in
        jacobian: wp.array[Symmetric],
        blocks: wp.array[wp.mat33d],
        allowed: wp.array2d[wp.vec3d],
        # state out
        entries: wp.array[wp.mat22d],
    ) -> None:
        """The block of Z^T A Z of each pair of patches; -1 stands for no element."""
        n = wp.tid()
        one = pair[n, 0]
        other = pair[n, 1]
        total = wp.mat22d()
        if one == other:
            for k in range(patch_start[one], patch_start[one + 1]):
                v = patch_vertex[k]
                first = blocks[v] * allowed[v, 0]
                second = blocks[v] * allowed[v, 1]
                total += motion_products(allowed[v, 0], allowed[v, 1], first, second)
        for k in range(pair_start[n], pair_start[n + 1]):
            e = pair_element[k]
            if e >= 0:
                in_one_0 = wp.vec3d()
                in_one_1 = wp.vec3d()
                in_other_0 = wp.vec3d()
                in_other_1 = wp.vec3d()
                for s in range(slots):
                    v = vertices[e, s]
                    if patch_of[v] == one:
                        in_one_0 += weights[e, s] * allowed[v, 0]
                        in_one_1 += weights[e, s] * allowed[v, 1]
                    if patch_of[v] == other:
                        in_other_0 += weights[e, s] * allowed[v, 0]
                        in_other_1 += weights[e, s] * allowed[v, 1]
                own = whole_matrix(jacobian[e])
                total -= motion_products(in_one_0, in_one_1, own * in_other_0, own * in_other_1)
        entries[n] = total

    return multiply_patches


@kernel
def restrict_residual(
    # model
    patch_start: wp.array[wp.int32],
    patch_vertex: wp.array[wp.int32],
    # state in
    allowed: wp.array2d[wp.vec3d],
    residual: wp.array[wp.vec3d],
    # state out
    coarse: wp.array[wp.float64],
) -> None:
    """Z^T r of each motion of each patch."""
    n = wp.tid()
    patch = n // 2
    total = wp.float64(0.0)
    for k in range(patch_start[patch], patch_start[patch + 1]):
        v = patch_vertex[k]
        total += wp.dot(allowed[v, n % 2], residual[v])
    coarse[n] = total


@kernel
def precondition(
    # model
    patch_of: wp.array[wp.int32],
    # state in
    inverse: wp.array[wp.mat33d],
    allowed: wp.array2d[wp.vec3d],
    coarse: wp.array[wp.float64],
    residual: wp.array[wp.vec3d],
    # state out
    conditioned: wp.array[wp.vec3d],
) -> None:
    """M^-1 r of each vertex, from the solution of the patches."""
    v = wp.tid()
    n = 2 * patch_of[v]
    conditioned[v] = inverse[v] * residual[v] + allowed[v, 0] * coarse[n] + allowed[v, 1] * coarse[n + 1]


@kernel(tile=THREADS)
def advance(
    # model
    chunk: int,
    # state in
    size: wp.array[wp.float64],
    parts: wp.array2d[wp.float64],
    direction: wp.array[wp.float64],
    image: wp.array[wp.float64],
    # state in and out
    sums: wp.array2d[wp.float64],
    solution: wp.array[wp.float64],
    residual: wp.array[wp.float64],
) -> None:
    """X + a d and r - a A d with a = r . z / d . A d; ``parts`` are those of d . A d."""
    block, lane = wp.tid()
    length = size[0] / add_parts(parts, 0, parts.shape[0], lane, sums[block])
    for i in range(block * chunk + lane, wp.min((block + 1) * chunk, solution.shape[0]), wp.block_dim()):
        solution[i] += length * direction[i]
        residual[i] -= length * image[i]


@kernel(tile=THREADS)
def turn(
    # model
    chunk: int,
    # state in
    size: wp.array[wp.float64],
    parts: wp.array2d[wp.float64],
    conditioned: wp.array[wp.float64],
    # state in and out
    sums: wp.array2d[wp.float64],
    direction: wp.array[wp.float64],
    # state out
    next_size: wp.array[wp.float64],
) -> None:
    """Z + b d with b = new r . z / old r . z; ``parts`` are those of the new one."""
    block, lane = wp.tid()
    new = add_parts(parts, 0, parts.shape[0], lane, sums[block])
    ratio = new / size[0]
    for i in range(block * chunk + lane, wp.min((block + 1) * chunk, direction.shape[0]), wp.block_dim()):
        direction[i] = conditioned[i] + ratio * direction[i]
    if block == 0 and lane == 0:
        next_size[0] = new


class StepSystem:
    """The matrix of a step and its two-level preconditioner, on a device; both change with the state of the fabric."""

    def __init__(self, assembly: Assembly, fabric_patches: Patches, device: wp.Device) -> None:
        """Upload what stays the same in all steps.

        Args:
            assembly: vertices of the elements.
            fabric_patches: patches of the same vertices.
            device: where the products are computed.
        """
        count, elements, coarse = len(fabric_patches.patch), len(assembly.vertices), fabric_patches.count
        self._device = device

        def integers(values: IntArray) -> wp.array[Any]:
            return wp.array(np.ascontiguousarray(values, dtype=np.int32), dtype=wp.int32, device=device)

        def empty(shape: int | tuple[int, ...], dtype: Any) -> wp.array[Any]:
            return wp.empty(shape, dtype=dtype, device=device)

        scatter = assembly.scatter
        weights = wp.array(assembly.weights, dtype=wp.float64, device=device)
        self._slots = assembly.vertices.shape[1]
        self._elements = [integers(assembly.vertices), weights]
        weight = wp.array(scatter.data, dtype=wp.float64, device=device)
        self._rows = [integers(scatter.indptr), integers(scatter.indices), weight]
        self._patch = integers(fabric_patches.patch)
        order, start = _grouped(fabric_patches.patch, coarse)
        self._patch_lists = [integers(start), integers(order)]
        motions = np.ascontiguousarray(np.moveaxis(fabric_patches.motions, 2, 1))
        self._motions = wp.array(motions, dtype=wp.vec3d, device=device)
        self._pairs = PatchPairs.of(assembly, fabric_patches)
        self._pair_lists = [integers(each) for each in (self._pairs.pair, self._pairs.start, self._pairs.element)]
        self._entries = empty(len(self._pairs.pair), wp.mat22d)
        self._jacobian, self._product = empty(elements, Symmetric), empty(elements, wp.vec3d)
        self._blocks, self._projector, self._inverse = (empty(count, wp.mat33d) for _ in range(3))
        self._allowed = empty((count, 2), wp.vec3d)
        self._solution, self._residual, self._direction, self._image, self._conditioned = (
            empty(count, wp.vec3d) for _ in range(5)
        )
        self._coarse, self._size, self._next_size = (empty(n, wp.float64) for n in (2 * coarse, 1, 1))
        self._read_coarse, self._read_size = HostCopy(self._coarse), HostCopy(self._next_size)
        self._capture(count, coarse)

    def _capture(self, count: int, coarse: int) -> None:
        """Prepare the launches of an iteration before and after the solution of the patches."""
        run = partial(prepare, device=self._device)
        chunk, blocks = chunk_of(3 * count, self._device), part_count(3 * count, self._device)
        parts = parts_for(3 * count, self._device)
        sums = wp.zeros_like(parts)
        solution, residual, direction, image, conditioned = (
            _flat(each)
            for each in (self._solution, self._residual, self._direction, self._image, self._conditioned)
        )
        multiplied = [*self._elements, self._jacobian, self._direction]
        gathered = [*self._rows, self._blocks, self._direction, self._product]
        restrict = run(
            restrict_residual, 2 * coarse, [*self._patch_lists, self._allowed, self._residual], [self._coarse]
        )
        self._restrict = CapturedLaunches([restrict], self._device)
        self._advance = CapturedLaunches(
            [
                CopyArray(self._next_size, self._size),
                run(multiply_elements(self._slots), len(self._product), multiplied, [self._product]),
                run(gather_products, count, gathered, [self._image]),
                run(dot_parts, blocks, [chunk, direction, image], [parts]),
                run(advance, blocks, [chunk, self._size, parts, direction, image], [sums, solution, residual]),
                restrict,
            ],
            self._device,
        )
        corrected = [self._patch, self._inverse, self._allowed, self._coarse, self._residual]
        self._turn = CapturedLaunches(
            [
                run(precondition, count, corrected, [self._conditioned]),
                run(dot_parts, blocks, [chunk, residual, conditioned], [parts]),
                run(turn, blocks, [chunk, self._size, parts, conditioned], [sums, direction, self._next_size]),
            ],
            self._device,
        )

    def net_force(self, force: wp.array[Any]) -> FloatArray:
        """Return the force on each vertex, shape (V, 3), from the forces of the elements, shape (elements, 3)."""
        launch(gather_forces, len(self._patch), [*self._rows, force], [self._image], self._device)
        return self._image.numpy().astype(np.float64)

    def set_matrix(self, jacobian: wp.array[Any], blocks: FloatArray, projector: FloatArray) -> None:
        """Set the matrix and build its preconditioner.

        Args:
            jacobian: negative semidefinite Jacobian B of each element [1/cm] (``forces.ElementForces``).
            blocks: positive definite block D of each vertex [1/cm], shape (V, 3, 3).
            projector: projector P onto the allowed directions of each vertex, shape (V, 3, 3).
        """
        wp.copy(self._jacobian, jacobian)
        self._blocks.assign(np.ascontiguousarray(blocks))
        self._projector.assign(np.ascontiguousarray(projector))
        inputs = [*self._rows, self._motions, self._jacobian, self._blocks, self._projector]
        launch(constrain_vertices, len(self._patch), inputs, [self._inverse, self._allowed], self._device)
        reduced = self.patch_matrix()
        entries = reduced.diagonal()
        added = diags_array(np.where(entries > NO_MOTION * entries.max(), REGULARIZATION * entries, 1.0))
        regularized = (reduced + added).tocsc()
        self._factor = splu(regularized, permc_spec="MMD_AT_PLUS_A", options={"SymmetricMode": True})

    def patch_matrix(self) -> bsr_array:
        """Return Z^T A Z of the matrix that was set last, shape (2 patches, 2 patches)."""
        matrix = [self._jacobian, self._blocks, self._allowed]
        inputs = [*self._elements, self._patch, *self._patch_lists, *self._pair_lists, *matrix]
        launch(multiply_patches(self._slots), len(self._entries), inputs, [self._entries], self._device)
        return self._pairs.matrix(self._entries.numpy())

    def solve(self, right: FloatArray, *, tolerance: float, max_iterations: int) -> tuple[FloatArray, int]:
        """Solve A x = b within the allowed directions, for the matrix that was set last.

        Args:
            right: right-hand side b, shape (V, 3).
            tolerance: residual over the right-hand side at which the solution has converged, both in the norm of the
                preconditioner. Rounding of what the filter removes leaves about 1e-8, so that it must be larger.
            max_iterations: largest number of iterations; also after these the solution is a descent direction.

        Returns:
            The solution, shape (V, 3), and the number of iterations.
        """
        self._residual.assign(np.ascontiguousarray(right))
        self._solution.zero_()
        self._direction.zero_()
        self._size.fill_(1.0)
        self._restrict.launch()
        size = self._precondition()
        goal, iteration = tolerance**2 * size, 0
        while size > goal and iteration < max_iterations:
            self._advance.launch()
            size = self._precondition()
            iteration += 1
        return self._solution.numpy().astype(np.float64), iteration

    def _precondition(self) -> float:
        """Solve for the patches, precondition the residual, turn the direction, and return r . z."""
        self._coarse.assign(self._factor.solve(self._read_coarse.read()))
        self._turn.launch()
        return float(self._read_size.read()[0])


@dataclass(frozen=True, eq=False)
class PatchPairs:
    """The pairs of patches that share elements, each pair once and each patch with itself."""

    pair: IntArray
    """The two patches, the smaller number first, shape (N, 2)."""
    start: IntArray
    """Number of the first element of each pair in ``element``, and at the end the number of all, shape (N + 1,)."""
    element: IntArray
    """Elements that touch both patches; -1 stands for none, so that each patch has a pair with itself."""
    order: IntArray
    """Order of the blocks of the matrix: those of the pairs, and then the transposed ones of different patches."""
    indices: IntArray
    """Column of each block in this order."""
    indptr: IntArray
    """Number of the first block of each row, and at the end the number of all."""

    @staticmethod
    def of(assembly: Assembly, fabric_patches: Patches) -> PatchPairs:
        """Find the pairs of patches that the elements touch."""
        touched = np.where(assembly.weights != 0.0, fabric_patches.patch[assembly.vertices], -1)
        slots, count = range(touched.shape[1]), fabric_patches.count
        new = [touched[:, k] >= 0 for k in slots]  # whether no earlier vertex of the element is in this patch
        for k in slots:
            for earlier in range(k):
                new[k] &= touched[:, k] != touched[:, earlier]
        element, one, other = [np.full(count, -1)], [np.arange(count)], [np.arange(count)]
        for a in slots:
            for b in slots:
                both = np.flatnonzero(new[a] & new[b] & (touched[:, a] <= touched[:, b]))
                element.append(both)
                one.append(touched[both, a])
                other.append(touched[both, b])
        pairs = np.stack([np.concatenate(one), np.concatenate(other)], axis=1)
        order = _in_order(pairs, count)
        pairs = pairs[order]
        first = np.flatnonzero(np.r_[True, (pairs[1:] != pairs[:-1]).any(axis=1)])
        pair = pairs[first]
        whole = np.concatenate([pair, pair[pair[:, 0] != pair[:, 1]][:, ::-1]])
        blocks = _in_order(whole, count)
        indptr = np.r_[0, np.cumsum(np.bincount(whole[:, 0], minlength=count))]
        start = np.r_[first, len(pairs)]
        return PatchPairs(pair, start, np.concatenate(element)[order], blocks, whole[blocks, 1], indptr)

    def matrix(self, entries: FloatArray) -> bsr_array:
        """Return the symmetric matrix of the patches from the blocks of the pairs, shape (N, 2, 2)."""
        apart = self.pair[:, 0] != self.pair[:, 1]
        blocks = np.concatenate([entries, entries[apart].transpose(0, 2, 1)])[self.order]
        size = 2 * (len(self.indptr) - 1)
        return bsr_array((blocks, self.indices, self.indptr), shape=(size, size))


def _in_order(pairs: IntArray, count: int) -> IntArray:
    """Return the order by the first and then by the second number of each pair; equal pairs keep their order."""
    by_second, _ = _grouped(pairs[:, 1], count)
    by_first, _ = _grouped(pairs[by_second, 0], count)
    order: IntArray = by_second[by_first]
    return order


def _grouped(group: IntArray, count: int) -> tuple[IntArray, IntArray]:
    """Return the members of each group, ascending, and the place of the first member of each; a counting sort."""
    members = np.arange(len(group))
    lists = coo_array((np.ones(len(group), dtype=np.int8), (group, members)), shape=(count, len(group))).tocsr()
    return lists.indices, lists.indptr


def _flat(vectors: wp.array[Any]) -> wp.array[Any]:
    """Return the same memory as single numbers."""
    return wp.array(ptr=vectors.ptr, dtype=wp.float64, shape=3 * len(vectors), device=vectors.device)
