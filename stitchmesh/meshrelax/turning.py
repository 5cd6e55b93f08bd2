# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Stiffness that comes from the turning of the surface and of its border under a vertex that moves.

Only the part of the force f along the allowed directions counts, and they change on the way. Of a border with tangent
t it is f . t, which changes with arc length s by f . dt/ds. Of a surface with normal n and shape operator S, where
dn = S dx, a tangent t turns by -(t . S dx) n, so the part of f along it changes by -(f . n) t . S dx: the stiffness is
(f . n) S. Where a surface or border turns within a stitch, between the fingers of a glove or at the ends of a slit,
this outweighs the springs. Only what holds a vertex back is kept, so the matrices stay semidefinite.
"""

from __future__ import annotations

import numpy as np

from stitchmesh.mesh import FloatArray
from stitchmesh.meshrelax.attachment import Placement


def turning_stiffness(placement: Placement, force: FloatArray) -> FloatArray:
    """Resistance of surface and border to moves along them [1/cm], shape (V, 3, 3).

    Args:
        placement: where the vertices are.
        force: net force on each vertex, in all directions, shape (V, 3).
    """
    across = np.einsum("vi,vi->v", force, placement.normal)
    size, axes = np.linalg.eigh(across[:, None, None] * placement.shape)
    surface = (axes * np.maximum(size, 0.0)[:, None, :]) @ axes.transpose(0, 2, 1)
    change = np.einsum("vi,vi->v", force, placement.bend)
    tangent = placement.tangent
    return surface + np.maximum(-change, 0.0)[:, None, None] * (tangent[:, :, None] * tangent[:, None, :])
