# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Time of a relaxation on a CPU against the number of threads, and whether the bits of the yarns are the same.

The columns are one iteration, one assessment, new lists with and without a broad phase, and a whole relaxation that is
stopped after ``--iterations`` iterations, with its start and its certificate. Each time is the shortest of some runs,
because other programs may use the same cores; the number in brackets is how many times as fast as one thread it is.
"""

from __future__ import annotations

import hashlib
import logging
import time
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from benchmarks.scenes.stockinette import stockinette_tube
from benchmarks.table import Rows
from benchmarks.timing import shortest_mean
from stitchmesh.compute.device import device_named
from stitchmesh.compute.threads import core_count, set_threads
from stitchmesh.quality import quality_named
from stitchmesh.run import QUIET
from stitchmesh.yarn import YarnSet
from stitchmesh.yarnrelax import YarnMaterial, relax_yarns
from stitchmesh.yarnrelax.relaxation_loop import RelaxationLoop
from stitchmesh.yarnrelax.simulation import YarnSimulation

COLUMNS = ("iteration", "assessment", "lists", "broad lists", "relaxation")
SETTLE = 20
"""Iterations before the measurement, after which yarns touch as in most of a relaxation."""


def tube(points: int, per_stitch: int) -> YarnSet:
    """A tube of plain knit with about ``points`` control points, as many rows as stitches in a row."""
    rows = max(round(np.sqrt(points / per_stitch)), 2)
    return stockinette_tube(rows, max(round(points / per_stitch / rows), 6), per_stitch)


def measure(yarns: YarnSet, iterations: int, runs: int) -> tuple[dict[str, float], str]:
    """Times by column [s], and a digest of the relaxed yarns."""
    quality = replace(quality_named("standard"), max_iterations=iterations)
    simulation = YarnSimulation.start(yarns, YarnMaterial.named("stitchmesh"), quality, device_named("cpu"))
    loop = RelaxationLoop(simulation, tolerance=0.0)
    loop.iterate(SETTLE)

    def iterate() -> None:
        simulation.solver.begin(np.array([1]))
        simulation.iterate()

    def search_broadly() -> None:
        simulation.candidates.near.invalidate()
        simulation.search_contacts()

    actions = (iterate, simulation.assess_cells, simulation.search_contacts, search_broadly)
    found = dict(zip(COLUMNS, (shortest_mean(action, runs) for action in actions), strict=False))
    began = time.perf_counter()
    relaxed = relax_yarns(yarns, quality=quality, device="cpu", run=QUIET).yarns
    found["relaxation"] = time.perf_counter() - began
    return found, hashlib.sha256(relaxed.points.tobytes()).hexdigest()[:8]


def threads_to_measure() -> list[int]:
    """One, two, four ... and all cores."""
    cores = core_count()
    return sorted({1 << k for k in range(cores.bit_length()) if 1 << k <= cores} | {cores})


def times_of(points: Sequence[int], threads: Sequence[int], iterations: int, runs: int) -> Rows:
    """Measure and print a table of milliseconds."""
    yield "points", "threads", *(f"{name} [ms]" for name in COLUMNS), "bits"
    for size in points:
        yarns = tube(size, quality_named("standard").control_points_per_stitch)
        alone: dict[str, float] = {}
        for count in threads:
            set_threads(count)
            found, digest = measure(yarns, iterations, runs)
            alone = alone or found
            times = (f"{1e3 * found[name]:.3g} ({alone[name] / found[name]:.2f})" for name in COLUMNS)
            yield len(yarns.points), count, *times, digest


@dataclass(frozen=True)
class Options:
    """What is measured."""

    points: tuple[int, ...] = (3000, 10000, 30000, 100000, 260000)
    threads: tuple[int, ...] = ()
    """by default 1, 2, 4 ... and all cores"""
    iterations: int = 100
    """iterations of the whole relaxation"""
    runs: int = 3
    """runs of which the shortest counts"""


def threads(given: Options) -> Rows:
    """Measure the sizes and the numbers of threads that the command line gives."""
    logging.disable(logging.WARNING)  # the relaxations are stopped on purpose
    yield from times_of(given.points, given.threads or threads_to_measure(), given.iterations, given.runs)
