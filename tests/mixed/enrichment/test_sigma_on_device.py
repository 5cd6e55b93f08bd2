# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Launches find Sigma and its inverse, for an odd and an even number of rows."""

from __future__ import annotations

from functools import partial

import numpy as np
import pytest
import warp as wp

from stitchmesh.compute.captured import CapturedLaunches
from stitchmesh.compute.device import device_named
from stitchmesh.compute.launch import prepare
from stitchmesh.mixed.enrichment.embedding import embed
from stitchmesh.mixed.enrichment.projection import Projection
from stitchmesh.mixed.enrichment.region import region_around
from stitchmesh.mixed.mixed_vector import MixedVector
from tests.mixed.patch import square_patch

CPU = device_named("cpu")
PATCH = square_patch(5, 3)
REGIONS = {
    "many": region_around(*PATCH.layout, PATCH.near((0.5, 0.5), 0.25)),
    "few": region_around(*PATCH.layout, [20]),
}


def projection_after(name: str, by_launches: bool) -> tuple[int, np.ndarray]:
    """Rows of Sigma, and a motion that is projected in a metric that varies over four decades."""
    embedding = embed(REGIONS[name])
    random = np.random.default_rng(3)
    counts = embedding.vertex_count, embedding.node_count
    metric = [np.exp(random.uniform(-4.6, 4.6, count)) for count in counts]
    projection = Projection(embedding, wp.float64, CPU)
    if by_launches:
        projection.vertex_inverse.assign(metric[0])
        projection.node_inverse.assign(metric[1])
        CapturedLaunches(projection.metric_launches(partial(prepare, device=CPU)), CPU).launch()
    else:
        projection.set_metric(*metric)
    parts = [random.normal(size=shape) for shape in ((counts[0], 3), (counts[1], 3), (counts[1], 2))]
    motion = MixedVector.from_numpy(*parts, wp.float64, CPU)
    CapturedLaunches(projection.launches(motion, partial(prepare, device=CPU)), CPU).launch()
    vertices, nodes, _ = motion.numpy()
    # rounding times the condition number of Sigma, about the ratio of the metric's numbers
    assert np.abs(embedding.constraint(vertices, nodes)).max() < 1e-11
    return projection.row_count, motion.values.numpy()


@pytest.mark.parametrize("name", REGIONS)
def test_projections_with_both_inverses_agree(name):
    rows, found = projection_after(name, by_launches=True)
    expected = projection_after(name, by_launches=False)[1]
    np.testing.assert_allclose(found, expected, rtol=0, atol=1e-11 * np.abs(expected).max())  # as above
    assert rows > 1


def test_both_parities_of_the_number_of_rows_are_there():
    assert {embed(region).independent.shape[1] % 2 for region in REGIONS.values()} == {0, 1}
