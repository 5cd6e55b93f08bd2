# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The stages of a job that relaxes one repeat of a pattern."""

from __future__ import annotations

import time
from contextlib import nullcontext
from dataclasses import asdict, replace
from typing import Any

from stitchmesh.compute.asking import answer_alone
from stitchmesh.compute.device import device_named
from stitchmesh.io.state_saver import StateSaver
from stitchmesh.io.stitches import write_stitches
from stitchmesh.jobs.budget_stage import chosen_quality
from stitchmesh.jobs.job_memory import check_job_memory, swatch_memory
from stitchmesh.jobs.kept_relaxations import KeptRelaxations
from stitchmesh.jobs.kept_stages import stage_key
from stitchmesh.jobs.sections import SwatchTable
from stitchmesh.jobs.stage_files import swatch_stage
from stitchmesh.jobs.stage_run import JobRun, cut_short
from stitchmesh.periodic.relaxation.prepared_swatch import prepare_swatch
from stitchmesh.periodic.resolve_pattern import Source, resolve_pattern
from stitchmesh.periodic.swatch import Swatch, in_fabric, relax_shaken
from stitchmesh.periodic.swatch_budget import plan_swatch
from stitchmesh.quality import DEFAULT_QUALITY, Quality
from stitchmesh.run import Run
from stitchmesh.time_limit import seconds_left


def relax_swatch(run: JobRun, table: SwatchTable) -> Swatch:
    """Relax the repeat.

    Raises:
        StitchMeshError: the repeat cannot be relaxed, or does not fit into the memory, or there is a checkpoint and
            the job shall not continue from it.
        JobStopped: the user wants the job to stop.
    """
    name = run.job.quality or DEFAULT_QUALITY
    source, given, device = resolve_pattern(table.pattern), table.quality(name), str(device_named(run.job.device))
    arguments = table.arguments()
    head = {"pattern": table.pattern, "name": source.name, "source": source.source}
    options = {"quality": name, "material": table.material, "stiffness": list(table.stiffness)}
    run.report |= head | {"options": options | arguments | {"rest_lengths": asdict(arguments["rest_lengths"])}}
    run.report |= {"quality": asdict(given)}
    run.report["memory"] = check_job_memory(
        lambda quality: swatch_memory(table, quality, device, run.job.render), given, device,
        "fewer repeats, or no pictures (render = [])",
    )  # fmt: skip
    planned = {name: value for name, value in arguments.items() if name != "friction"}
    quality = chosen_quality(
        run, given, lambda budget: plan_swatch(source, budget, given, device, **planned),
        source, sorted(planned.items()), device,
    )  # fmt: skip
    made = _relaxed(run, table, source, quality, device)
    if made.fabric is not None:
        for path in run.job.write_stitches:
            write_stitches(run.folder / path, made.fabric)
    run.report |= run.report.pop("swatch")
    return made


def _relaxed(run: JobRun, table: SwatchTable, source: Source, quality: Quality, device: str) -> Swatch:
    """Relax the repeat, with checkpoints in the folder of the stage."""
    arguments, material = table.arguments(), table.yarn_material()
    given = [*sorted(arguments.items()), table.shaken]
    key = stage_key("swatch", source, material, quality, given, device.partition(":")[0])
    stage = swatch_stage("swatch", key)
    relaxations = KeptRelaxations(run.kept.folder_of(stage), run.job.interval, run.stop.check)
    run.check_resume(stage, stopped=relaxations.exist())

    def show(stage: str, done: float, note: str) -> None:
        run.progress("swatch", done, note)

    def relax(report: dict[str, Any]) -> Swatch:
        """Relax the repeat from its beginning or from the checkpoints."""
        began, before = time.perf_counter(), relaxations.seconds()
        with run.continued(before) if before else nullcontext():
            preparation = prepare_swatch.asking(source, material=material, quality=quality, device=device, **arguments)
            prepared = answer_alone(preparation, relaxations.do)
            saver = StateSaver(run.folder, run.report, in_fabric(prepared.yarns, prepared.options))
            saving = replace(relaxations, on_state=lambda state: saver.keep(in_fabric(state, prepared.options)))
            made = answer_alone(relax_shaken.asking(prepared, table.shaken, Run(show)), saving.do)
            late = seconds_left() <= 0.0  # starts of the search for the lowest state may be left out
        own = {"seconds": before + time.perf_counter() - began, "search_out_of_time": late}
        made = replace(made, report=made.report | own)
        report["swatch"] = made.report
        return made

    made = run.run(stage, relax)
    if not cut_short(made.report):
        relaxations.remove()
    return made


