# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Scenes with triangles alone, with yarns in a region, and with yarns everywhere: errors, time and memory.

Runs scenes of ``examples/mixed``, each run in a process of its own, so that its memory is known. ``--density`` takes
the place of that of the scene (``divisions`` for stitches). A run ends after ``--seconds`` with the state that it has
reached. The table has, for each run, the nodes that are simulated (full + hybrid), the work and the time of the steps
or equilibria (that of a run with triangles alone at the start stands in brackets), the time of all processors from the
start of the program to its end, which depends less than the seconds on what else runs on the machine, the error of the
last step [cm/s] or the largest force that is not balanced [dyn], memory (the largest of the process, and on a GPU that
of Warp's pool), and root mean square distances from the run with yarns everywhere, in spacings of yarns or wales: in
the region of interest, its full-yarn nodes, and of all nodes. With ``-o`` the folders of the runs are kept, for
``stitchmesh view`` or pictures (``--picture``).
"""

from __future__ import annotations

import json
import subprocess
import sys
import tempfile
import time
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Literal

import numpy as np
import warp as wp
from tyro.conf import Positional

from benchmarks.measures.mixed.node_errors import all_nodes, position_error
from benchmarks.options import OptionalOutput
from benchmarks.places import MIXED_SCENES, RUN
from benchmarks.table import Rows, note
from stitchmesh.mixed.drape import drape
from stitchmesh.mixed.draped_folder import read_draped
from stitchmesh.mixed.enrichment.region import YARNS
from stitchmesh.mixed.scene.scene import Scene
from stitchmesh.mixed.scene.scene_file import read_scene
from stitchmesh.run import Run
from stitchmesh.time_limit import TimeLimit, limited_to

RUNS = {"triangles": "none", "mixed": "chosen", "yarns": "all"}
"""Names of the runs, and where each of them has yarns."""
ROW, PLACES = "row.json", "places.npz"
"""Files of a run: its numbers, and the places of all nodes of the layout."""


@dataclass(frozen=True)
class Options:
    """What is measured."""

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
    picture: bool = False
    """draw the runs side by side"""
    only: Literal["triangles", "mixed", "yarns"] | None = None
    """one run in this process, which this program starts itself"""


def mixed_scenes(given: Options) -> Rows:
    """Run the scenes, or one run of one scene in this process, and print the tables."""
    if given.only:
        assert given.output is not None  # the process of one run is told its folder
        _run(given.scenes[0], given.only, given, given.output)
        return
    with tempfile.TemporaryDirectory() as temporary:
        for name in given.scenes:
            folder = Path(given.output or temporary) / name
            for run in given.runs:
                options = ["--only", run, "-o", str(folder / run), *_passed_on(given)]
                subprocess.run([sys.executable, str(RUN), "mixed-scenes", name, *options], check=True)
            yield from _table(name, folder, given.runs)
            if given.picture:
                from stitchmesh.render.draped.picture import render_draped

                runs = [(run, read_draped(folder / run)) for run in given.runs]
                render_draped(runs, folder / "preview.png", size=(700, 700))


def _passed_on(given: Options) -> list[str]:
    """The options of the process of one run."""
    options = ["--device", given.device, "--seconds", str(given.seconds)]
    return options + ([] if given.density is None else ["--density", str(given.density)])


def scene_of(name: str, run: str, density: float | None, device: str) -> Scene:
    """Return a scene with the yarns of a run, at a density."""
    scene = read_scene(MIXED_SCENES / f"{name}.toml")
    yarns, kind = scene.yarns, RUNS[run]
    if density is not None:
        finer = {"divisions": round(density)} if yarns.knit == "stitches" else {"density": density}
        yarns = replace(yarns, **finer)
    region: dict[str, Any] = {"yarns": kind}
    return replace(
        scene, yarns=yarns, region=replace(scene.region, **region), solver=replace(scene.solver, device=device)
    )


def spacing_of(scene: Scene) -> float:
    """Return the distance of two yarns of a weave, or of two wales [cm]."""
    yarns = scene.yarns
    if yarns.weave is not None:
        return 1.0 / (yarns.ends * yarns.density)
    if yarns.knit == "stitches":
        assert scene.cloth.stitch_width is not None  # a cloth of stitches has one
        return scene.cloth.stitch_width / yarns.divisions
    return 1.0 / (yarns.wales * yarns.density)


def _run(name: str, run: str, given: Options, folder: Path) -> None:
    """Make one run and write its numbers and places."""
    scene = scene_of(name, run, given.density, given.device)
    folder.mkdir(parents=True, exist_ok=True)

    def progress(_stage: str, _part: float, said: str) -> None:
        note(f"{name}, {run}: {said}")

    with limited_to(TimeLimit(given.seconds)):
        made = drape(scene, folder, run=Run(progress))
    region, end, report = made.prepared.region, made.end, made.report["mixed"]
    np.savez(folder / PLACES, places=all_nodes(region, end.vertices, end.nodes), own=region.node_kind == YARNS)
    pool = wp.get_mempool_used_mem_high(wp.get_device(given.device)) if given.device.startswith("cuda") else 0
    row = {**report, "device_memory": pool, "spacing": spacing_of(scene), "processor": time.process_time()}
    (folder / ROW).write_text(json.dumps(row, indent=1) + "\n")


def _table(name: str, folder: Path, runs: Sequence[str]) -> Rows:
    rows = {run: json.loads((folder / run / ROW).read_text()) for run in runs}
    places = {run: np.load(folder / run / PLACES) for run in runs}
    names = "scene", "run", "nodes", "Newton", "products", "seconds", "processor s", "error", "memory MB", "GPU MB"
    yield ""
    yield *names, "region", "all"
    for run in runs:
        row = rows[run]
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
