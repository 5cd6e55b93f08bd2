# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Steps end before nodes merge along a yarn."""

from __future__ import annotations

import numpy as np
import pytest
import warp as wp

from stitchmesh.mixed.crossings.crossing_term import CrossingTerm
from tests.mixed.crossings.small_fabrics import CPU, plain_weave, vector_of

FABRIC = plain_weave(4, 3)
TERM = CrossingTerm(FABRIC.elements(), wp.float64, CPU)


def limit_of(sliding, change, term=TERM):
    return term.step_limit(vector_of(FABRIC.position, sliding), vector_of(0 * FABRIC.position, change))


def shortest_part(sliding, change, step):
    """Smallest part of its rest length that a segment keeps."""
    parts = []
    links = FABRIC.yarns.links
    for i, c in np.argwhere(links[:, ::2] >= 0):
        j, d = divmod(links[i, 2 * c], 2)
        rest = sliding[j, d] - sliding[i, c]
        parts.append((rest + step * (change[j, d] - change[i, c])) / rest)
    return min(parts)


def test_the_segment_that_loses_most_keeps_half_of_its_rest_length():
    change = np.random.default_rng(0).normal(size=FABRIC.sliding.shape)
    step = limit_of(FABRIC.sliding, change)
    assert 0 < step < 1
    assert shortest_part(FABRIC.sliding, change, step) == pytest.approx(0.5, rel=1e-12)


def test_short_steps_and_common_sliding_are_not_limited():
    assert limit_of(FABRIC.sliding, 1e-3 * np.random.default_rng(0).normal(size=FABRIC.sliding.shape)) == 1.0
    assert limit_of(FABRIC.sliding, np.full_like(FABRIC.sliding, 100.0)) == 1.0


def test_fixed_coordinates_do_not_limit():
    fixed = CrossingTerm(FABRIC.elements(slides=np.zeros(12)), wp.float64, CPU)
    assert limit_of(FABRIC.sliding, np.random.default_rng(0).normal(size=FABRIC.sliding.shape), fixed) == 1.0


def test_repeated_steps_never_merge_nodes():
    sliding = FABRIC.sliding.copy()
    change = np.zeros_like(sliding)
    change[5, 0] = -1.0
    for _ in range(200):
        sliding += limit_of(sliding, change) * change
    # from half to half down to the merging distance, then by half of it at most
    assert np.isfinite(sliding).all() and sliding[5, 0] > sliding[4, 0] - 200 * 0.02
