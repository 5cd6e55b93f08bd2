# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The lists of the grid hold exactly the pairs that a comparison of all samples finds."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.distance import cdist
from stockinette import flat_patch, tube

from stitchmesh.device import device_named
from stitchmesh.yarn import YarnSet
from stitchmesh.yarnrelax import YarnMaterial, forces
from stitchmesh.yarnrelax.candidates import FIRST_CAPACITY, find_candidates, make_candidates
from stitchmesh.yarnrelax.model import neighbour_reach, put_model
from stitchmesh.yarnrelax.precision import scalar_named
from stitchmesh.yarnrelax.state import make_state

MARGIN = 0.05


def lists_and_samples(yarns: YarnSet, samples: int) -> tuple[list[list[int]], np.ndarray]:
    model = put_model(
        yarns,
        YarnMaterial.named("leaf"),
        quadrature_points=3,
        contact_samples=samples,
        scalar=scalar_named("float64"),
        device=device_named("cpu"),
    )
    state, candidates = make_state(model), make_candidates(model, MARGIN)
    forces.sample(model, state, model.launch)
    find_candidates(model, state.samples, candidates)
    count, lists = candidates.count.numpy(), candidates.lists.numpy()
    return [lists[p, : count[p]].tolist() for p in range(model.sample_count)], state.samples.numpy()


def all_pairs(yarns: YarnSet, samples: np.ndarray, per_segment: int) -> list[list[int]]:
    """The rule word for word, pair by pair."""
    segment = np.repeat(np.arange(len(yarns.rest_length)), per_segment)
    yarn, radius = yarns.segment_yarn[segment], yarns.radius[yarns.segment_yarn[segment]]
    near = cdist(samples, samples) < radius[:, None] + radius[None, :] + MARGIN
    ahead = segment[None, :] - segment[:, None]
    cycle = np.where(yarns.closed, np.diff(yarns.segment_start), 1 << 30)[yarn]
    exempt = neighbour_reach(yarns)[segment]
    forward = np.where(ahead < 0, ahead + cycle[:, None], ahead)
    neighbours = (forward <= exempt[:, None]) | (cycle[:, None] - forward <= exempt[None, :])
    near &= (yarn[:, None] != yarn[None, :]) | ~neighbours
    return [np.flatnonzero(row).tolist() for row in near]


@pytest.mark.parametrize("yarns", [tube(3, 4), flat_patch(3, 3)], ids=["closed", "open"])
def test_lists_equal_all_pairs(yarns: YarnSet) -> None:
    lists, samples = lists_and_samples(yarns, 3)
    assert lists == all_pairs(yarns, samples, 3)
    assert sum(map(len, lists)) > 0


def test_different_radii_and_scattered_yarns() -> None:
    random = np.random.default_rng(2)
    curves = [random.normal(scale=0.5, size=(9, 3)) for _ in range(5)]
    yarns = YarnSet.from_curves(curves, closed=[True, False] * 2 + [True], radius=[0.05, 0.1, 0.15, 0.2, 0.1])
    lists, samples = lists_and_samples(yarns, 4)
    assert lists == all_pairs(yarns, samples, 4)


def test_lists_that_do_not_fit_grow() -> None:
    yarns = tube(3, 4)
    thick = replace(yarns, radius=4 * yarns.radius)
    lists, samples = lists_and_samples(thick, 5)
    assert max(map(len, lists)) > FIRST_CAPACITY
    assert lists == all_pairs(thick, samples, 5)


def test_segments_as_long_as_the_yarn_is_thick_skip_only_their_neighbours() -> None:
    yarns = tube(2, 3)  # segments of 2.6 radii
    assert (neighbour_reach(yarns) == 1).all()
    fine = replace(yarns, radius=4 * yarns.radius)  # segments of 0.65 radii: 2 / 0.65 = 3.1 of them make a diameter
    assert set(neighbour_reach(fine)) <= {3, 4}
