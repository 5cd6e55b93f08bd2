# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Conjugate gradients on filtered motions, against dense linear algebra."""

from __future__ import annotations

import numpy as np
import pytest
import warp as wp
from scipy.linalg import null_space

from stitchmesh.mixed.dynamics.conjugate_gradients import ConjugateGradients
from stitchmesh.mixed.enrichment.region import region_around
from stitchmesh.mixed.mixed_vector import MixedVector
from tests.mixed.dynamics.scene import CPU, Scene, set_hessian_product, spring_scene
from tests.mixed.patch import enriched_everywhere, square_patch

PATCH = square_patch(4, 3)
REGIONS = {
    "square": region_around(*PATCH.layout, PATCH.near((0.5, 0.5), 0.2)),
    "everywhere": enriched_everywhere(*PATCH.layout),
}


def dense_matrix(scene: Scene, of_mass: float) -> np.ndarray:
    """Factor 0 times M plus H, column by column."""
    unit, product, mass = (scene.system.zeros() for _ in range(3))
    columns = []
    for k in range(len(unit.values)):
        values = np.zeros(len(unit.values))
        values[k] = 1.0
        unit.values.assign(values)
        set_hessian_product(scene.system, unit, product)
        scene.system.set_mass_product(unit, mass)
        columns.append(product.values.numpy() + of_mass * mass.values.numpy())
    return np.stack(columns, axis=1)


def constraint_matrix(scene: Scene) -> np.ndarray:
    """E and the fixed coordinates as rows."""
    embedding = scene.embedding
    of_nodes = np.zeros((embedding.independent.shape[1], embedding.node_count))
    of_nodes[:, embedding.nodes] = embedding.independent.T.toarray()
    coupled = np.hstack([-embedding.gram.toarray(), of_nodes])
    rows = np.kron(coupled, np.eye(3))
    rows = np.hstack([rows, np.zeros((len(rows), 2 * embedding.node_count))])
    fixed = np.flatnonzero(scene.system.moves.numpy() == 0)
    return np.vstack([rows, np.eye(rows.shape[1])[fixed]])


def random_force(scene: Scene) -> MixedVector:
    """Forces on all that has mass."""
    random = np.random.default_rng(10)
    on_vertices = random.normal(size=scene.patch.vertices.shape) * (scene.masses.vertices > 0.0)[:, None]
    count = len(scene.region.nodes)
    parts = on_vertices, random.normal(size=(count, 3)), random.normal(size=(count, 2))
    return MixedVector.from_numpy(*parts, scene.system.scalar, CPU)


@pytest.mark.parametrize(("name", "stiffness_in_metric"), [("square", True), ("everywhere", True), ("square", False)])
def test_the_solution_is_that_of_dense_linear_algebra_on_the_motions(name, stiffness_in_metric):
    scene = spring_scene(PATCH, REGIONS[name], fixed_vertices=[0, 1], fixed_nodes=[60, 61], slides=True)
    position = scene.at_rest()
    scene.system.set_factors(1e4, 1.0, position, stiffness_in_metric=stiffness_in_metric)
    scene.system.linearize(position, 1.0)
    force = random_force(scene)
    given = force.values.numpy()
    report = scene.system.solver.solve(force, tolerance=1e-12, most_iterations=2000)
    motions = null_space(constraint_matrix(scene))
    matrix = motions.T @ dense_matrix(scene, 1e4) @ motions
    expected = motions @ np.linalg.solve(matrix, motions.T @ given)
    found = scene.system.solver.solution.values.numpy()
    assert not report.negative
    # The tolerance of the solve times the root of the condition number of the matrix, at most 1e3.
    np.testing.assert_allclose(found, expected, atol=1e-9 * np.abs(expected).max())


def test_single_precision_reaches_its_tolerance():
    scene = spring_scene(PATCH, REGIONS["square"], scalar=wp.float32)
    scene.system.set_factors(1e4, 1.0, scene.at_rest(), stiffness_in_metric=False)
    scene.system.linearize(scene.at_rest(), 1.0)
    report = scene.system.solver.solve(random_force(scene), tolerance=1e-4, most_iterations=500)
    assert report.norm <= 1e-4 * report.first_norm
    v, p, _ = scene.system.solver.solution.numpy()
    # Rounding of single precision in sums of some 50 numbers.
    assert np.abs(scene.embedding.constraint(v, p)).max() < 1e-4 * max(np.abs(v).max(), np.abs(p).max())


def test_no_force_needs_no_iteration():
    scene = spring_scene(PATCH, REGIONS["square"])
    scene.system.set_factors(1e4, 1.0, scene.at_rest(), stiffness_in_metric=False)
    scene.system.linearize(scene.at_rest(), 1.0)
    report = scene.system.solver.solve(scene.system.zeros(), tolerance=1e-4, most_iterations=10)
    assert (report.iterations, report.norm) == (0, 0.0)
    assert not scene.system.solver.solution.values.numpy().any()


def test_a_direction_of_negative_curvature_ends_the_iteration_with_a_descent_direction():
    scene = spring_scene(PATCH, REGIONS["square"], stiffness=1e4)
    squeezed = scene.at_rest()
    squeezed.values.assign(0.3 * squeezed.values.numpy())
    scene.system.set_factors(1e-3, 1.0, scene.at_rest(), stiffness_in_metric=False)
    scene.system.linearize(squeezed, 1.0)
    force = random_force(scene)
    report = scene.system.solver.solve(force, tolerance=1e-6, most_iterations=500)
    assert report.negative
    assert scene.system.solver.solution.values.numpy() @ force.values.numpy() > 0.0


def test_the_number_of_iterations_has_its_bound_and_a_repeated_solve_the_same_bits():
    scene = spring_scene(PATCH, REGIONS["square"], stiffness=1e6)
    scene.system.set_factors(1.0, 1.0, scene.at_rest(), stiffness_in_metric=False)
    scene.system.linearize(scene.at_rest(), 0.0)
    solver, force = scene.system.solver, random_force(scene)
    assert isinstance(solver, ConjugateGradients)
    assert solver.solve(force, tolerance=1e-14, most_iterations=7).iterations == 7
    first = solver.solution.values.numpy().copy()
    solver.solve(force, tolerance=1e-14, most_iterations=7)
    np.testing.assert_array_equal(first, solver.solution.values.numpy())
