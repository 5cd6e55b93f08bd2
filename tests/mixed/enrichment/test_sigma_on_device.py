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
from stitchmesh.mixed.mixed_vector import MixedBlocks, MixedVector
from tests.mixed.patch import square_patch

CPU = device_named("cpu")
PATCH = square_patch(5, 3)
REGIONS = {
    "many": region_around(*PATCH.layout, PATCH.near((0.5, 0.5), 0.25)),
    "few": region_around(*PATCH.layout, [20]),
}


def inverse_blocks(counts: tuple[int, int], element: type) -> MixedBlocks:
    """D^-1 that varies over four decades, with condition numbers of some tens where Sigma has blocks."""
    random = np.random.default_rng(3)
    inverse = MixedBlocks.of_numbers(*(np.exp(random.uniform(-4.6, 4.6, count)) for count in counts), wp.float64, CPU)
    if element is wp.mat33d:
        for array in (inverse.vertices, inverse.nodes):
            root = random.normal(size=(len(array), 3, 3))
            array.assign(array.numpy()[:, :1, :1] * (root @ root.swapaxes(1, 2) + 0.3 * np.eye(3)))
    return inverse


def projection_after(name: str, element: type, by_launches: bool) -> tuple[int, np.ndarray]:
    """Rows of Sigma, and a motion that is projected."""
    embedding = embed(REGIONS[name])
    counts = embedding.vertex_count, embedding.node_count
    projection = Projection(embedding, inverse_blocks(counts, element), element=element, device=CPU)
    if by_launches:
        CapturedLaunches(projection.inverse_launches(partial(prepare, device=CPU)), CPU).launch()
    else:
        projection.invert_present()
    random = np.random.default_rng(5)
    parts = [random.normal(size=shape) for shape in ((counts[0], 3), (counts[1], 3), (counts[1], 2))]
    motion = MixedVector.from_numpy(*parts, wp.float64, CPU)
    CapturedLaunches(projection.launches(motion, partial(prepare, device=CPU)), CPU).launch()
    vertices, nodes, _ = motion.numpy()
    # rounding times the condition number of Sigma, about the ratio of the metric's numbers
    assert np.abs(embedding.constraint(vertices, nodes)).max() < 1e-11
    return projection.row_count, motion.values.numpy()


@pytest.mark.parametrize("name", REGIONS)
@pytest.mark.parametrize("element", [wp.float64, wp.mat33d])
def test_projections_with_both_inverses_agree(name, element):
    rows, found = projection_after(name, element, by_launches=True)
    expected = projection_after(name, element, by_launches=False)[1]
    np.testing.assert_allclose(found, expected, rtol=0, atol=1e-11 * np.abs(expected).max())  # as above
    assert rows > 1


def test_both_parities_of_the_number_of_rows_are_there():
    assert {embed(region).independent.shape[1] % 2 for region in REGIONS.values()} == {0, 1}
