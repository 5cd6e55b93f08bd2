# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""No yarn passes through another, whatever pulls."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.distance import cdist
from stockinette import flat_patch

from stitchmesh.device import device_named
from stitchmesh.errors import SolverError
from stitchmesh.quality import PRESETS, Quality
from stitchmesh.yarn import YarnSet
from stitchmesh.yarnrelax import YarnMaterial, linking_certificate, relax_yarns
from stitchmesh.yarnrelax.iteration import Iteration
from stitchmesh.yarnrelax.model import neighbour_reach

DRAFT = PRESETS["draft"]


def hopf_link(shrink: float) -> YarnSet:
    """Two linked rings whose rest lengths pull them against each other."""
    angle = np.arange(24) / 24 * 2 * np.pi
    first = np.stack([np.cos(angle), np.sin(angle), 0 * angle], axis=1)
    second = np.stack([1 + np.cos(angle), 0 * angle, np.sin(angle)], axis=1)
    yarns = YarnSet.from_curves([first, second], closed=[True, True], radius=0.125)
    return replace(yarns, rest_length=shrink * yarns.rest_length)


def long_run(tolerance: float) -> Quality:
    return replace(DRAFT, tolerance=tolerance, max_iterations=2000)


def test_linked_rings_that_are_pulled_tight_stay_linked() -> None:
    yarns = hopf_link(0.5)
    result = relax_yarns(yarns, quality=long_run(0.01), device="cpu")
    assert linking_certificate(result.yarns)[0, 1] == linking_certificate(yarns)[0, 1] != 0
    assert result.report["certificate"] == "unchanged"
    assert 0.0 < result.report["min_distance_over_radius"] < 2.0


def test_without_any_contact_force_the_step_limit_alone_holds_them_apart() -> None:
    yarns = hopf_link(0.3)
    ghost = YarnMaterial(2000.0, 1000.0, 0.005, 0.0, 0.0, 0.0, 0.0, 0.006)
    last: list[YarnSet] = []
    with pytest.raises(SolverError, match=r"yarn \d \(control point \d+\): too close"):
        relax_yarns(yarns, material=ghost, quality=long_run(1e-6), device="cpu", on_state=last.append)
    assert linking_certificate(last[-1])[0, 1] == linking_certificate(yarns)[0, 1]


def test_clearances_are_below_the_true_distances_of_the_curves() -> None:
    patch = flat_patch(4, 3)
    noise = np.random.default_rng(4).normal(scale=0.01, size=patch.points.shape)
    radius = 0.22  # nearly twice as thick as the patch was made for: the rows overlap by almost half
    yarns = replace(patch, points=patch.points + noise, radius=np.full(4, radius))
    quality = replace(DRAFT, precision="float64", step_fraction=10.0)  # so large that every clearance is computed
    iteration = Iteration.start(yarns, YarnMaterial.named("kaldor-simulation"), quality, device_named("cpu"), None)
    iteration.look_around()
    clearance = iteration.state.segment_clearance.numpy()
    fine = np.concatenate([curve[:-1] for curve in yarns.sampled(24)])
    segment = np.repeat(np.arange(len(yarns.rest_length)), 24)
    distance = cdist(fine, fine)
    ahead = segment[None, :] - segment[:, None]
    same = yarns.segment_yarn[segment][:, None] == yarns.segment_yarn[segment][None, :]
    distance[same & (np.abs(ahead) <= neighbour_reach(yarns).max())] = np.inf
    arcs = np.arange(0, len(fine), 24)
    nearest = np.minimum.reduceat(np.minimum.reduceat(distance, arcs), arcs, axis=1)
    bound = np.minimum(clearance[:, None], clearance[None, :])
    assert (bound <= nearest + 1e-12).all()
    touching = nearest.min(axis=1) < 1.2 * radius
    assert touching.sum() > 10
    # where it matters the bound is a good one: sags of a few hundredths of a radius, and arcs cut at sample borders
    assert (clearance[touching] > nearest.min(axis=1)[touching] - 0.1 * radius).all()


def test_no_control_point_moves_more_than_its_part_of_the_radius() -> None:
    yarns = hopf_link(0.5)
    material = YarnMaterial.named("kaldor-simulation")
    iteration = Iteration.start(yarns, material, DRAFT, device_named("cpu"), None)
    for _ in range(10):
        before = iteration.state.points.numpy().copy()
        iteration.run(5)
        moved = np.linalg.norm(iteration.state.points.numpy() - before, axis=1)
        # five iterations, and float32 rounding of coordinates of one centimetre
        assert moved.max() <= 5 * DRAFT.step_fraction * 0.125 + 1e-6
    assert moved.max() > 0.0
