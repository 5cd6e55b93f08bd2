# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Cloth with B-spline yarns: the relaxation of the yarns alone, both ends of the region, masses and rigid motion."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from stitchmesh.errors import ParameterError
from stitchmesh.mixed.assembly import MixedFabric
from stitchmesh.mixed.crossings.crossing_material import CrossingMaterial, FabricMaterials
from stitchmesh.mixed.dynamics.backward_euler import Dynamics, DynamicsSettings
from stitchmesh.mixed.dynamics.equilibrium import EquilibriumSettings, find_equilibrium
from stitchmesh.mixed.enrichment.region import HYBRID
from stitchmesh.mixed.layout.crossing_yarns import CrossingYarns
from stitchmesh.mixed.layout.weave import lay_weave
from stitchmesh.mixed.mixed_vector import MixedVector
from tests.mixed.cloth_scene import cloth_scene
from tests.mixed.splines.jersey import CPU, RADIUS, SHEET, YARN, built, jersey, region_of
from tests.mixed.triangles.derivatives import rotation

SETTINGS = EquilibriumSettings(force_tolerance=1e-2)


def shaken(scene, size: float) -> MixedVector:
    """The start with the inner nodes displaced by a part of a radius."""
    v, p, s = scene.positions.numpy()
    free = scene.system.free.nodes[:, None]
    return MixedVector.from_numpy(
        v, p + free * np.random.default_rng(0).normal(size=p.shape) * size * RADIUS, s, scene.system.scalar, CPU
    )


def test_all_yarns_come_to_the_rest_of_the_relaxation_of_yarns_alone():
    _cloth, yarns, pinned = jersey()
    scene = built("all", nodes=pinned)
    positions = shaken(scene, 0.02)
    report = find_equilibrium(scene.system, positions, SETTINGS)
    assert report.converged and report.iterations > 1
    # 0.01 dyn over the smallest stiffness of a loop that slides, about 10 dyn / cm
    np.testing.assert_allclose(positions.numpy()[1], yarns.curves.points, atol=0.02 * RADIUS)


def test_enriched_everywhere_equals_the_full_yarn_run():
    _cloth, _yarns, pinned = jersey()
    settings = DynamicsSettings(time_step=1e-4, velocity_tolerance=1e-6, solve_tolerance=1e-5)
    runs = []
    for name in ("everywhere", "all"):
        scene = built(name, nodes=pinned, gravity=(0.0, 0.0, -981.0))
        start = MixedVector.from_numpy(
            scene.fabric.cloth.vertices, scene.fabric.yarns.curves.points, np.zeros((scene.fabric.yarns.node_count, 2)),
            scene.system.scalar, CPU,
        )  # fmt: skip
        runs.append(Dynamics(scene.system, start, settings))
    for step in range(1, 4):
        for run in runs:
            run.step()
        first, second = (run.positions.numpy()[1] for run in runs)
        np.testing.assert_allclose(first, second, atol=1e-8 * step)  # 1e-8 a step, the tolerance of the solver
    assert np.abs(first - scene.fabric.yarns.curves.points).max() > 1e-5  # the yarns fall


def test_no_yarns_equal_cloth_alone():
    cloth, _yarns, _pinned = jersey()
    with_splines = built("none", gravity=(0.0, 0.0, -981.0))
    weave = lay_weave(cloth, np.eye(2, dtype=int), ends=8.0, picks=8.0)
    region = replace(region_of("none"), node_triangle=weave.triangle.copy(), node_weight=weave.barycentric.copy())
    materials = FabricMaterials.of(CrossingMaterial.named())
    fabric = MixedFabric(cloth=cloth, yarns=weave, cloth_material=SHEET, yarn_materials=materials)
    alone = cloth_scene(fabric, region, gravity=(0.0, 0.0, -981.0))
    assert isinstance(alone.fabric.yarns, CrossingYarns)
    forces = []
    for scene in (with_splines, alone):
        bent = scene.positions.numpy()[0] * [1.1, 0.9, 1.0] + 0.1 * np.sin(3.0 * cloth.vertices[:, :1]) * [0, 0, 1]
        force = scene.system.zeros()
        scene.system.set_forces(MixedVector.from_numpy(bent, [], [], scene.system.scalar, CPU), force)
        forces.append(force.numpy()[0])
    np.testing.assert_array_equal(*forces)


@pytest.mark.parametrize("name", ["none", "middle", "all"])
def test_the_cloth_weighs_the_same_with_yarns_anywhere(name):
    cloth, yarns, _pinned = jersey()
    scene = built(name)
    of_yarns = YARN.density * yarns.curves.rest_length.sum()
    of_triangles = SHEET.density * cloth.rest_area.sum()
    # The border has more yarn than stitches inside. The shares of segments across the border of a hybrid region are
    # not exact: of 36 stitches 20 lie there.
    expected = {"none": (of_triangles, 1e-9), "middle": (of_triangles, 0.02)}.get(name, (of_yarns, 1e-9))
    assert scene.masses.total == pytest.approx(expected[0], rel=expected[1])
    assert (scene.masses.nodes > 0.0).all()


def test_a_turned_cloth_is_of_the_form_of_the_hybrid_region_and_keeps_its_energy():
    scene = built("middle")
    embedding = scene.system.embedding
    assert len(embedding.nodes) == (scene.region.node_kind == HYBRID).sum() > 50
    v, p, s = scene.positions.numpy()
    offset = p - scene.fabric.yarns.curves.points[scene.region.nodes]
    assert np.abs(offset).max() < RADIUS  # mainly the vertices have moved to the middle of the yarns
    energies, turn = [], rotation()
    for axes in (np.eye(3), turn):
        state = MixedVector.from_numpy(v @ axes.T + 1.0, p @ axes.T + 1.0, s, scene.system.scalar, CPU)
        np.testing.assert_allclose(embedding.constraint(*state.numpy()[:2]), 0.0, atol=1e-12)  # rounding of 1 cm
        for term in scene.system.terms:
            term.begin_step(state, 0.0, 0.0)
        energies.append([term.energy(state) for term in scene.system.terms if term.name != "gravity"])
    np.testing.assert_allclose(energies[1], energies[0], atol=1e-9)


def test_a_material_of_the_other_model_is_refused():
    cloth, yarns, _pinned = jersey()
    materials = FabricMaterials.of(CrossingMaterial.named())
    with pytest.raises(ParameterError, match="SplineYarns with FabricMaterials; expected"):
        MixedFabric(cloth=cloth, yarns=yarns, cloth_material=SHEET, yarn_materials=materials)
