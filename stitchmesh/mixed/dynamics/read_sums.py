# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Sums, dot products and minima that launches find in a fixed order, and that the host reads back together.

On a GPU a reading costs as much time as some launches, so that what is needed together is read together.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import warp as wp
from numpy.typing import NDArray

from stitchmesh.compute.captured import Launcher
from stitchmesh.compute.host_copy import HostCopy
from stitchmesh.compute.partial_sums import WIDTH, chunk_of, dot_parts, least_parts, part_count, sum_parts, total_parts
from stitchmesh.compute.thread_block import THREADS


class ReadSums:
    """Sums and minima that are found by launches and read back together."""

    def __init__(self, device: wp.Device) -> None:
        """Begin without sums."""
        self._device = device
        self._counts: list[int] = []
        self._todo: list[tuple[wp.Kernel, list[Any], int]] = []
        self._host = HostCopy(wp.zeros((0, WIDTH), dtype=wp.float64, device=device))

    def add_sum(self, values: wp.array[Any]) -> None:
        """Add the sum of an array of scalars."""
        self._add(sum_parts, [values], len(values))

    def add_dot(self, first: wp.array[Any], second: wp.array[Any]) -> None:
        """Add the dot product of two arrays of scalars."""
        self._add(dot_parts, [first, second], len(first))

    def add_minimum(self, values: wp.array[Any]) -> None:
        """Add the smallest value of an array of scalars; 1e300 where there is none."""
        self._add(least_parts, [values], len(values))

    def launches(self, run: Launcher) -> list[Any]:
        """The launches that find all sums that have been added."""
        if not self._counts:
            return []
        start = np.concatenate([[0], np.cumsum(self._counts)]).astype(np.int32)
        parts = wp.zeros((max(int(start[-1]), 1), WIDTH), dtype=wp.float64, device=self._device)
        sums = wp.zeros((len(self._counts), WIDTH), dtype=wp.float64, device=self._device)
        self._host = HostCopy(sums)
        result = []
        for (kernel_of_parts, inputs, chunk), first, last in zip(self._todo, start[:-1], start[1:], strict=True):
            if last > first:
                own = parts[int(first) : int(last)]
                result.append(run(kernel_of_parts, int(last - first), [chunk, *inputs], [own], tile=THREADS))
        starts = wp.array(start, dtype=wp.int32, device=self._device)
        minima = [kernel_of_parts is least_parts for kernel_of_parts, _inputs, _chunk in self._todo]
        of_minima = wp.array(np.array(minima, dtype=np.int32), dtype=wp.int32, device=self._device)
        self._kept = parts, starts, of_minima
        inputs = [starts, of_minima, parts]
        return [*result, run(total_parts, len(self._counts), inputs, [sums], tile=THREADS)]

    def read(self) -> NDArray[np.float64]:
        """The sums in the order in which they were added; their launches must have run."""
        return self._host.read()[:, 0]

    def _add(self, kernel_of_parts: wp.Kernel, inputs: list[Any], count: int) -> None:
        self._todo.append((kernel_of_parts, inputs, chunk_of(count, self._device)))
        self._counts.append(part_count(count, self._device))
