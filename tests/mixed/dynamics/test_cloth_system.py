# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Cloth of triangles with crossing yarns: the full-yarn run, masses, rigid motion, extremes of the region, resume."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
import warp as wp

from stitchmesh.mixed.assembly import MixedFabric, fabric_masses
from stitchmesh.mixed.cloth.panels import Panel, PanelPosition
from stitchmesh.mixed.cloth.seams import PanelBorder, PanelSeam, cloth_from_panels
from stitchmesh.mixed.crossings.crossing_material import CrossingMaterial, FabricMaterials
from stitchmesh.mixed.dynamics.backward_euler import Dynamics, DynamicsSettings
from stitchmesh.mixed.dynamics.equilibrium import EquilibriumSettings, find_equilibrium
from stitchmesh.mixed.enrichment.region import Region, region_around
from stitchmesh.mixed.layout.knit import lay_knit
from stitchmesh.mixed.layout.weave import lay_weave
from stitchmesh.mixed.mixed_vector import MixedBlocks, MixedVector
from stitchmesh.mixed.triangles.cloth_material import ClothMaterial
from stitchmesh.mixed.triangles.seam_rod import SeamMaterial
from tests.mixed.cloth_scene import ClothScene, cloth_scene
from tests.mixed.dynamics.scene import CPU, set_hessian_product
from tests.mixed.patch import enriched_everywhere

SIDE, ENDS = 3.0, 6.0
OUTLINE = np.array([[0.0, 0.0], [SIDE, 0.0], [SIDE, SIDE], [0.0, SIDE]])
CLOTH = cloth_from_panels([Panel(name="square", outline=OUTLINE)], [], edge_length=0.6)
YARNS = lay_weave(CLOTH, np.eye(2, dtype=int), ends=ENDS, picks=ENDS)
YARN = replace(CrossingMaterial.named(), radius=0.04)
SHEET = ClothMaterial.isotropic(
    "sheet", YARN.stretch_stiffness * ENDS, 0.1, YARN.bending_stiffness * ENDS, 2 * YARN.density * ENDS
)
FABRIC = MixedFabric(cloth=CLOTH, yarns=YARNS, cloth_material=SHEET, yarn_materials=FabricMaterials.of(YARN))
LAYOUT: Any = (CLOTH.triangles, len(CLOTH.vertices), YARNS.triangle, YARNS.barycentric)
MIDDLE = np.flatnonzero(np.abs(CLOTH.vertices[CLOTH.triangles].mean(axis=1)[:, :2] - SIDE / 2).max(axis=1) < 0.5)
REGIONS = {
    "middle": region_around(*LAYOUT, MIDDLE),
    "everywhere": enriched_everywhere(*LAYOUT),
    "all yarns": region_around(*LAYOUT, np.arange(len(CLOTH.triangles))),
    "none": region_around(*LAYOUT, []),
}
FALLING = (0.0, 0.0, -981.0)
TIGHT = DynamicsSettings(time_step=2e-4, velocity_tolerance=1e-7, solve_tolerance=1e-4)


def built(
    region: Region, *, nodes: Sequence[int] = (), vertices: Sequence[int] = (), scalar: Any = wp.float64
) -> ClothScene:
    return cloth_scene(FABRIC, region, nodes=nodes, vertices=vertices, gravity=FALLING, scalar=scalar)


def corner_nodes() -> list[int]:
    return [int(np.argmin(np.abs(YARNS.position - corner).sum(axis=1))) for corner in ([0, 0], [SIDE, SIDE])]


def test_terms_without_elements_are_not_made():
    assert [term.name for term in built(REGIONS["none"]).system.terms] == ["membrane", "bending", "gravity"]


def test_enriched_everywhere_equals_the_full_yarn_run():
    runs = [
        Dynamics((scene := built(REGIONS[name], nodes=corner_nodes())).system, scene.positions, TIGHT)
        for name in ("everywhere", "all yarns")
    ]
    for step in range(1, 6):
        for run in runs:
            assert run.step().halvings == 0
        (_, p, s), (_, full_p, full_s) = (run.positions.numpy() for run in runs)
        np.testing.assert_allclose(p, full_p, atol=1e-8 * step)  # 1e-8 a step, the tolerance of the solver
        np.testing.assert_allclose(s, full_s, atol=1e-8 * step)


@pytest.mark.parametrize("name", ["middle", "all yarns", "none"])
def test_masses_of_the_nodes_are_those_of_the_yarn_model_and_the_cloth_weighs_the_same(name):
    scene = built(REGIONS[name])
    scene.system.update_masses(scene.positions)
    of_yarns = scene.system.mass.nodes.mass.numpy()
    np.testing.assert_allclose(of_yarns, scene.masses.nodes, rtol=1e-12)
    # Yarns end half a spacing before the border: at most one spacing along the four sides is missing.
    assert scene.masses.total == pytest.approx(SHEET.density * SIDE**2, rel=4 / (SIDE * ENDS))


def test_a_cloth_in_free_fall_stays_as_it_is():
    scene = built(REGIONS["middle"])
    run = Dynamics(scene.system, scene.positions, replace(TIGHT, time_step=1e-3, velocity_tolerance=1e-6))
    start = scene.positions.numpy()
    for _ in range(3):
        run.step()
    fallen = -981.0 * 1e-6 * 3 * 4 / 2  # g h^2 n (n + 1) / 2
    for part, rest, moves in zip(
        run.positions.numpy()[:2], start[:2], (scene.region.unknown_vertices, slice(None)), strict=True
    ):
        np.testing.assert_allclose((part - rest)[moves], np.tile([0, 0, fallen], (len(part[moves]), 1)), atol=1e-7)
    # The tolerance of the velocities, which allows light nodes more than the mean.
    np.testing.assert_allclose(run.positions.numpy()[2], start[2], atol=1e-7)


def test_a_rod_along_a_seam_goes_on_from_the_triangles_to_the_yarns():
    """It weighs the same wherever the yarns are, but for the two ends of a rod of yarn, beyond its last nodes."""
    panels = [
        Panel(name=name, outline=OUTLINE, position=PanelPosition(origin=(SIDE * number, 0.0, 0.0)))
        for number, name in enumerate(("left", "right"))
    ]
    sides = PanelBorder(panel="left", start=1, end=2), PanelBorder(panel="right", start=3, end=0)
    cloth = cloth_from_panels(panels, [PanelSeam(first=sides[0], second=sides[1])], edge_length=0.6)
    yarns = lay_weave(cloth, np.eye(2, dtype=int), ends=ENDS, picks=ENDS)
    middle = cloth.vertices[cloth.triangles].mean(axis=1)
    light = replace(YARN, density=1e-12)
    fabric = MixedFabric(
        cloth=cloth,
        yarns=yarns,
        cloth_material=replace(SHEET, density=1e-12),
        yarn_materials=FabricMaterials(light, light, YARN),
        seam_material=SeamMaterial(1.0, 1.0, YARN.density),
    )
    weights = []
    for chosen in (np.zeros(0), np.flatnonzero(middle[:, 1] < SIDE / 2), np.arange(len(middle))):
        region = region_around(cloth.triangles, len(cloth.vertices), yarns.triangle, yarns.barycentric, chosen)
        weights.append(fabric_masses(fabric, region).total)
    assert weights[0] == pytest.approx(YARN.density * SIDE, rel=1e-6)
    assert weights[2] == pytest.approx(YARN.density * (SIDE - 0.75 / ENDS), rel=1e-6)
    assert weights[2] < weights[1] < weights[0]


def test_a_turned_cloth_has_no_forces():
    c, s = np.cos(0.8), np.sin(0.8)
    turn = np.array([[c, 0, s], [0, 1, 0], [-s, 0, c]])
    vertices = CLOTH.vertices @ turn.T + [1, 2, 3]
    turned = cloth_scene(FABRIC, REGIONS["middle"], gravity=(0.0, 0.0, 0.0), places=vertices)
    report = find_equilibrium(turned.system, turned.positions, EquilibriumSettings(force_tolerance=1e-5))
    # Rounding of the stretch of yarns: 1e4 dyn times 1e-15 over the length of a segment, and more for angles.
    assert (report.converged, report.iterations) == (True, 0)


def test_inner_forces_have_no_sum_and_no_moment_and_do_the_work_of_the_energy():
    """Momentum and angular momentum of a free cloth are kept, whatever its shape."""
    scene = cloth_scene(FABRIC, REGIONS["middle"], gravity=(0.0, 0.0, 0.0))
    random, system, state = np.random.default_rng(21), scene.system, scene.positions
    moved, motion, force = state.like(), state.like(), state.like()
    for vector, size in ((moved, 0.02), (motion, 1e-6)):
        vector.values.assign(random.normal(scale=size, size=len(state.values)) * system.moves.numpy())
        system.make_motion(vector)
    values = state.values.numpy() + moved.values.numpy()
    state.values.assign(values)
    system.set_forces(state, force)
    places, pulls = (np.concatenate(part.numpy()[:2]) for part in (state, force))
    size = np.abs(pulls).sum()
    np.testing.assert_allclose(pulls.sum(axis=0), 0.0, atol=1e-12 * size)  # rounding of sums of some 1,000 forces
    np.testing.assert_allclose(np.cross(places, pulls).sum(axis=0), 0.0, atol=1e-12 * size * SIDE)
    work, energies = float(force.values.numpy() @ motion.values.numpy()), []
    for sign in (1.0, -1.0):
        state.values.assign(values + sign * motion.values.numpy())
        energies.append(sum(system.energies(state).values()))
    # the difference of energies of 1e5 erg is rounded to 1e-11 of them
    assert energies[1] - energies[0] == pytest.approx(2.0 * work, rel=1e-4, abs=1e-9 * max(energies))


@pytest.mark.nightly
def test_a_swinging_cloth_loses_energy_only():
    """In single precision, with all terms and the whole solver."""
    scene = built(REGIONS["middle"], vertices=[0, 5], scalar=wp.float32)
    settings = DynamicsSettings(time_step=1e-3, velocity_tolerance=1e-2)
    run = Dynamics(scene.system, scene.positions, settings)
    energy = sum(run.energies().values())
    for _ in range(15):
        run.step()
    assert np.isfinite(run.positions.values.numpy()).all()
    # The error of the velocities times the momentum of some 1 g at 10 cm/s, at each step.
    assert sum(run.energies().values()) < energy + 15 * 1e-2 * scene.masses.total * 10.0


def test_a_run_with_friction_that_is_stopped_and_resumed_has_the_same_bits():
    def run(steps: int, arrays: dict[str, Any] | None = None) -> dict[str, Any]:
        scene = built(REGIONS["middle"], vertices=[0, 5])
        dynamics = Dynamics(scene.system, scene.positions, replace(TIGHT, velocity_tolerance=1e-3, time_step=1e-3))
        if arrays is not None:
            dynamics.resume(arrays)
        for _ in range(steps):
            dynamics.step()
        return {name: array.copy() for name, array in dynamics.arrays().items()}

    whole, resumed = run(4), run(2, run(2))
    for name, array in whole.items():
        np.testing.assert_array_equal(resumed[name], array)


@pytest.mark.parametrize("kind", ["weave", "knit"])
def test_the_blocks_of_the_metric_are_those_of_the_products(kind):
    yarns = YARNS if kind == "weave" else lay_knit(CLOTH, np.ones((1, 1)), wale_spacing=0.25, course_spacing=0.2)
    region = region_around(CLOTH.triangles, len(CLOTH.vertices), yarns.triangle, yarns.barycentric, MIDDLE)
    scene = cloth_scene(replace(FABRIC, yarns=yarns), region)
    system, state = scene.system, scene.positions
    bent = np.random.default_rng(15).normal(scale=0.01, size=len(state.values)) * system.moves.numpy()
    state.values.assign(state.values.numpy() + bent)
    system.linearize(state, 0.4)
    blocks = MixedBlocks.zeros(state.vertex_count, state.node_count, wp.float64, CPU)
    for term in system.terms:
        term.diagonal(blocks, system.launch)
    of_nodes, of_sliding = blocks.nodes.numpy(), blocks.sliding.numpy()
    columns = np.stack([blocks.coupling_u.numpy(), blocks.coupling_v.numpy()], axis=2)
    product, moved = state.like(), state.like()
    for node in range(0, state.node_count, 9):
        for axis in range(3):
            v, p, s = (np.zeros_like(part) for part in state.numpy())
            p[node, axis] = 1.0
            moved.assign(MixedVector.from_numpy(v, p, s, wp.float64, CPU))
            set_hessian_product(system, moved, product)
            _, force, pull = product.numpy()
            rounding = 1e-6 * np.abs(of_nodes[node]).max()  # blocks are stored in single precision
            np.testing.assert_allclose(force[node], of_nodes[node][:, axis], atol=rounding)
            # The weight of yarn couples heights and coordinates too, and is left out of the metric.
            weight = 981.0 * YARN.density
            np.testing.assert_allclose(pull[node], columns[node][axis], atol=rounding + weight)
    assert np.isfinite(of_sliding).all()
