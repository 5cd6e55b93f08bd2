# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Static equilibria: closed forms, patch tests, large motions, friction-like updates."""

from __future__ import annotations

import numpy as np
import pytest

from stitchmesh.errors import ParameterError
from stitchmesh.mixed.dynamics.equilibrium import EquilibriumSettings, find_equilibrium
from stitchmesh.mixed.dynamics.mass_matrix import FabricPoints
from stitchmesh.mixed.enrichment.region import region_around
from stitchmesh.simulation.dead_load import Gravity
from tests.mixed.dynamics.scene import spring_scene
from tests.mixed.patch import square_patch

PATCH = square_patch(8, 4)
CHOSEN = PATCH.near((0.5, 0.5), 0.26)
TIGHT = EquilibriumSettings(force_tolerance=1e-7)


def test_a_hanging_patch_of_springs_without_rest_length_has_the_parabola_of_the_closed_form():
    """For the energy k/2 |grad x|^2 and the weight m g per area a strip that hangs has x'' = -m g / k."""
    region = region_around(*PATCH.layout, [])
    top = np.flatnonzero(PATCH.vertices[:, 1] > 0.999)
    scene = spring_scene(PATCH, region, rest=0.0, fixed_vertices=top)
    system = scene.system
    system.add(Gravity().on(FabricPoints(system.mass.lumped, 1.0, system.scalar, system.device)))
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
