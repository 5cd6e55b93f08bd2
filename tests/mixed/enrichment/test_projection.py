# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The projection, with nodes of unit mass and vertices at rest: it removes what the triangles represent.

This is the kinematic filter F = I - B (B'B)^-1 B' of Casafranca et al. 2020, equation 3.
"""

from __future__ import annotations

from functools import partial
from typing import Any

import numpy as np
import pytest
import warp as wp

from stitchmesh.compute.captured import CapturedLaunches
from stitchmesh.compute.device import device_named
from stitchmesh.compute.launch import launch, prepare
from stitchmesh.mixed.enrichment.projection import Projection
from stitchmesh.mixed.enrichment.region import Embedding, basis_of, embed, independent_columns, region_around
from stitchmesh.mixed.mixed_vector import MixedBlocks, MixedVector
from tests.mixed.patch import enriched_everywhere, square_patch

CPU = device_named("cpu")
RUN = partial(launch, device=CPU)
PATCH = square_patch(6, 4)
REGIONS = {
    "two rings": region_around(*PATCH.layout, PATCH.near((0.5, 0.5), 0.2), rings=2),
    "everywhere": enriched_everywhere(*PATCH.layout),
}


def unit_projection(embedding: Embedding, scalar: Any) -> Projection:
    numbers = np.zeros(embedding.vertex_count), np.ones(embedding.node_count)
    metric = MixedBlocks.of_numbers(*numbers, scalar, CPU)
    projection = Projection(embedding, metric, element=wp.float64, device=CPU)
    projection.invert(*numbers)
    return projection


def filtered(embedding: Embedding, displacement: np.ndarray, scalar=wp.float64) -> np.ndarray:
    zeros = np.zeros((embedding.vertex_count, 3))
    vector = MixedVector.from_numpy(zeros, displacement, displacement[:, :2], scalar, CPU)
    unit_projection(embedding, scalar).launches(vector, RUN)
    vertices, nodes, sliding = vector.numpy()
    assert not vertices.any()
    np.testing.assert_array_equal(sliding, displacement[:, :2].astype(np.float32 if scalar is wp.float32 else float))
    return nodes


def sparse_embedding(corners: list[list[int]], weight: list[list[float]], vertex_count: int) -> Embedding:
    basis = basis_of(np.array(corners), np.array(weight), vertex_count)
    count = len(corners)
    return Embedding(vertex_count, count, np.arange(count), basis, independent_columns(basis))


@pytest.mark.parametrize(("name", "scalar"), [("two rings", wp.float64), ("everywhere", wp.float32)])
def test_filtered_displacements_are_orthogonal_to_the_triangles_and_stay_when_filtered_again(name, scalar):
    embedding = embed(REGIONS[name])
    displacement = np.random.default_rng(3).normal(size=(embedding.node_count, 3))
    once = filtered(embedding, displacement, scalar)
    rounding = 2e-6 if scalar is wp.float32 else 1e-13  # sums of some 100 numbers of size 1
    hybrid = embedding.nodes
    assert np.abs(embedding.basis.T @ once[hybrid]).max() < rounding * 10
    np.testing.assert_allclose(filtered(embedding, once, scalar), once, atol=rounding)
    assert np.linalg.norm(once) <= np.linalg.norm(displacement)
    free = np.setdiff1d(np.arange(embedding.node_count), hybrid)
    np.testing.assert_allclose(once[free], displacement[free], atol=rounding)


SINGULAR = {
    "a triangle with a single node": sparse_embedding([[0, 1, 2]], [[0.2, 0.3, 0.5]], 3),
    "a vertex without nodes": sparse_embedding(
        [[0, 1, 2]] * 4, [[1, 0, 0], [0, 1, 0], [0.5, 0.5, 0], [0.3, 0.7, 0]], 5
    ),
    "nodes of one triangle on a line": sparse_embedding(
        [[0, 1, 2]] * 4, [[0.8, 0.1, 0.1], [0.6, 0.2, 0.2], [0.4, 0.3, 0.3], [0.2, 0.4, 0.4]], 3
    ),
    "two nodes at one place": sparse_embedding([[0, 1, 2]] * 2, [[0.2, 0.3, 0.5]] * 2, 3),
    "a node at the far end of a triangle": sparse_embedding(
        [[0, 1, 2]] * 3, [[1e-6, 0.5, 0.499999], [0, 0.3, 0.7], [0, 0.6, 0.4]], 3
    ),
}


@pytest.mark.parametrize("name", SINGULAR)
def test_a_singular_matrix_of_few_nodes_is_handled(name):
    embedding = SINGULAR[name]
    dense = embedding.basis.toarray()
    assert len(embedding.columns) == np.linalg.matrix_rank(dense)
    displacement = np.random.default_rng(5).normal(size=(embedding.node_count, 3))
    once = filtered(embedding, displacement)
    assert np.abs(dense.T @ once).max() < 1e-13  # rounding of numbers of size 1
    np.testing.assert_allclose(filtered(embedding, once), once, atol=1e-13)
    expected = displacement - dense @ (np.linalg.pinv(dense) @ displacement)
    np.testing.assert_allclose(once, expected, atol=1e-9)  # 1e-6 is the smallest part of a column, twice in its square


def test_without_hybrid_nodes_there_is_nothing_to_launch():
    for chosen in ([], np.arange(len(PATCH.triangles))):
        embedding = embed(region_around(*PATCH.layout, chosen))
        zeros = MixedVector.zeros(embedding.vertex_count, embedding.node_count, wp.float64, CPU)
        assert unit_projection(embedding, wp.float64).launches(zeros, RUN) == []


SMALL = square_patch(5, 3)
SIZES = {
    "even": region_around(*SMALL.layout, SMALL.near((0.5, 0.5), 0.25)),
    "odd": region_around(*SMALL.layout, [20]),
}
"""Regions with even and odd numbers of rows of Sigma."""


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
    embedding = embed(SIZES[name])
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


@pytest.mark.parametrize(("name", "element"), [("even", wp.float64), ("even", wp.mat33d), ("odd", wp.mat33d)])
def test_projections_with_both_inverses_agree(name, element):
    rows, found = projection_after(name, element, by_launches=True)
    expected = projection_after(name, element, by_launches=False)[1]
    np.testing.assert_allclose(found, expected, rtol=0, atol=1e-11 * np.abs(expected).max())  # as above
    assert rows % 2 == (name == "odd") and rows > 1
