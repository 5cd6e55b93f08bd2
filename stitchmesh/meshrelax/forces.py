# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""All forces of mesh relaxation: the forces of Yuksel et al. 2012, section 6.1, and the area force of stitches."""

from __future__ import annotations

import numpy as np

from stitchmesh.mesh import FloatArray, IntArray
from stitchmesh.mesh.unit_vectors import unit_vectors
from stitchmesh.meshrelax.area import area_forces
from stitchmesh.meshrelax.placement import PlacedPoints
from stitchmesh.meshrelax.shear import shear_force
from stitchmesh.meshrelax.stretch import stretch_force
from stitchmesh.meshrelax.strut import strut_force
from stitchmesh.meshrelax.sub_quads import Springs

STRETCH, SHEAR, WALE = 2.0, 0.2, 2.0
"""Dimensionless stiffnesses of Yuksel et al. 2012."""
AREA = 1.0
"""Dimensionless stiffness of areas. With 0.2, stitches of openwork on the instep of a sock keep moving."""


def force_groups(springs: Springs) -> list[tuple[IntArray, list[float]]]:
    """Return for each kind of force the points of its elements, shape (n, m), and their m weights (``assembly``)."""
    groups = [
        (springs.stretch_ends, [1.0, -1.0]),
        (springs.corners, [-0.5, 1.0, -0.5]),
        (springs.struts[:, [0, 2]], [1.0, -1.0]),
    ]
    if springs.area_force:
        groups += [(springs.quads[:, [2, 0]], [1.0, -1.0]), (springs.quads[:, [3, 1]], [1.0, -1.0])]
    return groups


def element_forces(springs: Springs, placement: PlacedPoints) -> tuple[FloatArray, FloatArray]:
    """Compute the force and the negative semidefinite Jacobian of each element.

    The elements are springs, corners of sub-quads and struts, in this order. If the area force acts, the first
    diagonals and then the second diagonals of sub-quads follow.

    Args:
        springs: vertices and rest lengths of the elements.
        placement: placement of the vertices.

    Returns:
        Forces, shape (elements, 3), and Jacobians [1/cm], shape (elements, 3, 3).
    """
    position = placement.position
    i, j = position[springs.stretch_ends[:, 0]], position[springs.stretch_ends[:, 1]]
    stretch = stretch_force(i - j, springs.stretch_rest, STRETCH)
    i, j, k = (position[springs.corners[:, place]] for place in range(3))
    shear = shear_force(i - j, k - j, springs.unit, SHEAR)
    i, j, k = (position[springs.struts[:, place]] for place in range(3))
    strut = strut_force(i - j, k - j, springs.strut_rest, WALE)
    terms = [stretch, shear, strut]
    if springs.area_force:
        a, b, c, d = (position[springs.quads[:, place]] for place in range(4))
        normal = unit_vectors(placement.normal[springs.quads].sum(axis=1))
        terms.append(area_forces(c - a, d - b, normal, springs.quad_area, AREA))
    force, jacobian = zip(*terms, strict=True)
    return np.concatenate(force), np.concatenate(jacobian)
