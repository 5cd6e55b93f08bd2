# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Conjugate-gradient iterations with P, the mass diagonal and nothing (Casafranca et al. 2020, figure 2)."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from stitchmesh.mixed.enrichment.region import region_around
from tests.mixed.dynamics.scene import Scene, masses_of, spring_scene
from tests.mixed.hessian_product import set_hessian_product
from tests.mixed.patch import square_patch

PATCH = square_patch(5, 4)
REGION = region_around(*PATCH.layout, PATCH.near((0.5, 0.5), 0.25))
STEP = 1e-2
"""Time step [s]."""
Vector = np.ndarray
Map = Callable[[Vector], Vector]


def scene_of(ratio: float) -> Scene:
    """A patch whose heaviest vertex has ``ratio`` times the mass of its lightest node."""
    masses = masses_of(PATCH, REGION)
    lightest = masses.nodes.min()
    vertices = masses.vertices * (ratio * lightest / masses.vertices.max())
    return spring_scene(PATCH, REGION, masses=replace(masses, vertices=vertices), stiffness=0.1, fixed_vertices=[0, 5])


def product_of(scene: Scene) -> Map:
    """The product with M / h^2 + H."""
    direction, product, mass = (scene.system.zeros() for _ in range(3))

    def multiply(values: Vector) -> Vector:
        direction.values.assign(values)
        set_hessian_product(scene.system, direction, product)
        scene.system.set_mass_product(direction, mass)
        return product.values.numpy() + mass.values.numpy() / STEP**2

    return multiply


def filtered_by(scene: Scene, *, diagonal: bool) -> Map:
    """S D^-1 S for the generalized coordinates (v, x), with D the identity or the diagonal of the mass matrix."""
    embedding, count = scene.embedding, 3 * scene.embedding.vertex_count
    nodes = slice(count, count + 3 * embedding.node_count)
    basis = np.zeros((embedding.node_count, embedding.vertex_count))
    basis[embedding.nodes] = embedding.basis.toarray()
    removed = np.zeros((embedding.node_count, embedding.independent.shape[1]))
    removed[embedding.nodes] = embedding.independent.toarray()
    free = np.eye(embedding.node_count) - removed @ np.linalg.pinv(removed)
    moves = scene.system.moves.numpy().astype(float)
    of_vertices = scene.masses.vertices + (basis**2).T @ scene.masses.nodes
    of_vertices = np.where(of_vertices > 0.0, of_vertices, 1.0)  # vertices among yarns do not move
    of_vertices, of_nodes = (
        (of_vertices, scene.masses.nodes) if diagonal else (np.ones_like(of_vertices), np.ones_like(scene.masses.nodes))
    )

    def precondition(values: Vector) -> Vector:
        v, p = (values * moves)[:count].reshape(-1, 3), (values * moves)[nodes].reshape(-1, 3)
        v = np.divide((v + basis.T @ p) * moves[:count].reshape(-1, 3), of_vertices[:, None])
        x = free @ ((free @ p) / of_nodes[:, None])
        return np.concatenate([v.ravel(), (basis @ v + x).ravel(), np.zeros(2 * embedding.node_count)])

    return precondition


def by_projection(scene: Scene) -> Map:
    """The inverse of P."""
    scene.system.set_factors(1 / STEP**2, 1.0, scene.at_rest(), stiffness_in_metric=False)
    force, motion = scene.system.zeros(), scene.system.zeros()

    def precondition(values: Vector) -> Vector:
        force.values.assign(values)
        scene.system.preconditioner.launches(force, motion, scene.system.launch)
        return motion.values.numpy().copy()

    return precondition


def iterations(multiply: Map, precondition: Map, force: Vector, solution: Vector, most: int = 4000) -> int:
    """Iterations until all velocities together have a relative error of 1e-4."""
    x, r = np.zeros_like(force), force.copy()
    z = precondition(r)
    d, rz = z.copy(), r @ z
    for count in range(1, most + 1):
        product = multiply(d)
        alpha = rz / (d @ product)
        x, r = x + alpha * d, r - alpha * product
        if np.linalg.norm(x - solution) <= 1e-4 * np.linalg.norm(solution):
            return count
        z = precondition(r)
        rz, old = r @ z, rz
        d = z + rz / old * d
    return most


@pytest.mark.parametrize("ratio", [1e3, 1e4, 1e6])
def test_p_needs_ten_times_fewer_iterations_than_no_preconditioner(ratio):
    scene = scene_of(ratio)
    precondition = by_projection(scene)
    scene.system.linearize(scene.at_rest(), 0.0)
    random = np.random.default_rng(14)
    velocities = scene.vector(random.normal(size=PATCH.vertices.shape), random.normal(size=PATCH.nodes.shape))
    scene.system.make_motion(velocities)
    impulse = scene.system.zeros()
    scene.system.set_mass_product(velocities, impulse)
    force = impulse.values.numpy().copy()
    scene.system.solver.solve(impulse, tolerance=1e-11, most_iterations=4000)
    solution, multiply = scene.system.solver.solution.values.numpy().copy(), product_of(scene)
    counts = {
        "P": iterations(multiply, precondition, force, solution),
        "mass diagonal": iterations(multiply, filtered_by(scene, diagonal=True), force, solution),
        "none": iterations(multiply, filtered_by(scene, diagonal=False), force, solution),
    }
    assert 10 * counts["P"] <= counts["none"], counts
    assert counts["P"] <= counts["mass diagonal"], counts
