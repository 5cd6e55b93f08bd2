# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""A run of mixed yarns and triangles, from the scene to its results: what ``drape`` runs (Casafranca et al. 2020).

A run makes the cloth and lays out yarns everywhere on it. The region says where the yarns are simulated. The system
then moves in time or comes to an equilibrium, and its states become curves and a smooth surface for display.
"""

from __future__ import annotations

import logging
import time
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property, partial
from os import PathLike
from pathlib import Path
from typing import Any

import numpy as np
import warp as wp

from stitchmesh import __version__
from stitchmesh.compute.device import alone, device_named, others_may_launch
from stitchmesh.compute.free_memory import available_memory, peak_memory
from stitchmesh.compute.precision import scalar_named
from stitchmesh.errors import ParameterError
from stitchmesh.io.atomic import write_json
from stitchmesh.io.checkpoint_file import was_written
from stitchmesh.io.contents import FilePath
from stitchmesh.mixed.adaptive_region import AdaptiveRegion, resumed_budget, resumed_region
from stitchmesh.mixed.automatic_region import node_budget, place_yarns, run_triangles, unwatched
from stitchmesh.mixed.cloth.cloth import Cloth
from stitchmesh.mixed.dynamics.equilibrium import AfterIteration, search_progress
from stitchmesh.mixed.layout.spline_yarns import LaidYarns
from stitchmesh.mixed.memory import check_scene_memory
from stitchmesh.mixed.output.display import Display, Displays, Shown
from stitchmesh.mixed.output.files import ANIMATION, MAPS, SURFACE, YARNS, RunFiles
from stitchmesh.mixed.output.frames import DrapeFrame, Frames
from stitchmesh.mixed.output.report import RunTotals, mixed_report, region_counts, work_of
from stitchmesh.mixed.placement.chosen_region import NodeBudget
from stitchmesh.mixed.run_checkpoint import RunCheckpoint, read_run, run_inputs, write_run
from stitchmesh.mixed.scene.scene import Scene, read_scene, write_scene
from stitchmesh.mixed.scene.scene_fabric import PreparedScene, prepare
from stitchmesh.mixed.simulation import Simulation, SimulationStep, begin_simulation
from stitchmesh.progress import Progress, shown_stages
from stitchmesh.run import CHECKPOINT, SHOWN, Run
from stitchmesh.run_control import RunControl, RunStopped, Snapshot
from stitchmesh.simulation.term import LoadedPoints, TermChoice
from stitchmesh.time_limit import check_time
from stitchmesh.yarn import YarnSet

logger = logging.getLogger(__name__)

STAGE = "drape"
"""Name of the stage in reports of progress."""
REPORT, SCENE_FILE = "report.json", "scene.toml"
"""Names of files in the output folder."""


@dataclass(frozen=True, eq=False, kw_only=True)
class Draped:
    """The result of a run."""

    prepared: PreparedScene
    """Cloth, yarns, materials, region and loads."""
    displays: Displays
    """The maps from states to their display, for each region that the run has had."""
    frames: Frames
    """States at the times of the frames; the last one is the end."""
    report: dict[str, Any]
    """The report as plain numbers."""

    @property
    def display(self) -> Display:
        """The maps of the last state to its display."""
        return self.display_of(self.end)

    def display_of(self, frame: DrapeFrame) -> Display:
        """Return the maps for the region of a frame."""
        return self.displays.of(frame)

    @property
    def end(self) -> DrapeFrame:
        """The last state."""
        return self.frames[-1]

    @property
    def shown(self) -> Shown:
        """Vertices, yarn nodes and smooth surface at the end [cm]."""
        return self.shown_at(self.end)

    @property
    def yarns(self) -> YarnSet:
        """All yarns at the end, as curves."""
        return self.yarns_at(self.end)

    def write(self, folder: str | PathLike[str]) -> None:
        """Write yarns, surface, maps, animation, scene and report, as the scene asks.

        Raises:
            FileError: a file cannot be written.
        """
        target, output = Path(folder), self.prepared.scene.output
        files = RunFiles(target, self.prepared.fabric, self.displays)
        files.write_state(self.end, output.yarns)
        if output.animation and len(self.frames) > 1:
            files.write_animation(self.frames, self._frames_per_second)
        write_scene(target / SCENE_FILE, self.prepared.scene)
        write_json(target / REPORT, self.report)

    @property
    def _frames_per_second(self) -> float:
        """Frames for each second of an animation. The load steps of a static run are spread over its duration."""
        scene = self.prepared.scene
        return scene.output.frames_per_second if scene.mode == "dynamic" else scene.load_steps / scene.duration

    def shown_at(self, frame: DrapeFrame) -> Shown:
        """Return vertices, yarn nodes and smooth surface of a frame [cm]."""
        return self.displays.show(frame)

    def yarns_at(self, frame: DrapeFrame) -> YarnSet:
        """Return all yarns of a frame as curves."""
        return self.display_of(frame).curves(self.shown_at(frame), self.prepared.fabric.yarn_radius)


def output_names(scene: Scene) -> list[str]:
    """Return the names of the files that a run of a scene writes for the user."""
    return [SCENE_FILE, REPORT, *(f"{YARNS}.{suffix}" for suffix in scene.output.yarns), SURFACE, MAPS, ANIMATION]


def drape(
    scene: Scene | FilePath, folder: str | PathLike[str] | None = None, *, cloth: Cloth | None = None,
    yarns: LaidYarns | None = None, terms: Sequence[TermChoice[LoadedPoints]] = (), run: Run[Draped] = SHOWN,
) -> Draped:  # fmt: skip
    """Run a scene of mixed yarns and triangles.

    Args:
        scene: the scene, or a scene file.
        folder: output folder, for checkpoints and frames; without it, frames are kept in memory.
        cloth: a cloth that replaces the cloth of the scene.
        yarns: yarns laid out on this cloth, which replace the yarns of the scene.
        terms: further loads, such as ``Wind``.
        run: progress; checkpoints in the output folder; the checkpoint to resume from; and a control, whose snapshots
            are results. The iterations between checkpoints are steps in time, or iterations of a static run. A run that
            is stopped also writes a checkpoint. If the checkpoint to resume from does not exist yet, the run begins at
            the start. A resumed run gives the same bits as a run without an interruption.

    Raises:
        ParameterError: a setting of the scene is not possible, or the scene does not fit into the memory.
        FileError: a file cannot be read or written.
        SolverError: no time step is small enough.
    """
    given = scene if isinstance(scene, Scene) else read_scene(scene)
    target = _checked_folder(folder, run)
    with shown_stages(run.progress) as progress:
        prepared = prepare(given, cloth=cloth, yarns=yarns, terms=terms, folder=target, progress=progress)
        device = device_named(given.solver.device)
        with alone():
            state = None if run.resume is None else _state_to_resume(Path(run.resume), prepared, device)
            start = _start(prepared, device, progress, run.control) if state is None else _resumed(prepared, state)
            _check_memory(start, device)
            draping = _Draping(start, target, device, run, progress)
            if state is not None:
                draping.resume(state)
            if target is not None:
                write_scene(target / SCENE_FILE, prepared.scene)
            if start.stopped is None:
                draping.go()
            else:
                draping.end_with(start.stopped)
        return draping.result()


def _check_memory(start: _Start, device: wp.Device) -> None:
    """Check that the scene fits into the memory, with the nodes that its region may have later."""
    scene, region = start.prepared.scene, start.prepared.region
    contact = bool(scene.bodies) or scene.contact.self_collision
    may_grow_to = start.most_nodes if scene.region.changes_every is not None else 0
    check_scene_memory(region, available_memory(device), contact=contact, may_grow_to=may_grow_to)


def _state_to_resume(path: Path, prepared: PreparedScene, device: wp.Device) -> RunCheckpoint | None:
    """Read a checkpoint; None if the run was stopped before it wrote one."""
    if was_written(path):
        return read_run(path, run_inputs(prepared, device))
    logger.info("%s: is not there yet; the run begins at the start", path)
    return None


def _checked_folder(folder: str | PathLike[str] | None, run: Run[Draped]) -> Path | None:
    """Return the output folder of a run.

    Raises:
        ParameterError: the run asks for something that ``drape`` does not obey, or for checkpoints in another folder.
    """
    run.refuse_all_but("drape", "checkpoints", "resume", "control")
    if folder is None and (run.checkpoints is not None or run.resume is not None):
        raise ParameterError("drape: got checkpoints or a run to resume without a folder; expected their folder")
    target = None if folder is None else Path(folder)
    if run.checkpoints is not None and Path(run.checkpoints.folder) != target:
        found = f"got the folder {run.checkpoints.folder}; expected {target}, the output folder, which holds the frames"
        raise ParameterError(f"drape, checkpoints: {found}")
    return target


@dataclass(frozen=True, eq=False)
class _Start:
    """The values with which a run begins."""

    prepared: PreparedScene
    most_nodes: int = 0
    """Nodes that an automatic region may have while the run goes on."""
    triangles: RunTotals | None = None
    """Work of the run with triangles alone, if there was one."""
    stopped: Simulation | None = None
    """The run with triangles alone, if it was stopped."""


def _start(
    prepared: PreparedScene, device: wp.Device, progress: Progress, control: RunControl[Draped] | None
) -> _Start:
    """Run the triangles alone where the region or the start of the yarns follows from them."""
    section = prepared.scene.region
    grows = section.grows_from_nothing
    by_errors = section.yarns == "automatic" and not (grows and section.seconds is None)
    if not (by_errors or section.starts_on_triangles):
        return _Start(prepared, section.nodes or 0)
    scalar = scalar_named(prepared.scene.solver.precision)
    watch = unwatched if control is None else partial(_watch_triangles, control)
    run = run_triangles(prepared, scalar, device, progress=progress, after_step=watch)
    if run.stopped:
        return _Start(run.end.prepared, triangles=run.totals, stopped=run.end)
    most_nodes = 0
    if section.yarns == "automatic":
        budget = node_budget(prepared, run.error, scalar, device)
        prepared = prepared if grows else place_yarns(prepared, run.error, budget)
        most_nodes = budget.nodes
    starts = run.vertices if section.starts_on_triangles else None
    return _Start(replace(prepared, triangle_equilibrium=starts), most_nodes, run.totals)


def _watch_triangles(control: RunControl[Draped], simulation: Simulation, iterations: int, error: float) -> None:
    """Show the triangles, and wait or stop where the user asks for it."""

    def snapshot() -> Snapshot[Draped]:
        prepared, frames = simulation.prepared, Frames()
        fabric, region = prepared.fabric, prepared.region
        frames.add(frame_of(simulation))
        displays = Displays(fabric.cloth, fabric.yarns, region, prepared.scene.output.subdivisions)
        state = Draped(prepared=prepared, displays=displays, frames=frames, report={})
        return Snapshot(state, iterations, error, simulation.tolerance, 0.0, simulation.energies())

    control.after_step(snapshot, aside=others_may_launch)


def frame_of(simulation: Simulation) -> DrapeFrame:
    """Return the present state of a simulation."""
    region = simulation.prepared.region
    return DrapeFrame(simulation.time, *simulation.positions, region.triangle_kind, region.vertex_alpha)


def _resumed(prepared: PreparedScene, state: RunCheckpoint) -> _Start:
    """The values with which a resumed run begins; the checkpoint holds the positions, and an automatic region too."""
    if prepared.scene.region.yarns != "automatic":
        return _Start(prepared)
    return _Start(resumed_region(prepared, state.arrays), resumed_budget(state.arrays).nodes)


class _Draping:
    """A run in progress: the simulation, its frames and its sums."""

    def __init__(
        self, start: _Start, folder: Path | None, device: wp.Device, run: Run[Draped], progress: Progress
    ) -> None:
        self.folder, self.device = folder, device
        self.run, self.progress = run, progress
        self.start = start
        scene = start.prepared.scene
        self.simulation: Simulation = begin_simulation(start.prepared, scalar_named(scene.solver.precision), device)
        self.region: AdaptiveRegion | None = None
        if scene.region.yarns == "automatic":
            self.region = AdaptiveRegion(start.prepared, NodeBudget(nodes=start.most_nodes))
        self.frames, self.totals = Frames(folder), RunTotals()
        self.stopped = False

    @property
    def prepared(self) -> PreparedScene:
        """The scene with its present region."""
        return self.simulation.prepared

    @cached_property
    def displays(self) -> Displays:
        """The maps from states to their display, which are made when a result is asked for."""
        fabric, output = self.start.prepared.fabric, self.start.prepared.scene.output
        return Displays(fabric.cloth, fabric.yarns, self.start.prepared.region, output.subdivisions)

    @cached_property
    def inputs(self) -> dict[str, str]:
        """Everything that decides the run, for its checkpoints."""
        return run_inputs(self.start.prepared, self.device)

    def resume(self, state: RunCheckpoint) -> None:
        """Continue from a checkpoint."""
        self.simulation.resume(state.arrays)
        if self.region is not None:
            self.region.resume(state.arrays)
        self.totals = state.totals
        self.frames.count = state.frames

    def go(self) -> None:
        """Run to the end, or until the user or the time limit stops the run."""
        self.frames.begin(self.frames.count)
        if not self.frames.count:
            self.frames.add(self._frame())
        try:
            while not self.simulation.done:
                self._step()
                if self.prepared.scene.mode == "dynamic":
                    self._between_steps(self.totals.steps)
        except RunStopped:
            self.stopped = True
            self._write_checkpoint()
        if self.frames[-1].time != self.simulation.time:
            self.frames.add(self._frame())

    def end_with(self, simulation: Simulation) -> None:
        """End with the state of a stopped run with triangles alone; there is nothing to resume."""
        self.stopped = True
        self.frames.begin()
        self.frames.add(frame_of(simulation))

    def result(self) -> Draped:
        """The result so far."""
        return Draped(prepared=self.prepared, displays=self.displays, frames=self.frames, report=self._report())

    def _step(self) -> None:
        before, began = self._frame(), time.perf_counter()
        try:
            made = self.simulation.step(self._after_iteration())
        finally:
            self.totals.seconds += time.perf_counter() - began
        made.add_to(self.totals)
        after = self._frame()
        changed = self.region is not None and self.region.look(self.simulation)
        # A static run finds its equilibrium again after a change of the region, and shows the new one.
        for moment in () if changed and self.prepared.scene.mode == "static" else self._frames_due(made):
            self.frames.add(before.between(after, moment))
        self.progress(STAGE, min(made.time / self.prepared.scene.duration, 1.0), self._note(made))

    def _after_iteration(self) -> AfterIteration:
        """Return the function that is called after each iteration of a search for an equilibrium."""
        scene = self.prepared.scene
        report = search_progress(
            STAGE, self.totals.steps, scene.equilibria, self.progress,
            tolerance=self.simulation.tolerance, most_iterations=scene.solver.most_iterations,
        )  # fmt: skip

        def after_iteration(iterations: int, force: float) -> None:
            report(iterations, force)
            self.totals.error = force
            self._between_steps(self.totals.newton_iterations + iterations)

        return after_iteration

    def _between_steps(self, number: int) -> None:
        """Write checkpoints and obey the control after each step in time, or each iteration of a search."""
        if self.run.checkpoints is not None and number % self.run.checkpoints.every == 0:
            self._write_checkpoint()
        check_time()
        if self.run.control is not None:
            self.run.control.after_step(lambda: self._snapshot(number), aside=others_may_launch)

    def _frames_due(self, made: SimulationStep) -> Iterator[float]:
        """The times of frames that lie within a step."""
        scene = self.prepared.scene
        if scene.mode == "static":
            yield made.time
            return
        number = len(self.frames)
        while number / scene.output.frames_per_second <= min(made.time, scene.duration):
            yield number / scene.output.frames_per_second
            number += 1

    def _frame(self) -> DrapeFrame:
        return frame_of(self.simulation)

    def _note(self, made: SimulationStep) -> str:
        unit = "dyn" if self.prepared.scene.mode == "static" else "cm/s"
        return f"time {made.time:.4g} s, {made.newton_iterations} iterations, error {made.error:.2g} {unit}"

    def _snapshot(self, number: int) -> Snapshot[Draped]:
        current = Frames()
        current.add(self._frame())
        state = replace(self.result(), frames=current)
        simulation, totals = self.simulation, self.totals
        return Snapshot(state, number, totals.error, simulation.tolerance, totals.seconds, simulation.energies())

    def _write_checkpoint(self) -> None:
        if self.folder is not None:
            arrays = self.simulation.arrays()
            if self.region is not None:
                arrays |= self.region.arrays(self.simulation)
            state = RunCheckpoint(self.totals, len(self.frames), arrays)
            write_run(self.folder / CHECKPOINT, self.inputs, state)

    def _report(self) -> dict[str, Any]:
        scene, fabric, totals = self.prepared.scene, self.prepared.fabric, self.totals
        energies = self.simulation.energies()
        mixed = mixed_report(
            totals,
            region_counts(fabric.cloth, fabric.yarns, self.prepared.region),
            mode=scene.mode,
            time=self.simulation.time,
            converged=not totals.not_converged and not self.stopped,
            error=totals.error,
            frames=len(self.frames),
            energy=float(np.sum(list(energies.values()))),
            energies=energies,
            memory_bytes=peak_memory(),
        )
        if self.region is not None and self.region.every is not None:
            mixed |= {"region_changes": self.region.changes, "largest_energy_jump": self.region.energy_jump}
        if self.start.triangles is not None:
            mixed["triangle_run"] = work_of(self.start.triangles)
        device, precision = self.device.alias, scene.solver.precision
        return {"stitchmesh": __version__, "device": device, "precision": precision, "mixed": mixed}
