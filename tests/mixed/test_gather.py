# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Slots of elements are added up at their vertices, in the order of the slots."""

from __future__ import annotations

from functools import partial

import numpy as np
import pytest
import warp as wp

from stitchmesh.compute.device import device_named
from stitchmesh.compute.launch import launch, prepare
from stitchmesh.errors import ParameterError
from stitchmesh.mixed.gather import GatherTable

CPU = device_named("cpu")


def test_the_sums_are_those_of_a_loop_over_elements():
    random = np.random.default_rng(2)
    index = random.integers(-1, 6, size=(40, 3))
    values, before = random.normal(size=(120, 3)), random.normal(size=(6, 3))
    expected = before.copy()
    flat = index.ravel()
    np.add.at(expected, flat[flat >= 0], values[flat >= 0])
    target = wp.array(before, dtype=wp.vec3d, device=CPU)
    table = GatherTable.of(index, 6, CPU)
    prepared = table.launches(wp.array(values, dtype=wp.vec3d, device=CPU), target, partial(prepare, device=CPU))
    for each in prepared:
        each.launch()
    # sums of some 20 numbers of size 1 in another order: a few units in the last place
    np.testing.assert_allclose(target.numpy(), expected, rtol=0, atol=1e-14)


def test_wrong_indices_and_lengths_are_refused():
    with pytest.raises(ParameterError, match="slot 1 has the target 4; expected -1 to 3"):
        GatherTable.of([0, 4], 4, CPU)
    table = GatherTable.of([0, 1], 4, CPU)
    zeros = wp.zeros(2, dtype=wp.vec3f, device=CPU)
    with pytest.raises(ParameterError, match="got 2 slots and 2 targets; expected 2 and 4"):
        table.launches(zeros, zeros, partial(launch, device=CPU))
