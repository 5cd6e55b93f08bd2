# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Forces and Hessians of a term as NumPy arrays, and what every term must satisfy."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

import numpy as np
import warp as wp
from numpy.typing import NDArray

from stitchmesh.compute.device import device_named
from stitchmesh.compute.launch import launch
from stitchmesh.mixed.mixed_vector import MixedBlocks, MixedVector
from stitchmesh.mixed.term import MixedTerm

CPU = device_named("cpu")
RUN = partial(launch, device=CPU)
FloatArray = NDArray[np.float64]


def state_of(vertices: FloatArray, scalar: type = wp.float64) -> MixedVector:
    return MixedVector.from_numpy(vertices, [], [], scalar, CPU)


def energy_of(term: MixedTerm, vertices: FloatArray, scalar: type = wp.float64) -> float:
    return term.energy(state_of(vertices, scalar))


def forces_of(term: MixedTerm, vertices: FloatArray, scalar: type = wp.float64) -> FloatArray:
    """Forces on the vertices, shape (V, 3)."""
    state = state_of(vertices, scalar)
    force = state.like()
    term.forces(state, force, RUN)
    return force.numpy()[0]


def product_of(
    term: MixedTerm, vertices: FloatArray, direction: FloatArray, exact: float = 1.0, scalar: type = wp.float64
) -> FloatArray:
    """Hessian times a direction, shape (V, 3)."""
    state = state_of(vertices, scalar)
    term.exact = exact
    term.linearize(state, RUN)
    product = state.like()
    term.products(state_of(direction, scalar), product, RUN)
    return product.numpy()[0]


def hessian_of(term: MixedTerm, vertices: FloatArray, exact: float = 1.0) -> FloatArray:
    """The whole Hessian, shape (3 V, 3 V)."""
    state = state_of(vertices)
    term.exact = exact
    term.linearize(state, RUN)
    columns = []
    for direction in np.eye(vertices.size):
        product = state.like()
        term.products(state_of(direction.reshape(-1, 3)), product, RUN)
        columns.append(product.numpy()[0].ravel())
    return np.array(columns).T


def blocks_of(term: MixedTerm, vertices: FloatArray, exact: float = 1.0) -> FloatArray:
    """The diagonal blocks, shape (V, 3, 3)."""
    state = state_of(vertices)
    term.exact = exact
    term.linearize(state, RUN)
    blocks = MixedBlocks.zeros(len(vertices), 0, wp.float64, CPU)
    term.diagonal(blocks, RUN)
    return blocks.vertices.numpy()


def diagonal_of(matrix: FloatArray) -> FloatArray:
    """The 3 x 3 blocks on the diagonal of a matrix, shape (V, 3, 3)."""
    count = len(matrix) // 3
    return np.array([matrix[3 * i : 3 * i + 3, 3 * i : 3 * i + 3] for i in range(count)])


def slope(values: Callable[[float], FloatArray | float], step: float) -> FloatArray | float:
    """Derivative at zero by the central difference of fourth order."""
    near, far = values(step) - values(-step), values(2.0 * step) - values(-2.0 * step)
    return (8.0 * near - far) / (12.0 * step)


def assert_forces_are_minus_the_gradient(term: MixedTerm, vertices: FloatArray, step: float = 2e-5) -> None:
    """Differences of the energy along random directions."""
    force = forces_of(term, vertices)
    random = np.random.default_rng(1)
    for direction in random.normal(size=(4, *vertices.shape)):
        rise = slope(lambda d, way=direction: energy_of(term, vertices + d * way), step)
        # steps are a ten-thousandth of an edge: their fourth power, and rounding of 1e-16 over the step
        np.testing.assert_allclose(rise, -(force * direction).sum(), rtol=0, atol=1e-7 * _size(force))


def assert_products_are_differences_of_forces(term: MixedTerm, vertices: FloatArray, step: float = 2e-5) -> None:
    """Differences of the forces along random directions."""
    random = np.random.default_rng(2)
    for direction in random.normal(size=(4, *vertices.shape)):
        expected = slope(lambda d, way=direction: -forces_of(term, vertices + d * way), step)
        product = product_of(term, vertices, direction)
        # as for the forces; the fifth derivatives of angles are large where triangles are narrow
        np.testing.assert_allclose(product, expected, rtol=0, atol=1e-6 * _size(product))


def assert_nothing_acts_on_the_whole(term: MixedTerm, vertices: FloatArray) -> None:
    """Internal forces have no resultant and no torque, because a rigid motion costs nothing."""
    force = forces_of(term, vertices)
    scale = _size(force)
    # sums of a few hundred forces, each with a rounding of 1e-16 of the largest
    np.testing.assert_allclose(force.sum(axis=0), 0.0, atol=1e-12 * scale)
    np.testing.assert_allclose(np.cross(vertices, force).sum(axis=0), 0.0, atol=1e-12 * scale * np.abs(vertices).max())


def _size(values: FloatArray) -> float:
    return float(np.abs(values).max())


def rotation(seed: int = 0) -> FloatArray:
    """A random rotation, shape (3, 3)."""
    axes, _upper = np.linalg.qr(np.random.default_rng(seed).normal(size=(3, 3)))
    return axes * np.sign(np.linalg.det(axes))
