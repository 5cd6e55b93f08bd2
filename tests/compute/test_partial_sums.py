# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Sums by parts: those of NumPy for every length, in few parts, and always the same bits."""

from __future__ import annotations

from functools import partial

import numpy as np
import pytest
import warp as wp

from stitchmesh.compute.device import device_named
from stitchmesh.compute.launch import launch
from stitchmesh.compute.partial_sums import MOST_PARTS, chunk_of, part_count
from stitchmesh.mixed.dynamics.vector_sums import ReadSums

CPU = device_named("cpu")


def read(*arrays: wp.array) -> np.ndarray:
    """Sum, dot product with itself and minimum of each array."""
    sums = ReadSums(CPU)
    for array in arrays:
        sums.add_sum(array)
        sums.add_dot(array, array)
        sums.add_minimum(array)
    sums.launches(partial(launch, device=CPU))
    return sums.read().reshape(-1, 3)


@pytest.mark.parametrize("kind", [np.float32, np.float64])
def test_sums_dot_products_and_minima_are_those_of_numpy(kind):
    random = np.random.default_rng(2)
    values = [random.normal(size=count).astype(kind) for count in (1, 255, 4096, 4097, 50_001)]
    found = read(*(wp.array(each, device=CPU) for each in values))
    wide = [each.astype(np.float64) for each in values]
    # Rounding of sums of 5e4 numbers of size 1 in double precision.
    np.testing.assert_allclose(found[:, 0], [each.sum() for each in wide], rtol=0, atol=1e-10)
    np.testing.assert_allclose(found[:, 1], [each @ each for each in wide], rtol=1e-12)
    assert found[:, 2].tolist() == [each.min() for each in wide]
    assert read(*(wp.array(each, device=CPU) for each in values)).tolist() == found.tolist()


def test_no_values_have_the_sum_zero_and_no_minimum():
    (found,) = read(wp.zeros(0, dtype=wp.float64, device=CPU))
    assert found.tolist() == [0.0, 0.0, 1e300]


@pytest.mark.parametrize("count", [0, 1, 10**6, 10**9])
def test_the_parts_are_few_and_cover_all_elements(count):
    assert part_count(count, CPU) <= MOST_PARTS
    assert chunk_of(count, CPU) * part_count(count, CPU) >= count
