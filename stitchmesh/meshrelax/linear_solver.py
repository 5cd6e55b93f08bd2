# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The linear system of a step: conjugate gradients with constraints, and their two-level preconditioner.

Each vertex may move only in its allowed directions: the tangent plane, the tangent of a border, or no direction. The
solution contains only allowed directions, and only the residual in these directions must vanish (Baraff and Witkin
1998, section 5.3). The filter that removes all other directions is part of the preconditioner. The algorithm uses the
residual only after preconditioning, so that no separate filter is needed.

The inverse of the diagonal block D of each vertex reduces errors between neighbours fast, but it carries a motion of
the whole garment on by only one stitch per iteration. A coarse space solves for such motions directly. The fabric is
divided into patches of about thirty stitches, and each patch may shift in its plane (additive Schwarz with a coarse
space; Nicolaides 1987):

    M^-1 = P D^-1 P + Z (Z^T A Z)^-1 Z^T

P is the projector onto the allowed directions, and the columns of Z are also allowed directions. The matrix Z^T A Z of
the patches is factored as a sparse matrix, because dense factorizations become very slow if their threads share few
cores.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from scipy.sparse import bsr_array, diags_array
from scipy.sparse.linalg import splu

from stitchmesh.compute.threads import each_block
from stitchmesh.mesh import FloatArray, IntArray
from stitchmesh.mesh.arrays import unit_vectors
from stitchmesh.meshrelax.placement import VERTICES_OF_BLOCK

PATCH_VERTICES = 30
"""Approximate number of vertices per patch. Larger patches need more iterations; smaller ones need larger factors."""
REGULARIZATION = 1e-6
"""This part of its diagonal is added to the matrix of the patches. Without it the matrix is singular for a patch of
border vertices, because the two motions of such a patch are linearly dependent."""
NO_MOTION = 1e-12
"""If the diagonal entry of a motion, divided by the largest entry, is below this, it is only rounding error, because
the vertices of the patch may not make this motion."""

Preconditioner = Callable[[FloatArray], FloatArray]
"""Function from a residual to the preconditioned residual, shape (3V,) each."""


@dataclass(frozen=True, eq=False)
class Patches:
    """The patches of a fabric and their motions."""

    patch: IntArray
    """Patch of each vertex, shape (V,)."""
    count: int
    """Number of patches."""
    motions: FloatArray
    """Displacement of each vertex in the motions of its patch, shape (V, 3, motions)."""


def patches(position: FloatArray, normal: FloatArray, area: float) -> Patches:
    """Divide a fabric into patches; a patch consists of the vertices in one grid cell whose normals are in one octant.

    Args:
        position: positions of the vertices [cm], shape (V, 3).
        normal: unit normal of the surface at each vertex, shape (V, 3).
        area: area of the surface [cm^2].
    """
    size = np.sqrt(area * PATCH_VERTICES / len(position))
    key = np.concatenate([np.floor((position - position.mean(axis=0)) / size), normal > 0.0], axis=1)
    patch = np.unique(key, axis=0, return_inverse=True)[1].ravel()
    count = int(patch.max()) + 1
    total: FloatArray = np.stack([np.bincount(patch, normal[:, k], count) for k in range(3)], axis=1)
    return Patches(patch, count, _tangent_frames(total)[patch])


def preconditioner(
    matrix: bsr_array, diagonal: FloatArray, projector: FloatArray, fabric_patches: Patches
) -> Preconditioner:
    """Build the preconditioner of one linear system.

    Args:
        matrix: symmetric positive definite matrix A, shape (3V, 3V).
        diagonal: diagonal blocks of the matrix, shape (V, 3, 3).
        projector: projector onto the allowed directions of each vertex, shape (V, 3, 3).
        fabric_patches: patches of the same vertices.
    """
    count = len(diagonal)
    inverse = np.empty_like(projector)

    def invert(some: slice) -> None:
        own = projector[some]
        inverse[some] = own @ np.linalg.inv(own @ diagonal[some] @ own + (np.eye(3) - own)) @ own

    each_block(invert, count, VERTICES_OF_BLOCK)
    vertex_part = bsr_array((inverse, np.arange(count), np.arange(count + 1)), shape=(3 * count, 3 * count))
    vectors, patch = projector @ fabric_patches.motions, fabric_patches.patch
    shape = (3 * count, vectors.shape[2] * fabric_patches.count)
    motions = bsr_array((vectors, patch, np.arange(count + 1)), shape=shape)
    rows, columns = motions.T.tocsr(), motions.tocsr()
    reduced = rows @ (matrix @ motions)
    entries = reduced.diagonal()
    regularized = reduced + diags_array(np.where(entries > NO_MOTION * entries.max(), REGULARIZATION * entries, 1.0))
    factor = splu(regularized.tocsc(), permc_spec="MMD_AT_PLUS_A", options={"SymmetricMode": True})

    def apply(residual: FloatArray) -> FloatArray:
        return vertex_part @ residual + columns @ factor.solve(rows @ residual)

    return apply


def _tangent_frames(normal: FloatArray) -> FloatArray:
    """Two orthogonal unit vectors perpendicular to each normal, shape (n, 3, 2)."""
    axis = np.eye(3)[np.abs(normal).argmin(axis=1)]
    first = np.cross(normal, axis)
    second = np.cross(normal, first)
    return unit_vectors(np.stack([first, second], axis=2), axis=1)


def modified_conjugate_gradients(
    matrix: bsr_array,
    right: FloatArray,
    filtered_preconditioner: Preconditioner,
    *,
    tolerance: float,
    max_iterations: int,
) -> tuple[FloatArray, int]:
    """Solve a symmetric positive definite system within the allowed directions.

    Args:
        matrix: matrix of the system, shape (3V, 3V).
        right: right-hand side, shape (3V,).
        filtered_preconditioner: symmetric preconditioner, positive definite in the allowed directions and zero in all
            others.
        tolerance: residual over the right-hand side at which the solution has converged, both in the norm of the
            preconditioner. Rounding of what the filter removes leaves about 1e-8, so that it must be larger.
        max_iterations: largest number of iterations; also after these the solution is a descent direction.

    Returns:
        The solution, shape (3V,), and the number of iterations.
    """
    product = _product_by_rows(matrix)
    solution = np.zeros_like(right)
    residual = right.copy()
    direction = filtered_preconditioner(residual)
    size = _dot(residual, direction)
    goal = tolerance**2 * size
    for iteration in range(max_iterations):
        if size <= goal:
            return solution, iteration
        image = product(direction)
        length = size / _dot(direction, image)
        solution += length * direction
        residual -= length * image
        conditioned = filtered_preconditioner(residual)
        previous, size = size, _dot(residual, conditioned)
        direction *= size / previous
        direction += conditioned
    return solution, max_iterations


def _dot(one: FloatArray, other: FloatArray) -> float:
    """Sum of products without the linear algebra library, whose threads would wait busily beside those of blocks."""
    return float(np.einsum("i,i->", one, other))


def _product_by_rows(matrix: bsr_array) -> Callable[[FloatArray], FloatArray]:
    """Return the product of a matrix in blocks with a vector; threads share its rows."""
    count = matrix.shape[0] // 3

    def rows(some: slice) -> bsr_array:
        first, last = matrix.indptr[[some.start, some.stop]]
        entries = matrix.data[first:last], matrix.indices[first:last], matrix.indptr[some.start : some.stop + 1] - first
        return bsr_array(entries, shape=(3 * (some.stop - some.start), matrix.shape[1]))

    parts = [rows(slice(first, min(first + VERTICES_OF_BLOCK, count))) for first in range(0, count, VERTICES_OF_BLOCK)]

    def product(vector: FloatArray) -> FloatArray:
        return np.concatenate(each_block(lambda some: parts[some.start] @ vector, len(parts), 1))

    return product
