# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Speed and accuracy of mixed yarns and triangles: size and hybrid width of the region against time and error.

Each loading of ``mixed_loadings`` runs with yarns everywhere, with triangles alone, and with yarns in regions. A run is
compared with the one with yarns everywhere: root mean square distance of the nodes of the measured part and of all
nodes in yarn spacings, stored energy, and spectrum of the heights of the wefts in the measured part. The run with yarns
everywhere is repeated from shaken starts, which shows how far from one another runs of the same model end.

Each region made by hand is followed by one of at most as many nodes that the error of the run with triangles alone
chooses. Triangles are matched to the yarns.

    python benchmarks/mixed.py
    python benchmarks/mixed.py corner --size 16 --density 8 --device cuda:0 --rings 1 2 3 --json curve.json
    python benchmarks/mixed.py --read curve.json --plot curve.png
"""

from __future__ import annotations

import argparse
import json
import time
from dataclasses import asdict, dataclass, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from benchmarks.mixed_loadings import LOADINGS, Loading
from benchmarks.mixed_measures import all_nodes, position_error, spectrum_error, wrinkle_spectrum
from benchmarks.mixed_plot import draw
from stitchmesh.compute.device import alone, device_named
from stitchmesh.compute.precision import scalar_named
from stitchmesh.mixed.adaptive_region import AdaptiveRegion
from stitchmesh.mixed.automatic_region import place_yarns
from stitchmesh.mixed.placement.chosen_region import NodeBudget
from stitchmesh.mixed.scene.region_section import RegionSection
from stitchmesh.mixed.scene.scene import SolverSection
from stitchmesh.mixed.scene.scene_fabric import PreparedScene, with_region
from stitchmesh.mixed.simulation import begin_simulation
from stitchmesh.mixed.triangle_run import run_triangles

Numbers = NDArray[np.float64]
ALL, AGAIN, NONE, HAND = "yarns everywhere", "again, shaken", "triangles alone", "by hand"
AUTOMATIC, ADAPTING = "automatic", "adapting"
"""Kinds of regions."""


@dataclass(frozen=True)
class Row:
    """One run against the run with yarns everywhere."""

    loading: str
    region: str
    size: float
    """Size of the region made by hand [cm]."""
    rings: int
    nodes: int
    """Simulated nodes."""
    seconds: float
    newton: int
    """Newton iterations."""
    products: int
    """Products with the matrix."""
    converged: bool
    near: float
    """Root mean square distance in the measured part [yarn spacings]."""
    everywhere: float
    """The same of all nodes."""
    energy: float
    """Stored energy over that of the full run, minus 1."""
    spectrum: float
    """Relative difference of the spectrum of heights in the measured part."""


@dataclass(frozen=True, eq=False)
class End:
    """The end of a run."""

    nodes: Numbers
    """All nodes of the layout."""
    simulated: int
    """Number of nodes that are simulated at the end."""
    energy: float
    seconds: float
    newton: int
    products: int
    converged: bool


def main() -> None:
    """Run the loadings, and print and draw the rows."""
    options = _options()
    rows = [row for name in options.loading for row in _rows(_loading(name, options), options)]
    if options.read:
        rows = [Row(**entry) for entry in json.loads(Path(options.read).read_text())]
    if options.json:
        Path(options.json).write_text(json.dumps([asdict(row) for row in rows], indent=1) + "\n")
    if options.plot:
        draw([asdict(row) for row in rows], options.plot)


def _options() -> argparse.Namespace:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("loading", nargs="*", default=list(LOADINGS), help=", ".join(LOADINGS))
    parser.add_argument("--size", type=float, default=8.0, help="side of the square of the corner [cm]")
    parser.add_argument("--density", type=float, default=4.0, help="its warps and wefts for each cm")
    parser.add_argument("--edge", type=float, default=1.0, help="edges of its triangles [cm]")
    parser.add_argument("--rings", type=int, nargs="+", help="hybrid widths; 1 by default, and 1 and 2 for the corner")
    parser.add_argument("--adapting", action="store_true", help="also regions that change after each load step")
    parser.add_argument("--repeats", type=int, default=2, help="runs from shaken starts")
    parser.add_argument("--tolerance", type=float, default=0.1, help="largest unbalanced force [dyn]")
    parser.add_argument("--device", default="cpu")
    parser.add_argument("--precision", default="float64")
    parser.add_argument("--json", help="file for the rows")
    parser.add_argument("--read", help="rows of an earlier run to draw, in the place of runs")
    parser.add_argument("--plot", help="PNG file for the curves")
    options = parser.parse_args()
    unknown = [name for name in options.loading if name not in LOADINGS]
    if unknown:
        parser.error(f"got the loading {unknown[0]!r}; expected some of {', '.join(LOADINGS)}")
    options.loading = [] if options.read else options.loading
    return options


def _loading(name: str, options: argparse.Namespace) -> Loading:
    solver = SolverSection(
        precision=options.precision, device=options.device, force_tolerance=options.tolerance, most_iterations=2000
    )
    of_corner = {"size": options.size, "density": options.density, "edge": options.edge} if name == "corner" else {}
    return LOADINGS[name](solver, **of_corner)


def _rows(loading: Loading, options: argparse.Namespace) -> list[Row]:
    """Run a loading with all regions."""
    start, cloth = loading.shaken(0), loading.prepared.fabric.cloth
    everything = np.arange(len(cloth.triangles))
    compare = _Comparison(loading, run_scene(with_region(start, everything)))
    rows = [compare.row(ALL, 0.0, with_region(start, everything), compare.full)]
    for seed in range(1, options.repeats + 1):
        again = with_region(loading.shaken(seed), everything)
        rows.append(compare.row(AGAIN, 0.0, again, run_scene(again)))
    none = with_region(start, everything[:0])
    rows.append(compare.row(NONE, 0.0, none, run_scene(none)))
    with alone():
        error = run_triangles(none, *_where(none)).error
    for rings in options.rings or loading.rings:
        for size in loading.sizes:
            hand = with_region(with_rings(start, rings), loading.by_hand(size))
            rows.append(compare.row(HAND, size, hand, run_scene(hand)))
            budget = NodeBudget(nodes=len(hand.region.nodes))
            placed = place_yarns(with_rings(start, rings), error, budget)
            rows.append(compare.row(AUTOMATIC, size, placed, run_scene(placed)))
            if options.adapting:
                adapting = run_scene(with_rings(none, rings, adapt_every=1), budget)
                rows.append(compare.row(ADAPTING, size, with_rings(none, rings), adapting))
    return rows


def with_rings(prepared: PreparedScene, rings: int, adapt_every: int | None = None) -> PreparedScene:
    """A scene with another hybrid width, and a region by errors."""
    section = RegionSection(yarns="automatic", nodes=1, rings=rings, adapt_every=adapt_every)
    return replace(prepared, scene=replace(prepared.scene, region=section))


def _where(prepared: PreparedScene) -> tuple[object, object]:
    """Floating-point type and processor of a scene."""
    solver = prepared.scene.solver
    return scalar_named(solver.precision), device_named(solver.device)


def run_scene(prepared: PreparedScene, budget: NodeBudget | None = None) -> End:
    """Run a scene over all its load steps; a region that adapts keeps to the budget."""
    newton, products, converged = 0, 0, True
    region = AdaptiveRegion(prepared, budget or NodeBudget(nodes=0))
    with alone():
        simulation = begin_simulation(prepared, *_where(prepared))
        began = time.perf_counter()
        while not simulation.done:
            made = simulation.step()
            newton, products = newton + made.newton_iterations, products + made.solve_iterations
            converged = converged and made.converged
            region.look(simulation)
        seconds = time.perf_counter() - began
        vertices, nodes, _sliding = simulation.positions
        energy = sum(simulation.energies().values())
    last = simulation.prepared.region
    everywhere = all_nodes(last, vertices, nodes)
    return End(everywhere, len(last.nodes), energy, seconds, newton, products, converged)


class _Comparison:
    """Compares runs of a loading with the one with yarns everywhere, and prints the rows."""

    def __init__(self, loading: Loading, full: End) -> None:
        self.loading, self.full = loading, full
        yarns = loading.prepared.fabric.yarns
        print(f"{loading.name}: {yarns.node_count} nodes, {len(loading.prepared.fabric.cloth.triangles)} triangles")

    def row(self, kind: str, size: float, prepared: PreparedScene, end: End) -> Row:
        """Return the row of a run."""
        loading, full, near = self.loading, self.full, self.loading.near
        yarns = loading.prepared.fabric.yarns
        waves = [wrinkle_spectrum(yarns, near, one.nodes, (0.0, 0.0, 1.0)) for one in (end, full)]
        row = Row(
            loading.name, kind, size, prepared.scene.region.rings, end.simulated, end.seconds, end.newton,
            end.products, end.converged,
            near=position_error(end.nodes[near], full.nodes[near], loading.spacing),
            everywhere=position_error(end.nodes, full.nodes, loading.spacing),
            energy=end.energy / full.energy - 1.0,
            spectrum=spectrum_error(*waves),
        )  # fmt: skip
        print(
            f"| {row.region}{f' {size:g} cm' if size else ''} | {row.rings} | {row.nodes} | {row.seconds:.1f} | "
            f"{row.products:,} | {row.near:.3f} | {row.everywhere:.3f} | {100.0 * row.energy:+.1f} % | "
            f"{100.0 * row.spectrum:.1f} % |{'' if row.converged else ' not converged'}",
            flush=True,
        )
        return row


if __name__ == "__main__":
    main()
