# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Linear systems of mixed cloths, and iterations of conjugate gradients with several preconditioners.

Squares of woven or knitted cloth with yarns in their middle hang at two corners and swing under their weight
(Casafranca et al. 2020, figure 2). After some time the linear system of the next Newton iteration is solved from zero.
The patch of ``examples/mixed/loops.toml`` is near its layout, with its nodes moved by a hundredth of a radius.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from unittest.mock import patch

import numpy as np
import warp as wp
from numpy.typing import NDArray
from scipy.sparse.linalg import splu

from benchmarks.places import MIXED_SCENES
from stitchmesh.compute.device import device_named
from stitchmesh.mixed.assembly import Loads, MixedFabric, fabric_masses, loaded_system, start_positions
from stitchmesh.mixed.cloth.panels import Panel
from stitchmesh.mixed.cloth.seams import cloth_from_panels
from stitchmesh.mixed.contact.motion import Attachment
from stitchmesh.mixed.crossings.crossing_material import CrossingMaterial, FabricMaterials
from stitchmesh.mixed.dynamics.backward_euler import Dynamics, DynamicsSettings
from stitchmesh.mixed.dynamics.mass_matrix import BlendedMasses
from stitchmesh.mixed.dynamics.mixed_system import MixedSystem
from stitchmesh.mixed.enrichment import preconditioner
from stitchmesh.mixed.enrichment.region import Region, region_around
from stitchmesh.mixed.layout.knit import lay_knit
from stitchmesh.mixed.layout.weave import lay_weave
from stitchmesh.mixed.mixed_vector import MixedVector
from stitchmesh.mixed.scene.scene import read_scene
from stitchmesh.mixed.scene.scene_fabric import cloth_of_knit, prepare
from stitchmesh.mixed.triangles.cloth_material import ClothMaterial

Vector = NDArray[np.float64]
CPU = device_named("cpu")
SIDE = 5.0
"""Side of the square [cm]."""
COURSES = 1.35
"""Courses of a knit for each wale."""
SWING = 0.02
"""Time before the solve [s]."""
SHAKE = 0.01
"""Displacements of the control points of B-splines, in yarn radii."""
ENOUGH = 1e-4
"""Error of the positions of vertices and nodes at which iterations are counted."""


@dataclass(frozen=True)
class Case:
    """The linear system of a step in time, with its solution."""

    fabric: MixedFabric
    region: Region
    system: MixedSystem
    positions: MixedVector
    force: Vector
    reference: Vector
    of_mass: float

    @property
    def masses(self) -> BlendedMasses:
        """Masses of vertices and nodes."""
        return fabric_masses(self.fabric, self.region)

    @property
    def sizes(self) -> tuple[int, int, int, int]:
        """Unknown vertices, nodes, hybrid nodes, and vertices of Sigma."""
        embedding = self.system.embedding
        unknown = int(self.region.unknown_vertices.sum())
        return unknown, len(self.region.nodes), len(embedding.nodes), embedding.independent.shape[1]


@dataclass(frozen=True)
class Hanging:
    """A square cloth that hangs at two corners and swings."""

    kind: str
    """``weave`` or ``knit``."""
    edge: float
    """Edges of its triangles [cm]."""
    density: float
    """Warps and wefts, or wales, for each cm."""
    step: float
    """Length of the step whose system is solved [s]."""

    @property
    def name(self) -> str:
        """The cloth in words."""
        unit = "yarns" if self.kind == "weave" else "wales"
        return f"{self.kind}, {self.density:g} {unit}/cm, edge {self.edge:g} cm"

    def case(self) -> Case:
        """Swing the cloth, and find the system of the next step with its solution."""
        fabric, region, loads = self._loaded_cloth()
        system = loaded_system(fabric, region, loads, device=CPU)
        run = Dynamics(system, start_positions(fabric, region, system), DynamicsSettings(time_step=1e-3))
        while run.time < SWING:
            run.step()
        start = run.positions, run.velocities
        return solved(fabric, region, system, start, run.time, self.step)

    def _loaded_cloth(self) -> tuple[MixedFabric, Region, Loads]:
        outline = np.array([[0.0, 0.0], [SIDE, 0.0], [SIDE, SIDE], [0.0, SIDE]])
        cloth = cloth_from_panels([Panel(name="square", outline=outline)], [], edge_length=self.edge)
        number = self.density
        if self.kind == "weave":
            yarns = lay_weave(cloth, np.eye(2, dtype=int), ends=number, picks=number)
            yarn = replace(CrossingMaterial.named(), radius=0.25 / number)
            stretch, bending, density = yarn.stretch_stiffness, yarn.bending_stiffness, yarn.density
            sheet = ClothMaterial.isotropic("sheet", stretch * number, 0.1, bending * number, 2 * density * number)
        else:
            yarns = lay_knit(cloth, np.ones((1, 1)), wale_spacing=1 / number, course_spacing=1 / (number * COURSES))
            yarn = replace(CrossingMaterial.named(), radius=0.08 / number)
            sheet = cloth_of_knit(yarn, 4.0 * number * COURSES)
        centre = cloth.vertices[cloth.triangles].mean(axis=1)[:, :2]
        chosen = np.flatnonzero(np.abs(centre - SIDE / 2).max(axis=1) < 0.15 * SIDE)
        region = region_around(cloth.triangles, len(cloth.vertices), yarns.triangle, yarns.barycentric, chosen)
        materials = FabricMaterials.of(yarn)
        fabric = MixedFabric(cloth=cloth, yarns=yarns, cloth_material=sheet, yarn_materials=materials)
        corners = [
            int(np.argmin(np.abs(cloth.vertices[:, :2] - place).sum(axis=1))) for place in ([0, SIDE], [SIDE, SIDE])
        ]
        return fabric, region, Loads(gravity=(0.0, 0.0, -981.0), held=[Attachment(np.array(corners))])


@dataclass(frozen=True)
class ShakenLoops:
    """The patch of B-splines near its layout."""

    step: float
    name: str = "B-splines"

    def case(self) -> Case:
        """The system of its first step, with its solution."""
        prepared = prepare(read_scene(MIXED_SCENES / "loops.toml"))
        fabric, region = prepared.fabric, prepared.region
        loads = Loads(gravity=(0.0, 0.0, 0.0), held=[Attachment(prepared.held[0].vertices)])
        system = loaded_system(fabric, region, loads, device=CPU)
        v, p, s = start_positions(fabric, region, system).numpy()
        shake = SHAKE * float(fabric.yarn_radius.mean()) * np.random.default_rng(0).normal(size=p.shape)
        positions = MixedVector.from_numpy(v, p + shake, s, wp.float64, CPU)
        system.make_motion(positions)
        return solved(fabric, region, system, (positions, positions.like()), 0.0, self.step)


def solved(
    fabric: MixedFabric, region: Region, system: MixedSystem, start: tuple[MixedVector, MixedVector], time: float,
    step: float,
) -> Case:  # fmt: skip
    """The linear system of a step in time with its solution."""
    positions, velocities = start
    force, inertia = positions.like(), positions.like()
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
    return Case(fabric, region, system, positions, right, reference, 1.0 / step**2)


Precondition = Callable[[Vector], Vector]


def generalized(case: Case, *, by_mass: bool) -> Precondition:
    """The filter of the generalized coordinates q = (v, x), and a division by the diagonal of their masses."""
    system, embedding = case.system, case.system.embedding
    moves = system.moves.numpy().astype(bool)
    basis, own = embedding.basis, embedding.independent
    gram = splu((own.T @ own).tocsc())
    masses = case.masses
    of_vertices = masses.vertices + basis.power(2).T @ masses.nodes[embedding.nodes]
    sliding = system.mass.nodes.sliding_mass.numpy().ravel()
    scale = np.concatenate([np.repeat(of_vertices, 3), np.repeat(masses.nodes, 3), sliding])
    scale = np.where(scale > 0.0, scale, 1.0) if by_mass else np.ones_like(scale)

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


def by_projection(case: Case, *, stiffness: bool) -> Precondition:
    """P as the solver has it, with the masses alone or with the diagonal of the stiffness in blocks."""
    system = case.system
    system.set_factors(case.of_mass, 1.0, case.positions, stiffness_in_metric=stiffness)
    return applied(case, system.preconditioner)


def by_one_number(case: Case) -> Precondition:
    """P with the mean of the diagonal of each block in the hybrid region."""
    system, masses = case.system, case.masses
    by_projection(case, stiffness=True)  # finds the blocks
    with patch.object(preconditioner, "MOST_BLOCK_ROWS", 0):
        own = preconditioner.Preconditioner(
            system.embedding, system.free, (masses.vertices, masses.nodes), system.scalar, system.device,
            by_masses=False,
        )  # fmt: skip
    own.set_metric(system._blocks, case.of_mass)
    return applied(case, own)


def applied(case: Case, chosen: preconditioner.Preconditioner) -> Precondition:
    """A preconditioner of the solver as a function of flat vectors."""
    system = case.system
    force, motion = system.zeros(), system.zeros()

    def precondition(values: Vector) -> Vector:
        force.values.assign(values)
        chosen.launches(force, motion, system.launch)
        return motion.values.numpy().copy()

    return precondition


def iterations(case: Case, precondition: Precondition, most: int) -> int:
    """Conjugate-gradient iterations to the error ``ENOUGH``; ``most`` where it is not reached."""
    system = case.system
    direction, product, mass = system.zeros(), system.zeros(), system.zeros()

    def multiply(values: Vector) -> Vector:
        direction.values.assign(values)
        product.values.zero_()
        for term in system.terms:
            term.products(direction, product, system.launch)
        system.set_mass_product(direction, mass)
        return product.values.numpy() + case.of_mass * mass.values.numpy()

    places = 3 * (case.positions.vertex_count + case.positions.node_count)
    enough = ENOUGH * np.linalg.norm(case.reference[:places])
    x, r = np.zeros_like(case.force), case.force.copy()
    z = precondition(r)
    d, rz = z.copy(), r @ z
    for count in range(1, most + 1):
        image = multiply(d)
        alpha = rz / (d @ image)
        x, r = x + alpha * d, r - alpha * image
        if np.linalg.norm((x - case.reference)[:places]) <= enough:
            return count
        z = precondition(r)
        rz, old = r @ z, rz
        d = z + (rz / old) * d
    return most
