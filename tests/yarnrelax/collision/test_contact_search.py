# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The candidate lists of the contact search hold exactly the pairs that a comparison of all samples finds."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.distance import cdist

from stitchmesh.simulation.pair_lists import FIRST_CAPACITY
from stitchmesh.yarn import YarnSet
from stitchmesh.yarnrelax.collision.captured_search import ContactSearch
from stitchmesh.yarnrelax.collision.narrow_phase import (
    NARROWEST_MARGIN,
    WIDEST_MARGIN,
    Candidates,
    make_candidates,
)
from stitchmesh.yarnrelax.model.constants import Model
from stitchmesh.yarnrelax.model.state import make_state
from stitchmesh.yarnrelax.model.upload import neighbour_reach
from tests.yarnrelax.one_term import on_device
from tests.yarnrelax.stockinette import tube

pytestmark = pytest.mark.decides

MARGIN = 0.4
"""In mean yarn radii."""


def lists_and_samples(yarns: YarnSet, samples: int) -> tuple[list[list[int]], np.ndarray, Model]:
    model = on_device(yarns, contact_samples=samples)
    state, candidates = make_state(model), make_candidates(model, MARGIN)
    ContactSearch(model, state, candidates).run()
    return lists_of(candidates), state.samples.numpy(), model


def lists_of(candidates: Candidates) -> list[list[int]]:
    count, lists = candidates.count.numpy(), candidates.lists.numpy()
    return [sorted(lists[p, : count[p]].tolist()) for p in range(len(count))]


def all_pairs(samples: np.ndarray, model: Model, margin: float = MARGIN) -> list[list[int]]:
    """The definition of the lists, applied to every pair of samples."""
    yarns = model.yarns
    segment = np.repeat(np.arange(len(yarns.rest_length)), np.diff(model.sample_start))
    yarn, radius = yarns.segment_yarn[segment], model.radius[yarns.segment_yarn[segment]]
    np.testing.assert_array_equal(samples[:, 3], radius)
    near = cdist(samples[:, :3], samples[:, :3]) < radius[:, None] + radius[None, :] + margin
    ahead = segment[None, :] - segment[:, None]
    cycle = np.where(yarns.closed, np.diff(yarns.segment_start), 1 << 30)[yarn]
    exempt = neighbour_reach(yarns)[segment]
    forward = np.where(ahead < 0, ahead + cycle[:, None], ahead)
    neighbours = (forward <= exempt[:, None]) | (cycle[:, None] - forward <= exempt[None, :])
    near &= (yarn[:, None] != yarn[None, :]) | ~neighbours
    return [np.flatnonzero(row).tolist() for row in near]


def test_lists_of_knitted_yarns_equal_all_pairs() -> None:
    lists, samples, model = lists_and_samples(tube(3, 4), 3)
    assert lists == all_pairs(samples, model)
    assert sum(map(len, lists)) > 0


def test_lists_of_random_yarns_with_different_radii_equal_all_pairs() -> None:
    random = np.random.default_rng(2)
    curves = [random.normal(scale=0.5, size=(9, 3)) for _ in range(5)]
    yarns = YarnSet.from_curves(curves, closed=[True, False] * 2 + [True], radius=[0.05, 0.1, 0.15, 0.2, 0.1])
    lists, samples, model = lists_and_samples(yarns, 4)
    assert lists == all_pairs(samples, model)


def test_margins_that_change_to_and_fro_between_searches_leave_no_pair_out() -> None:
    yarns = tube(3, 4)
    model = on_device(yarns)
    state, candidates = make_state(model), make_candidates(model, NARROWEST_MARGIN)
    search, start, random = ContactSearch(model, state, candidates), state.points.numpy(), np.random.default_rng(4)
    for margin in 2 * (NARROWEST_MARGIN, WIDEST_MARGIN, MARGIN):
        # moves that the near lists of the search before hardly allow
        state.points.assign(start + random.normal(scale=0.2, size=start.shape))
        candidates.set_margins(margin)
        search.run()
        assert lists_of(candidates) == all_pairs(state.samples.numpy(), model, margin)


def test_lists_grow_beyond_their_first_capacity() -> None:
    yarns = tube(3, 4)
    thick = replace(yarns, radius=4 * yarns.radius)
    lists, samples, model = lists_and_samples(thick, 5)
    assert max(map(len, lists)) > FIRST_CAPACITY
    assert lists == all_pairs(samples, model)


def test_long_segments_get_enough_samples_to_leave_no_gap() -> None:
    line = np.cumsum([0.0, 0.3, 0.3, 0.3, 2.0, 2.0, 0.3, 0.3, 0.3])
    yarns = YarnSet.from_curves([line[:, None] * [1.0, 0.0, 0.0]], closed=[False], radius=0.2)
    _, samples, model = lists_and_samples(yarns, 2)
    counts = np.diff(model.sample_start)
    assert counts.min() == 2
    # a segment of ten radii needs 10 / (2 * 0.85) = 5.9 samples, so that no point is farther than 0.85 radii from one
    assert counts.max() == 6
    assert np.diff(samples[:, 0]).max() < 2.0
    assert len(samples) == model.sample_count == counts.sum()


def test_long_segments_exclude_only_their_neighbours_from_self_contact() -> None:
    yarns = tube(2, 3)  # segments of 2.6 radii
    assert (neighbour_reach(yarns) == 1).all()
    fine = replace(yarns, radius=4 * yarns.radius)  # segments of 0.65 radii: a diameter is 2 / 0.65 = 3.1 segments
    assert set(neighbour_reach(fine)) <= {3, 4}
