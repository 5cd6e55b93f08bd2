# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""How far the guard lets straight yarns travel: none of them passes through another one, and turning is no approach."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from stitchmesh.compute.device import device_named
from stitchmesh.mesh import FloatArray
from stitchmesh.quality import PRESETS
from stitchmesh.yarn import YarnSet
from stitchmesh.yarnrelax import YarnMaterial
from stitchmesh.yarnrelax.motion.travel_guard import PART, PASSED, TravelGuard
from stitchmesh.yarnrelax.simulation import YarnSimulation

RADIUS = 0.1
EXACT = replace(PRESETS["draft"], precision="float64")


def crossing_yarns(height: float) -> YarnSet:
    """A straight yarn along x, and one along y at a height above it."""
    along = np.linspace(-1.0, 1.0, 41)
    flat = np.zeros_like(along)
    curves = [np.stack([along, flat, flat], axis=1), np.stack([flat, along, flat + height], axis=1)]
    return YarnSet.from_curves(curves, closed=[False, False], radius=RADIUS)


def travelled(yarns: YarnSet, ways: FloatArray, travels: int = 1) -> tuple[float, FloatArray]:
    """Travel along ways [cm]; return the part that is passed, and the places."""
    material = YarnMaterial.named().of_radius(RADIUS)
    simulation = YarnSimulation.start(yarns, material, EXACT, device_named("cpu"))
    model, state = simulation.model, simulation.state
    guard = TravelGuard(model, state, simulation.candidates)
    target = model.upload(model.to_device(yarns.points + ways), 3)
    guard.way.assign(target.numpy() - state.points.numpy())
    for _ in range(travels):
        for launch in guard.launches(target):
            launch.launch()
        simulation.search.run()
    return float(guard.progress.numpy()[PASSED]), model.from_device(state.points)


@pytest.mark.parametrize("height", [0.19, 1.0])
def test_a_yarn_stops_before_the_one_that_it_would_pass_through(height: float) -> None:
    """At the smaller height the two are on the lists, at the larger one the runs find them."""
    yarns = crossing_yarns(height)
    ways = np.zeros_like(yarns.points)
    ways[yarns.start[1] :, 2] = -2.0 * height
    passed, places = travelled(yarns, ways)
    # the clearance of straight yarns is their distance, less the reaches of two arcs if they are not on the lists
    reach = 2.0 * (0.05 / 3 / 2)
    clearance = height if height < 0.3 else height - reach
    # the nearest samples are not one above the other, but up to half an arc beside that
    assert passed == pytest.approx(float(PART) * clearance / (2.0 * height), rel=2e-4)
    passed, places = travelled(yarns, ways, travels=60)
    assert passed < 0.5
    assert places[yarns.start[1] :, 2].min() > 0.0


def test_yarns_that_turn_together_and_yarns_that_move_apart_are_not_stopped() -> None:
    yarns = crossing_yarns(0.19)
    angle = 0.5
    turn = np.array([[np.cos(angle), -np.sin(angle), 0], [np.sin(angle), np.cos(angle), 0], [0, 0, 1]])
    assert travelled(yarns, yarns.points @ turn.T - yarns.points)[0] == 1.0
    apart = np.zeros_like(yarns.points)
    apart[yarns.start[1] :, 2] = 3.0
    assert travelled(yarns, apart)[0] == 1.0
