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


def test_views_share_the_memory_of_the_flat_array_and_keep_it():
    random = np.random.default_rng(1)
    parts = [random.normal(size=shape) for shape in ((4, 3), (7, 3), (7, 2))]
    vector = MixedVector.from_numpy(*parts, wp.float64, CPU)
    vertices, nodes, sliding = vector.vertices, vector.nodes, vector.sliding
    expected = [part.numpy() for part in (vertices, nodes, sliding)]
    np.testing.assert_array_equal(vector.values.numpy(), np.concatenate([part.ravel() for part in expected]))
    nodes.zero_()
    assert not vector.numpy()[1].any()
    np.testing.assert_array_equal(vector.numpy()[0], expected[0])
    np.testing.assert_array_equal(vector.numpy()[2], expected[2])
    del vector
    np.testing.assert_array_equal(sliding.numpy(), expected[2])


def test_wrong_shapes_and_counts_are_refused():
    with pytest.raises(ParameterError, match=r"got shapes \(4, 3\), \(7, 3\), \(6, 2\)"):
        MixedVector.from_numpy(np.zeros((4, 3)), np.zeros((7, 3)), np.zeros((6, 2)), wp.float64, CPU)
    with pytest.raises(ParameterError, match="got -1 vertices and 2 nodes"):
        MixedVector.zeros(-1, 2, wp.float64, CPU)
    with pytest.raises(ParameterError, match=r"got \(1, 2\) vertices and nodes; expected \(2, 1\)"):
        MixedVector.zeros(2, 1, wp.float64, CPU).assign(MixedVector.zeros(1, 2, wp.float64, CPU))
