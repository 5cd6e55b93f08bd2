# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Times of actions: of some runs, and the shortest mean of many repetitions where one run is too short for a clock."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
import warp as wp
from numpy.typing import NDArray

from stitchmesh.quality import Quality
from stitchmesh.yarn import YarnSet
from stitchmesh.yarnrelax.relax import Relaxation, relax_yarns

LEAST_RUN = 0.2
"""Time of a run [s], of as many repetitions as it takes."""
LOADING = 20
"""Iterations of a relaxation that loads the kernels."""


def milliseconds(
    work: Callable[..., object], runs: int, fresh: Callable[[], object] | None = None
) -> NDArray[np.float64]:
    """Return the time of each run [ms].

    Args:
        work: what is timed.
        runs: number of runs.
        fresh: makes what a run works on, before its time begins; without it a run works on its number.
    """
    times = []
    for run in range(runs):
        made = run if fresh is None else fresh()
        began = time.perf_counter()
        work(made)
        times.append(1e3 * (time.perf_counter() - began))
    return np.array(times)


def shortest_mean(action: Callable[[], object], runs: int, device: wp.Device | None = None) -> float:
    """Return the shortest mean time of an action [s] of some runs, with what it has begun on a device."""

    def mean(repeats: int) -> float:
        if device is not None:
            wp.synchronize_device(device)
        began = time.perf_counter()
        for _ in range(repeats):
            action()
        if device is not None:
            wp.synchronize_device(device)
        return (time.perf_counter() - began) / repeats

    mean(1)
    repeats = max(1, int(LEAST_RUN / max(mean(1), 1e-6)))
    return min(mean(repeats) for _ in range(runs))


def relaxed(yarns: YarnSet, quality: Quality, **options: Any) -> tuple[Relaxation, float]:
    """Relax yarns, and return the time [s] with loaded kernels: a short run loads them."""
    relax_yarns(yarns, quality=replace(quality, max_iterations=LOADING), **options)
    began = time.perf_counter()
    return relax_yarns(yarns, quality=quality, **options), time.perf_counter() - began


def median_and_largest(times: Sequence[float] | NDArray[np.float64]) -> tuple[str, str]:
    """Return the median and the largest of some times, as cells of a table."""
    return f"{np.median(times):.1f}", f"{np.max(times):.1f}"
