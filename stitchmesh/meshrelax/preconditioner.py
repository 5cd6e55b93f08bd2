# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Preconditioner of the step's linear system: single vertices, and small patches of the fabric as a whole.

The inverse of each vertex's diagonal block evens out neighbours fast, but passes a move of the whole garment on by one
stitch an iteration. Patches of some thirty stitches, each of which may shift in its plane, solve for such moves at
once (additive Schwarz with a coarse space; Nicolaides 1987):

    M^-1 = P D^-1 P + Z (Z^T A Z)^-1 Z^T

P is the projector onto the allowed directions and the columns of Z lie in them, so the filter of Baraff and Witkin is
part of the preconditioner: it answers with allowed directions whatever it is given. The patches' matrix is sparse and
factored as such: dense factorizations stall where threads share few cores.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from scipy.sparse import bsr_array, diags_array
from scipy.sparse.linalg import splu

from stitchmesh.mesh import FloatArray, IntArray

PATCH_VERTICES = 30
"""Vertices of a patch to aim at: larger ones cost iterations, smaller ones factorization."""
REGULARIZATION = 1e-6
"""Part of its diagonal added to the patches' matrix: on a patch of border vertices its two motions are one."""
NO_MOTION = 1e-12
"""Stiffness over the largest below which a motion of a patch is nothing but rounding: its vertices cannot make it."""

Preconditioner = Callable[[FloatArray], FloatArray]


@dataclass(frozen=True, eq=False)
class Patches:
    """The motions of patches of a fabric."""

    patch: IntArray
    """Patch of each vertex, shape (V,)."""
    count: int
    motions: FloatArray
    """Displacement of each vertex under the two motions of its patch, shape (V, 3, 2)."""


def patches(position: FloatArray, normal: FloatArray, area: float) -> Patches:
    """Cut a fabric into patches: vertices in one box of space whose normals are in one octant.

    Args:
        position: vertices [cm], shape (V, 3).
        normal: unit normals of the surface there, shape (V, 3).
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
    vectors, patch = projector @ fabric_patches.motions, fabric_patches.patch
    shape = (3 * count, 2 * fabric_patches.count)
    motions = bsr_array((vectors, patch, np.arange(count + 1)), shape=shape)
    rows, columns = motions.T.tocsr(), motions.tocsr()
    reduced = rows @ (matrix @ motions)
    own = reduced.diagonal()
    steadied = reduced + diags_array(np.where(own > NO_MOTION * own.max(), REGULARIZATION * own, 1.0))
    factor = splu(steadied.tocsc(), permc_spec="MMD_AT_PLUS_A", options={"SymmetricMode": True})

    def apply(residual: FloatArray) -> FloatArray:
        return vertex_part @ residual + columns @ factor.solve(rows @ residual)

    return apply


def _tangent_frames(normal: FloatArray) -> FloatArray:
    """Two unit vectors across each vector, shape (n, 3, 2)."""
    axis = np.eye(3)[np.abs(normal).argmin(axis=1)]
    first = np.cross(normal, axis)
    second = np.cross(normal, first)
    frame = np.stack([first, second], axis=2)
    length = np.linalg.norm(frame, axis=1, keepdims=True)
    return frame / np.where(length > 0.0, length, 1.0)
