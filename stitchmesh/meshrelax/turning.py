# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Turning stiffness: the stiffness that comes from the curvature of the surface and of its border.

Only the part of the force f in the allowed directions of a vertex counts, and these directions turn when the vertex
moves. On a border with tangent t this part is f . t, whose derivative with respect to the arc length s is f . dt/ds. On
a surface with normal n and shape operator S, where dn = S dx, a tangent t turns by -(t . S dx) n. The part of f along t
therefore changes by -(f . n) t . S dx, which is a stiffness of (f . n) S. This stiffness dominates the springs where a
surface or a border turns within a stitch, for example between the fingers of a glove or at the ends of a slit. Only the
positive part of the stiffness is kept, so that the matrices are positive semidefinite.
"""

from __future__ import annotations

import numpy as np

from stitchmesh.mesh import FloatArray
from stitchmesh.meshrelax.placement import SurfacePlacement


def turning_stiffness(placement: SurfacePlacement, force: FloatArray) -> FloatArray:
    """Compute the positive semidefinite turning stiffness of each vertex [1/cm], shape (V, 3, 3).

    Args:
        placement: placement of the vertices.
        force: net force on each vertex before projection onto the allowed directions, shape (V, 3).
    """
    across = np.einsum("vi,vi->v", force, placement.normal)
    size, axes = np.linalg.eigh(across[:, None, None] * placement.shape)
    surface = (axes * np.maximum(size, 0.0)[:, None, :]) @ axes.transpose(0, 2, 1)
    change = np.einsum("vi,vi->v", force, placement.curvature)
    tangent = placement.tangent
    return surface + np.maximum(-change, 0.0)[:, None, None] * (tangent[:, :, None] * tangent[:, None, :])
