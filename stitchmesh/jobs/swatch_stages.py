# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The stages of a job that relaxes one repeat of a pattern.

The computation relaxes yarns several times, for example in the search for the lowest state. Each relaxation of it has a
folder of checkpoints, whose name is the checksum of the inputs. The last checkpoint is written at the end of the
relaxation; a relaxation that continues from it gives the same result without an iteration. A computation that begins
again therefore passes through the finished relaxations, continues the stopped relaxation, and ends with the same bits
as without a stop. The short work between the relaxations is done again.
"""

from __future__ import annotations

import shutil
import time
from collections.abc import Callable, Iterator, Mapping
from contextlib import nullcontext
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any

from stitchmesh import __version__
from stitchmesh.compute.device import device_named
from stitchmesh.compute.shared_work import Call, Worker, done_by
from stitchmesh.io.state_saver import StateSaver
from stitchmesh.io.stitches import write_stitches
from stitchmesh.jobs.job_memory import check_job_memory, swatch_memory
from stitchmesh.jobs.kept_stages import KeptStage, stage_key
from stitchmesh.jobs.sections import SwatchTable
from stitchmesh.jobs.stage_run import JobRun, cut_short
from stitchmesh.periodic.relaxation.prepared_swatch import prepare_swatch
from stitchmesh.periodic.resolve_pattern import Source, resolve_pattern
from stitchmesh.periodic.swatch import Swatch, in_fabric, plan_swatch, relax_shaken
from stitchmesh.pipeline.garment import Made
from stitchmesh.pipeline.stages import planned_quality
from stitchmesh.quality import DEFAULT_QUALITY, Quality
from stitchmesh.run import CHECKPOINT, SHOWN, Checkpoints, Run
from stitchmesh.time_limit import seconds_left
from stitchmesh.yarn import YarnSet
from stitchmesh.yarnrelax import relax_yarns
from stitchmesh.yarnrelax.checkpoint import seconds_of
from stitchmesh.yarnrelax.fingerprint import checksum
from stitchmesh.yarnrelax.load_steps import relax_through_steps


def relax_swatch(run: JobRun, table: SwatchTable) -> Made[Swatch]:
    """Relax the repeat, and return it with the report of the job.

    Raises:
        StitchMeshError: the repeat cannot be relaxed, or does not fit into the memory, or there is a checkpoint and
            the job shall not continue from it.
        JobStopped: the user wants the job to stop.
    """
    name = run.job.quality or DEFAULT_QUALITY
    source = resolve_pattern(table.pattern)
    given = table.quality(name)
    device = str(device_named(run.job.device))
    arguments = table.arguments()
    options = {"quality": name, "material": table.material, "stiffness": list(table.stiffness)}
    report = {
        "stitchmesh": __version__, "pattern": table.pattern, "name": source.name, "source": source.source,
        "options": options | arguments | {"rest_lengths": asdict(arguments["rest_lengths"])},
        "quality": asdict(given),
        "memory": check_job_memory(
            lambda quality: swatch_memory(table, quality, device, run.job.render), given, device,
            "fewer repeats, or no pictures (render = [])",
        ),
    }  # fmt: skip
    planned = _planned(run, table, source, given, device)
    report |= planned.report
    made = _relaxed(run, table, source, planned.value, device, report)
    if made.fabric is not None:
        for path in run.job.write_stitches:
            write_stitches(run.folder / path, made.fabric)
    return Made(made, report | made.report)


def _planned(run: JobRun, table: SwatchTable, source: Source, given: Quality, device: str) -> Made[Quality]:
    """Return the quality that the budget of a job chooses. It is kept, because a calibration is not repeatable."""
    budget = run.budget
    if budget is None:
        return Made(given, {})
    arguments = table.arguments()
    inputs = source, sorted(arguments.items()), device, given, budget.within, budget.error, budget.chooses

    def plan() -> Made[Quality]:
        return planned_quality(plan_swatch(source, budget, given, device, **arguments), asdict(given))

    return run.keep(KeptStage("budget", stage_key("budget", *inputs), Quality), plan)


def _relaxed(
    run: JobRun, table: SwatchTable, source: Source, quality: Quality, device: str, report: Mapping[str, Any]
) -> Swatch:
    """Relax the repeat, with checkpoints in the folder of the stage."""
    arguments = table.arguments()
    material = table.yarn_material()
    given = [*sorted(arguments.items()), table.shaken]
    key = stage_key("swatch", source, material, quality, given, device.partition(":")[0])
    stage = KeptStage("swatch", key, Swatch)
    relaxations = KeptRelaxations(run.kept.folder_of(stage), run.job.interval, run.stop.check)
    run.check_resume(stage, stopped=relaxations.exist())

    def show(stage: str, done: float, note: str) -> None:
        run.progress("swatch", done, note)

    def relax() -> Made[Swatch]:
        began = time.perf_counter()
        before = relaxations.seconds()
        with run.continued(before) if before else nullcontext():
            with done_by(relaxations):
                prepared = prepare_swatch(source, material=material, quality=quality, device=device, **arguments)
            saver = StateSaver(run.folder, report, in_fabric(prepared.yarns, prepared.options))
            saving = replace(relaxations, on_state=lambda state: saver.keep(in_fabric(state, prepared.options)))
            with done_by(saving):
                made = relax_shaken(prepared, table.shaken, Run(show))
            late = seconds_left() <= 0.0  # the search for the lowest state may leave starts out
        own = {"seconds": before + time.perf_counter() - began, "search_out_of_time": late}
        made = replace(made, report=made.report | own)
        return Made(made, {"swatch": made.report})

    made = run.keep(stage, relax).value
    if not cut_short(made.report):
        relaxations.remove()
    return made


RELAXATIONS = "relaxations"
"""Folder of the folders of the relaxations."""
NO_INPUTS = ("run", "device")
"""Arguments of relaxations that do not change a result; each checkpoint holds the kind of the device."""


@dataclass(frozen=True)
class KeptRelaxations(Worker):
    """The relaxations of one computation in a folder; as a worker, it continues each of them."""

    folder: Path
    """Folder of the computation."""
    every: int
    """Iterations between two checkpoints of a relaxation."""
    check: Callable[[], None]
    """Called before each piece of work; it raises an exception if the computation is to stop."""
    on_state: Callable[[YarnSet], None] | None = None
    """Called every few seconds with the last accepted state of the present relaxation."""

    def do(self, call: Call) -> Any:
        """Do one piece of work; a relaxation writes checkpoints, and continues from the last one if there is any."""
        self.check()
        return self._relax(call) if call.function in (relax_yarns, relax_through_steps) else call.do()

    def exist(self) -> bool:
        """Return whether an earlier run has begun a relaxation."""
        return any(True for _ in self._checkpoints())

    def seconds(self) -> float:
        """Return the time that earlier runs have spent on relaxations [s].

        Raises:
            FileError: a checkpoint is damaged.
        """
        return sum(seconds_of(path) for path in self._checkpoints())

    def remove(self) -> None:
        """Remove all checkpoints, because the result of the computation is kept."""
        shutil.rmtree(self.folder / RELAXATIONS, ignore_errors=True)

    def _relax(self, call: Call) -> Any:
        given = {name: value for name, value in sorted(call.arguments.items()) if name not in NO_INPUTS}
        key = checksum("relaxation", given)
        checkpoints = Checkpoints(self.folder / RELAXATIONS / key, self.every)
        resume = checkpoints.path if checkpoints.path.is_file() else None
        run = replace(
            call.arguments.get("run", SHOWN), on_state=self.on_state, checkpoints=checkpoints, resume=resume
        )  # fmt: skip
        return replace(call, arguments={**call.arguments, "run": run}).do()

    def _checkpoints(self) -> Iterator[Path]:
        """Yield the newest checkpoint of each relaxation."""
        yield from (self.folder / RELAXATIONS).glob(f"*/{CHECKPOINT}")
