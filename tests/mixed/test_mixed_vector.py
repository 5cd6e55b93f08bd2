# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The parts of a vector of the mixed system are views of one flat array."""

from __future__ import annotations

import numpy as np
import pytest
import warp as wp

from stitchmesh.compute.device import device_named
from stitchmesh.errors import ParameterError
from stitchmesh.mixed.mixed_vector import MixedVector

CPU = device_named("cpu")


def parts(vertex_count: int, node_count: int) -> list[np.ndarray]:
    random = np.random.default_rng(1)
    return [random.normal(size=shape) for shape in ((vertex_count, 3), (node_count, 3), (node_count, 2))]


@pytest.mark.parametrize("counts", [(4, 7), (4, 0), (0, 7), (0, 0)])
@pytest.mark.parametrize("scalar", [wp.float32, wp.float64])
def test_numpy_arrays_go_to_the_device_and_back(counts, scalar):
    given = parts(*counts)
    vector = MixedVector.from_numpy(*given, scalar, CPU)
    assert (vector.vertex_count, vector.node_count) == counts
    for part, back in zip(given, vector.numpy(), strict=True):
        kind = np.float32 if scalar is wp.float32 else np.float64
        np.testing.assert_array_equal(part.astype(kind), back)  # conversion to the precision alone


def test_views_share_the_memory_of_the_flat_array_and_keep_it():
    vector = MixedVector.from_numpy(*parts(4, 7), wp.float64, CPU)
    vertices, nodes, sliding = vector.vertices, vector.nodes, vector.sliding
    expected = [part.numpy() for part in (vertices, nodes, sliding)]
    np.testing.assert_array_equal(vector.values.numpy(), np.concatenate([part.ravel() for part in expected]))
    nodes.zero_()
    assert not vector.numpy()[1].any()
    np.testing.assert_array_equal(vector.numpy()[0], expected[0])
    np.testing.assert_array_equal(vector.numpy()[2], expected[2])
    del vector
    np.testing.assert_array_equal(sliding.numpy(), expected[2])


def test_a_copy_has_its_own_numbers_and_assign_takes_those_of_another():
    vector = MixedVector.from_numpy(*parts(2, 3), wp.float32, CPU)
    copy, zeros = vector.copy(), vector.like()
    vector.values.zero_()
    assert copy.values.numpy().all()
    assert not zeros.values.numpy().any()
    zeros.assign(copy)
    np.testing.assert_array_equal(zeros.values.numpy(), copy.values.numpy())


def test_wrong_shapes_and_counts_are_refused():
    with pytest.raises(ParameterError, match=r"got shapes \(4, 3\), \(7, 3\), \(6, 2\)"):
        MixedVector.from_numpy(np.zeros((4, 3)), np.zeros((7, 3)), np.zeros((6, 2)), wp.float64, CPU)
    with pytest.raises(ParameterError, match="got -1 vertices and 2 nodes"):
        MixedVector.zeros(-1, 2, wp.float64, CPU)
    with pytest.raises(ParameterError, match=r"got \(1, 2\) vertices and nodes; expected \(2, 1\)"):
        MixedVector.zeros(2, 1, wp.float64, CPU).assign(MixedVector.zeros(1, 2, wp.float64, CPU))
