# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Sums, minima and maxima in a fixed order, so that the same run gives the same bits.

Each strand, which is a thread, goes through an array with a stride and keeps its own result. The host then reads the
results of the strands. The number of strands depends only on the length of the array.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import warp as wp
from numpy.typing import NDArray

from stitchmesh.compute.kernel import kernel
from stitchmesh.compute.launch import launch
from stitchmesh.compute.precision import Number, Scalar

FEWEST_STRANDS, MOST_STRANDS = 256, 32_768
"""Bounds of the number of threads of a reduction."""
TILE = 256
"""Values that a block of threads sums together."""
VALUES_PER_STRAND = 32
"""An array gets more than the fewest strands if it has more than this number of values for each of them."""


def strands_for(count: int) -> int:
    """Number of strands for an array of ``count`` values, a power of two."""
    wanted = max(count // VALUES_PER_STRAND, 1)
    return int(np.clip(1 << (wanted - 1).bit_length(), FEWEST_STRANDS, MOST_STRANDS))


@kernel
def strand_sums(
    # state in
    values: wp.array[Scalar],
    # state out
    sums: wp.array[wp.float64],
) -> None:
    """Sum of a strand's values, in ascending order."""
    strand = wp.tid()
    total = wp.float64(0.0)
    for k in range(strand, values.shape[0], sums.shape[0]):
        total += wp.float64(values[k])
    sums[strand] = total


@kernel
def strand_maxima(
    # state in
    sign: wp.float64,
    values: wp.array[Number],
    # state out
    maxima: wp.array[wp.float64],
) -> None:
    """Largest of sign times a strand's values; not a number where one of them is not."""
    strand = wp.tid()
    most = wp.float64(-1.0e300)
    for k in range(strand, values.shape[0], maxima.shape[0]):
        value = sign * wp.float64(values[k])
        if most == most and not (value <= most):  # a result that is not a number stays
            most = value
    maxima[strand] = most


@kernel(tile=TILE)
def row_totals(
    # state in
    parts: wp.array2d[wp.float64],
    # state out
    totals: wp.array[wp.float64],
) -> None:
    """Sum of each row, whose length is a multiple of 256; one block for each row."""
    row, lane = wp.tid()
    whole = wp.tile_zeros(shape=(1, 256), dtype=wp.float64)
    for k in range(parts.shape[1] // 256):
        whole += wp.tile_load(parts, shape=(1, 256), offset=(row, k * 256))
    total = wp.tile_sum(whole)
    if lane == 0:
        totals[row] = total[0]


@wp.func
def strands_of(count: int, most: int) -> int:
    """``strands_for`` in a kernel, at most ``most``; the strands of a range do not depend on the other ranges."""
    strands = int(wp.static(FEWEST_STRANDS))
    while strands < most and strands < count // wp.static(VALUES_PER_STRAND):
        strands *= 2
    return strands


@kernel
def range_sums(
    # model
    strands: int,
    start: wp.array[wp.int32],
    # state in
    values: wp.array[Scalar],
    # state out
    sums: wp.array[wp.float64],
) -> None:
    """Sum of a strand's values in its range, in ascending order; the longest range has ``strands`` strands."""
    cell = wp.tid() // strands
    strand = wp.tid() - cell * strands
    own = strands_of(start[cell + 1] - start[cell], strands)
    total = wp.float64(0.0)
    if strand < own:
        for k in range(start[cell] + strand, start[cell + 1], own):
            total += wp.float64(values[k])
    sums[wp.tid()] = total


@kernel
def range_minima(
    # model
    strands: int,
    start: wp.array[wp.int32],
    # state in
    values: wp.array[Scalar],
    # state out
    minima: wp.array[wp.float64],
) -> None:
    """Smallest of a strand's values in its range; not a number where one of them is not."""
    cell = wp.tid() // strands
    strand = wp.tid() - cell * strands
    least = wp.float64(1.0e300)
    for k in range(start[cell] + strand, start[cell + 1], strands):
        value = wp.float64(values[k])
        if least == least and not (value >= least):  # a result that is not a number stays
            least = value
    minima[wp.tid()] = least


def sums_over(values: wp.array[Any], start: wp.array[Any], longest: int) -> NDArray[np.float64]:
    """Sum of an array of scalars over each range, read back to the host."""
    sums: NDArray[np.float64] = _of_strands(range_sums, values, start, longest).sum(axis=1)
    return sums


def minima_over(values: wp.array[Any], start: wp.array[Any], longest: int) -> NDArray[np.float64]:
    """Smallest value of an array of scalars in each range, read back to the host; NaN if the range has a NaN."""
    smallest: NDArray[np.float64] = _of_strands(range_minima, values, start, longest).min(axis=1)
    return smallest


def _of_strands(
    kernel: wp.Kernel, values: wp.array[Any], start: wp.array[Any], longest: int
) -> NDArray[np.float64]:  # fmt: skip
    """The results of the strands, a row for each range; no range is longer than ``longest``."""
    strands, ranges = strands_for(longest), len(start) - 1
    partial = wp.empty(ranges * strands, dtype=wp.float64, device=values.device)
    launch(kernel, len(partial), [strands, start, values], [partial], values.device)
    return np.asarray(partial.numpy().reshape(ranges, strands))


class Sums:
    """Sums of several arrays over ranges, read back together, because each synchronisation takes a GPU long."""

    def __init__(self, count: int, longest: int, ranges: int, device: wp.Device) -> None:
        """Allocate ``count`` sums over ``ranges`` ranges of at most ``longest`` values."""
        self._strands = strands_for(longest)
        self._parts = wp.zeros((count * ranges, self._strands), dtype=wp.float64, device=device)
        self._totals = wp.zeros(count * ranges, dtype=wp.float64, device=device)
        self._ranges = ranges
        self._names: list[str] = []

    def add(self, name: str, values: wp.array[Any], start: wp.array[Any], run: Callable[..., Any]) -> Any:
        """Return the launch that sums an array over ranges; range k is from ``start[k]`` to ``start[k + 1]``."""
        first = len(self._names) * self._ranges
        part = self._parts[first : first + self._ranges].flatten()
        self._names.append(name)
        return run(range_sums, len(part), [self._strands, start, values], [part])

    def total_launch(self, run: Callable[..., Any]) -> Any:
        """Return the launch that adds up the results of the strands."""
        return run(row_totals, len(self._totals), [self._parts], [self._totals])

    def totals(self) -> dict[str, NDArray[np.float64]]:
        """The sums over each range, in the order of ``add``."""
        return dict(zip(self._names, self._totals.numpy().reshape(-1, self._ranges), strict=False))

    def read(self) -> dict[str, NDArray[np.float64]]:
        """Add up the results of the strands and read the sums."""
        launch(row_totals, len(self._totals), [self._parts], [self._totals], self._totals.device)
        return self.totals()


def ordered_sum(values: wp.array[Any]) -> float:
    """Sum of an array of scalars, read back to the host."""
    return float(np.sum(_reduced(strand_sums, [values], values)))


def maximum(values: wp.array[Any]) -> float:
    """Largest value of an array of scalars, read back to the host; NaN if one of them is NaN."""
    return float(np.max(_reduced(strand_maxima, [wp.float64(1.0), values], values)))


def minimum(values: wp.array[Any]) -> float:
    """Smallest value of an array of scalars, read back to the host; NaN if one of them is NaN."""
    return -float(np.max(_reduced(strand_maxima, [wp.float64(-1.0), values], values)))


def _reduced(kernel: wp.Kernel, inputs: list[Any], values: wp.array[Any]) -> NDArray[np.float64]:
    partial = wp.empty(strands_for(len(values)), dtype=wp.float64, device=values.device)
    launch(kernel, len(partial), inputs, [partial], values.device)
    return partial.numpy()
