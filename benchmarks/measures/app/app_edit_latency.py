# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Latency of edits in the application: from a click on a stitch to the changed picture in a real browser.

The dress at a stitch width of 0.78 cm has about 20,000 faces. For each edit the program clicks at stitches on the
front, undoes the edit by its key, and prints the least and the median of the times in milliseconds. Other programs on
the machine change the median, and hardly the least:

- *server*: from the event of the click to the last message that the page sends;
- *scripts*: what the scripts of the page take from the click to the picture;
- *sent*: from the release of the mouse button in the browser until the browser has the new colours and positions;
- *drawn*: until the first frame that shows them has been drawn. On a machine without graphics card the browser draws
  in software, which takes most of this time.
"""

from __future__ import annotations

import tempfile
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.scenes.garments import Garment
from benchmarks.table import Rows
from stitchmesh.app.pages.edit.edit_page import EditPage
from stitchmesh.app.project.project import Project
from stitchmesh.io import write_stitches
from stitchmesh.mesh import StitchMesh
from stitchmesh.mesh.stitch import Stitch
from tests.app.browser import Rig, rig_on, started_browser

RUNS = 9
"""Number of stitches at which each edit is tried."""
WATCH = """() => {
  const S = window.stitchmesh, B = window.bench = { clicked: 0, sent: 0, drawn: 0 };
  const frame = () => window.__viserTestpoints.rendererInfo.render.frame;
  window.addEventListener("pointerup", () => Object.assign(B, { clicked: performance.now(), sent: 0, drawn: 0 }), true);
  const apply = S.applyColours;
  S.applyColours = () => {
    const waited = Object.keys(S.wanted).length;
    apply();
    const done = waited && !Object.keys(S.wanted).length;
    if (done && B.clicked) Object.assign(B, { sent: performance.now(), at: frame() });
  };
  const watch = () => {
    if (B.sent && !B.drawn && frame() > B.at) B.drawn = performance.now();
    requestAnimationFrame(watch);
  };
  watch();
}"""
"""Script that records when a click ended, when new colours were applied, and when a frame was drawn after that."""
CASES: list[tuple[str, Callable[[Rig], None]]] = [
    ("paint a purl", lambda rig: rig.act("stitch", "p")),
    ("paint a row", lambda rig: rig.choose("Brush", "Row")),
    ("paint a yarn", lambda rig: rig.act("tool", "Paint yarns")),
    ("insert a row", lambda rig: rig.act("tool", "Rows and wales")),
    ("insert a wale, whole", lambda rig: rig.choose("Edit of rows", "Insert a wale")),
    ("split an edge", lambda rig: rig.choose("Edit of loops", "Split an edge")),
    ("bobble", lambda rig: rig.choose("Edit of loops", "Bobble")),
]
"""Edits, and what is pressed before them, one after another."""


def middles(fabric: StitchMesh) -> np.ndarray:
    """Middles of stitches on the front that no other part hides, shape (RUNS, 3)."""
    centre = np.add.reduceat(fabric.corner_position, fabric.face_start[:-1]) / np.diff(fabric.face_start)[:, None]
    area = fabric.face_vector_area / np.linalg.norm(fabric.face_vector_area, axis=1, keepdims=True)
    size = np.ptp(centre, axis=0)
    inner = (abs(centre[:, 0]) < 0.1 * size[0]) & (fabric.stitch == Stitch.KNIT) & (area[:, 2] > 0.7)
    height = (centre[:, 1] - centre[:, 1].min()) / size[1]
    faces = np.flatnonzero(inner & (height > 0.2) & (height < 0.6))
    return centre[np.random.default_rng(0).permutation(faces)[:RUNS]]


def script_time(inspector: Any) -> float:
    """How long scripts of the page have run since it was loaded [ms]."""
    metrics = inspector.send("Performance.getMetrics")["metrics"]
    return 1e3 * next(metric["value"] for metric in metrics if metric["name"] == "ScriptDuration")


def timed_click(rig: Rig, point: np.ndarray, served: list[float], inspector: Any) -> tuple[float, ...] | None:
    """Click, and return the four times [ms]; None if the edit was refused."""
    page: Any = rig.browser_page
    before = len(rig.app.project.edits)
    place = rig.on_page(point)
    page.mouse.move(*place)
    page.wait_for_timeout(150)
    served.clear()
    scripts = script_time(inspector)
    page.mouse.click(*place)
    rig.settle()
    if len(rig.app.project.edits) == before:
        return None
    page.wait_for_function("() => window.bench.drawn > 0")
    scripts = script_time(inspector) - scripts
    sent, drawn = page.evaluate("() => [bench.sent - bench.clicked, bench.drawn - bench.clicked]")
    rig.key("Control+z")
    rig.wait_for(lambda: len(rig.app.project.edits) == before, "the edit is undone")
    rig.settle()
    return served[0], scripts, sent, drawn


def measured_clicks(page: EditPage) -> list[float]:
    """Let the page record how long it handles each click [ms]; returns the list that it fills."""
    served: list[float] = []
    handle = page.picked

    def picked(pick: Any) -> None:
        start = time.perf_counter()
        handle(pick)
        served.append(1e3 * (time.perf_counter() - start))

    page.picked = picked  # type: ignore[method-assign]
    return served


def app_edit_latency() -> Rows:
    """Yield the table."""
    fabric = Garment("dress", width=0.78).divided()
    with tempfile.TemporaryDirectory() as folder, started_browser() as browser:
        write_stitches(path := Path(folder) / "dress.h5", fabric)
        project = Project.create(Path(folder) / "project")
        project.import_mesh(path.name, path.read_bytes())
        project.close()
        with rig_on(browser, Path(folder) / "project", "Edit", (1000, 700)) as rig:
            yield from table(rig, fabric)


def table(rig: Rig, fabric: StitchMesh) -> Rows:
    """Measure all cases."""
    page = rig.app.page
    assert isinstance(page, EditPage)
    served = measured_clicks(page)
    rig.browser_page.evaluate(WATCH)
    yield f"{fabric.face_count} faces, window {rig.browser_page.viewport_size}"
    inspector = rig.browser_page.context.new_cdp_session(rig.browser_page)
    inspector.send("Performance.enable")
    yield "least / median, ms", "server", "scripts", "sent", "drawn", "runs"
    for name, prepare in CASES:
        if name == "split an edge":
            rig.act("tool", "Loops and edges")
            rig.settle()
        prepare(rig)
        rig.settle()
        runs = [run for point in middles(fabric) if (run := timed_click(rig, point, served, inspector)) is not None]
        least, middle = np.min(runs, axis=0), np.median(runs, axis=0)
        cells = [f"{one:.0f} / {other:.0f}" for one, other in zip(least, middle, strict=True)]
        yield name, *cells, len(runs)
