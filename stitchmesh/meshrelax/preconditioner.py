# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Preconditioner of the step's linear system: single vertices, and patches of the fabric as a whole.

The inverse of each vertex's diagonal block evens out neighbours fast, but passes a move of the whole garment on by one
stitch an iteration. Patches of some hundred stitches, each of which may shift and deform linearly in its plane, solve
for such moves at once (additive Schwarz with a coarse space; Nicolaides 1987):

    M^-1 = P D^-1 P + Z (Z^T A Z)^-1 Z^T

P is the projector onto the allowed directions and the columns of Z lie in them, so the filter of Baraff and Witkin is
part of the preconditioner: it answers with allowed directions whatever it is given.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from scipy.linalg import cho_factor, cho_solve
from scipy.sparse import bsr_array

from stitchmesh.mesh import FloatArray, IntArray

PATCHES = 250
"""Patches to aim at: the dense system of six motions each costs less than the iterations it saves."""
SMALLEST_PATCH = 16
"""Mean number of vertices of a patch below which more patches save nothing."""
REGULARIZATION = 1e-6
"""Part of its diagonal added to the patches' matrix: on patches of few vertices the motions depend on each other."""

Preconditioner = Callable[[FloatArray], FloatArray]


@dataclass(frozen=True, eq=False)
class Patches:
    """The motions of patches of a fabric."""

    patch: IntArray
    """Patch of each vertex, shape (V,)."""
    count: int
    motions: FloatArray
    """Displacement of each vertex under the six motions of its patch, shape (V, 3, 6)."""


def patches(position: FloatArray, normal: FloatArray, area: float) -> Patches:
    """Cut a fabric into patches: vertices in one box of space whose normals are in one octant.

    Args:
        position: vertices [cm], shape (V, 3).
        normal: unit normals of the surface there, shape (V, 3).
        area: area of the surface [cm^2].
    """
    size = np.sqrt(area / max(1.0, min(PATCHES, len(position) / SMALLEST_PATCH)))
    key = np.concatenate([np.floor((position - position.mean(axis=0)) / size), normal > 0.0], axis=1)
    patch = np.unique(key, axis=0, return_inverse=True)[1].ravel()
    count = int(patch.max()) + 1
    members = np.bincount(patch)[:, None]
    centre = _patch_sums(position, patch, count) / members
    frame = _tangent_frames(_patch_sums(normal, patch, count))[patch]
    place = np.einsum("vi,vik->vk", position - centre[patch], frame) / size
    motions = np.concatenate([frame, frame * place[:, None, :1], frame * place[:, None, 1:]], axis=2)
    return Patches(patch, count, motions)


def preconditioner(
    matrix: bsr_array, diagonal: FloatArray, projector: FloatArray, fabric_patches: Patches
) -> Preconditioner:
    """The two parts for one system.

    Args:
        matrix: symmetric positive definite, shape (3V, 3V).
        diagonal: its diagonal blocks, shape (V, 3, 3).
        projector: projectors onto the allowed directions, shape (V, 3, 3).
        fabric_patches: patches of the same vertices.
    """
    count = len(diagonal)
    inverse = projector @ np.linalg.inv(projector @ diagonal @ projector + (np.eye(3) - projector)) @ projector
    vertex_part = bsr_array((inverse, np.arange(count), np.arange(count + 1)), shape=(3 * count, 3 * count))
    columns = 6 * fabric_patches.count
    motions = bsr_array(
        (projector @ fabric_patches.motions, fabric_patches.patch, np.arange(count + 1)), shape=(3 * count, columns)
    )
    rows = motions.T.tocsr()
    reduced = (rows @ (matrix @ motions)).toarray()
    own = np.diagonal(reduced).copy()
    reduced[np.arange(columns), np.arange(columns)] += np.where(own > 0.0, REGULARIZATION * own, 1.0)
    factor = cho_factor(reduced, lower=True, overwrite_a=True, check_finite=False)
    spread = motions.tocsr()

    def apply(residual: FloatArray) -> FloatArray:
        shifted = cho_solve(factor, rows @ residual, check_finite=False)
        return vertex_part @ residual + spread @ shifted

    return apply


def _patch_sums(values: FloatArray, patch: IntArray, count: int) -> FloatArray:
    return np.stack([np.bincount(patch, values[:, k], count) for k in range(values.shape[1])], axis=1)


def _tangent_frames(normal: FloatArray) -> FloatArray:
    """Two unit vectors across each vector, shape (n, 3, 2)."""
    axis = np.eye(3)[np.abs(normal).argmin(axis=1)]
    first = np.cross(normal, axis)
    second = np.cross(normal, first)
    frame = np.stack([first, second], axis=2)
    length = np.linalg.norm(frame, axis=1, keepdims=True)
    return frame / np.where(length > 0.0, length, 1.0)
