# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Conjugate-gradient iterations of one linear solve of a swinging cloth, for several preconditioners.

A square of woven cloth with yarns in its middle hangs at two corners and swings under its weight (Casafranca et al.
2020, figure 2). After some time the linear system of the next Newton iteration is solved from zero with no
preconditioner, with the diagonal of the generalized mass matrix, with P = S M + I - S, and with P whose masses contain
the diagonal of the stiffness. All solves filter every direction. The table holds the iterations until the velocities of
all vertices and nodes differ by 1e-4 from those of a solve to 1e-10, relative root mean squares.

The ratio of masses is that of the heaviest vertex to the lightest node, which has the smallest alpha.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.sparse.linalg import splu

from benchmarks.table import Rows
from stitchmesh.compute.device import device_named
from stitchmesh.mixed.cloth.panels import Panel
from stitchmesh.mixed.cloth.seams import cloth_from_panels
from stitchmesh.mixed.crossings.materials.crossing_material import CrossingMaterial
from stitchmesh.mixed.crossings.materials.fabric_materials import FabricMaterials
from stitchmesh.mixed.dynamics.backward_euler import Dynamics, DynamicsSettings
from stitchmesh.mixed.dynamics.cloth_system import ClothModel, ClothSystem, cloth_system
from stitchmesh.mixed.enrichment.region import region_around
from stitchmesh.mixed.layout.weave import lay_weave
from stitchmesh.mixed.mixed_vector import MixedVector
from stitchmesh.mixed.triangles.cloth_material import ClothMaterial

SIDE = 5.0
"""Side of the cloth [cm]."""
CASES = ((1.0, 8.0, 1e-3), (0.5, 16.0, 1e-3), (1.0, 16.0, 1e-3), (1.0, 16.0, 1e-4), (1.0, 32.0, 1e-4))
"""Edges of triangles [cm], yarns [1/cm] and time step [s] of each row."""
SWING = 0.02
"""Time before the solve [s]."""
ENOUGH = 1e-4
"""Error at which iterations are counted."""

Vector = NDArray[np.float64]


@dataclass(frozen=True)
class Case:
    """A cloth that swings, and the linear system of its next step."""

    scene: ClothSystem
    positions: MixedVector
    force: Vector
    reference: Vector
    of_mass: float


def hanging_cloth(edge: float, yarns_per_cm: float, device: str | None) -> ClothSystem:
    """A square that hangs at two corners, with yarns in its middle."""
    outline = np.array([[0.0, 0.0], [SIDE, 0.0], [SIDE, SIDE], [0.0, SIDE]])
    cloth = cloth_from_panels([Panel(name="square", outline=outline)], [], edge_length=edge)
    yarns = lay_weave(cloth, np.eye(2, dtype=int), ends=yarns_per_cm, picks=yarns_per_cm)
    yarn = replace(CrossingMaterial.named(), radius=0.25 / yarns_per_cm)
    sheet = ClothMaterial.isotropic(
        "sheet", yarn.stretch_stiffness * yarns_per_cm, 0.1, yarn.bending_stiffness * yarns_per_cm,
        2 * yarn.density * yarns_per_cm,
    )  # fmt: skip
    centre = cloth.vertices[cloth.triangles].mean(axis=1)[:, :2]
    chosen = np.flatnonzero(np.abs(centre - SIDE / 2).max(axis=1) < 0.15 * SIDE)
    region = region_around(cloth.triangles, len(cloth.vertices), yarns.triangle, yarns.barycentric, chosen)
    corners = [int(np.argmin(np.abs(cloth.vertices[:, :2] - place).sum(axis=1))) for place in ([0, SIDE], [SIDE, SIDE])]
    model = ClothModel(sheet, FabricMaterials.of(yarn), acceleration=(0.0, 0.0, -981.0))
    return cloth_system(cloth, yarns, region, model, fixed_vertices=corners, device=device_named(device))


def swinging(scene: ClothSystem, step: float) -> Case:
    """Swing a cloth, and find the system of the next step with its solution."""
    run = Dynamics(scene.system, scene.positions, DynamicsSettings(time_step=1e-3))
    while run.time < SWING:
        run.step()
    return solved(scene, run.positions, run.velocities, run.time, step)


def solved(scene: ClothSystem, positions: MixedVector, velocities: MixedVector, time: float, step: float) -> Case:
    """The linear system of a step in time with its solution."""
    system, force, inertia = scene.system, positions.like(), positions.like()
    system.update_masses(positions)
    for term in system.terms:
        term.begin_step(positions, time, step)
    system.set_forces(positions, force)
    system.set_mass_product(velocities, inertia)
    force.values.assign(force.values.numpy() + inertia.values.numpy() / step)
    system.set_factors(1.0 / step**2, 1.0, positions, stiffness_in_metric=False)
    system.linearize(positions, 0.0)
    system.solver.solve(force, tolerance=1e-10, most_iterations=50_000)
    right, reference = force.values.numpy().copy(), system.solver.solution.values.numpy().copy()
    return Case(scene, positions, right, reference, 1.0 / step**2)


def products(case: Case) -> Callable[[Vector], Vector]:
    """The product with the matrix of the system."""
    system = case.scene.system
    direction, product, mass = system.zeros(), system.zeros(), system.zeros()

    def multiply(values: Vector) -> Vector:
        direction.values.assign(values)
        system.set_hessian_product(direction, product)
        system.set_mass_product(direction, mass)
        return product.values.numpy() + case.of_mass * mass.values.numpy()

    return multiply


def generalized(case: Case, diagonal: bool) -> Callable[[Vector], Vector]:
    """No preconditioner or the mass diagonal, for the generalized coordinates q = (v, x) with the filter."""
    system, embedding = case.scene.system, case.scene.system.embedding
    moves = system.moves.numpy().astype(bool)
    basis, own = embedding.basis, embedding.independent
    gram = splu((own.T @ own).tocsc())
    masses = case.scene.masses
    of_vertices = masses.vertices + basis.power(2).T @ masses.nodes[embedding.nodes]
    sliding = system.mass.nodes.sliding_mass.numpy().ravel()
    scale = np.concatenate([np.repeat(of_vertices, 3), np.repeat(masses.nodes, 3), sliding])
    scale = np.where(scale > 0.0, scale, 1.0) if diagonal else np.ones_like(scale)

    def filtered(displacement: Vector) -> Vector:
        return displacement - own @ gram.solve(own.T @ displacement)

    def precondition(values: Vector) -> Vector:
        """Filter, divide, and filter again."""
        v, p, s = views(values * moves, system.zeros())
        q, h = p.copy(), embedding.nodes
        q[h] = filtered(p[h])
        joined = np.concatenate([(v + basis.T @ p[h]).ravel(), q.ravel(), s.ravel()]) * moves / scale
        v, q, s = views(joined, system.zeros())
        p = q.copy()
        p[h] = filtered(q[h]) + basis @ v
        return np.concatenate([v.ravel(), p.ravel(), s.ravel()]) * moves

    return precondition


def views(values: Vector, shape: MixedVector) -> tuple[Vector, Vector, Vector]:
    """Vertices, nodes and Eulerian coordinates of a flat vector."""
    first, second = 3 * shape.vertex_count, 3 * shape.vertex_count + 3 * shape.node_count
    return values[:first].reshape(-1, 3), values[first:second].reshape(-1, 3), values[second:].reshape(-1, 2)


def by_projection(case: Case, stiffness_in_metric: bool) -> Callable[[Vector], Vector]:
    """P, with the masses alone or with the diagonal of the stiffness."""
    system = case.scene.system
    system.set_factors(case.of_mass, 1.0, case.positions, stiffness_in_metric=stiffness_in_metric)
    force, motion = system.zeros(), system.zeros()

    def precondition(values: Vector) -> Vector:
        """Apply the preconditioner of the solver."""
        force.values.assign(values)
        system.preconditioner.launches(force, motion, system.launch)
        return motion.values.numpy().copy()

    return precondition


def iterations(case: Case, precondition: Callable[[Vector], Vector], most: int) -> int:
    """Conjugate-gradient iterations to the error ``ENOUGH``; ``most`` where it is not reached."""
    multiply, places = products(case), 3 * (case.scene.positions.vertex_count + case.scene.positions.node_count)
    enough = ENOUGH * np.linalg.norm(case.reference[:places])
    x, r = np.zeros_like(case.force), case.force.copy()
    z = precondition(r)
    d, rz = z.copy(), r @ z
    for count in range(1, most + 1):
        product = multiply(d)
        alpha = rz / (d @ product)
        x, r = x + alpha * d, r - alpha * product
        if np.linalg.norm((x - case.reference)[:places]) <= enough:
            return count
        z = precondition(r)
        rz, old = r @ z, rz
        d = z + (rz / old) * d
    return most


def mixed_preconditioner(*, device: str | None = None, most: int = 5000) -> Rows:
    """Yield the table."""
    yield (
        "yarns /cm", "edge cm", "step s", "vertices", "nodes", "mass ratio", "none", "mass diagonal", "P",
        "P with stiffness",
    )  # fmt: skip
    for edge, yarns, step in CASES:
        case = swinging(hanging_cloth(edge, yarns, device), step)
        masses = case.scene.masses
        ratio = masses.vertices.max() / masses.nodes.min()
        counts = [iterations(case, generalized(case, diagonal), most) for diagonal in (False, True)]
        for stiff in (False, True):
            precondition = by_projection(case, stiff)
            counts.append(iterations(case, precondition, most))
        size = int(case.scene.region.unknown_vertices.sum()), len(masses.nodes)
        found = (f"over {most}" if count == most else count for count in counts)
        yield f"{yarns:g}", f"{edge:g}", f"{step:g}", *size, f"{ratio:.1e}", *found
