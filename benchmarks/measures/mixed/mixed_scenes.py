# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Scenes of ``examples/mixed`` with triangles alone, with yarns in a region and with yarns everywhere.

- ``regions``: each run in a process of its own, so that its memory is known. ``--density`` takes the place of that of
  the scene (``divisions`` for stitches). A run ends after ``--seconds`` with the state that it has reached. The table
  has, for each run, the nodes that are simulated (full + hybrid), the work and the time of the steps or equilibria
  (that of a run with triangles alone at the start stands in brackets), the time of all processors from the start of the
  process to its end, which depends less than the seconds on what else runs on the machine, the error of the last step
  [cm/s] or the largest force that is not balanced [dyn], memory (the largest of the process, and on a GPU that of
  Warp's pool), and root mean square distances from the run with yarns everywhere, in spacings of yarns or wales: in the
  region of interest, its full-yarn nodes, and of all nodes. With ``-o`` the folders of the runs are kept, for
  ``stitchmesh view``.
- ``starts``: yarns that begin on the layout, and on the result of the triangles: products of the linear solves, those
  of the triangles in brackets, and energies at the end. With ``--held`` nothing that is attached is released.
- ``models``: crossings of ``gong-1`` against B-splines on the patch of ``loops.toml``. The time is that of all cores
  together, without the preparation of the scene.
"""

from __future__ import annotations

import tempfile
import time
from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Literal

import numpy as np
import warp as wp
from tyro.conf import Positional

from benchmarks.measures.mixed.node_errors import all_nodes, position_error
from benchmarks.options import OptionalOutput
from benchmarks.own_process import results_of
from benchmarks.places import MIXED_SCENES
from benchmarks.table import Rows, note
from stitchmesh.mixed.drape import drape
from stitchmesh.mixed.enrichment.region import YARNS
from stitchmesh.mixed.scene.region_section import RegionSection
from stitchmesh.mixed.scene.scene import Scene, read_scene
from stitchmesh.mixed.scene.scene_fabric import prepare
from stitchmesh.run import QUIET, Run
from stitchmesh.time_limit import TimeLimit, limited_to

RUNS = {"triangles": "none", "mixed": "chosen", "yarns": "all"}
"""Names of the runs, and where each of them has yarns."""
PLACES = "places.npz"
"""File of a run with the places of all nodes of the layout."""


@dataclass(frozen=True)
class Options:
    """The scenes and their runs."""

    scenes: Positional[tuple[str, ...]]
    """names of scenes of examples/mixed, such as shirt"""
    runs: tuple[Literal["triangles", "mixed", "yarns"], ...] = ("triangles", "mixed", "yarns")
    density: float | None = None
    """that of the scene by default"""
    seconds: float = 3600.0
    """time of each run"""
    device: str = "cpu"
    output: OptionalOutput = None
    """folder that keeps the runs"""


@dataclass(frozen=True)
class SceneRun:
    """One run of a scene."""

    name: str
    kind: str
    options: Options
    folder: Path

    @property
    def scene(self) -> Scene:
        """The scene with the yarns of the run."""
        scene, density = read_scene(MIXED_SCENES / f"{self.name}.toml"), self.options.density
        yarns = scene.yarns
        if density is not None:
            finer = {"divisions": round(density)} if yarns.knit == "stitches" else {"density": density}
            yarns = replace(yarns, **finer)
        region: dict[str, Any] = {"yarns": RUNS[self.kind]}
        solver = replace(scene.solver, device=self.options.device)
        return replace(scene, yarns=yarns, region=replace(scene.region, **region), solver=solver)


def regions(given: Options) -> Rows:
    """Compare triangles alone, yarns in a region and yarns everywhere."""
    with tempfile.TemporaryDirectory() as temporary:
        for name in given.scenes:
            folder = Path(given.output or temporary) / name
            runs = [SceneRun(name, kind, given, folder / kind) for kind in given.runs]
            found = {}
            for run, rows, why in results_of(drape_run, runs):
                if rows:
                    found[run.kind] = rows[0]
                else:
                    yield f"{name}, {run.kind}: {why}"
            yield from _table(name, folder, found)


def drape_run(run: SceneRun) -> Iterator[dict[str, Any]]:
    """Make one run, write its places, and yield its numbers."""
    scene = run.scene
    run.folder.mkdir(parents=True, exist_ok=True)

    def progress(_stage: str, _part: float, said: str) -> None:
        note(f"{run.name}, {run.kind}: {said}")

    with limited_to(TimeLimit(run.options.seconds)):
        made = drape(scene, run.folder, run=Run(progress))
    region, end, report = made.prepared.region, made.end, made.report["mixed"]
    places = all_nodes(region, end.vertices, end.nodes)
    np.savez(run.folder / PLACES, places=places, own=region.node_kind == YARNS)
    device = run.options.device
    pool = wp.get_mempool_used_mem_high(wp.get_device(device)) if device.startswith("cuda") else 0
    yield {**report, "device_memory": pool, "spacing": spacing_of(scene), "processor": time.process_time()}


def spacing_of(scene: Scene) -> float:
    """Return the distance of two yarns of a weave, or of two wales [cm]."""
    yarns = scene.yarns
    if yarns.weave is not None:
        return 1.0 / (yarns.ends * yarns.density)
    if yarns.knit == "stitches":
        assert scene.cloth.stitch_width is not None  # a cloth of stitches has one
        return scene.cloth.stitch_width / yarns.divisions
    return 1.0 / (yarns.wales * yarns.density)


def _table(name: str, folder: Path, rows: dict[str, dict[str, Any]]) -> Rows:
    places = {run: np.load(folder / run / PLACES) for run in rows}
    names = "scene", "run", "nodes", "Newton", "products", "seconds", "processor s", "error", "memory MB", "GPU MB"
    yield ""
    yield *names, "region", "all"
    for run, row in rows.items():
        errors = [_error(places, run, own, row["spacing"]) for own in (True, False)]
        nodes = f"{row['yarn_nodes_full']:,} + {row['yarn_nodes_hybrid']:,}"
        triangles = row.get("triangle_run", {}).get("seconds")
        seconds = f"{row['seconds']:.1f}" + (f" ({triangles:.1f})" if triangles is not None else "")
        memory = f"{row['memory_bytes'] / 1e6:,.0f}", f"{row['device_memory'] / 1e6:,.0f}"
        work = row["newton_iterations"], f"{row['solve_iterations']:,}", seconds, f"{row['processor']:.1f}"
        yield name, run, nodes, *work, f"{row['error']:.3g}", *memory, *errors


def _error(places: dict[str, Any], run: str, own: bool, spacing: float) -> str:
    """Distance from the run with yarns everywhere, of the nodes of the region or of all."""
    if "yarns" not in places:
        return "-"
    inside = places["mixed"]["own"] if own and "mixed" in places else slice(None)
    return f"{position_error(places[run]['places'][inside], places['yarns']['places'][inside], spacing):.3f}"


def starts(
    scenes: tuple[Path, ...],
    /,
    *,
    regions: tuple[Literal["chosen", "all"], ...] = ("chosen",),
    nodes: int | None = None,
    held: bool = False,
) -> Rows:
    """Compare starts on the layout and on the result of the triangles.

    Args:
        nodes: an automatic region of so many yarn nodes
        held: release no attachment
    """
    yield "scene", "yarns", "products from the layout", "from the triangles", "energies [erg]"
    for path in scenes:
        scene = read_scene(path)
        if held:
            scene = replace(scene, attachments=tuple(replace(each, release=None) for each in scene.attachments))
        if nodes is not None:
            scene = replace(scene, region=RegionSection(yarns="automatic", nodes=nodes))
        for region in regions if nodes is None else ["automatic"]:
            found = []
            for start in ("layout", "triangles"):
                chosen: dict[str, Any] = {"yarns": region, "start": start}
                made = drape(replace(scene, region=replace(scene.region, **chosen)))
                found.append(made.report["mixed"])
            energies = ", ".join(f"{each['energy']:.6g}" for each in found)
            yield path.name, region, *map(products_of, found), energies


def products_of(report: dict[str, Any]) -> str:
    """Return the products of a run, with those of its triangles in brackets, and whether it converged."""
    triangles = f" (+ {report['triangle_run']['solve_iterations']:,})" if "triangle_run" in report else ""
    return f"{report['solve_iterations']:,}{triangles}" + ("" if report["converged"] else ", not converged")


def models() -> Rows:
    """Compare crossings and B-splines."""
    scene = read_scene(MIXED_SCENES / "loops.toml")
    crossings = replace(scene.yarns, model="crossings", loop_length=None, material="gong-1")
    yield "yarns", "model", "nodes simulated", "Newton iterations", "products", "processor time [s]"
    for place, region in (("region", scene.region), ("everywhere", RegionSection(yarns="all"))):
        for model, yarns in (("crossings", crossings), ("B-splines", scene.yarns)):
            chosen = replace(scene, region=region, yarns=yarns)
            prepared = prepare(chosen).fabric
            began = time.process_time()
            made = drape(chosen, cloth=prepared.cloth, yarns=prepared.yarns, run=QUIET)
            seconds, found = time.process_time() - began, made.report["mixed"]
            nodes = found["yarn_nodes_full"] + found["yarn_nodes_hybrid"]
            ended = "" if found["converged"] else " (not converged)"
            work = f"{found['newton_iterations']}{ended}", f"{found['solve_iterations']:,}"
            yield place, model, f"{nodes:,}", *work, f"{seconds:.0f}"


ACTIONS = (regions, starts, models)
