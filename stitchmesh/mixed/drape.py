# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""A run of mixed yarns and triangles, from a scene to what it leaves (Casafranca et al. 2020).

The cloth is made and yarns are laid out on it everywhere; the region says where they are simulated; the system moves in
time or comes to an equilibrium; everything is turned into curves and a smooth surface for display.
"""

from __future__ import annotations

import time
from collections.abc import Iterator
from dataclasses import dataclass, replace
from os import PathLike
from pathlib import Path
from typing import Any

import numpy as np
import warp as wp

from stitchmesh import __version__
from stitchmesh.compute.device import alone, device_named
from stitchmesh.compute.precision import scalar_named
from stitchmesh.errors import ParameterError
from stitchmesh.io.atomic import write_json
from stitchmesh.io.contents import FilePath
from stitchmesh.mixed.automatic_region import place_yarns
from stitchmesh.mixed.cloth.cloth import Cloth
from stitchmesh.mixed.layout.laid_yarns import LaidYarns
from stitchmesh.mixed.memory import available_memory, check_memory
from stitchmesh.mixed.output.display import Display, Shown
from stitchmesh.mixed.output.files import RunFiles
from stitchmesh.mixed.output.frames import Frame, Frames
from stitchmesh.mixed.output.report import RunTotals, mixed_report, peak_memory, region_counts
from stitchmesh.mixed.run_checkpoint import NAME, RunCheckpoint, read_run, run_inputs, write_run
from stitchmesh.mixed.scene.scene import Scene
from stitchmesh.mixed.scene.scene_fabric import PreparedScene, prepare
from stitchmesh.mixed.scene.scene_file import read_scene, write_scene
from stitchmesh.mixed.simulation import Simulation, SimulationStep, begin_simulation
from stitchmesh.progress import Progress, no_progress
from stitchmesh.run_control import RunControl, RunStopped, Snapshot
from stitchmesh.time_limit import check_time
from stitchmesh.yarn import YarnSet

STAGE = "drape"
"""Name of the stage in reports of progress."""
REPORT, SCENE_FILE = "report.json", "scene.toml"
"""Names of files in the output folder."""


@dataclass(frozen=True, eq=False, kw_only=True)
class Draped:
    """The result of a run."""

    prepared: PreparedScene
    """Cloth, yarns, materials, region and loads."""
    display: Display
    """The maps from a state to what is shown."""
    frames: Frames
    """States at the times of the frames; the last one is the end."""
    report: dict[str, Any]
    """Plain numbers."""

    @property
    def end(self) -> Frame:
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
        files = RunFiles(target, self.prepared.fabric, self.display)
        files.write_state(self.end, output.yarns)
        if output.animation and len(self.frames) > 1:
            files.write_animation(self.frames, self._frames_per_second)
        write_scene(target / SCENE_FILE, self.prepared.scene)
        write_json(target / REPORT, self.report)

    @property
    def _frames_per_second(self) -> float:
        """Frames for each second of an animation; equilibria are a second apart."""
        scene = self.prepared.scene
        return scene.output.frames_per_second if scene.mode == "dynamic" else scene.load_steps / scene.duration

    def shown_at(self, frame: Frame) -> Shown:
        """Return vertices, yarn nodes and smooth surface of a frame [cm]."""
        return self.display.show(frame.vertices, frame.nodes)

    def yarns_at(self, frame: Frame) -> YarnSet:
        """Return all yarns of a frame as curves."""
        return self.display.curves(self.shown_at(frame), self.prepared.fabric.yarn_radius)


def drape(
    scene: Scene | FilePath, folder: str | PathLike[str] | None = None, *, cloth: Cloth | None = None,
    yarns: LaidYarns | None = None, progress: Progress = no_progress,
    control: RunControl[Draped] | None = None, checkpoint_every: int | None = None, resume: bool = False,
) -> Draped:  # fmt: skip
    """Run a scene of mixed yarns and triangles.

    Args:
        scene: the scene, or a scene file.
        folder: output folder, for checkpoints and frames; without it, frames are kept in memory.
        cloth: a cloth in the place of that of the scene.
        yarns: yarns laid out on it in the place of those of the scene.
        progress: called with the completed part and a line of text.
        control: watches, pauses and stops the run; its snapshots are results.
        checkpoint_every: number of steps between two checkpoints; none by default. Needs a folder.
        resume: whether to continue from the checkpoint in the folder; the result has the bits of a run that was never
            stopped.

    Raises:
        ParameterError: something in the scene is not possible, or does not fit into the memory.
        FileError: a file cannot be read or written.
        SolverError: no time step is small enough.
    """
    given = scene if isinstance(scene, Scene) else read_scene(scene)
    target = _checked_folder(folder, checkpoint_every, resume)
    prepared = prepare(given, cloth=cloth, yarns=yarns)
    device = device_named(given.solver.device)
    contact = bool(given.bodies) or given.contact.self_collision
    with alone():
        if given.region.yarns == "automatic":
            prepared = place_yarns(prepared, scalar_named(given.solver.precision), device, progress=progress)
        check_memory(prepared.region, available_memory(device), contact=contact)
        run = _Run(prepared, target, device)
        if resume and target is not None:
            run.resume(target / NAME)
        run.go(progress, control, checkpoint_every)
    return run.result()


def _checked_folder(folder: str | PathLike[str] | None, every: int | None, resume: bool) -> Path | None:
    if folder is None and (every is not None or resume):
        raise ParameterError("drape: got checkpoints or a run to resume without a folder; expected their folder")
    if every is not None and every < 1:
        raise ParameterError(f"drape: checkpoint_every: got {every}; expected at least 1")
    return None if folder is None else Path(folder)


class _Run:
    """One run: the simulation, its frames and its sums."""

    def __init__(self, prepared: PreparedScene, folder: Path | None, device: wp.Device) -> None:
        self.prepared, self.folder, self.device = prepared, folder, device
        scene, fabric = prepared.scene, prepared.fabric
        self.simulation: Simulation = begin_simulation(prepared, scalar_named(scene.solver.precision), device)
        self.display = Display(fabric.cloth, fabric.yarns, prepared.region, scene.output.subdivisions)
        self.frames, self.totals = Frames(folder), RunTotals()
        self.inputs = run_inputs(prepared, device)
        self.stopped = False

    def resume(self, path: Path) -> None:
        """Continue from a checkpoint."""
        state = read_run(path, self.inputs)
        self.simulation.resume(state.arrays)
        self.totals = state.totals
        self.frames.count = state.frames

    def go(self, progress: Progress, control: RunControl[Draped] | None, every: int | None) -> None:
        """Run to the end, or until the user or the time stops it."""
        self.frames.begin(self.frames.count)
        if not self.frames.count:
            self.frames.add(self._frame())
        try:
            while not self.simulation.done:
                self._step(progress)
                if every is not None and self.totals.steps % every == 0:
                    self._write_checkpoint()
                check_time()
                if control is not None:
                    control.after_step(self._snapshot, before_wait=lambda: None)
        except RunStopped:
            self.stopped = True
            self._write_checkpoint()
        if self.frames[-1].time != self.simulation.time:
            self.frames.add(self._frame())

    def result(self) -> Draped:
        """The result so far."""
        return Draped(prepared=self.prepared, display=self.display, frames=self.frames, report=self._report())

    def _step(self, progress: Progress) -> None:
        before, began = self._frame(), time.perf_counter()
        made = self.simulation.step()
        totals = self.totals
        totals.seconds += time.perf_counter() - began
        totals.steps += 1
        totals.newton_iterations += made.newton_iterations
        totals.solve_iterations += made.solve_iterations
        totals.halvings += made.halvings
        totals.not_converged += not made.converged
        totals.error = made.error
        for moment in self._frames_due(made):
            self.frames.add(before.between(self._frame(), moment))
        progress(STAGE, min(made.time / self.prepared.scene.duration, 1.0), self._note(made))

    def _frames_due(self, made: SimulationStep) -> Iterator[float]:
        """Times of the frames that a step has passed."""
        scene = self.prepared.scene
        if scene.mode == "static":
            yield made.time
            return
        number = len(self.frames)
        while number / scene.output.frames_per_second <= min(made.time, scene.duration):
            yield number / scene.output.frames_per_second
            number += 1

    def _frame(self) -> Frame:
        return Frame(self.simulation.time, *self.simulation.positions)

    def _note(self, made: SimulationStep) -> str:
        unit = "dyn" if self.prepared.scene.mode == "static" else "cm/s"
        return f"time {made.time:.4g} s, {made.newton_iterations} iterations, error {made.error:.2g} {unit}"

    def _snapshot(self) -> Snapshot[Draped]:
        current = Frames()
        current.add(self._frame())
        state = replace(self.result(), frames=current)
        simulation, totals = self.simulation, self.totals
        return Snapshot(state, totals.steps, totals.error, simulation.tolerance, totals.seconds, simulation.energies())

    def _write_checkpoint(self) -> None:
        if self.folder is not None:
            state = RunCheckpoint(self.totals, len(self.frames), self.simulation.arrays())
            write_run(self.folder, self.inputs, state)

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
        device, precision = self.device.alias, scene.solver.precision
        return {"stitchmesh": __version__, "device": device, "precision": precision, "mixed": mixed}
