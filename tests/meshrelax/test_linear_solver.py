# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
from __future__ import annotations

import numpy as np
from scipy.sparse import bsr_array

from stitchmesh.mesh import FloatArray
from stitchmesh.meshrelax.linear_solver import modified_conjugate_gradients, patches, preconditioner


def system(count: int, seed: int) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray, FloatArray]:
    """A symmetric positive definite system; the vertices may move, in turn, in a plane, along a line, or not at all.

    Returns:
        The matrix, the right-hand side, the projectors, and the normals and positions of the vertices.
    """
    random = np.random.default_rng(seed)
    root = random.normal(size=(3 * count, 3 * count))
    normal = random.normal(size=(count, 3))
    normal /= np.linalg.norm(normal, axis=1, keepdims=True)
    along = normal[:, :, None] * normal[:, None, :]
    kind = (np.arange(count) % 3)[:, None, None]
    projector = np.select([kind == 0, kind == 1], [np.eye(3) - along, along], 0.0)
    return (
        root @ root.T + np.eye(3 * count),
        random.normal(size=3 * count),
        projector,
        normal,
        random.normal(size=(count, 3)),
    )


def test_the_filtered_solution_agrees_with_the_dense_reduced_system() -> None:
    matrix, right, projector, normal, place = system(12, 5)
    sparse = bsr_array(matrix, blocksize=(3, 3))
    diagonal = np.stack([matrix[3 * v : 3 * v + 3, 3 * v : 3 * v + 3] for v in range(12)])
    filtered = preconditioner(sparse, diagonal, projector, patches(place, normal, 30.0))
    solution, _ = modified_conjugate_gradients(sparse, right, filtered, tolerance=1e-7, max_iterations=500)
    assert modified_conjugate_gradients(sparse, 0.0 * right, filtered, tolerance=1e-12, max_iterations=500)[1] == 0
    whole = np.zeros_like(matrix)
    for vertex, block in enumerate(projector):
        whole[3 * vertex : 3 * vertex + 3, 3 * vertex : 3 * vertex + 3] = block
    values, vectors = np.linalg.eigh(whole)
    allowed = vectors[:, values > 0.5]
    expected = allowed @ np.linalg.solve(allowed.T @ matrix @ allowed, allowed.T @ right)
    # Conjugate gradients stop at 1e-7 of the residual, and the condition number of the reduced matrix is below ten.
    np.testing.assert_allclose(solution, expected, atol=1e-6 * np.abs(expected).max())
    np.testing.assert_allclose(whole @ solution, solution, atol=1e-13)
