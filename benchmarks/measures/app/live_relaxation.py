# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""How much watching a relaxation slows its solver.

The yarns of a garment relax for a fixed number of iterations: without anybody who watches, with a ``RunControl`` whose
snapshots nobody draws, on the page Yarns without a browser, on the page Yarns of a server, and, with ``--browser``, on
the page of a server with a browser that draws in software on the same processor. These runs alternate. Each run is
compared with the unwatched run of the same round; the median over the rounds is printed.

Two times are compared. ``wall`` is that of the solver's own report, which depends on what else the machine does.
``processor`` is the time of all threads of this process, the browser's process excluded: watching cannot slow the
solver by more, because its other threads would take that time from the solver even on a single core. The same is done
for mesh relaxation, without pages.
"""

from __future__ import annotations

import platform
import tempfile
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path
from typing import Any

import numpy as np

import stitchmesh as sm
from benchmarks.places import MESHES
from benchmarks.scenes.garments import Garment
from benchmarks.table import Rows
from stitchmesh.app.application import App
from stitchmesh.app.front import Front
from stitchmesh.app.pages.yarns.page import YarnsPage
from stitchmesh.app.project.division import Division
from stitchmesh.app.project.project import Project
from stitchmesh.app.server import open_server
from stitchmesh.app.viser_front import ViserFront
from stitchmesh.labeling.steps import LabelStep
from stitchmesh.meshrelax import relax_mesh
from stitchmesh.pipeline.options import RelaxOptions
from stitchmesh.pipeline.yarn_relaxation import relax_with_options
from stitchmesh.quality import quality_named, quality_with
from stitchmesh.run import QUIET, Run
from stitchmesh.run_control import RunControl
from tests.app.null_front import NullFront

GARMENTS = (("hat", 1.0, 300), ("sweater", 1.2, 60))
"""Mesh, stitch width [cm] and iterations."""
ROUNDS = 5
"""Rounds in which the runs alternate."""
PAGE = "page, no server"
Times = tuple[float, float]
"""Time of the solver and time of the processor of one run [s]."""


class WatchedApp:
    """The application with the page Yarns open on generated yarns."""

    def __init__(self, source: Project, front: Front, folder: Path) -> None:
        """Copy the stages of a project, and open the page."""
        project = Project.create(folder)
        assert source.source is not None and source.division is not None
        project.import_mesh(source.source.name, source.source.content)
        project.apply_label_step(LabelStep("label_all"))
        project.divide(source.division)
        assert source.evened is not None and source.yarns is not None
        project.set_evened(source.evened)
        project.set_settings("Yarns", source.settings("Yarns"))
        project.set_yarns(source.yarns, source.yarn_settings or {})
        self.app = App(project, front)
        self.busy = 0.0
        """Time that the thread of the events has spent on frames [s]."""
        self.frames = 0
        self._call(self.app.open_page, "Yarns")

    def relax(self) -> Times:
        """Relax the yarns on the page."""
        began = time.process_time()
        self._call(self._start)
        while self.app.tasks.running:
            time.sleep(0.02)
        self.app.queue.settle()
        assert self.app.project.report is not None
        return float(self.app.project.report["seconds"]), time.process_time() - began

    def _start(self) -> None:
        page = self.app.page
        assert isinstance(page, YarnsPage)
        page.relax()
        run = page._run.live
        assert run is not None and run.on_snapshot is not None
        show = run.on_snapshot

        def timed(snapshot: Any) -> None:
            began = time.perf_counter()
            show(snapshot)
            self.busy += time.perf_counter() - began
            self.frames += 1

        run.on_snapshot = timed

    def _call(self, function: Callable[..., object], *arguments: object) -> None:
        self.app.post(function, *arguments)
        self.app.queue.settle(600.0)


def made_project(folder: Path, mesh: str, stitch_width: float, iterations: int) -> Project:
    """Return a project with generated yarns."""
    project = Project.create(folder)
    project.import_mesh(f"{mesh}.obj", (MESHES / f"{mesh}.obj").read_bytes())
    project.apply_label_step(LabelStep("label_all"))
    project.divide(Division(stitch_width=stitch_width))
    assert project.fabric is not None and project.mesh is not None
    project.set_evened(sm.relax_mesh(project.fabric, surface=project.mesh, run=QUIET).fabric)
    assert project.evened is not None
    choices = {"quality": "draft", "most_iterations": iterations, "device": "cpu"}
    project.set_settings("Yarns", {"choices": choices})
    project.set_yarns(sm.generate_yarns(project.evened, quality="draft"), {})
    return project


@contextmanager
def browser_on(address: str) -> Iterator[None]:
    """Open a page of a server in a browser without a window, which draws in software."""
    from tests.app.browser import started_browser

    with started_browser() as browser:
        page = browser.new_page(viewport={"width": 1000, "height": 700})
        page.goto(f"{address}{'&' if '?' in address else '?'}fixedDpr=1")
        page.wait_for_function("() => !!window.stitchmesh")
        page.wait_for_timeout(3000)
        yield


def measure_yarns(mesh: str, stitch_width: float, iterations: int, browser: bool) -> Rows:
    """Yield how much each kind of watching slows the relaxation of yarns."""
    with ExitStack() as stack:
        folder = Path(stack.enter_context(tempfile.TemporaryDirectory()))
        project = made_project(folder / "made", mesh, stitch_width, iterations)
        stack.callback(project.close)
        yarns, fabric = project.yarns, project.evened
        assert yarns is not None
        quality = quality_named(quality_with("draft", max_iterations=iterations))

        def plain(control: RunControl[sm.YarnSet] | None = None) -> Times:
            began = time.process_time()
            made = relax_with_options(
                yarns, RelaxOptions(), quality=quality, device="cpu", fabric=fabric,
                run=Run(False, control=control),
            )  # fmt: skip
            return float(made.report["seconds"]), time.process_time() - began

        null = WatchedApp(project, NullFront(), folder / "null")
        stack.callback(null.app.close)
        server = open_server(port=0)
        stack.callback(server.stop)
        served = WatchedApp(project, ViserFront(server.server), folder / "served")
        stack.callback(served.app.close)
        runs: dict[str, Callable[[], Times]] = {
            "RunControl": lambda: plain(RunControl(lambda snapshot: None)),
            PAGE: null.relax,
            "page, server without a browser": served.relax,
        }
        if browser:
            runs = {"page, browser drawing in software": served.relax}
            stack.enter_context(browser_on(server.address))
        times: dict[str, list[Times]] = {name: [] for name in ("unwatched", *runs)}
        plain()
        for _ in range(ROUNDS):
            times["unwatched"].append(plain())
            for name, run in runs.items():
                times[name].append(run())
        yield from show_times(f"{mesh}, {len(yarns.points):,} control points, {iterations} iterations", times)
        for name, watched in (("no server", null), ("server", served)):
            if watched.frames:
                each = 1e3 * watched.busy / watched.frames
                yield f"{name}: {watched.frames} frames, {each:.0f} ms of the thread of the events for each"


def measure_mesh(mesh: str, stitch_width: float) -> Rows:
    """Yield how much watching slows mesh relaxation."""
    garment = Garment(mesh, stitch_width)
    surface, fabric = garment.mesh(), garment.divided()

    def relax(control: RunControl[sm.StitchMesh] | None = None) -> Times:
        began = time.process_time()
        report = relax_mesh(fabric, surface=surface, run=Run(False, control=control)).report
        return report.seconds, time.process_time() - began

    relax()
    times: dict[str, list[Times]] = {"unwatched": [], "RunControl": []}
    for _ in range(ROUNDS):
        times["unwatched"].append(relax())
        times["RunControl"].append(relax(RunControl(lambda snapshot: None)))
    yield from show_times(f"{mesh}, {fabric.face_count:,} stitches, mesh relaxation", times)


def show_times(title: str, times: dict[str, list[Times]]) -> Rows:
    """Yield the median times of each kind of run, and how much more they are than those of the unwatched run."""
    yield title
    yield "", "wall s", "slower %", "processor s", "slower %"
    unwatched = np.array(times["unwatched"])
    for name, found in times.items():
        wall, processor = np.median(found, axis=0)
        slower = 100.0 * (np.median(np.array(found) / unwatched, axis=0) - 1.0)
        yield name, f"{wall:.2f}", f"{slower[0]:+.1f}", f"{processor:.2f}", f"{slower[1]:+.1f}"


def live_relaxation(*, browser: bool = False) -> Rows:
    """Measure all garments.

    Args:
        browser: measure with a browser instead
    """
    yield f"{platform.machine()}, {threading.active_count()} thread, unwatched runs first in each round"
    for mesh, stitch_width, iterations in GARMENTS:
        yield from measure_yarns(mesh, stitch_width, iterations, browser)
    if not browser:
        for mesh, stitch_width, _ in GARMENTS:
            yield from measure_mesh(mesh, 0.5 * stitch_width)
