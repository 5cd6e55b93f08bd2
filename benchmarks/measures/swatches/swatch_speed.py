# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Speed of swatches, compared with Leaf et al. 2018: iterations, batches, tiled weaves and sizes.

The stiffness of the yarn is that of Leaf et al. (material "leaf"), the quality is "standard", and the kernels are
compiled. A single iteration is measured with displacements of 0, so that the same work is repeated. "In a run" is the
mean over the iterations 41 to 140 of a relaxation, with new candidate lists and an assessment every 20 iterations. The
times of Leaf et al. are for a GeForce GTX TITAN X and for four cores of a Xeon E5-2637 v3.
"""

from __future__ import annotations

import itertools
import math
import platform
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import warp as wp

import stitchmesh as sm
from benchmarks.scenes.swatches import LEAF, cell_of, evenly
from benchmarks.table import Rows, note
from benchmarks.timing import shortest_mean
from stitchmesh.compute.device import device_named
from stitchmesh.periodic.fabric_shape import FlatFabric
from stitchmesh.periodic.relaxation.support import planes
from stitchmesh.periodic.repeat.drawn_swatch import draw_swatch
from stitchmesh.periodic.resolve_pattern import resolve_pattern
from stitchmesh.periodic.swatch_options import SwatchOptions
from stitchmesh.quality import PRESETS
from stitchmesh.yarn import YarnSet
from stitchmesh.yarn.tiling import tile_yarns
from stitchmesh.yarnrelax import RelaxCell, YarnMaterial, relax_yarns
from stitchmesh.yarnrelax.relaxation_loop import RelaxationLoop
from stitchmesh.yarnrelax.simulation import YarnSimulation
from stitchmesh.yarnrelax.solvers.solver import ASSESSMENT_INTERVAL
from stitchmesh.yarnrelax.together.relax_cells import relax_cells

QUALITY = PRESETS["standard"]
MATERIAL = YarnMaterial.named("leaf")
FREE = RelaxCell(shear=False)
PATTERNS = ("stockinette", "rib1x1", "plain", "cartridge-belt-rib", "king-charles-brocade")
ENDLESS = 10**9
"""More iterations than any measurement runs; also a budget that no control point uses up [units]."""
WARM, ROUNDS = 2, 5
"""Numbers of assessment intervals before the timing starts, and during the timing."""
LOADED = 100_000
"""Control points above which one run suffices, because a smaller size has already loaded the kernels."""
REPEATS = 3
"""Number of measurements, of which the shortest is reported."""
ALONE = 20
"""Number of variants that are also relaxed one after another."""
GAMMAS, RADII, BENDING = np.linspace(0.9, 1.3, 10), np.linspace(0.8, 1.2, 10), np.geomspace(0.5, 50.0, 10)
"""The grid of variants: gamma, factor on the yarn radius, and k_bend [erg cm]."""
PERIOD, MEDIUM, LARGE = 0, 4_500, 21_000
"""Approximate numbers of control points to which the weaves are tiled; ``PERIOD`` is one period without tiling."""
COLUMNS = ((PERIOD, "CPU"), (MEDIUM, "CPU"), (PERIOD, "GPU"), (MEDIUM, "GPU"), (LARGE, "GPU"))
TABLE_5 = {
    "plain": ((88, 1.38), (4288, 33.29), (88, 0.42), (4544, 2.11), (21744, 14.54)),
    "twill-2x1": ((130, 1.62), (4288, 35.91), (130, 0.44), (4544, 1.90), (21158, 10.78)),
    "twill-4x1": ((238, 2.88), (4288, 31.49), (238, 0.45), (4544, 1.51), (21744, 9.50)),
    "twill-3x2": ((238, 2.88), (4288, 31.35), (238, 0.51), (4544, 1.48), (21744, 10.44)),
    "basket-2x2": ((180, 1.71), (3780, 28.88), (180, 0.49), (4020, 1.40), (20580, 10.82)),
    "basket-3x3": ((304, 3.25), (4288, 34.61), (304, 0.50), (4544, 1.37), (19448, 8.78)),
    "satin-3x2": ((238, 2.85), (4288, 31.50), (238, 0.44), (4544, 1.47), (21744, 10.40)),
    "satin-2x3": ((238, 2.79), (4288, 31.59), (238, 0.48), (4544, 1.42), (21744, 8.39)),
}
"""Control points and milliseconds per step of weaves in L's table 5, in the order of ``COLUMNS``."""


@dataclass(frozen=True)
class Timing:
    """Time of an iteration."""

    points: int
    alone: float
    """Seconds of the launches of an iteration."""
    in_run: float
    """Seconds per iteration of a relaxation, including contact searches and assessments."""


def machine(device: wp.Device) -> str:
    """The processor, and the versions of what runs on it."""
    return f"{device.name or platform.machine()}; Python {platform.python_version()}, Warp {wp.__version__}"


def mean_ratio(pairs: Sequence[tuple[float, float]]) -> float:
    """Geometric mean of the ratios first / second of pairs."""
    return math.exp(float(np.mean([math.log(first / second) for first, second in pairs])))


def advance(loop: RelaxationLoop, rounds: int) -> None:
    """Run ``rounds`` assessment intervals as in a relaxation: iterations, an assessment, acceptance of the state."""
    simulation, every = loop.simulation, np.ones(loop.simulation.model.cell_count, dtype=bool)
    for _ in range(rounds):
        loop.iterate(ASSESSMENT_INTERVAL)
        simulation.assess_cells()
        loop.accept(every)
    wp.synchronize_device(simulation.model.device)


def forbid_motion(simulation: YarnSimulation) -> None:
    """Prepare a simulation for repeated iterations of the same work, which move no control point."""
    simulation.step_fraction = 0.0
    simulation.search.generation += 1  # the launches are captured again
    simulation.state.budget.fill_(ENDLESS)
    simulation.solver.begin(np.full(simulation.model.cell_count, ENDLESS))


def launch_seconds(simulation: YarnSimulation) -> float:
    """Seconds of the launches of one iteration: the shortest mean of ``REPEATS`` measurements."""
    device = simulation.model.device
    return shortest_mean(simulation.iterate, REPEATS, device) / simulation.graph_iterations


def timing(yarns: YarnSet, device: wp.Device, cell: RelaxCell | None = None) -> Timing:
    """Time the iterations of yarns from their generated state, in the second of two runs."""
    for _ in range(2 if len(yarns.points) <= LOADED else 1):
        simulation = YarnSimulation.start(yarns, MATERIAL, QUALITY, device, cell=cell)
        loop = RelaxationLoop(simulation, tolerance=0.0)
        advance(loop, WARM)
        began = time.perf_counter()
        advance(loop, ROUNDS)
        in_run = (time.perf_counter() - began) / (ROUNDS * ASSESSMENT_INTERVAL)
    forbid_motion(simulation)
    return Timing(len(yarns.points), launch_seconds(simulation), in_run)


def iteration(*, device: str | None = None) -> Rows:
    """Time one iteration of small patterns, with fixed and with free periods."""
    where = device_named(device)
    yield machine(where)
    yield "pattern", "points", "fixed periods us", "in a run us", "free periods us", "in a run us", "L: points", "us"
    for name in PATTERNS:
        yarns = cell_of(name, QUALITY)
        fixed, free = timing(yarns, where), timing(yarns, where, FREE)
        numbers = [f"{1e6 * seconds:.1f}" for seconds in (fixed.alone, fixed.in_run, free.alone, free.in_run)]
        theirs = (LEAF[name][2], f"{1e3 * LEAF[name][1]:.0f}") if name in LEAF else ("", "")
        yield name, fixed.points, *numbers, *theirs


def held_corpus(quality: str) -> dict[str, Any]:
    """The patterns of Leaf et al. with their periods held, as arguments of ``relax_cells``."""
    cells = [cell_of(name, quality) for name in LEAF]
    return {"cells": cells, "materials": [MATERIAL] * len(cells)}


def free_library(quality: str) -> dict[str, Any]:
    """The patterns of the library, free between the planes of a swatch, as arguments of ``relax_cells``."""
    cells, between, options = [], [], SwatchOptions(relax_cell=True)
    for name in sm.pattern_names():
        source = resolve_pattern(name)
        try:
            fabric, drawn = draw_swatch(source, options, PRESETS[quality])
        except sm.StitchMeshError as error:
            note(f"{name} is left out: {error}")
            continue
        cells.append(drawn)
        between += planes(options, FlatFabric.of(drawn, fabric, source), drawn.radius)
    return {"cells": cells, "free": [FREE] * len(cells), "planes": between}


def batches(*, device: str | None = None) -> Rows:
    """Relax the patterns of Leaf et al. and those of the library in one batch each, the second time timed."""
    yield machine(device_named(device))
    yield "batch", "quality", "cells", "points", "s", "at rest", "iterations of the slowest", "largest change left %"
    for label, make in (("37 of L, periods held", held_corpus), ("library, free between planes", free_library)):
        for quality in ("draft", "standard"):
            chosen = make(quality)
            for _ in range(2):
                batch = relax_cells(**chosen, quality=quality, device=device, progress=False)
            left = [cell.report["remaining_change"]["spacing"] for cell in batch.cells
                    if cell.report["converged"] and cell.report["remaining_change"]]  # fmt: skip
            report, points = batch.report, sum(len(yarns.points) for yarns in chosen["cells"])
            yield (
                label, quality, len(batch.cells), points, f"{report['seconds']:.2f}", report["converged"],
                report["launched"], f"{100 * max(left, default=math.nan):.2g}",
            )  # fmt: skip


def variants_of_grid() -> list[tuple[YarnSet, YarnMaterial]]:
    """Variants of the generated stockinette cell, one for each point of the grid.

    By the similarity of L's eq 4, a yarn of gamma times the radius represents a fabric that is gamma times as tight.
    """
    yarns = cell_of("stockinette", QUALITY)
    return [
        (replace(yarns, radius=yarns.radius * gamma * factor), replace(MATERIAL, k_bend=k_bend).scaled(gamma))
        for gamma, factor, k_bend in itertools.product(GAMMAS.tolist(), RADII.tolist(), BENDING.tolist())
    ]


def mean_seconds(
    chosen: Sequence[tuple[YarnSet, YarnMaterial]], relax: Callable[[YarnSet, YarnMaterial], object]
) -> float:
    """Mean time of relaxing the chosen variants one after another; an extra first call compiles the kernels."""
    relax(*chosen[0])
    began = time.perf_counter()
    for yarns, material in chosen:
        relax(yarns, material)
    return (time.perf_counter() - began) / len(chosen)


def variants(*, device: str | None = None) -> Rows:
    """Relax a grid of variants in one batch, and some of them one after another."""
    yield machine(device_named(device))
    every = variants_of_grid()
    cells, materials = zip(*every, strict=True)
    for _ in range(2):
        batch = relax_cells(cells, materials=materials, free=[FREE] * len(cells), quality=QUALITY, device=device)
    together = batch.report["seconds"] / len(cells)
    some = [every[number] for number in evenly(len(every), ALONE)]
    alone = mean_seconds(some, lambda yarns, material: relax_yarns(
        yarns, material=material, quality=QUALITY, device=device, cell=FREE))  # fmt: skip
    batch_of_one = mean_seconds(some, lambda yarns, material: relax_cells(
        [yarns], materials=[material], free=[FREE], quality=QUALITY, device=device))  # fmt: skip
    yield "method", "measured", "ms each", "s for all", "speed-up of the batch"
    yield ("one batch", len(cells), f"{1e3 * together:.3f}", f"{together * len(cells):.2f}", "")
    single = (("one after another", alone), ("one after another, no linking certificate", batch_of_one))
    for label, seconds in single:
        times = f"{seconds / together:.1f}"
        yield (label, len(some), f"{1e3 * seconds:.3f}", f"{seconds * len(cells):.2f}", times)
    report = batch.report
    yield f"{report['converged']} at rest, {report['launched']} iterations of the slowest"


def tiled_to(yarns: YarnSet, points: int) -> YarnSet:
    """Periodic tiling of a cell to about ``points`` control points, with about as many columns as rows."""
    count = points / len(yarns.points)
    columns = max(round(math.sqrt(count)), 1)
    return tile_yarns(yarns, columns, max(round(count / columns), 1), periodic=True)


def weaves(*, device: str | None = None) -> Rows:
    """Time the weaves of L's table 5, each as one period and tiled."""
    where = device_named(device)
    yield machine(where)
    own, cpu, gpu = ("points", "ms", "in a run ms"), ("L CPU: points", "ms"), ("L GPU: points", "ms")
    yield ("weave", *(*own, *cpu, *gpu) * 2, *own, *gpu)
    ratios: dict[tuple[int, str], list[tuple[float, float]]] = {column: [] for column in COLUMNS}
    for name, theirs in TABLE_5.items():
        yarns = cell_of(name, QUALITY)
        cells: list[object] = []
        for size in (PERIOD, MEDIUM, LARGE):
            found = timing(yarns if size == PERIOD else tiled_to(yarns, size), where)
            cells += [found.points, f"{1e3 * found.alone:.3f}", f"{1e3 * found.in_run:.3f}"]
            for column, (points, ms) in zip(COLUMNS, theirs, strict=True):
                if column[0] == size:
                    cells += [points, f"{ms:.2f}"]
                    ratios[column].append((1e-3 * ms / points, found.alone / found.points))
        yield name, *cells
    times = ", ".join(
        f"{mean_ratio(pairs):.1f} ({f'about {size} points' if size else 'one period'}, L on a {processor})"
        for (size, processor), pairs in ratios.items()
    )
    yield f"Speed-up over L per control point and iteration, mean of the weaves: {times}."


def sides(points: int, most: int) -> list[int]:
    """Numbers of tiles along the side of a square, doubling from one tile to about ``most`` control points."""
    last = max(round(math.sqrt(most / points)), 1)
    return [*(2**k for k in range(last.bit_length()) if 2**k < last), last]


def sizes(*, device: str | None = None) -> Rows:
    """L's fig. 13: time per iteration against the size of a plain weave."""
    where = device_named(device)
    yield machine(where)
    yarns = cell_of("plain", QUALITY)
    yield "tiles", "points", "ms", "us per point", "in a run ms", "us per point"
    for side in sides(len(yarns.points), most=5_000_000):
        found = timing(tile_yarns(yarns, side, side, periodic=True), where)
        times = (
            f"{value:.4f}"
            for seconds in (found.alone, found.in_run)
            for value in (1e3 * seconds, 1e6 * seconds / found.points)
        )
        yield side * side, found.points, *times


ACTIONS = (iteration, batches, variants, weaves, sizes)
