# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Speed of swatches, compared with Leaf et al. 2018: iterations, batches, tiled weaves, sizes and edits of charts.

    python benchmarks/swatch_speed.py [iteration] [variants] [weaves] [sizes] [frame] [--device cuda:0] [--most 5000000]

The stiffness of the yarn is that of Leaf et al. (material "leaf"), the quality is "standard", and the kernels are
compiled. A single iteration is measured with displacements of 0, so that the same work is repeated. "In a run" is the
mean over the iterations 41 to 140 of a relaxation, with new candidate lists and an assessment every 20 iterations. The
times of Leaf et al. are for a GeForce GTX TITAN X and for four cores of a Xeon E5-2637 v3.
"""

from __future__ import annotations

import argparse
import itertools
import math
import platform
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np
import warp as wp
from corpus import LEAF
from swatch_session import LONGEST, changes_of

import stitchmesh as sm
from stitchmesh.compute.device import device_named
from stitchmesh.periodic.resolve_pattern import resolve_pattern
from stitchmesh.periodic.swatch import draw_swatch
from stitchmesh.periodic.swatch_options import SwatchOptions
from stitchmesh.quality import PRESETS
from stitchmesh.yarn import YarnSet
from stitchmesh.yarn.tiling import tile_yarns
from stitchmesh.yarnrelax import RelaxCell, YarnMaterial, relax_yarns
from stitchmesh.yarnrelax.relax_cells import relax_cells
from stitchmesh.yarnrelax.relaxation_loop import RelaxationLoop
from stitchmesh.yarnrelax.simulation import YarnSimulation
from stitchmesh.yarnrelax.solvers.solver import ASSESSMENT_INTERVAL

QUALITY = PRESETS["standard"]
MATERIAL = YarnMaterial.named("leaf")
FREE = RelaxCell(shear=False)
PATTERNS = ("stockinette", "rib1x1", "plain", "cartridge-belt-rib", "king-charles-brocade")
SMALL = 200
"""Control points of the largest small pattern."""
SMALL_BAR, VARIANT_BAR, FRAME_BAR = 15e-6, 20.0, {"cuda": 0.1, "cpu": 1.0}
"""What is to be reached: seconds of an iteration of a small pattern, throughput of variants together over one after
another, and seconds to the first frame after a chart edit."""
ENDLESS = 10**9
"""Iterations that no measurement comes to the end of; also a budget that no control point uses up [units]."""
WARM, ROUNDS = 2, 5
"""Assessments before a run is timed, and while it is."""
LOADED = 100_000
"""Control points beyond which kernels have been loaded by a smaller size, so that one run will do."""
LEAST_SECONDS = 0.2
"""Shortest measurement of launches that repeat."""
REPEATS = 3
"""Measurements of which the shortest counts."""
ALONE = 20
"""Variants that are relaxed one after another."""
GAMMAS, RADII, BENDING = np.linspace(0.9, 1.3, 10), np.linspace(0.8, 1.2, 10), np.geomspace(0.5, 50.0, 10)
"""The grid of variants: gamma, factor of the yarn's radius, and k_bend [erg cm]."""
EDITS = 5
"""Times that a chart is changed and changed back."""
PERIOD, MEDIUM, LARGE = 0, 4_500, 21_000
"""About how many control points the weaves are tiled to; one period is as it is."""
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
"""Control points and milliseconds a step of weaves in L's table 5, in these columns."""


@dataclass(frozen=True)
class Timing:
    """What an iteration takes."""

    points: int
    alone: float
    """Seconds of its launches."""
    in_run: float
    """Seconds of one of many, with all that comes between them."""


def row(*cells: object) -> None:
    """A line of a table."""
    print("| " + " | ".join(str(cell) for cell in cells) + " |", flush=True)


def head(*names: str) -> None:
    """The first lines of a table."""
    row(*names)
    print("|" + "---|" * len(names))


def cell_of(name: str) -> YarnSet:
    """One period as it is drawn."""
    return draw_swatch(resolve_pattern(name), SwatchOptions(), QUALITY)[1]


def mean_ratio(pairs: Sequence[tuple[float, float]]) -> float:
    """Geometric mean of firsts over seconds."""
    return math.exp(float(np.mean([math.log(first / second) for first, second in pairs])))


def advance(loop: RelaxationLoop, rounds: int) -> None:
    """Iterations and assessments as in a relaxation."""
    simulation, every = loop.simulation, np.ones(loop.simulation.model.cell_count, dtype=bool)
    for _ in range(rounds):
        loop.iterate(ASSESSMENT_INTERVAL)
        simulation.assess()
        loop.accept(every)
    wp.synchronize_device(simulation.model.device)


def stand_still(simulation: YarnSimulation) -> None:
    """Let iterations repeat for as long as it takes, none of which moves anything."""
    simulation.step_fraction = 0.0
    simulation.discard_launches()
    simulation.state.budget.fill_(ENDLESS)
    simulation.solver.begin(np.full(simulation.model.cell_count, ENDLESS))


def launch_seconds(simulation: YarnSimulation) -> float:
    """Seconds of the launches of one iteration, the shortest measurement of some."""
    count, taken = 1, list[float]()
    while len(taken) < REPEATS:
        wp.synchronize_device(simulation.model.device)
        began = time.perf_counter()
        for _ in range(count):
            simulation.iterate()
        wp.synchronize_device(simulation.model.device)
        seconds = time.perf_counter() - began
        if seconds < LEAST_SECONDS:
            count *= 2
        else:
            taken.append(seconds / (count * simulation.graph_iterations))
    return min(taken)


def timing(yarns: YarnSet, device: wp.Device, cell: RelaxCell | None = None) -> Timing:
    """Time the iterations of yarns from where they are drawn; the second of two runs."""
    for _ in range(2 if len(yarns.points) <= LOADED else 1):
        simulation = YarnSimulation.start(yarns, MATERIAL, QUALITY, device, cell=cell)
        loop = RelaxationLoop(simulation, tolerance=0.0)
        advance(loop, WARM)
        began = time.perf_counter()
        advance(loop, ROUNDS)
        in_run = (time.perf_counter() - began) / (ROUNDS * ASSESSMENT_INTERVAL)
    stand_still(simulation)
    return Timing(len(yarns.points), launch_seconds(simulation), in_run)


def iteration(device: wp.Device, given: argparse.Namespace) -> None:
    """One iteration of small patterns, periods held and free."""
    head("pattern", "points", "held us", "in a run us", "free us", "in a run us", "L: points", "us")
    small, plain = [], 0.0
    for name in PATTERNS:
        yarns = cell_of(name)
        held, free = timing(yarns, device), timing(yarns, device, FREE)
        if held.points <= SMALL:
            small += [held.alone, free.alone]
        if name == "plain":
            plain = held.alone
        numbers = [f"{1e6 * seconds:.1f}" for seconds in (held.alone, held.in_run, free.alone, free.in_run)]
        theirs = (LEAF[name][2], f"{1e3 * LEAF[name][1]:.0f}") if name in LEAF else ("", "")
        row(name, held.points, *numbers, *theirs)
    leaf = 1e-3 * LEAF["plain"][1]
    met = "met" if max(small) <= SMALL_BAR else "not met"
    print(f"\nAn iteration of a small pattern takes {1e6 * min(small):.1f} to {1e6 * max(small):.1f} us (bar "
          f"{1e6 * SMALL_BAR:.0f}: {met}); of the plain weave, periods held, {1e6 * plain:.1f} us, {leaf / plain:.1f} "
          f"times as fast as L's {1e6 * leaf:.0f}.")  # fmt: skip


def variants_of_grid(count: int) -> list[tuple[YarnSet, YarnMaterial]]:
    """Variants of stockinette as it is drawn, evenly chosen from the grid.

    By the similarity of L's eq 4 yarn of gamma times the radius stands for a fabric that is gamma times as tight.
    """
    yarns = cell_of("stockinette")
    grid = list(itertools.product(GAMMAS.tolist(), RADII.tolist(), BENDING.tolist()))
    return [
        (replace(yarns, radius=yarns.radius * gamma * factor), replace(MATERIAL, k_bend=k_bend).scaled(gamma))
        for gamma, factor, k_bend in (grid[number] for number in evenly(len(grid), count))
    ]


def evenly(length: int, count: int) -> list[int]:
    """Places of so many in a sequence, evenly spaced."""
    return np.linspace(0, length - 1, min(count, length)).round().astype(int).tolist()


def mean_seconds(of: Sequence[tuple[YarnSet, YarnMaterial]], relax: Callable[[YarnSet, YarnMaterial], object]) -> float:
    """Mean time of relaxing some one after another, kernels compiled by the first of them."""
    relax(*of[0])
    began = time.perf_counter()
    for yarns, material in of:
        relax(yarns, material)
    return (time.perf_counter() - began) / len(of)


def variants(device: wp.Device, given: argparse.Namespace) -> None:
    """A grid of variants together, against some of them one after another."""
    every, name = variants_of_grid(given.variants), str(device)
    cells, materials = zip(*every, strict=True)
    for _ in range(2):
        batch = relax_cells(cells, materials=materials, free=[FREE] * len(cells), quality=QUALITY, device=name)
    together = batch.report["seconds"] / len(cells)
    some = [every[number] for number in evenly(len(every), ALONE)]
    alone = mean_seconds(some, lambda yarns, material: relax_yarns(
        yarns, material=material, quality=QUALITY, device=name, cell=FREE))  # fmt: skip
    batch_of_one = mean_seconds(some, lambda yarns, material: relax_cells(
        [yarns], materials=[material], free=[FREE], quality=QUALITY, device=name))  # fmt: skip
    head("how", "measured", "ms each", "s for all", "times as fast together")
    row("together", len(cells), f"{1e3 * together:.3f}", f"{together * len(cells):.2f}", "")
    for label, seconds in (("one after another", alone), ("likewise, no linking certificate", batch_of_one)):
        times = f"{seconds / together:.1f}"
        row(label, len(some), f"{1e3 * seconds:.3f}", f"{seconds * len(cells):.2f}", times)
    met = "met" if alone / together >= VARIANT_BAR else "not met"
    told = batch.report
    print(f"\n{len(cells)} variants of stockinette together take {told['seconds']:.2f} s ({told['converged']} at rest, "
          f"{told['launched']} iterations of the longest): {alone / together:.1f} times the throughput of one after "
          f"another (bar {VARIANT_BAR:.0f}: {met}).")  # fmt: skip


def tiled_to(yarns: YarnSet, points: int) -> YarnSet:
    """Tiles of a cell, as nearly square as it goes, of about so many control points; they repeat in their turn."""
    count = points / len(yarns.points)
    columns = max(round(math.sqrt(count)), 1)
    return tile_yarns(yarns, columns, max(round(count / columns), 1), periodic=True)


def weaves(device: wp.Device, given: argparse.Namespace) -> None:
    """L's table 5: each weave as one period and tiled."""
    own, cpu, gpu = ("points", "ms", "in a run ms"), ("L CPU: points", "ms"), ("L GPU: points", "ms")
    head("weave", *(*own, *cpu, *gpu) * 2, *own, *gpu)
    ratios: dict[tuple[int, str], list[tuple[float, float]]] = {column: [] for column in COLUMNS}
    for name, theirs in TABLE_5.items():
        yarns = cell_of(name)
        cells: list[object] = []
        for size in (PERIOD, MEDIUM, LARGE):
            found = timing(yarns if size == PERIOD else tiled_to(yarns, size), device)
            cells += [found.points, f"{1e3 * found.alone:.3f}", f"{1e3 * found.in_run:.3f}"]
            for column, (points, ms) in zip(COLUMNS, theirs, strict=True):
                if column[0] == size:
                    cells += [points, f"{ms:.2f}"]
                    ratios[column].append((1e-3 * ms / points, found.alone / found.points))
        row(name, *cells)
    times = ", ".join(
        f"{mean_ratio(pairs):.1f} ({f'about {size} points' if size else 'one period'}, L on a {processor})"
        for (size, processor), pairs in ratios.items()
    )
    print(f"\nPer control point an iteration is so many times as fast as L's, mean of the weaves: {times}.")


def sides(points: int, most: int) -> list[int]:
    """Tiles along a side of squares that double, from one tile to about ``most`` control points."""
    last = max(round(math.sqrt(most / points)), 1)
    return [*(2**k for k in range(last.bit_length()) if 2**k < last), last]


def sizes(device: wp.Device, given: argparse.Namespace) -> None:
    """L's fig. 13: time against the size of a plain weave."""
    yarns = cell_of("plain")
    head("tiles", "points", "ms", "us a point", "in a run ms", "us a point")
    best, found = math.inf, None
    for side in sides(len(yarns.points), given.most):
        found = timing(tile_yarns(yarns, side, side, periodic=True), device)
        best = min(best, found.alone / found.points)
        numbers = [
            f"{value:.4f}"
            for seconds in (found.alone, found.in_run)
            for value in (1e3 * seconds, 1e6 * seconds / found.points)
        ]
        row(side * side, found.points, *numbers)
    assert found is not None
    on_gpu = (pair for (_, processor), pair in zip(COLUMNS, TABLE_5["plain"], strict=True) if processor == "GPU")
    theirs = ", ".join(f"{1e3 * ms / points:.2f} us at {points}" for points, ms in on_gpu)
    last = 1e6 * found.alone / found.points
    print(f"\nAn iteration takes {last:.4f} us a point at {found.points} control points, {1e6 * best:.4f} at the best "
          f"size (L on a GPU: {theirs}, and 0.07 us in a sweater of 250k).")  # fmt: skip


def frame(device: wp.Device, given: argparse.Namespace) -> None:
    """The first frames of a live swatch after its chart was changed."""
    taken: dict[str, list[tuple[float, float, float]]] = {}
    with sm.SwatchSession(
        "stockinette", material=MATERIAL, quality=QUALITY, device=str(device), relax_cell=True
    ) as session:
        width = session.wait_until_rest(LONGEST).size[0]
        edits = {name: edit for name, edit in changes_of("stockinette", width).items() if "pattern" in edit}
        for _ in range(1 + EDITS):  # the first of them loads kernels
            for name, edit in edits.items():
                taken.setdefault(name, []).append(seconds_of_edit(session, edit))
    head("change", "as drawn ms", f"after {ASSESSMENT_INTERVAL} iterations ms", "at rest ms")
    medians = {name: np.median(times[1:], axis=0) for name, times in taken.items()}
    for name, times in medians.items():
        row(name, *(f"{1e3 * seconds:.1f}" for seconds in times))
    slowest, bar = max(times[1] for times in medians.values()), FRAME_BAR["cuda" if device.is_cuda else "cpu"]
    met = "met" if slowest <= bar else "not met"
    print(f"\nA chart edit shows as drawn after {1e3 * max(times[0] for times in medians.values()):.1f} ms, and as it "
          f"relaxes after {1e3 * slowest:.1f} ms (bar {1e3 * bar:.0f}: {met}); medians of {EDITS}.")  # fmt: skip


def seconds_of_edit(session: sm.SwatchSession, edit: dict[str, object]) -> tuple[float, float, float]:
    """Time from a change to its first frame, to the first one that iterations have been at, and to rest."""
    number = session.frame.number
    session.set(**edit)
    first = seen = session.wait_for_frame(LONGEST, after=number)
    assert first is not None
    while seen is not None and seen.report["iteration"] == 0:
        seen = session.wait_for_frame(LONGEST, after=seen.number)
    assert seen is not None
    rest = session.wait_until_rest(LONGEST)
    return first.report["seconds"], seen.report["seconds"], rest.report["seconds"]


SECTIONS = {"iteration": iteration, "variants": variants, "weaves": weaves, "sizes": sizes, "frame": frame}


def main() -> None:
    """Measure the sections that were asked for."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("sections", nargs="*", metavar="SECTION", help=f"of {', '.join(SECTIONS)}; all by default")
    parser.add_argument("--device")
    parser.add_argument("--most", type=int, default=5_000_000, help="control points of the largest plain weave")
    parser.add_argument("--variants", type=int, default=1000, help=argparse.SUPPRESS)
    given = parser.parse_args()
    unknown = set(given.sections) - set(SECTIONS)
    if unknown:
        parser.error(f"section: got {', '.join(sorted(unknown))}; expected some of {', '.join(SECTIONS)}")
    device = device_named(given.device)
    print(f"{device.name or platform.machine()}; Python {platform.python_version()}, Warp {wp.__version__}")
    for name in given.sections or SECTIONS:
        print(f"\n## {name}\n")
        SECTIONS[name](device, given)


if __name__ == "__main__":
    main()
