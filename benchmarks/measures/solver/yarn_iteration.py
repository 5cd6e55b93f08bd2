# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Time of one iteration of the yarn relaxation for each kernel, compared with the bound from the memory traffic."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
import warp as wp

from benchmarks.scenes.stockinette import stockinette_tube
from benchmarks.table import Rows
from benchmarks.timing import shortest_mean
from stitchmesh.compute.device import device_named
from stitchmesh.quality import Quality, quality_named
from stitchmesh.yarnrelax.model.material import YarnMaterial
from stitchmesh.yarnrelax.relaxation_loop import RelaxationLoop
from stitchmesh.yarnrelax.simulation import YarnSimulation

BANDWIDTH = {"cuda": 4.8e12, "cpu": 1.0e10}
"""Memory bandwidth [bytes/s] of an H200 GPU, and of one core of a server."""
RUNS = 3
"""Runs of which the shortest counts."""


def repeated(device: wp.Device, launches: Sequence[wp.Launch], times: int) -> Callable[[], object]:
    """An action that runs all launches several times; on a GPU it launches a captured graph."""

    def run_all() -> None:
        for _ in range(times):
            for launch in launches:
                launch.launch()

    if not device.is_cuda:
        return run_all
    with wp.ScopedCapture(device=device) as capture:
        run_all()
    return lambda: wp.capture_launch(capture.graph)


def traffic(simulation: YarnSimulation) -> dict[str, float]:
    """Bytes that each kernel must at least read and write, if it accesses each array once."""
    model, candidates = simulation.model, simulation.candidates
    real = 4 if model.scalar is wp.float32 else 8
    n, s, p = model.point_count, model.segment_count, model.sample_count
    entries = float(candidates.count.numpy().sum())
    vectors = 3 * real
    return {
        "samples_and_segment_forces": n * vectors + s * (16 + real + 8) + p * 4 * real + s * (3 * vectors + 7 * real),
        "contact_forces": p * (4 * real + 4 + real) + 4 * entries + p * 10 * real,
        "gather_forces": s * 3 * vectors + p * 4 * real + n * (16 + 4 + real) + n * 4 * real,
        "find_preconditioner": s * (7 + 8) * real + p * 6 * real + n * (16 + 4 + real) + n * 6 * real,
        "compare_forces": n * (2 * vectors + 6 * real + 7 * vectors + 2 * vectors + real + 2 * vectors),
        "apply_preconditioner": n * (vectors + 7 * real + 7 * vectors + vectors),
        "propose_moves": n * (3 * vectors + 7 * vectors + real + vectors + real),
        "apply_moves": n * 4 * vectors,
    }


def measure(points: int, quality: Quality, device: wp.Device, settle: int) -> Rows:
    """Measure and print the times for one number of control points."""
    per_stitch = quality.control_points_per_stitch
    rows = max(int(np.sqrt(points / per_stitch)), 2)
    yarns = stockinette_tube(rows, max(round(points / per_stitch / rows), 6), per_stitch)
    material = YarnMaterial.named("stitchmesh")
    simulation = YarnSimulation.start(yarns, material, quality, device)
    loop = RelaxationLoop(simulation, tolerance=0.0)
    loop.iterate(settle)
    residual = simulation.assess_cells()[0].residual
    relaxed_points = wp.clone(simulation.state.points)
    n = simulation.model.point_count
    touching = float(simulation.candidates.count.numpy().sum()) / 2
    samples = simulation.model.sample_count
    yield f"{n} points, {samples} samples, {touching:.0f} listed pairs, residual {residual:.4f}"
    yield f"margin {simulation.candidates.margins[0]:.2f} r, {quality.precision}, {device.name}"
    times = 20 if n < 100_000 else 2
    bound = traffic(simulation)
    bandwidth = BANDWIDTH["cuda" if device.is_cuda else "cpu"]
    yield "kernel", "us", "ns/point", "bound us", "share"
    launches = simulation.iterations.launches
    for launch in launches:
        name = launch.kernel.key.split("__")[-1]
        took = shortest_mean(repeated(device, [launch], times), RUNS, device) / times
        limit = bound[name] / bandwidth if name in bound else np.nan
        yield name, f"{took * 1e6:.2f}", f"{took / n * 1e9:.2f}", f"{limit * 1e6:.2f}", f"{limit / took:.0%}"
        wp.copy(simulation.state.points, relaxed_points)
    all_forces = shortest_mean(repeated(device, launches[:3], times), RUNS, device) / times
    yield "all forces", f"{all_forces * 1e6:.2f}", f"{all_forces / n * 1e9:.2f}"
    whole = shortest_mean(repeated(device, launches, times), RUNS, device) / times
    wp.copy(simulation.state.points, relaxed_points)
    yield "one iteration", f"{whole * 1e6:.2f}", f"{whole / n * 1e9:.2f}"
    for name, action in (("assessment", simulation.assess_cells), ("new lists", loop.search_contacts)):
        took = shortest_mean(action, RUNS, device)
        yield name, f"{took * 1e6:.2f}", f"{took / n * 1e9:.2f}"


@dataclass(frozen=True)
class Options:
    """What is measured."""

    device: str | None = None
    points: tuple[int, ...] = (3000, 60000)
    quality: str = "standard"
    settle: int = 100
    """iterations before the measurement"""


def yarn_iteration(arguments: Options) -> Rows:
    """Measure the sizes given on the command line."""
    for points in arguments.points:
        quality = quality_named(arguments.quality)
        yield from measure(points, quality, device_named(arguments.device), arguments.settle)
