# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Speed and accuracy of mixed yarns and triangles: size and hybrid width of the region against time and error.

Each loading of ``mixed_loadings`` runs with yarns everywhere, with triangles alone, and with yarns in regions. A run is
compared with the one with yarns everywhere: root mean square distance of the nodes of the measured part and of all
nodes in yarn spacings, stored energy, and spectrum of the heights of the wefts in the measured part. The run with yarns
everywhere is repeated from shaken starts, which shows how far from one another runs of the same model end.

Each region made by hand is followed by one of at most as many nodes that the error of the run with triangles alone
chooses. Triangles are matched to the yarns.
"""

from __future__ import annotations

import time
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray
from tyro.conf import Positional

from benchmarks.measures.mixed.node_errors import all_nodes, position_error, spectrum_error, wrinkle_spectrum
from benchmarks.scenes.loadings import LOADINGS, Loading
from benchmarks.table import Rows
from stitchmesh.compute.device import alone, device_named
from stitchmesh.compute.precision import scalar_named
from stitchmesh.mixed.adaptive_region import AdaptiveRegion
from stitchmesh.mixed.automatic_region import place_yarns, run_triangles
from stitchmesh.mixed.placement.chosen_region import NodeBudget
from stitchmesh.mixed.scene.region_section import RegionSection
from stitchmesh.mixed.scene.scene import SceneSolverSection
from stitchmesh.mixed.scene.scene_fabric import PreparedScene, with_region
from stitchmesh.mixed.simulation import begin_simulation

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


HEAD = (
    "region", "rings", "nodes", "s", "products", "distance", "everywhere", "energy", "spectrum", "",
)  # fmt: skip


@dataclass(frozen=True)
class Options:
    """What is measured."""

    loading: Positional[tuple[str, ...]] = tuple(LOADINGS)
    size: float = 8.0
    """side of the square of the corner [cm]"""
    density: float = 4.0
    """its warps and wefts for each cm"""
    edge: float = 1.0
    """edges of its triangles [cm]"""
    rings: tuple[int, ...] = ()
    """hybrid widths; 1 by default, and 1 and 2 for the corner"""
    adapting: bool = False
    """also regions that change after each load step"""
    repeats: int = 2
    """runs from shaken starts"""
    tolerance: float = 0.1
    """largest unbalanced force [dyn]"""
    device: str = "cpu"
    precision: str = "float64"
    plot: str | None = None
    """PNG file for the curves"""


def mixed(options: Options) -> Rows:
    """Run the loadings, and print and draw the rows."""
    rows = []
    for name in options.loading:
        loading = _loading(name, options)
        start, cloth = loading.shaken(0), loading.prepared.fabric.cloth
        yield f"{name}: {loading.prepared.fabric.yarns.node_count} nodes, {len(cloth.triangles)} triangles"
        yield HEAD
        full = run_scene(with_region(start, np.arange(len(cloth.triangles))))
        for row in runs(loading, start, full, options):
            rows.append(row)
            yield cells_of(row)
    if options.plot:
        draw(rows, options.plot)


def _loading(name: str, options: Options) -> Loading:
    solver = SceneSolverSection(
        precision=options.precision, device=options.device, force_tolerance=options.tolerance, most_iterations=2000
    )
    of_corner = {"size": options.size, "density": options.density, "edge": options.edge} if name == "corner" else {}
    return LOADINGS[name](solver, **of_corner)


def runs(loading: Loading, start: PreparedScene, full: End, options: Options) -> Iterator[Row]:
    """Run a loading with all regions, and yield a row for each."""
    everything = np.arange(len(loading.prepared.fabric.cloth.triangles))

    def row(kind: str, size: float, prepared: PreparedScene, end: End) -> Row:
        return compared(loading, full, kind, size, prepared, end)

    yield row(ALL, 0.0, with_region(start, everything), full)
    for seed in range(1, options.repeats + 1):
        again = with_region(loading.shaken(seed), everything)
        yield row(AGAIN, 0.0, again, run_scene(again))
    none = with_region(start, everything[:0])
    yield row(NONE, 0.0, none, run_scene(none))
    with alone():
        error = run_triangles(none, *_where(none)).error
    for rings in options.rings or loading.rings:
        for size in loading.sizes:
            hand = with_region(with_rings(start, rings), loading.by_hand(size))
            yield row(HAND, size, hand, run_scene(hand))
            budget = NodeBudget(nodes=len(hand.region.nodes))
            placed = place_yarns(with_rings(start, rings), error, budget)
            yield row(AUTOMATIC, size, placed, run_scene(placed))
            if options.adapting:
                adapting = run_scene(with_rings(none, rings, adapt_every=1), budget)
                yield row(ADAPTING, size, with_rings(none, rings), adapting)


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


def compared(loading: Loading, full: End, kind: str, size: float, prepared: PreparedScene, end: End) -> Row:
    """Compare a run with the one that has yarns everywhere."""
    near = loading.near
    waves = [wrinkle_spectrum(loading.prepared.fabric.yarns, near, one.nodes, (0.0, 0.0, 1.0)) for one in (end, full)]
    return Row(
        loading.name, kind, size, prepared.scene.region.rings, end.simulated, end.seconds, end.newton,
        end.products, end.converged,
        near=position_error(end.nodes[near], full.nodes[near], loading.spacing),
        everywhere=position_error(end.nodes, full.nodes, loading.spacing),
        energy=end.energy / full.energy - 1.0,
        spectrum=spectrum_error(*waves),
    )  # fmt: skip


def cells_of(row: Row) -> tuple[object, ...]:
    """Return the cells of a row, in the order of ``HEAD``."""
    return (
        f"{row.region}{f' {row.size:g} cm' if row.size else ''}", row.rings, row.nodes, f"{row.seconds:.1f}",
        f"{row.products:,}", f"{row.near:.3f}", f"{row.everywhere:.3f}", f"{100.0 * row.energy:+.1f} %",
        f"{100.0 * row.spectrum:.1f} %", "" if row.converged else "not converged",
    )  # fmt: skip


MEASURES = (
    ("near", "rms distance in the measured part [spacings]", 1.0),
    ("spectrum", "difference of the spectrum of wrinkles [%]", 100.0),
    ("energy", "difference of the stored energy [%]", 100.0),
    ("products", "products (line: yarns everywhere)", 1.0),
)
"""Columns of the picture: field of a row, name and factor."""
STYLES = {HAND: ("s", "tab:orange"), AUTOMATIC: ("o", "tab:blue"), ADAPTING: ("^", "tab:green")}
"""Marker and colour of each kind of region."""
WIDTHS = {1: "-", 2: "--", 3: ":"}
"""Line of each hybrid width in rings."""


def draw(rows: Sequence[Row], path: str) -> None:
    """Draw one row of panels for each loading: each measure over the number of simulated nodes."""
    import matplotlib

    matplotlib.use("Agg")
    import matplotlib.pyplot as plt

    loadings = list(dict.fromkeys(row.loading for row in rows))
    shape = len(loadings), len(MEASURES)
    figure, panels = plt.subplots(*shape, figsize=(3.6 * shape[1], 2.9 * shape[0] + 0.5), squeeze=False)
    for line, loading in zip(panels, loadings, strict=True):
        own = [row for row in rows if row.loading == loading]
        for panel, measure in zip(line, MEASURES, strict=True):
            _draw_panel(panel, own, *measure)
        line[0].set_ylabel(loading, weight="bold", fontsize=11)
    for panel in panels[-1]:
        panel.set_xlabel("simulated yarn nodes [%]")
    handles, labels = panels[0][0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="lower center", ncols=len(labels), frameon=False, fontsize=9)
    figure.tight_layout(rect=(0, 0.5 / (2.9 * shape[0] + 0.5), 1, 1))
    figure.savefig(path, dpi=110)
    plt.close(figure)


def _draw_panel(panel: Any, rows: list[Row], entry: str, name: str, factor: float) -> None:
    """Draw one measure of a loading, with the run of triangles at the left and the full run at the right."""
    full = next(row for row in rows if row.region == ALL)
    triangles = next(row for row in rows if row.region == NONE)
    for kind, (marker, colour) in STYLES.items():
        for rings in sorted({row.rings for row in rows if row.region == kind}):
            chosen = [row for row in rows if row.region == kind and row.rings == rings]
            chosen.sort(key=lambda row: row.nodes)
            panel.plot(
                [100.0 * row.nodes / full.nodes for row in chosen],
                [factor * abs(getattr(row, entry)) for row in chosen],
                marker=marker, color=colour, linestyle=WIDTHS.get(rings, "-."), markersize=5,
                markerfacecolor=colour if rings == 1 else "none",
                label=f"{kind}, {rings} ring{'s' if rings > 1 else ''}",
            )  # fmt: skip
    if entry == "products":
        panel.axhline(getattr(full, entry), color="black", linewidth=1, label=ALL)
    else:
        panel.axhline(factor * abs(getattr(triangles, entry)), color="tab:gray", linewidth=1, label=NONE)
        again = [factor * abs(getattr(row, entry)) for row in rows if row.region == AGAIN]
        if again:
            panel.axhline(max(again), color="black", linestyle=":", linewidth=1, label="yarns everywhere, shaken")
        panel.set_yscale("log")
    panel.set_title(name, fontsize=9)
    panel.set_xlim(0.0, 105.0)
