# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""What blocks of 3 x 3 in the metric of the hybrid region save, against one number for each node and vertex.

The metric D of the preconditioner contains the stiffness. With blocks Sigma = E D^-1 E' couples the coordinates and has
three times as many rows as with the mean of their diagonals, which the solver takes where the hybrid region has very
many vertices. Knits and weaves of crossings of ``gong-1`` swing as in ``mixed_preconditioner.py``, and the patch of
``examples/mixed/loops.toml`` is near its layout, with its nodes moved by a hundredth of a radius. One linear system of
each is solved with both metrics; the table holds the iterations of conjugate gradients until all positions have a
relative error of 1e-4.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from unittest.mock import patch

import numpy as np
import warp as wp

from benchmarks.measures.mixed.mixed_preconditioner import (
    SIDE,
    Case,
    Vector,
    by_projection,
    hanging_cloth,
    iterations,
    solved,
    swinging,
)
from benchmarks.measures.mixed.mixed_splines import SCENE
from benchmarks.table import Rows
from stitchmesh.compute.device import device_named
from stitchmesh.mixed.cloth.panels import Panel
from stitchmesh.mixed.cloth.seams import cloth_from_panels
from stitchmesh.mixed.crossings.materials.crossing_material import CrossingMaterial
from stitchmesh.mixed.crossings.materials.fabric_materials import FabricMaterials
from stitchmesh.mixed.dynamics.cloth_system import ClothModel, ClothSystem, cloth_system
from stitchmesh.mixed.enrichment import preconditioner
from stitchmesh.mixed.enrichment.region import region_around
from stitchmesh.mixed.layout.knit import lay_knit
from stitchmesh.mixed.mixed_vector import MixedVector
from stitchmesh.mixed.scene.cloth_of_yarns import cloth_of_knit
from stitchmesh.mixed.scene.scene_fabric import prepare
from stitchmesh.mixed.scene.scene_file import read_scene

KNITS = ((1.0, 4.0, 1e-3), (1.0, 4.0, 1e-1), (0.5, 4.0, 1e-1))
"""Edges of triangles [cm], wales [1/cm] and time step [s] of each knit."""
WEAVES = ((1.0, 16.0, 1e-3), (1.0, 16.0, 1e-1), (0.5, 8.0, 1e-1))
"""Edges of triangles [cm], yarns [1/cm] and time step [s] of each weave."""
SPLINE_STEPS = (1e-3, 1e-1)
"""Time steps of the patch of B-splines [s]."""
COURSES = 1.35
"""Courses for each wale."""
SHAKE = 0.01
"""Displacements of the control points, in yarn radii."""


def hanging_knit(edge: float, wales: float) -> ClothSystem:
    """A knitted square that hangs at two corners, with yarns in its middle."""
    outline = np.array([[0.0, 0.0], [SIDE, 0.0], [SIDE, SIDE], [0.0, SIDE]])
    cloth = cloth_from_panels([Panel(name="square", outline=outline)], [], edge_length=edge)
    yarns = lay_knit(cloth, np.ones((1, 1)), wale_spacing=1.0 / wales, course_spacing=1.0 / (wales * COURSES))
    yarn = replace(CrossingMaterial.named(), radius=0.08 / wales)
    sheet = cloth_of_knit(yarn, 4.0 * wales * COURSES)
    centre = cloth.vertices[cloth.triangles].mean(axis=1)[:, :2]
    chosen = np.flatnonzero(np.abs(centre - SIDE / 2).max(axis=1) < 0.15 * SIDE)
    region = region_around(cloth.triangles, len(cloth.vertices), yarns.triangle, yarns.barycentric, chosen)
    corners = [int(np.argmin(np.abs(cloth.vertices[:, :2] - place).sum(axis=1))) for place in ([0, SIDE], [SIDE, SIDE])]
    model = ClothModel(sheet, FabricMaterials.of(yarn), acceleration=(0.0, 0.0, -981.0))
    return cloth_system(cloth, yarns, region, model, fixed_vertices=corners, device=device_named("cpu"))


def shaken_loops(step: float) -> Case:
    """The patch of B-splines near its layout."""
    prepared = prepare(read_scene(SCENE))
    fabric = prepared.fabric
    model = ClothModel(fabric.cloth_material, fabric.yarn_materials, acceleration=(0.0, 0.0, 0.0))
    held = prepared.held[0].vertices
    scene = cloth_system(
        fabric.cloth, fabric.yarns, prepared.region, model, fixed_vertices=held, device=device_named("cpu")
    )
    v, p, s = scene.positions.numpy()
    shake = SHAKE * float(fabric.yarn_radius.mean()) * np.random.default_rng(0).normal(size=p.shape)
    positions = MixedVector.from_numpy(v, p + shake, s, wp.float64, device_named("cpu"))
    scene.system.make_motion(positions)
    return solved(scene, positions, positions.like(), 0.0, step)


def by_one_number(case: Case) -> Callable[[Vector], Vector]:
    """The projection of the solver with the mean of the diagonal of each block in the hybrid region."""
    system, masses = case.scene.system, case.scene.masses
    by_projection(case, stiffness_in_metric=True)  # finds the blocks
    with patch.object(preconditioner, "MOST_BLOCK_ROWS", 0):
        of_all = masses.vertices, masses.nodes
        own = preconditioner.Preconditioner(
            system.embedding, system.free, of_all, system.scalar, system.device, by_masses=False
        )
    own.set_metric(system._blocks, case.of_mass)
    force, motion = system.zeros(), system.zeros()

    def precondition(values: Vector) -> Vector:
        """Apply it."""
        force.values.assign(values)
        own.launches(force, motion, system.launch)
        return motion.values.numpy().copy()

    return precondition


def row(name: str, step: float, case: Case, most: int) -> tuple[object, ...]:
    """Iterations with both metrics."""
    metrics = by_one_number(case), by_projection(case, stiffness_in_metric=True)
    counts = [iterations(case, metric, most) for metric in metrics]
    embedding = case.scene.system.embedding
    sizes = len(case.scene.region.nodes), len(embedding.nodes), embedding.independent.shape[1]
    return name, f"{step:g}", *sizes, *counts


def mixed_block_metric(*, most: int = 8000) -> Rows:
    """Yield the table."""
    yield "yarns", "step s", "nodes", "hybrid", "vertices of Sigma", "one number", "blocks"
    for edge, wales, step in KNITS:
        case = swinging(hanging_knit(edge, wales), step)
        yield row(f"knit, {wales:g} wales/cm, edge {edge:g} cm", step, case, most)
    for edge, yarns, step in WEAVES:
        case = swinging(hanging_cloth(edge, yarns, "cpu"), step)
        yield row(f"weave, {yarns:g} yarns/cm, edge {edge:g} cm", step, case, most)
    for step in SPLINE_STEPS:
        yield row("B-splines", step, shaken_loops(step), most)
