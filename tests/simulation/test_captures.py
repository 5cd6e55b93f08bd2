# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""A simulation that nothing refers to is freed at once, with its captured launches and its arrays on the device."""

from __future__ import annotations

import gc
import weakref
from collections.abc import Callable
from typing import Any

import pytest

from stitchmesh.compute.device import device_named
from stitchmesh.mixed.enrichment.region import region_around
from stitchmesh.quality import PRESETS
from stitchmesh.yarnrelax import YarnMaterial
from stitchmesh.yarnrelax.simulation import YarnSimulation
from tests.mixed.dynamics.scene import spring_scene
from tests.mixed.patch import square_patch
from tests.yarnrelax.stockinette import tube


def used_yarns() -> Any:
    simulation = YarnSimulation.start(tube(8, 3), YarnMaterial.named("leaf"), PRESETS["draft"], device_named("cpu"))
    simulation.iterate()
    simulation.assess_cells()
    return simulation


def used_system() -> Any:
    patch = square_patch(4, 3)
    scene = spring_scene(patch, region_around(*patch.layout, patch.near((0.5, 0.5), 0.2)))
    state = scene.at_rest()
    scene.system.set_forces(state, scene.system.zeros())
    scene.system.set_factors(1.0, 1.0, state, stiffness_in_metric=True)
    assert scene.system.solver is not None
    return scene.system


@pytest.mark.parametrize("used", [used_yarns, used_system])
def test_a_simulation_is_freed_without_the_collector_of_cycles(used: Callable[[], Any]) -> None:
    gc.collect()
    gc.disable()
    try:
        of_simulation = weakref.ref(used())
        assert of_simulation() is None
    finally:
        gc.enable()
