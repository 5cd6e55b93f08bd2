# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The stage of a job that relaxes one repeat of a pattern."""

from __future__ import annotations

from dataclasses import asdict
from typing import Any

from stitchmesh.compute.device import device_named
from stitchmesh.io.stitches import write_stitches
from stitchmesh.jobs.job_memory import check_memory, swatch_memory
from stitchmesh.jobs.kept_stages import stage_key
from stitchmesh.jobs.sections import SwatchTable
from stitchmesh.jobs.stage_files import swatch_stage
from stitchmesh.jobs.stage_run import JobRun
from stitchmesh.periodic.resolve_pattern import resolve_pattern
from stitchmesh.periodic.swatch import Swatch, swatch
from stitchmesh.progress import relaxing_progress
from stitchmesh.quality import DEFAULT_QUALITY


def make_swatch(run: JobRun, table: SwatchTable) -> Swatch:
    """Relax the repeat.

    Raises:
        StitchMeshError: the repeat cannot be relaxed, or does not fit into the memory.
        JobStopped: the user wants the job to stop.
    """
    name, budget = run.job.quality or DEFAULT_QUALITY, run.budget
    source, material, quality = resolve_pattern(table.pattern), table.yarn_material(), table.quality(name)
    device, arguments = str(device_named(run.job.device)), table.arguments()
    head = {"pattern": table.pattern, "name": source.name, "source": source.source}
    options = {"quality": name, "material": table.material, "stiffness": list(table.stiffness)}
    run.report |= head | {"options": options | arguments | {"rest_lengths": asdict(arguments["rest_lengths"])}}
    run.report["memory"] = check_memory(
        lambda quality: swatch_memory(table, quality, run.job.render), quality, device,
        "fewer repeats, or no pictures (render = [])",
    )  # fmt: skip
    report_progress = relaxing_progress(
        "swatch", quality.tolerance, run.progress, max_iterations=quality.max_iterations
    )

    def relax(report: dict[str, Any]) -> Swatch:
        made = swatch(
            source, material=material, quality=quality, device=device, budget=budget,
            progress=lambda entry: report_progress(entry["iteration"], entry["residual"], entry["energies"]),
            **arguments,
        )  # fmt: skip
        report["swatch"] = made.report
        return made

    amounts = None if budget is None else (budget.error, budget.chooses)
    key = stage_key("swatch", source, material, quality, sorted(arguments.items()), device.partition(":")[0], amounts)
    made = run.run(swatch_stage("swatch", key), relax)
    if made.fabric is not None:
        for name in run.job.write_stitches:
            write_stitches(run.folder / name, made.fabric)
    run.report |= run.report.pop("swatch")
    run.report["quality"] = run.report.get("budget", {}).get("quality") or asdict(quality)
    return made
