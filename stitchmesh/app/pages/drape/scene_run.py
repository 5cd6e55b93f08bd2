# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The run of the scene in the worker thread, and its result."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np

from stitchmesh.app.pages.drape.drape_session import DrapeSession
from stitchmesh.app.pages.drape.opened_scene import OpenedScene
from stitchmesh.app.pages.page_run import LiveRun, PageRun, WatchedWork
from stitchmesh.app.pages.view.draped_view import LARGE
from stitchmesh.compute.device import alone, device_named
from stitchmesh.compute.precision import scalar_named
from stitchmesh.errors import ParameterError, StitchMeshError
from stitchmesh.mixed.automatic_region import node_budget, place_yarns, run_triangles
from stitchmesh.mixed.drape import SCENE_FILE, Draped, drape
from stitchmesh.mixed.draped_folder import read_draped
from stitchmesh.mixed.enrichment.region import YARNS
from stitchmesh.mixed.scene.region_section import RegionSection
from stitchmesh.mixed.scene.scene import Scene, read_scene, scene_text
from stitchmesh.progress import Progress
from stitchmesh.run import CHECKPOINT, Checkpoints, Run
from stitchmesh.run_control import RunControl

DRAPING, PLACING = "draping the cloth", "finding the region"
"""Names of the tasks."""


class SceneRun:
    """Holds at most one run; all methods belong to the event thread."""

    def __init__(self, session: DrapeSession, of_page: PageRun[Draped, Draped]) -> None:
        """Begin without a result; the page starts and shows the run."""
        self._session, self.of_page = session, of_page
        self._result: Draped | None = None

    @property
    def live(self) -> LiveRun[Draped, Draped] | None:
        """The run; None while nothing runs."""
        return self.of_page.live

    @property
    def result(self) -> Draped | None:
        """The result of the last run; None if the scene has another cloth or other yarns since."""
        opened, made = self._session.opened, self._result
        return made if opened is None or made is None or same_fabric(opened.scene, made.prepared.scene) else None

    @property
    def can_continue(self) -> bool:
        """Whether the last run was stopped before its end, and the scene is still the same."""
        folder, opened = self._session.run_folder, self._session.opened
        if self.live is not None or opened is None or not (folder / CHECKPOINT).is_file():
            return False
        if self.result is not None and self.result.report.get("mixed", {}).get("converged"):
            return False
        return same_scene(folder / SCENE_FILE, opened.scene)

    def start(self, *, resume: bool) -> None:
        """Start a run, or continue the stopped one.

        Raises:
            ParameterError: there is no scene, its region is not possible, or another task runs.
        """
        opened = self._checked()
        scene, folder, project = opened.scene, self._session.run_folder, self._session.app.project

        def run(control: RunControl[Draped], progress: Progress) -> Draped:
            kept = Checkpoints(folder, 20)  # a killed run can continue from the last multiple
            made = drape(scene, folder, run=Run(
                progress, checkpoints=kept, resume=kept.path if resume else None, control=control,
            ))  # fmt: skip
            made.write(folder)
            return made

        def done(made: Draped) -> None:
            if self._session.app.project is project:
                self._result = made

        if not resume:
            (folder / CHECKPOINT).unlink(missing_ok=True)
        size = min(opened.counts["yarn_nodes"], LARGE)
        self.of_page.start(WatchedWork(name=DRAPING, relax=run, stage=None, frame_bytes=12 * size), done)
        self._result = None

    def find_region(self) -> None:
        """Run the triangles alone, and make the triangles with the largest errors the region.

        Raises:
            ParameterError: there is no scene, its region is not possible, or another task runs.
        """
        opened = self._checked()

        def work(progress: Progress) -> tuple[int, ...]:
            return automatic_triangles(opened, progress)

        def done(found: tuple[int, ...]) -> None:
            if self._session.opened is opened:
                self._session.change_region(lambda section, cloth: chosen_region(section, found))

        self._session.app.tasks.start(PLACING, work, done)

    @property
    def is_current(self) -> bool:
        """Return whether the result belongs to the present scene."""
        opened = self._session.opened
        return (
            opened is None or self.result is None or scene_text(self.result.prepared.scene) == scene_text(opened.scene)
        )

    def read_result(self) -> None:
        """Read the result from the project, if it has one; a damaged one is ignored."""
        if self.live is None and self._result is None and (self._session.run_folder / SCENE_FILE).is_file():
            try:
                self._result = read_draped(self._session.run_folder)
            except StitchMeshError:
                self._result = None

    def _checked(self) -> OpenedScene:
        opened = self._session.opened
        if opened is None:
            raise ParameterError("run: there is no scene yet; open one first")
        if opened.trouble:
            raise ParameterError(opened.trouble)
        return opened


def automatic_triangles(opened: OpenedScene, progress: Progress) -> tuple[int, ...]:
    """Return the triangles with yarns alone of an automatic region, from a run with triangles alone.

    Raises:
        StitchMeshError: the scene cannot run, or the budget is too small.
    """
    device, scalar = device_named(opened.scene.solver.device), scalar_named(opened.scene.solver.precision)
    with alone():
        error = run_triangles(opened.prepared, scalar, device, progress=progress).error
        budget = node_budget(opened.prepared, error, scalar, device)
        region = place_yarns(opened.prepared, error, budget).region
    return tuple(np.flatnonzero(region.triangle_kind == YARNS).tolist())


def same_fabric(one: Scene, other: Scene) -> bool:
    """Return whether two scenes have the same cloth and the same yarns; their names of files may differ."""
    if (one.cloth, one.yarns) == (other.cloth, other.yarns):
        return True
    first, second = (scene_text(Scene(cloth=each.cloth, yarns=each.yarns)) for each in (one, other))
    return first == second


def chosen_region(section: RegionSection, triangles: tuple[int, ...]) -> RegionSection:
    """Return an automatic region as a chosen region with the triangles that were found."""
    return replace(section, yarns="chosen", nodes=None, seconds=None, boxes=(), faces=triangles)


def same_scene(path: Path, scene: Scene) -> bool:
    """Return whether a scene file holds a scene; the names of files may differ."""
    try:
        return scene_text(read_scene(path)) == scene_text(scene)
    except StitchMeshError:
        return False
