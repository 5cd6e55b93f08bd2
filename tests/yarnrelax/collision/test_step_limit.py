# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The step limit prevents yarns from passing through each other under any force."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.distance import cdist

from stitchmesh.compute.device import device_named
from stitchmesh.errors import SolverError
from stitchmesh.linking.certificate import linking_certificate
from stitchmesh.quality import PRESETS, Quality, Solver
from stitchmesh.run import Run
from stitchmesh.yarn import YarnSet
from stitchmesh.yarnrelax import YarnMaterial, relax_yarns
from stitchmesh.yarnrelax.model.upload import neighbour_reach
from stitchmesh.yarnrelax.simulation import YarnSimulation
from tests.yarnrelax.stockinette import flat_patch, hopf_link

pytestmark = pytest.mark.decides

DRAFT = PRESETS["draft"]


def many_iterations(tolerance: float) -> Quality:
    return replace(DRAFT, tolerance=tolerance, max_iterations=2000)


def test_linked_rings_that_are_pulled_tight_stay_linked() -> None:
    yarns = hopf_link(0.5, 0.3)
    result = relax_yarns(yarns, quality=many_iterations(0.01), device="cpu")
    assert linking_certificate(result.yarns)[0, 1] == linking_certificate(yarns)[0, 1] != 0
    assert result.report["certificate"] == "unchanged"
    assert result.report["converged"]
    # the hole in a ring of radius 0.5 is too small for the other ring
    assert 1.0 < result.report["min_distance_over_radius"] < 2.0
    assert result.report["energies"]["contact"] > 0.0


def test_the_step_limit_alone_separates_yarns_without_contact_energy() -> None:
    yarns = hopf_link(0.3)
    without_contact = YarnMaterial(2000.0, 1000.0, 0.005, 0.0, 0.0, 0.0, 0.0, 0.006)
    last: list[YarnSet] = []
    with pytest.raises(SolverError, match=r"yarn \d \(control point \d+\): too close"):
        relax_yarns(yarns, material=without_contact, quality=many_iterations(1e-6), device="cpu",
                    run=Run(on_state=last.append))  # fmt: skip
    assert linking_certificate(last[-1])[0, 1] == linking_certificate(yarns)[0, 1]


def test_clearances_are_lower_bounds_of_the_distances_of_the_curves() -> None:
    patch = flat_patch(4, 3)
    noise = np.random.default_rng(4).normal(scale=0.01, size=patch.points.shape)
    radius = 0.22  # nearly twice the radius that the patch is made for: the rows overlap by almost half
    yarns = replace(patch, points=patch.points + noise, radius=np.full(4, radius))
    quality = replace(DRAFT, precision="float64")
    simulation = YarnSimulation.start(yarns, YarnMaterial.named("kaldor-simulation"), quality, device_named("cpu"))
    simulation.search_contacts(2.0)  # wide enough that every clearance up to two radii is computed
    clearance = simulation.search.clearance.numpy() * simulation.model.unit
    assert (np.diff(simulation.model.sample_start) == 3).all()
    # eight points on each of the three arcs of a segment, from one end of the arc to the other
    fine = np.concatenate([curve[:-1] for curve in yarns.sampled(24)])
    segment = np.repeat(np.arange(len(yarns.rest_length)), 24)
    distance = cdist(fine, fine)
    ahead = segment[None, :] - segment[:, None]
    same = yarns.segment_yarn[segment][:, None] == yarns.segment_yarn[segment][None, :]
    distance[same & (np.abs(ahead) <= neighbour_reach(yarns).max())] = np.inf
    arcs = np.arange(0, len(fine), 8)
    nearest = np.minimum.reduceat(np.minimum.reduceat(distance, arcs), arcs, axis=1)
    bound = np.minimum(clearance[:, None], clearance[None, :])
    assert (bound <= nearest + 1e-12).all()
    touching = nearest.min(axis=1) < 1.2 * radius
    assert touching.sum() > 10
    # For touching arcs, the bound is close: the arcs differ from their chords by a few hundredths of a radius.
    assert (clearance[touching] > nearest.min(axis=1)[touching] - 0.1 * radius).all()


@pytest.mark.parametrize(("solver", "forces"), [("quasistatic", "random"), ("dynamics", "of tight rings")])
def test_no_control_point_moves_beyond_its_budget_on_one_list(solver: Solver, forces: str) -> None:
    quality = replace(DRAFT, solver=solver, step_fraction=10.0)  # only the budget limits a step
    simulation = YarnSimulation.start(hopf_link(0.3), YarnMaterial.named("leaf"), quality, device_named("cpu"))
    state = simulation.state
    listed, budget = state.listed_points.numpy().copy(), state.budget.numpy().copy()
    simulation.solver.begin(np.array([200]))
    travelled = np.zeros(len(budget))
    for turn in range(200):
        for launch in simulation.iterations.launches:  # without the loop, which would make new lists
            launch.launch()
            if forces == "random" and launch.kernel.key == "gather_forces":
                wild = np.random.default_rng(turn).normal(scale=1e6, size=listed.shape)
                state.force.assign(wild.astype(np.float32))
        travelled = np.maximum(travelled, np.linalg.norm(state.points.numpy().astype(np.float64) - listed, axis=1))
    # float32 rounding of coordinates of twelve units in each move; few moves reach the limit
    assert (travelled <= budget + 1e-5).all()
    assert (travelled > 0.5 * budget).any()
    assert np.array_equal(state.listed_points.numpy(), listed) and np.array_equal(state.budget.numpy(), budget)
