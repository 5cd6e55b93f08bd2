# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Sums, minima and maxima on the device equal those of NumPy for every length. Repeated sums have the same bits."""

from __future__ import annotations

import math
from itertools import pairwise

import numpy as np
import pytest
import warp as wp

from stitchmesh.compute.reduction import (
    FEWEST_STRANDS,
    MOST_STRANDS,
    TILE,
    VALUES_PER_STRAND,
    Sums,
    maximum,
    minima_over,
    minimum,
    ordered_sum,
    strands_for,
)

LENGTHS = [1, 256, 257, 300_001]


def array(values: np.ndarray) -> wp.array:
    return wp.array(values, device="cpu")


def launch(kernel: wp.Kernel, count: int, inputs: list, outputs: list) -> None:
    wp.launch(kernel, count, inputs, outputs, device="cpu")


def ranges(*start: int) -> wp.array:
    return wp.array(np.array(start, dtype=np.int32), device="cpu")


def random(count: int, kind: type = np.float64) -> np.ndarray:
    return np.random.default_rng(count).normal(size=count).astype(kind)


@pytest.mark.parametrize("count", LENGTHS)
@pytest.mark.parametrize("kind", [np.float32, np.float64])
def test_sums_and_extremes_equal_those_of_the_host(count: int, kind: type) -> None:
    values = random(count, kind)
    # Sums are taken in float64. The bound allows the rounding of a thousand summands; a strand has fewer summands
    # than that, and so has the sum over strands.
    bound = 1e3 * np.finfo(np.float64).eps * np.abs(values).astype(np.float64).sum()
    assert ordered_sum(array(values)) == pytest.approx(math.fsum(values), abs=bound)
    assert maximum(array(values)) == values.max()
    assert minimum(array(values)) == values.min()


def test_a_nan_is_never_lost() -> None:
    values = random(1000)
    values[999] = np.nan
    for reduced in (ordered_sum, maximum, minimum):
        assert math.isnan(reduced(array(values)))


def test_the_same_values_give_the_same_bits() -> None:
    values = array(random(50_000, np.float32))
    assert len({ordered_sum(values) for _ in range(5)}) == 1


def test_sums_and_minima_over_ranges_equal_those_of_each_range() -> None:
    values, start = random(20_000), [0, 3, 4, 12_345, 20_000]
    sums = Sums(2, 20_000, 4, wp.get_device("cpu"))
    sums.add("plain", array(values), ranges(*start), launch)
    sums.add("squared", array(values**2), ranges(*start), launch)
    found, smallest = sums.read(), minima_over(array(values), ranges(*start), 20_000)
    for k, (first, last) in enumerate(pairwise(start)):
        part = values[first:last]
        # float64 rounding: the two sums add in different orders
        assert found["plain"][k] == pytest.approx(math.fsum(part), abs=1e-13 * np.abs(part).sum())
        assert found["squared"][k] == pytest.approx(math.fsum(part**2), rel=1e-13)
        assert smallest[k] == part.min()


def test_the_number_of_strands_depends_only_on_the_length_and_is_a_multiple_of_the_tile() -> None:
    counts = [strands_for(length) for length in range(1, 3 * MOST_STRANDS * VALUES_PER_STRAND, 9973)]
    assert counts == sorted(counts)
    assert {count % TILE for count in counts} == {0}
    assert (counts[0], counts[-1]) == (FEWEST_STRANDS, MOST_STRANDS)
