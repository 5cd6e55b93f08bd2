# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""A job that makes a garment: it runs the table of stages, and keeps the value of each stage."""

from __future__ import annotations

from contextlib import nullcontext
from dataclasses import replace
from typing import TypeVar

from stitchmesh.io.checkpoint_file import previous_path
from stitchmesh.io.contents import read_bytes
from stitchmesh.io.path_kind import is_file
from stitchmesh.io.state_saver import StateSaver
from stitchmesh.io.stitches import write_stitches
from stitchmesh.jobs.job import recipe_of
from stitchmesh.jobs.job_memory import check_job_memory, found_memory, garment_memory
from stitchmesh.jobs.kept_stages import KeptStage, stage_key
from stitchmesh.jobs.stage_run import JobRun, cut_short
from stitchmesh.pipeline.garment import Garment, Made
from stitchmesh.pipeline.options import KnitOptions
from stitchmesh.pipeline.stage_table import RELAX_YARNS, ROWS, STITCHES, YARNS, Stage, run_stages
from stitchmesh.quality import Quality
from stitchmesh.recipe.recipe import recipe_options
from stitchmesh.recipe.recipe_file import edits_with_paths
from stitchmesh.run import CHECKPOINT, Checkpoints, Run
from stitchmesh.selection.selection import with_paths
from stitchmesh.yarnrelax.checkpoint import seconds_of
from stitchmesh.yarnrelax.relaxation_result import Relaxation

T = TypeVar("T")


def make_garment(run: JobRun) -> Garment:
    """Run the stages of a garment, up to the relaxed yarns.

    Raises:
        StitchMeshError: a stage cannot be carried out, the garment does not fit into the memory, or there is a
            checkpoint and the job shall not continue from it.
        JobStopped: the user wants the job to stop.
    """
    recipe = recipe_of(run.job)
    found = recipe.read_mesh()
    options = recipe_options(recipe, found.up)
    decisive = _with_contents(options)

    def work(stage: Stage[T], garment: Garment) -> Made[T]:
        """Provide the result of a stage: the result that an earlier run has kept, or a new result."""
        return run.keep(_kept(stage, garment, decisive), lambda: stage.run(garment, Run(run.progress)))

    garment = Garment.begin(found.mesh, options, budget=run.budget, repair=found.repairs)
    garment = run_stages(ROWS, garment, work)
    garment = garment.reporting({"memory": _checked_memory(run, garment)})
    garment = run_stages(STITCHES, garment, work)
    for name in run.job.write_stitches:
        write_stitches(run.folder / name, garment.fabric)
    garment = run_stages(YARNS, garment, work)
    return garment.after(Relaxation, _relaxed(run, garment, _kept(RELAX_YARNS, garment, decisive)))


def _with_contents(options: KnitOptions) -> KnitOptions:
    """Return the options with paths replaced by the content of the files."""
    regions = [
        region if region.on is None else replace(region, on=with_paths(region.on, _content))
        for region in options.patterns
    ]
    return replace(options, patterns=regions, edits=edits_with_paths(options.edits, _content))


def _content(path: str) -> str:
    return read_bytes(path).hex()


def _kept(stage: Stage[T], garment: Garment, decisive: KnitOptions) -> KeptStage[T]:
    """Return the stage with the key of its inputs and of those of its settings that decide bits."""
    return KeptStage(stage.name, stage_key(stage.name, stage.inputs(garment), stage.settings(decisive)), stage.kind)


def _checked_memory(run: JobRun, garment: Garment) -> dict[str, float]:
    """Refuse a job that does not fit into the memory, and return the memory that it needs, for the report.

    Raises:
        ParameterError: as for ``check_job_memory``.
    """
    fabric, options, device, pictures = garment.fabric, garment.options, garment.device, run.job.render

    def memory_at(quality: Quality) -> float:
        if garment.found is None:
            return garment_memory(fabric, options, quality, device, pictures)
        return found_memory(fabric, quality, device, pictures)

    smaller = "wider stitches, a smaller mesh, or no pictures (render = [])"
    return check_job_memory(memory_at, garment.quality, device, smaller)


def _relaxed(run: JobRun, garment: Garment, kept: KeptStage[Relaxation]) -> Made[Relaxation]:
    """Relax the yarns, with checkpoints in the folder of the stage."""
    folder = run.kept.folder_of(kept)
    checkpoint = folder / CHECKPOINT
    run.check_resume(kept, stopped=is_file(checkpoint))

    def relax() -> Made[Relaxation]:
        saver, continues = StateSaver(run.folder, garment.report, garment.yarns), is_file(checkpoint)
        relaxation = Run(
            run.progress, on_state=saver.keep, checkpoints=Checkpoints(folder, run.job.interval),
            resume=checkpoint if continues else None,
        )  # fmt: skip
        before = seconds_of(checkpoint) if continues else 0.0
        with run.continued(before) if continues else nullcontext():
            return RELAX_YARNS.run(garment, relaxation)

    made = run.keep(kept, relax)
    if not cut_short(made.value.report):
        for path in (checkpoint, previous_path(checkpoint)):
            path.unlink(missing_ok=True)
    return made
