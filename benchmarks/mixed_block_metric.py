# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""What blocks of 3 x 3 in the metric of the hybrid region would save, against the number that the solver has there.

    python benchmarks/mixed_block_metric.py [--most 5000]

The metric D of the preconditioner contains the stiffness. Hybrid nodes and the vertices around them have the mean of
the diagonal of their block, so that one Sigma = E D^-1 E' serves all three coordinates. With whole blocks Sigma couples
the coordinates and has three times as many rows; with the three numbers of their diagonals there are three of them.
Knits of crossings of ``gong-1`` swing, as the weaves of ``mixed_preconditioner.py`` do, and the patch of
``examples/mixed/loops.toml`` is near its layout, with its nodes moved by a hundredth of a radius. One linear system of
each is solved with all metrics; the table holds the iterations of conjugate gradients until all positions have a
relative error of 1e-4.
"""

from __future__ import annotations

import argparse
from collections.abc import Callable
from dataclasses import replace

import numpy as np
import warp as wp

from benchmarks.mixed_preconditioner import SIDE, Case, Vector, by_projection, iterations, solved, swinging, views
from benchmarks.mixed_splines import SCENE
from stitchmesh.compute.device import device_named
from stitchmesh.mixed.cloth.panels import Panel
from stitchmesh.mixed.cloth.seams import cloth_from_panels
from stitchmesh.mixed.crossings.materials.crossing_material import CrossingMaterial
from stitchmesh.mixed.crossings.materials.fabric_materials import FabricMaterials
from stitchmesh.mixed.dynamics.cloth_system import ClothModel, ClothSystem, cloth_system
from stitchmesh.mixed.enrichment.projection import symmetric_inverse
from stitchmesh.mixed.enrichment.region import region_around
from stitchmesh.mixed.layout.knit import lay_knit
from stitchmesh.mixed.mixed_vector import MixedVector
from stitchmesh.mixed.scene.cloth_of_yarns import cloth_of_knit
from stitchmesh.mixed.scene.scene_fabric import prepare
from stitchmesh.mixed.scene.scene_file import read_scene

KNITS = ((1.0, 4.0, 1e-3), (1.0, 4.0, 1e-1), (0.5, 4.0, 1e-1))
"""Edges of triangles [cm], wales [1/cm] and time step [s] of each knit."""
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


def by_blocks(case: Case, *, diagonal: bool) -> Callable[[Vector], Vector]:
    """The projection with blocks, or their diagonals, in the hybrid region; elsewhere as in the solver."""
    system, embedding = case.scene.system, case.scene.system.embedding
    whole = by_projection(case, stiffness_in_metric=True)
    moves = system.moves.numpy().astype(bool)
    blocks, projection = system._blocks, system.preconditioner._projection
    coupled = embedding.coupled
    inverses = []
    bounds = projection.vertex_inverse.numpy(), projection.node_inverse.numpy()
    for block, taken, bound in zip((blocks.vertices.numpy(), blocks.nodes.numpy()), coupled, bounds, strict=True):
        found = np.zeros_like(block)
        for i in np.flatnonzero(taken & (bound > 0.0)):
            # what has hardly any mass or stiffness of its own is bounded as in the solver
            own = np.diag(np.diag(block[i])) if diagonal else (block[i] + block[i].T) / 2.0
            values, vectors = np.linalg.eigh(own)
            least = 1e-2 / bound[i]
            found[i] = (vectors / np.maximum(values, least)) @ vectors.T
        inverses.append(found)
    of_vertices, of_nodes = -embedding.gram.toarray(), embedding.independent.T.toarray()
    at_nodes = inverses[1][embedding.nodes]
    rows = embedding.independent.shape[1]
    sigma = np.einsum("cv,vij,dv->cidj", of_vertices, inverses[0], of_vertices, optimize=True)
    sigma += np.einsum("cn,nij,dn->cidj", of_nodes, at_nodes, of_nodes, optimize=True)
    inverse = symmetric_inverse(sigma.reshape(3 * rows, 3 * rows))

    def precondition(values: Vector) -> Vector:
        """Apply D^-1 and project."""
        force = values * moves
        v, p, s = views(whole(values).copy(), system.zeros())
        fv, fp, _fs = views(force, system.zeros())
        zv = np.einsum("vij,vj->vi", inverses[0], fv)
        zn = np.einsum("nij,nj->ni", at_nodes, fp[embedding.nodes])
        mu = (inverse @ (of_vertices @ zv + of_nodes @ zn).ravel()).reshape(rows, 3)
        zv -= np.einsum("vij,vj->vi", inverses[0], of_vertices.T @ mu)
        zn -= np.einsum("nij,nj->ni", at_nodes, of_nodes.T @ mu)
        v[coupled[0]] = zv[coupled[0]]
        p[embedding.nodes] = zn
        return np.concatenate([v.ravel(), p.ravel(), s.ravel()]) * moves

    return precondition


def row(name: str, step: float, case: Case, most: int) -> str:
    """Iterations with both metrics."""
    counts = [iterations(case, by_projection(case, stiffness_in_metric=True), most)]
    counts += [iterations(case, by_blocks(case, diagonal=diagonal), most) for diagonal in (True, False)]
    embedding = case.scene.system.embedding
    sizes = f"{len(case.scene.region.nodes)} | {len(embedding.nodes)} | {embedding.independent.shape[1]}"
    return f"| {name} | {step:g} | {sizes} | {' | '.join(map(str, counts))} |"


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--most", type=int, default=5000)
    most = parser.parse_args().most
    print("| yarns | step s | nodes | hybrid | rows of Sigma | one number | three numbers | blocks |")
    print("|---|---:|---:|---:|---:|---:|---:|---:|")
    for edge, wales, step in KNITS:
        case = swinging(hanging_knit(edge, wales), step)
        print(row(f"knit, {wales:g} wales/cm, edge {edge:g} cm", step, case, most), flush=True)
    for step in SPLINE_STEPS:
        print(row("B-splines", step, shaken_loops(step), most), flush=True)


if __name__ == "__main__":
    main()
