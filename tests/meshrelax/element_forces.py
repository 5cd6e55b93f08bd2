# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The forces of single elements of mesh relaxation on arrays, through kernels."""

from __future__ import annotations

from typing import Any

import numpy as np
import warp as wp

from stitchmesh.compute.kernel import kernel
from stitchmesh.compute.launch import launch
from stitchmesh.mesh import FloatArray
from stitchmesh.meshrelax import forces
from stitchmesh.meshrelax.forces import Elements, Symmetric
from stitchmesh.meshrelax.placement import PlacedPoints
from stitchmesh.meshrelax.sub_quads import Springs

WHOLE = [0, 1, 2, 1, 3, 4, 2, 4, 5]
"""Entries of a whole matrix within xx, xy, xz, yy, yz, zz."""


@kernel
def stretch_forces(
    span: wp.array[wp.vec3d], rest: wp.array[wp.float64], stiffness: wp.float64,
    force: wp.array[wp.vec3d], jacobian: wp.array[Symmetric],
) -> None:  # fmt: skip
    """Forces of springs."""
    e = wp.tid()
    own, matrix = forces.stretch_force(span[e], rest[e], stiffness)
    force[e] = own
    jacobian[e] = matrix


@kernel
def shear_forces(
    first: wp.array[wp.vec3d], second: wp.array[wp.vec3d], unit: wp.array[wp.float64], stiffness: wp.float64,
    force: wp.array[wp.vec3d], jacobian: wp.array[Symmetric],
) -> None:  # fmt: skip
    """Forces of corners."""
    e = wp.tid()
    own, matrix = forces.shear_force(first[e], second[e], unit[e], stiffness)
    force[e] = own
    jacobian[e] = matrix


@kernel
def strut_forces(
    lower: wp.array[wp.vec3d], upper: wp.array[wp.vec3d], wale: wp.array[wp.float64], stiffness: wp.float64,
    force: wp.array[wp.vec3d], jacobian: wp.array[Symmetric],
) -> None:  # fmt: skip
    """Forces of struts."""
    e = wp.tid()
    own, matrix = forces.strut_force(lower[e], upper[e], wale[e], stiffness)
    force[e] = own
    jacobian[e] = matrix


@kernel
def quad_forces(
    first: wp.array[wp.vec3d], second: wp.array[wp.vec3d], normal: wp.array[wp.vec3d], rest: wp.array[wp.float64],
    stiffness: wp.float64, force: wp.array[wp.vec3d], jacobian: wp.array[Symmetric],
) -> None:  # fmt: skip
    """Forces of sub-quads: those on the first diagonals, and then those on the second ones."""
    e = wp.tid()
    count = first.shape[0]
    q = e % count
    one, other, of_one, of_other = forces.area_forces(first[q], second[q], normal[q], rest[q], stiffness)
    if e < count:
        force[e] = one
        jacobian[e] = of_one
    else:
        force[e] = other
        jacobian[e] = of_other


def stretch_force(span: FloatArray, rest: FloatArray, stiffness: float) -> tuple[FloatArray, FloatArray]:
    """Forces of springs, shape (S, 3), and their Jacobians, shape (S, 3, 3)."""
    return _evaluated(stretch_forces, [span], rest, stiffness, len(span))


def shear_force(first: FloatArray, second: FloatArray, unit: float, stiffness: float) -> tuple[FloatArray, FloatArray]:
    """Forces of corners, shape (S, 3), and their Jacobians, shape (S, 3, 3)."""
    return _evaluated(shear_forces, [first, second], unit, stiffness, len(first))


def strut_force(lower: FloatArray, upper: FloatArray, wale: float, stiffness: float) -> tuple[FloatArray, FloatArray]:
    """Forces of struts, shape (S, 3), and their Jacobians, shape (S, 3, 3)."""
    return _evaluated(strut_forces, [lower, upper], wale, stiffness, len(lower))


def area_forces(
    first: FloatArray, second: FloatArray, normal: FloatArray, rest: float, stiffness: float
) -> tuple[FloatArray, FloatArray]:
    """Forces on first and then on second diagonals, shape (2Q, 3), and their Jacobians, shape (2Q, 3, 3)."""
    return _evaluated(quad_forces, [first, second, normal], rest, stiffness, 2 * len(first))


def element_forces(springs: Springs, placement: PlacedPoints) -> tuple[FloatArray, FloatArray]:
    """Forces of all elements, shape (elements, 3), and their Jacobians, shape (elements, 3, 3)."""
    found = Elements(springs, wp.get_device("cpu")).forces(placement)
    return found.force.numpy().copy(), found.jacobian.numpy()[:, WHOLE].reshape(-1, 3, 3)


def _evaluated(
    of_elements: Any, vectors: list[FloatArray], rest: float | FloatArray, stiffness: float, count: int
) -> tuple[FloatArray, FloatArray]:
    device = wp.get_device("cpu")
    numbers = np.broadcast_to(rest, len(vectors[0])).copy()
    inputs = [wp.array(each, dtype=wp.vec3d, device=device) for each in vectors]
    inputs += [wp.array(numbers, dtype=wp.float64, device=device), wp.float64(stiffness)]
    force = wp.zeros(count, dtype=wp.vec3d, device=device)
    jacobian = wp.zeros(count, dtype=Symmetric, device=device)
    launch(of_elements, count, inputs, [force, jacobian], device)
    return force.numpy(), jacobian.numpy()[:, WHOLE].reshape(-1, 3, 3)
