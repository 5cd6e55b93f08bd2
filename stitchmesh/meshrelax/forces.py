# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The forces of mesh relaxation together (Yuksel et al. 2012, section 6.1)."""

from __future__ import annotations

import numpy as np

from stitchmesh.mesh import FloatArray
from stitchmesh.meshrelax.assembly import Assembly, assembly
from stitchmesh.meshrelax.shear import shear_force
from stitchmesh.meshrelax.stretch import stretch_force
from stitchmesh.meshrelax.strut import strut_force
from stitchmesh.meshrelax.sub_quads import Springs

STRETCH, SHEAR, WALE = 2.0, 0.2, 2.0
"""Stiffnesses of Yuksel et al. 2012, free of units."""


def force_assembly(springs: Springs, vertex_count: int) -> Assembly:
    """Where the forces of ``element_forces`` go."""
    groups = [
        (springs.stretch_ends, [1.0, -1.0]),
        (springs.corners, [-0.5, 1.0, -0.5]),
        (springs.struts[:, [0, 2]], [1.0, -1.0]),
    ]
    return assembly(vertex_count, groups)


def element_forces(springs: Springs, position: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Force and semidefinite Jacobian of every spring, corner and strut, in this order.

    Args:
        springs: what joins which vertices.
        position: vertices [cm], shape (V, 3).

    Returns:
        Forces, shape (elements, 3), and Jacobians [1/cm], shape (elements, 3, 3).
    """
    i, j = position[springs.stretch_ends[:, 0]], position[springs.stretch_ends[:, 1]]
    stretch = stretch_force(i - j, springs.stretch_rest, STRETCH)
    i, j, k = (position[springs.corners[:, place]] for place in range(3))
    shear = shear_force(i - j, k - j, springs.rest.unit, SHEAR)
    i, j, k = (position[springs.struts[:, place]] for place in range(3))
    strut = strut_force(i - j, k - j, springs.rest.wale, WALE)
    force, jacobian = zip(stretch, shear, strut, strict=True)
    return np.concatenate(force), np.concatenate(jacobian)
