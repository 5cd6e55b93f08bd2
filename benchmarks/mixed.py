# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Speed and accuracy of mixed yarns and triangles: size and hybrid width of the region against time and error.

A square weave is held along its upper border, and stretched by its lower border, except for the last quarter of it. The
lower right corner there, as large as a triangle, is pulled up, inwards and out of the plane, so that the cloth buckles
and folds beside it. The part that is measured is a square beside the corner. Each run is compared with the run with
yarns everywhere: root mean square distance of the nodes of the measured part and of all nodes in yarn spacings, stored
energy, and spectrum of the heights of the wefts in the measured part. A second full run, which begins with other random
displacements, shows how far two equilibria of the same model are apart.

Each region made by hand, a square at the corner, is followed by one of the same number of nodes that the error of the
run with triangles alone chooses. Triangles are matched to the yarns first.

    python benchmarks/mixed.py
    python benchmarks/mixed.py --size 20 --density 8 --edge 1 --device cuda:0 --regions 3 6 9 12 --json curve.json
"""

from __future__ import annotations

import argparse
import json
import time
from dataclasses import asdict, dataclass, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

import stitchmesh as sm
from benchmarks.mixed_measures import all_nodes, position_error, spectrum_error, wrinkle_spectrum
from stitchmesh.compute.device import alone, device_named
from stitchmesh.compute.precision import scalar_named
from stitchmesh.mixed.enrichment.region import Region, region_around
from stitchmesh.mixed.placement.chosen_region import NodeBudget, choose_triangles
from stitchmesh.mixed.placement.error_indicator import indicate_errors
from stitchmesh.mixed.scene.cloth_section import ClothSection
from stitchmesh.mixed.scene.motion_section import AttachmentSection, Keyframe
from stitchmesh.mixed.scene.region_section import BoxSection
from stitchmesh.mixed.scene.scene import Scene, SolverSection
from stitchmesh.mixed.scene.scene_fabric import PreparedScene, prepare
from stitchmesh.mixed.scene.yarns_section import YarnsSection
from stitchmesh.mixed.simulation import begin_simulation

Numbers = NDArray[np.float64]
PULL = (-0.08, 0.04, 0.08)
"""Displacement of the corner, in sizes of the cloth."""
STRETCH = 0.01
"""Displacement of the lower border, in sizes of the cloth."""
DISTURBANCE = 1e-3
"""Random displacements at the start [cm]; the second run with yarns everywhere begins with twice as much."""


@dataclass(frozen=True)
class Row:
    """One run against the run with yarns everywhere."""

    region: str
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

    vertices: Numbers
    nodes: Numbers
    """All nodes of the layout."""
    energy: float
    seconds: float
    newton: int
    products: int
    converged: bool


def main() -> None:
    """Run the regions and print the table."""
    options = _options()
    base = _prepared(options)
    cloth, yarns = base.fabric.cloth, base.fabric.yarns
    print(f"{yarns.node_count} nodes, {len(cloth.triangles)} triangles, {len(cloth.vertices)} vertices")
    full = _run(base, _region(base, np.arange(len(cloth.triangles)), 1), options)
    near = _near(base, options)
    rows = [_row("all yarns", 0, base, _region(base, np.arange(len(cloth.triangles)), 1), full, full, near, options)]
    again = _prepared(options, 2.0 * DISTURBANCE)
    everywhere = _region(base, np.arange(len(cloth.triangles)), 1)
    rows.append(_row("yarns again", 0, base, everywhere, _run(again, everywhere, options), full, near, options))
    none = _region(base, np.zeros(0, dtype=np.int64), 1)
    alone_run = _run(base, none, options)
    rows.append(_row("triangles", 0, base, none, alone_run, full, near, options))
    for rings in options.rings:
        for size in options.regions:
            region = _region(base, _corner(base, size, options), rings)
            rows.append(
                _row(f"hand {size:g} cm", rings, base, region, _run(base, region, options), full, near, options)
            )
            chosen = _automatic(base, alone_run.vertices, len(region.nodes), rings)
            region = _region(base, chosen, rings)
            rows.append(_row("automatic", rings, base, region, _run(base, region, options), full, near, options))
    if options.json:
        Path(options.json).write_text(json.dumps([asdict(row) for row in rows], indent=1) + "\n")


def _options() -> argparse.Namespace:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--size", type=float, default=8.0, help="side of the cloth [cm]")
    parser.add_argument("--density", type=float, default=4.0, help="warps and wefts for each cm")
    parser.add_argument("--edge", type=float, default=1.0, help="edges of the triangles [cm]")
    parser.add_argument("--near", type=float, default=3.0, help="side of the part that is measured [cm]")
    parser.add_argument("--regions", type=float, nargs="+", default=[3.0, 4.0, 5.0], help="sides of the regions [cm]")
    parser.add_argument("--rings", type=int, nargs="+", default=[1, 2], help="hybrid widths")
    parser.add_argument("--material", default="gong-1", help="name of the yarn")
    parser.add_argument("--tolerance", type=float, default=1.0, help="largest unbalanced force [dyn]")
    parser.add_argument("--device", default="cpu")
    parser.add_argument("--precision", default="float64")
    parser.add_argument("--json", help="file for the table")
    return parser.parse_args()


def _prepared(options: argparse.Namespace, disturbance: float = DISTURBANCE) -> PreparedScene:
    """The scene, with triangles that are matched to the yarns."""
    size, far = options.size, options.size + 1.0
    strip = 0.6 / options.density  # holds the outermost yarn, or the outermost vertices
    corner = BoxSection(low=(size - options.edge, -1.0, -1.0), high=(far, options.edge, 1.0))
    pull = tuple(part * size for part in PULL)
    border = BoxSection(low=(-1.0, -1.0, -1.0), high=(0.75 * size, strip, 1.0))
    down = Keyframe(time=1.0, displacement=(0.0, -STRETCH * size, 0.0))
    scene = Scene(
        cloth=ClothSection(rectangle=(size, size), edge_length=options.edge),
        yarns=YarnsSection(weave="plain", ends=options.density, picks=options.density, material=options.material),
        gravity=(0.0, 0.0, 0.0),
        disturbance=disturbance,
        attachments=(
            AttachmentSection(boxes=(BoxSection(low=(-1.0, size - strip, -1.0), high=(far, far, 1.0)),)),
            AttachmentSection(boxes=(border,), keyframes=(Keyframe(time=0.0), down)),
            AttachmentSection(boxes=(corner,), keyframes=(Keyframe(time=0.0), Keyframe(time=1.0, displacement=pull))),
        ),
        solver=SolverSection(
            precision=options.precision, device=options.device, force_tolerance=options.tolerance, most_iterations=2000
        ),
    )
    prepared = prepare(scene)
    matched = _match(options).material
    return replace(prepared, fabric=replace(prepared.fabric, cloth_material=matched))


def _match(options: argparse.Namespace) -> sm.ClothMatch:
    yarn = sm.FabricMaterials.of(sm.CrossingMaterial.named(options.material))
    cell = sm.weave_cell([[1, 0], [0, 1]], ends=options.density, picks=options.density, materials=yarn)
    return sm.match_cloth(cell)


def _region(prepared: PreparedScene, chosen: NDArray[np.int64], rings: int) -> Region:
    cloth, yarns = prepared.fabric.cloth, prepared.fabric.yarns
    return region_around(cloth.triangles, len(cloth.vertices), yarns.triangle, yarns.barycentric, chosen, rings=rings)


def _corner(prepared: PreparedScene, size: float, options: argparse.Namespace) -> NDArray[np.int64]:
    """Triangles in the square of a size at the corner that is pulled."""
    centre = prepared.fabric.cloth.rest.mean(axis=1)
    return np.flatnonzero((centre[:, 0] > options.size - size) & (centre[:, 1] < size))


def _near(prepared: PreparedScene, options: argparse.Namespace) -> NDArray[np.bool_]:
    """The nodes of the part that is measured, without the corner itself, which is held."""
    position = prepared.fabric.yarns.position
    right, low = options.size - position[:, 0], position[:, 1]
    corner = (right < options.edge) & (low < options.edge)
    return np.array((right < options.near) & (low < options.near) & ~corner)


def _automatic(prepared: PreparedScene, vertices: Numbers, nodes: int, rings: int) -> NDArray[np.int64]:
    """The triangles that the error of triangles alone chooses for a number of nodes."""
    fabric = prepared.fabric
    error = indicate_errors(fabric.cloth, vertices, fabric.cloth_material).total
    triangles, home = fabric.cloth.triangles, fabric.yarns.triangle
    return choose_triangles(triangles, home, error, NodeBudget(nodes=nodes), rings=rings)


def _run(prepared: PreparedScene, region: Region, options: argparse.Namespace) -> End:
    """Run the scene with yarns in a region."""
    device, scalar = device_named(options.device), scalar_named(options.precision)
    with alone():
        simulation = begin_simulation(replace(prepared, region=region), scalar, device)
        began = time.perf_counter()
        made = simulation.step()
        seconds = time.perf_counter() - began
        vertices, nodes, _sliding = simulation.positions
        energy = sum(simulation.energies().values())
    everywhere = all_nodes(region, vertices, nodes)
    return End(vertices, everywhere, energy, seconds, made.newton_iterations, made.solve_iterations, made.converged)


def _row(
    name: str,
    rings: int,
    prepared: PreparedScene,
    region: Region,
    end: End,
    full: End,
    near: NDArray[np.bool_],
    options: argparse.Namespace,
) -> Row:
    """Compare a run with the full one, and print the row."""
    yarns, spacing = prepared.fabric.yarns, 1.0 / options.density
    waves = [wrinkle_spectrum(yarns, near, one.nodes, (0.0, 0.0, 1.0)) for one in (end, full)]
    row = Row(
        name, rings, len(region.nodes), end.seconds, end.newton, end.products, end.converged,
        near=position_error(end.nodes[near], full.nodes[near], spacing),
        everywhere=position_error(end.nodes, full.nodes, spacing),
        energy=end.energy / full.energy - 1.0,
        spectrum=spectrum_error(*waves),
    )  # fmt: skip
    print(
        f"{row.region:<12} rings {row.rings}  {row.nodes:7d} nodes  {row.seconds:8.2f} s  {row.newton:4d} Newton  "
        f"{row.products:7d} products  near {row.near:7.4f}  everywhere {row.everywhere:7.4f} spacings  "
        f"energy {100.0 * row.energy:+7.2f} %  spectrum {100.0 * row.spectrum:6.2f} %"
        f"{'' if row.converged else '  not converged'}",
        flush=True,
    )
    return row


if __name__ == "__main__":
    main()
