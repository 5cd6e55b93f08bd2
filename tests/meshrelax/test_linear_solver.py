# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
from __future__ import annotations

from typing import Any

import numpy as np
import warp as wp

from stitchmesh.mesh import FloatArray
from stitchmesh.meshrelax.assembly import Assembly, assembly
from stitchmesh.meshrelax.forces import Symmetric
from stitchmesh.meshrelax.linear_solver import StepSystem, patches

VERTICES = 12


def stiff_elements(seed: int) -> tuple[Assembly, FloatArray, FloatArray, FloatArray]:
    """Elements of two and of three vertices in random places, their matrices, and their dense matrix.

    Returns:
        The elements, their Jacobians, the blocks of the vertices, and the matrix of both, shape (3V, 3V).
    """
    random = np.random.default_rng(seed)
    pairs, triples = (
        np.stack([random.choice(VERTICES, size, replace=False) for _ in range(40)]) for size in (2, 3)
    )
    weights = random.normal(size=triples.shape)
    root = random.normal(size=(80, 3, 3))
    jacobian = -root @ root.transpose(0, 2, 1)
    elements = assembly(VERTICES, [(pairs, [1.0, -1.0]), (triples, weights)])
    dense = np.eye(3 * VERTICES)
    for e in range(80):
        of_element = dict(zip(pairs[e], (1.0, -1.0), strict=True)) if e < 40 else dict(
            zip(triples[e - 40], weights[e - 40], strict=True)
        )
        for v, one in of_element.items():
            for w, other in of_element.items():
                dense[3 * v : 3 * v + 3, 3 * w : 3 * w + 3] -= one * other * jacobian[e]
    return elements, jacobian, np.broadcast_to(np.eye(3), (VERTICES, 3, 3)), dense


def on_device(jacobian: FloatArray) -> Any:
    """Symmetric matrices, shape (elements, 3, 3), as the solver takes them."""
    return wp.array(jacobian.reshape(-1, 9)[:, [0, 1, 2, 4, 5, 8]], dtype=Symmetric, device="cpu")


def constraints(seed: int) -> tuple[FloatArray, FloatArray]:
    """Projectors of vertices that may move, in turn, in a plane, along a line, or not at all; and their normals."""
    normal = np.random.default_rng(seed).normal(size=(VERTICES, 3))
    normal /= np.linalg.norm(normal, axis=1, keepdims=True)
    along = normal[:, :, None] * normal[:, None, :]
    kind = (np.arange(VERTICES) % 3)[:, None, None]
    return np.select([kind == 0, kind == 1], [np.eye(3) - along, along], 0.0), normal


def solved(right: FloatArray, **limits: Any) -> tuple[FloatArray, int]:
    """Solve the system of the functions above, with patches of random vertices."""
    elements, jacobian, blocks, _ = stiff_elements(5)
    projector, normal = constraints(5)
    place = np.random.default_rng(6).normal(size=(VERTICES, 3))
    system = StepSystem(elements, patches(place, normal, 1.0), wp.get_device("cpu"))
    system.set_matrix(on_device(jacobian), blocks, projector)
    return system.solve(right, **limits)


def test_the_filtered_solution_agrees_with_the_dense_reduced_system() -> None:
    right = np.random.default_rng(7).normal(size=(VERTICES, 3))
    solution, _ = solved(right, tolerance=1e-7, max_iterations=500)
    matrix, projector = stiff_elements(5)[3], constraints(5)[0]
    whole = np.zeros_like(matrix)
    for vertex, block in enumerate(projector):
        whole[3 * vertex : 3 * vertex + 3, 3 * vertex : 3 * vertex + 3] = block
    values, vectors = np.linalg.eigh(whole)
    allowed = vectors[:, values > 0.5]
    reduced = allowed.T @ matrix @ allowed
    expected = allowed @ np.linalg.solve(reduced, allowed.T @ right.ravel())
    # Conjugate gradients stop at 1e-7 of the residual in the norm of the preconditioner; the error exceeds that by at
    # most the condition number of the reduced matrix, which is below a thousand.
    assert np.linalg.cond(reduced) < 1e3
    np.testing.assert_allclose(solution.ravel(), expected, atol=1e-4 * np.abs(expected).max())
    np.testing.assert_allclose(whole @ solution.ravel(), solution.ravel(), atol=1e-13)


def test_a_system_without_a_force_needs_no_iteration() -> None:
    solution, iterations = solved(np.zeros((VERTICES, 3)), tolerance=1e-12, max_iterations=500)
    assert iterations == 0 and not solution.any()


def test_the_matrix_of_the_patches_is_that_of_their_motions() -> None:
    """One vertex is in each patch, and may move in a plane."""
    elements, jacobian, blocks, dense = stiff_elements(9)
    normal = np.tile([0.0, 0.0, 1.0], (VERTICES, 1))
    projector = np.broadcast_to(np.eye(3) - np.diag(normal[0]), (VERTICES, 3, 3))
    place = np.arange(VERTICES)[:, None] * [10.0, 0.0, 0.0]
    each_alone = patches(place, normal, 1.0)
    assert each_alone.count == VERTICES
    system = StepSystem(elements, each_alone, wp.get_device("cpu"))
    system.set_matrix(on_device(jacobian), blocks, projector)
    pairs = system.patch_matrix().toarray()
    motions = np.zeros((3 * VERTICES, 2 * VERTICES))
    for vertex, own in enumerate(each_alone.motions):
        column = 2 * each_alone.patch[vertex]
        motions[3 * vertex : 3 * vertex + 3, column : column + 2] = own
    # Rounding of sums of some hundred products.
    np.testing.assert_allclose(pairs, motions.T @ dense @ motions, atol=1e-11 * np.abs(dense).max())
