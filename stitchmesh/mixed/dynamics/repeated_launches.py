# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Launches that are captured when they first run with some vectors, and repeated after that.

A launch from Python takes some ten microseconds, longer than most kernels of a small system run. Forces, energies and
what a product needs are therefore captured like the iterations of the linear solver: one graph on a GPU, one table on a
CPU.
"""

from __future__ import annotations

from collections.abc import Callable, Hashable
from functools import partial
from typing import Any

import numpy as np
import warp as wp
from numpy.typing import NDArray

from stitchmesh.compute.captured import CapturedLaunches, Launcher
from stitchmesh.compute.launch import prepare
from stitchmesh.mixed.dynamics.read_sums import ReadSums
from stitchmesh.mixed.mixed_vector import MixedVector

MOST = 64
"""Largest number of sequences that are kept; the one that was captured first is forgotten first."""


class RepeatedLaunches:
    """Captured sequences of launches of one system."""

    def __init__(self, device: wp.Device) -> None:
        """Begin without any."""
        self._device = device
        self._run: Launcher = partial(prepare, device=device)
        self._captured: dict[Hashable, tuple[CapturedLaunches | None, ReadSums, tuple[MixedVector, ...]]] = {}

    def clear(self) -> None:
        """Forget all sequences, because an array that they name has been replaced."""
        self._captured.clear()

    def run(
        self, name: Hashable, vectors: tuple[MixedVector, ...], make: Callable[[Launcher, ReadSums], list[Any]]
    ) -> ReadSums:
        """Run a sequence of launches.

        Args:
            name: what the sequence does; numbers that its launches contain are part of the name.
            vectors: the vectors that it reads and writes.
            make: from a launcher to the launches; called when the sequence has not run with these vectors yet. It may
                add sums, which are found after the launches.

        Returns:
            the sums, to be read.
        """
        key = (name, *(id(vector) for vector in vectors))
        if key not in self._captured:
            self._captured[key] = self._capture(vectors, make)
            while len(self._captured) > MOST:
                del self._captured[next(iter(self._captured))]
        captured, sums, _vectors = self._captured[key]
        if captured is not None:
            captured.launch()
        return sums

    def read(
        self, name: Hashable, vectors: tuple[MixedVector, ...], make: Callable[[Launcher, ReadSums], list[Any]]
    ) -> NDArray[np.float64]:
        """Run a sequence and read its sums; arguments as for ``run``."""
        return self.run(name, vectors, make).read()

    def _capture(
        self, vectors: tuple[MixedVector, ...], make: Callable[[Launcher, ReadSums], list[Any]]
    ) -> tuple[CapturedLaunches | None, ReadSums, tuple[MixedVector, ...]]:
        sums = ReadSums(self._device)
        launches = make(self._run, sums)
        launches += sums.launches(self._run)
        return CapturedLaunches(launches, self._device) if launches else None, sums, vectors
