# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Static equilibria: closed forms, patch tests, large motions, friction-like updates."""

from __future__ import annotations

import numpy as np
import pytest

from stitchmesh.errors import ParameterError
from stitchmesh.mixed.dynamics.equilibrium import EquilibriumSettings, find_equilibrium
from stitchmesh.mixed.dynamics.weight import Weight
from stitchmesh.mixed.enrichment.region import region_around
from tests.mixed.dynamics.scene import spring_scene
from tests.mixed.patch import enriched_everywhere, square_patch

PATCH = square_patch(8, 4)
CHOSEN = PATCH.near((0.5, 0.5), 0.26)
BORDER = np.flatnonzero((np.abs(PATCH.vertices[:, :2] - 0.5) > 0.499).any(axis=1))
TIGHT = EquilibriumSettings(force_tolerance=1e-7)
STRETCH = np.array([[1.3, 0.1, 0.0], [0.0, 0.9, 0.0], [0.0, 0.0, 1.0]])


def rotation(angle: float) -> np.ndarray:
    c, s = np.cos(angle), np.sin(angle)
    return np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]]) @ np.array([[1, 0, 0], [0, c, -s], [0, s, c]])


@pytest.mark.parametrize("rings", [1, 2])
def test_a_rigid_motion_is_an_equilibrium_and_a_motion_of_the_mixed_system(rings):
    region = region_around(*PATCH.layout, CHOSEN, rings=rings)
    scene = spring_scene(PATCH, region)
    turned = [points @ rotation(0.7).T + [1.0, 2.0, 3.0] for points in (PATCH.vertices, PATCH.nodes)]
    state = scene.vector(*turned)
    v, p, _ = state.numpy()
    assert np.abs(scene.embedding.constraint(v, p)).max() < 1e-13  # rounding of positions of size 1
    report = find_equilibrium(scene.system, state, EquilibriumSettings(force_tolerance=1e-10))
    assert (report.converged, report.iterations) == (True, 0)


def test_uniform_stretch_passes_the_hybrid_region_nearly_unchanged():
    """Both blended models together balance at each vertex but for the sampling of triangles by yarns; what the gradient
    of alpha leaves at the nodes is less where alpha falls over two rings."""
    errors = []
    for rings in (1, 2):
        region = region_around(*PATCH.layout, CHOSEN, rings=rings)
        scene = spring_scene(PATCH, region, rest=0.0, fixed_vertices=BORDER)
        state = scene.vector(PATCH.vertices @ STRETCH.T, PATCH.nodes @ STRETCH.T)
        start = [part.copy() for part in state.numpy()]
        assert find_equilibrium(scene.system, state, EquilibriumSettings(force_tolerance=1e-5)).converged
        spacing = 1.0 / PATCH.nodes_a_side
        moved = np.linalg.norm(state.numpy()[1] - start[1], axis=1)[scene.region.sliding_nodes] / spacing
        errors.append(float(np.sqrt(np.mean(moved**2))))
    # In spacings of yarns, for springs without rest length, whose stress is that of a strain of 1.
    assert errors[0] < 0.02
    assert errors[1] < errors[0]


def test_uniform_stretch_is_the_equilibrium_of_yarns_alone_and_of_triangles_alone():
    regions = region_around(*PATCH.layout, []), region_around(*PATCH.layout, np.arange(128))
    outer = np.flatnonzero((np.abs(PATCH.nodes[:, :2] - 0.5) > 0.48).any(axis=1))
    for region in regions:
        scene = spring_scene(PATCH, region, rest=0.0, fixed_vertices=BORDER, fixed_nodes=outer)
        state = scene.vector(PATCH.vertices @ STRETCH.T, PATCH.nodes @ STRETCH.T)
        expected = state.values.numpy().copy()
        disturbed = np.random.default_rng(11).normal(scale=0.02, size=expected.shape) * scene.system.moves.numpy()
        state.values.assign(expected + disturbed)
        assert find_equilibrium(scene.system, state, TIGHT).converged
        # The tolerance of the forces over the smallest stiffness of a smooth motion.
        np.testing.assert_allclose(state.values.numpy(), expected, atol=1e-6)


def test_a_hanging_patch_of_springs_without_rest_length_has_the_parabola_of_the_closed_form():
    """For the energy k/2 |grad x|^2 and the weight m g per area a strip that hangs has x'' = -m g / k."""
    region = region_around(*PATCH.layout, [])
    top = np.flatnonzero(PATCH.vertices[:, 1] > 0.999)
    scene = spring_scene(PATCH, region, rest=0.0, fixed_vertices=top)
    scene.system.add(Weight(scene.system.mass))
    state = scene.at_rest()
    report = find_equilibrium(scene.system, state, TIGHT)
    assert report.converged
    load = 0.1 * 981.0 / 50.0
    y = PATCH.vertices[:, 1]
    # Linear elements with loads at the vertices meet the parabola at the vertices.
    expected = 1.0 - load * ((1 - y) - (1 - y) ** 2 / 2)
    found = state.numpy()[0][:, 1]
    middle = np.abs(PATCH.vertices[:, 0] - 0.5) < 0.1
    np.testing.assert_allclose(found[middle], expected[middle], atol=0.01)


def test_the_energy_of_enriched_and_full_yarn_equilibria_is_the_same():
    energies = []
    for region in (enriched_everywhere(*PATCH.layout), region_around(*PATCH.layout, np.arange(128))):
        top = np.flatnonzero(PATCH.nodes[:, 1] > 0.96)
        scene = spring_scene(PATCH, region, fixed_nodes=top)
        scene.system.add(Weight(scene.system.mass, (10.0, -30.0, 5.0)))
        state = scene.at_rest()
        report = find_equilibrium(scene.system, state, EquilibriumSettings(force_tolerance=1e-6))
        assert report.converged
        energies.append(report.energy)
    assert energies[0] == pytest.approx(energies[1], rel=1e-8)


def test_a_crumpled_start_comes_to_rest_with_springs_at_their_rest_length():
    region = region_around(*PATCH.layout, CHOSEN)
    scene = spring_scene(PATCH, region)
    state = scene.at_rest()
    random = np.random.default_rng(12).normal(scale=0.05, size=len(state.values)) * scene.system.moves.numpy()
    motion = state.like()
    motion.values.assign(random)
    scene.system.make_motion(motion)
    state.values.assign(state.values.numpy() + motion.values.numpy())
    before = sum(scene.system.energies(state).values())
    report = find_equilibrium(scene.system, state, EquilibriumSettings(force_tolerance=1e-4))
    assert report.converged
    assert report.energy < 1e-3 * before


def test_settings_out_of_range_are_refused():
    with pytest.raises(ParameterError, match="equilibrium: force_tolerance: got -1"):
        EquilibriumSettings(force_tolerance=-1)
