# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The stages of a job that makes a garment, in their order; stages that would change nothing are left out."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import nullcontext
from dataclasses import asdict
from typing import Any

from stitchmesh.budget.plan import make_plan
from stitchmesh.budget.tables import BudgetScene
from stitchmesh.compute.device import device_named
from stitchmesh.editing.edit import Edit
from stitchmesh.io.checkpoint_file import previous_path
from stitchmesh.io.contents import read_bytes
from stitchmesh.io.path_kind import is_file
from stitchmesh.io.state_saver import StateSaver
from stitchmesh.io.stitches import write_stitches
from stitchmesh.jobs.budget_stage import chosen_quality
from stitchmesh.jobs.job import recipe_of
from stitchmesh.jobs.job_memory import check_job_memory, found_memory, garment_memory
from stitchmesh.jobs.kept_stages import stage_key
from stitchmesh.jobs.stage_files import fabric_stage, found_stage, relaxation_stage, yarns_stage
from stitchmesh.jobs.stage_run import JobRun, cut_short
from stitchmesh.mesh import Mesh, StitchMesh
from stitchmesh.pipeline.knit import repair_entries
from stitchmesh.pipeline.options import KnitOptions
from stitchmesh.pipeline.stages import (
    edge_forms_stage,
    edit_stage,
    label_stage,
    mesh_stage,
    pattern_stage,
    room_stage,
    shape_stage,
    spiral_stage,
    tessellate_stage,
    whole_mesh,
    yarn_stage,
)
from stitchmesh.pipeline.yarn_relaxation import relax_with_options
from stitchmesh.quality import Quality, quality_named
from stitchmesh.recipe.recipe import recipe_options
from stitchmesh.recipe.recipe_file import edits_with_paths
from stitchmesh.run import CHECKPOINT, Checkpoints, Run
from stitchmesh.selection.selection import Selection, with_paths
from stitchmesh.shaping.panels.panel_mesh import PanelMesh
from stitchmesh.shaping.triangle_surface import TriangleSurface
from stitchmesh.yarn import YarnSet
from stitchmesh.yarnrelax.checkpoint import seconds_of
from stitchmesh.yarnrelax.relaxation_result import Relaxation


def make_garment(run: JobRun) -> tuple[StitchMesh, Relaxation]:
    """Run the stages of a garment; returns the stitches and the relaxed yarns.

    Raises:
        StitchMeshError: a stage cannot be carried out, the garment does not fit into the memory, or there is a
            checkpoint and the job shall not continue from it.
        JobStopped: the user wants the job to stop.
    """
    recipe = recipe_of(run.job)
    found = recipe.read_mesh()
    mesh, options = found.mesh, recipe_options(recipe, found.up)
    device = str(device_named(options.device))
    entry = options.quality if isinstance(options.quality, str) else asdict(options.quality)
    run.report |= {"device": device, "quality": entry}
    if found.repairs is not None:
        run.report["repair"] = repair_entries(found.repairs)
    if options.finds_rows:
        fabric = _found_fabric(run, mesh, options, device)
    else:
        fabric = _labeled_fabric(run, whole_mesh(mesh), options, device)
    for name in run.job.write_stitches:
        write_stitches(run.folder / name, fabric)
    scene = BudgetScene(kind="garment", stitches=fabric.face_count)
    quality = chosen_quality(
        run, quality_named(options.quality), lambda budget: make_plan(budget, scene, options.quality, device),
        fabric, device,
    )  # fmt: skip
    sampling = quality.control_points_per_stitch
    yarn = options.yarn_radius, options.drawn_radius, options.mass_per_length
    key = stage_key("generate_yarns", fabric, *yarn, options.finish, sampling)
    yarns = run.run(
        yarns_stage("generate_yarns", key),
        lambda report: yarn_stage(fabric, options, quality, report, run.progress, run.report.get("shape")),
    )
    return fabric, _relaxed(run, fabric, yarns, options, quality, device)


def _labeled_fabric(run: JobRun, mesh: Mesh, options: KnitOptions, device: str) -> StitchMesh:
    """Return the stitches of a modelled mesh, evened out on their surface."""
    stage = fabric_stage("label", stage_key("label", mesh, options.borders, options.seeds, options.flip))
    labeled = run.run(stage, lambda report: label_stage(mesh, options, report, run.progress))
    _check_memory(
        run, options, device, lambda quality: garment_memory(labeled, options, quality, device, run.job.render)
    )
    size = options.stitch_width, options.stitch_height, options.counts, options.marked, options.increase
    stage = fabric_stage("tessellate", stage_key("tessellate", labeled, *size))
    fabric = run.run(stage, lambda report: tessellate_stage(labeled, options, report, run.progress))
    return _fabric(run, mesh, fabric, options, device)


def _found_fabric(run: JobRun, mesh: Mesh | PanelMesh, options: KnitOptions, device: str) -> StitchMesh:
    """Return stitches that are found on a mesh of any kind or on panels, evened out on its surface."""
    size = options.stitch_width, options.stitch_height, options.increase
    name = "auto_stitches" if options.panels is None else "shape_panels"
    chosen = options.shaping if options.panels is None else options.panels
    stage = found_stage(name, stage_key(name, mesh, size, chosen))
    found = run.run(stage, lambda report: shape_stage(mesh, options, report, run.progress))
    _check_memory(run, options, device, lambda quality: found_memory(found.fabric, quality, device, run.job.render))
    return _fabric(run, found.surface_mesh, found.fabric, options, device, found.given)


def _check_memory(run: JobRun, options: KnitOptions, device: str, memory_at: Callable[[Quality], float]) -> None:
    """Refuse a job that does not fit into the memory, and report what it needs.

    Raises:
        ParameterError: as for ``check_job_memory``.
    """
    run.report["memory"] = check_job_memory(
        memory_at, quality_named(options.quality), device,
        "wider stitches, a smaller mesh, or no pictures (render = [])",
    )  # fmt: skip


def _fabric(
    run: JobRun, mesh: Mesh, fabric: StitchMesh, options: KnitOptions, device: str, given: TriangleSurface | None = None
) -> StitchMesh:
    """Return stitches with patterns and edits, evened out on a surface.

    Args:
        run: the run.
        mesh: the surface.
        fabric: the stitches.
        options: options of all stages.
        device: Warp's name of the device.
        given: the surface from which the distance of found stitches is measured; None for those of a modelled mesh.
    """

    def next_stage(name: str, make: Callable[[StitchMesh, dict[str, Any]], StitchMesh], *inputs: Any) -> None:
        nonlocal fabric
        before = fabric
        stage = fabric_stage(name, stage_key(name, before, *inputs))
        fabric = run.run(stage, lambda report: make(before, report))

    def relax(fabric: StitchMesh, report: dict[str, Any]) -> StitchMesh:
        """Even out the stitches, and make room for the yarns of those that were found."""
        relaxed = mesh_stage(fabric, mesh, options, device, report, run.progress)
        if given is None:
            return relaxed
        report["shape"] = run.report["shape"]
        return room_stage(relaxed, given, options, report, run.progress)

    if options.palette or options.patterns:
        next_stage(
            "apply_pattern", lambda fabric, report: pattern_stage(fabric, options, report, run.progress),
            options.palette,
            [(part.pattern, part.remainder, part.ground, _selected(part.on)) for part in options.patterns],
        )  # fmt: skip
    if options.edits:
        next_stage(
            "apply_edit", lambda fabric, report: edit_stage(fabric, options, report, run.progress),
            [_edit(edit) for edit in options.edits],
        )  # fmt: skip
    found = () if given is None else (given, options.stitch_width, *_inputs_of_room(options))
    next_stage("relax_mesh", relax, mesh, options.mesh_arguments, _processor(device), *found)
    if options.edge_forms:
        next_stage(
            "edge_forms", lambda fabric, report: edge_forms_stage(fabric, options, report),
            list(options.edge_forms), options.yarn_radius,
        )  # fmt: skip
    if options.spiral:
        next_stage("make_spiral", lambda fabric, report: spiral_stage(fabric, options, report))
    return fabric


def _inputs_of_room(options: KnitOptions) -> tuple[object, ...]:
    """What the room for the yarns depends on."""
    return options.yarn_radius, quality_named(options.quality).control_points_per_stitch, options.finish


def _selected(on: Selection | None) -> str:
    """Return a selection as text, with the content of files in the place of their paths."""
    return str(None if on is None else with_paths(on, _content))


def _edit(edit: Edit) -> tuple[str, dict[str, Any]]:
    """Return the name and the arguments of an edit, with the content of files in the place of their paths."""
    changed = edits_with_paths([edit], _content)[0]
    return changed.name, dict(changed.arguments)


def _content(path: str) -> str:
    """Return the content of a file as text."""
    return read_bytes(path).hex()


def _processor(device: str) -> str:
    """Return the kind of a device; results of two devices of one kind have the same bits."""
    return device.partition(":")[0]


def _relaxed(
    run: JobRun, fabric: StitchMesh, yarns: YarnSet, options: KnitOptions, quality: Quality, device: str
) -> Relaxation:
    """Relax the yarns, with checkpoints in the folder of the stage."""
    chosen = options.relaxation
    given = chosen.material, chosen.stiffness, chosen.rest_lengths, chosen.terms
    stage = relaxation_stage("relax_yarns", stage_key("relax_yarns", fabric, yarns, given, quality, _processor(device)))
    folder = run.kept.folder_of(stage)
    checkpoint = folder / CHECKPOINT
    run.check_resume(stage, stopped=is_file(checkpoint))

    def relax(report: dict[str, Any]) -> Relaxation:
        """Relax the yarns from their beginning or from the checkpoint."""
        saver, continues = StateSaver(run.folder, run.report, yarns), is_file(checkpoint)
        kept = Run(
            run.progress, on_state=saver.keep, checkpoints=Checkpoints(folder, run.job.relax_yarns.checkpoint_every),
            resume=checkpoint if continues else None,
        )  # fmt: skip
        before = seconds_of(checkpoint) if continues else 0.0
        with run.continued(before) if continues else nullcontext():
            relaxed = relax_with_options(
                yarns, chosen, quality=quality, device=device, fabric=fabric, keep_shape=True, run=kept,
            )  # fmt: skip
        report["yarnrelax"] = relaxed.report
        return relaxed

    relaxed = run.run(stage, relax)
    if not cut_short(relaxed.report):
        for path in (checkpoint, previous_path(checkpoint)):
            path.unlink(missing_ok=True)
    return relaxed
