# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The whole pipeline: from a polygon mesh to files of relaxed yarns."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from os import PathLike
from pathlib import Path
from typing import Any, cast

from stitchmesh import __version__
from stitchmesh.budget.budget import Budget
from stitchmesh.budget.plan import limit_of, make_plan
from stitchmesh.budget.tables import BudgetScene
from stitchmesh.compute.device import device_named
from stitchmesh.editing.pattern_regions import PatternRegion
from stitchmesh.errors import LabelError
from stitchmesh.io.history import HistoryEntry, write_history
from stitchmesh.io.library_meshes import MeshLike, as_mesh
from stitchmesh.io.state_saver import StateSaver, save_yarns
from stitchmesh.io.stitches import write_stitches
from stitchmesh.mesh import Mesh, StitchMesh
from stitchmesh.mesh.repair import RepairAction
from stitchmesh.patterns import Pattern
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
from stitchmesh.progress import Progress, shown_stages, with_work_after
from stitchmesh.quality import DEFAULT_QUALITY, Quality, quality_named
from stitchmesh.run import SHOWN, Run
from stitchmesh.shaping.options import ShapingOptions
from stitchmesh.shaping.panels.panel_mesh import PanelMesh
from stitchmesh.tessellate import STITCH_WIDTH
from stitchmesh.time_limit import limited_to
from stitchmesh.yarn import YarnSet


@dataclass(frozen=True)
class Knitted:
    """The results of ``knit`` and ``knit_recipe``."""

    fabric: StitchMesh
    """Stitch mesh after mesh relaxation."""
    yarns: YarnSet
    """Relaxed yarns."""
    report: dict[str, object]
    """Figures of all stages, as in ``report.json``."""
    history: Sequence[HistoryEntry]
    """Assessments of the relaxation of yarns, in order."""

    def __repr__(self) -> str:
        """Return one line: the fabric, and the yarns."""
        return f"Knitted({self.fabric}, {self.yarns})"


def knit(
    mesh: MeshLike, *, stitch_width: float = STITCH_WIDTH, auto: bool = False, pattern: Pattern | None = None,
    quality: str | Quality = DEFAULT_QUALITY, device: str | None = None, folder: str | PathLike[str] | None = None,
    run: Run[YarnSet] = SHOWN,
) -> Knitted:  # fmt: skip
    """Make relaxed yarns from a polygon mesh.

    ``knit_recipe`` makes a garment with all that can be chosen.

    Args:
        mesh: a ``Mesh``, or a ``trimesh.Trimesh``, ``meshio.Mesh`` or ``pyvista.PolyData`` with lengths in centimetres.
        stitch_width: wale spacing [cm].
        auto: whether rows are found on a mesh of any kind, such as triangles; if not, the rows of the mesh are labeled.
        pattern: knitting pattern on the whole fabric; plain knit if it is None.
        quality: name of a preset of ``quality.py``, or a ``Quality``.
        device: Warp's name of the device; None for the preferred device.
        folder: folder of the files that ``knit_and_write`` writes; None writes no files.
        run: progress of all stages; checkpoints and control of the relaxation of yarns.

    Raises:
        ParameterError: the mesh is no mesh, or a number is out of bounds.
        LabelError: rows are to be labeled, and the mesh has none.
        StitchMeshError: another stage cannot continue; the error is that of the stage.
    """
    options = KnitOptions(
        stitch_width=stitch_width,
        shaping=ShapingOptions() if auto else None,
        patterns=() if pattern is None else (PatternRegion(pattern),),
        quality=quality,
        device=device,
    )
    try:
        return knit_and_write(as_mesh(mesh, place="knit"), folder, options, run=run)
    except LabelError as error:
        remedy = "knit it with auto=True, which finds rows where a mesh has none; or change the mesh"
        raise LabelError(f"{remedy}: {error}", labeling=error.labeling) from error


def knit_and_write(
    mesh: Mesh | PanelMesh, folder: str | PathLike[str] | None, options: KnitOptions, *, budget: Budget | None = None,
    repair: Sequence[RepairAction] | None = None, run: Run[YarnSet] = SHOWN,
    seconds_after: Callable[[YarnSet], float] | None = None,
) -> Knitted:  # fmt: skip
    """Make relaxed yarns from a polygon mesh, and write them.

    The function writes ``stitches.h5``, ``yarns.h5``, ``yarns.bcc``, ``report.json`` and ``convergence.csv`` into the
    folder. During the relaxation of yarns, the last good state is written at intervals and when the user interrupts;
    ``report.json`` then says that the relaxation is unfinished.

    Args:
        mesh: the polygon mesh; the panels of a sewing pattern if the options have ``panels``.
        folder: output folder; None writes no files.
        options: options of all stages.
        budget: limits on the time of all stages and on the error; measured tables then choose the quality once the
            stitches are known, unless it is another than the default, and the report says what they chose. The
            stitches may take half of the time, and the yarns take what is left.
        repair: what was changed in the mesh before, for the report; None if the mesh was not repaired.
        run: progress of all stages; checkpoints and control of the relaxation of yarns.
        seconds_after: function of the yarns that estimates the time of the caller's own work after this function [s];
            the progress of the last stage counts this time.

    Raises:
        StitchMeshError: a stage cannot continue; the error is that of the stage.
    """
    with limited_to(limit_of(budget)), shown_stages(run.progress) as report:
        target = None if folder is None else Path(folder)
        return _knit(mesh, target, options, budget, repair, report, run, seconds_after)


def _knit(
    mesh: Mesh | PanelMesh, target: Path | None, options: KnitOptions, budget: Budget | None,
    repair: Sequence[RepairAction] | None, progress: Progress, run: Run[YarnSet],
    seconds_after: Callable[[YarnSet], float] | None,
) -> Knitted:  # fmt: skip
    """Make and write relaxed yarns in the time that is left."""
    quality = quality_named(options.quality)
    device = str(device_named(options.device))
    quality_entry = options.quality if isinstance(options.quality, str) else asdict(options.quality)
    report: dict[str, object] = {"stitchmesh": __version__, "device": device, "quality": quality_entry}
    if repair is not None:
        report["repair"] = repair_entries(repair)
    fabric = _relaxed_stitches(mesh, options, device, report, progress)
    fabric = spiral_stage(edge_forms_stage(fabric, options, report), options, report)
    if budget is not None:
        plan = make_plan(budget, BudgetScene(kind="garment", stitches=fabric.face_count), options.quality, device)
        quality, report["budget"] = plan.quality, plan.report()
        report["quality"] = plan.report()["quality"] or quality_entry
    shape = cast(Mapping[str, Any] | None, report.get("shape"))
    yarns = yarn_stage(fabric, options, quality, report, progress, shape)
    progress("yarnrelax", 0.0, f"{len(yarns.points)} control points")
    saver = None if target is None else StateSaver(target, report, yarns)
    if target is not None:
        write_stitches(target / "stitches.h5", fabric)
    shown = with_work_after(progress, seconds_after(yarns)) if seconds_after else progress
    try:
        relaxed = relax_with_options(
            yarns, options.relaxation, quality=quality, device=device, fabric=fabric, keep_shape=True,
            run=replace(run, progress=shown, on_state=saver.keep if saver else run.on_state),
        )  # fmt: skip
    except KeyboardInterrupt:
        if saver is not None:
            saver.save()
        raise
    report["yarnrelax"] = relaxed.report
    if target is not None:
        save_yarns(target, relaxed.yarns, report)
        write_history(target / "convergence.csv", relaxed.history)
    return Knitted(fabric, relaxed.yarns, report, relaxed.history)


def _relaxed_stitches(
    mesh: Mesh | PanelMesh, options: KnitOptions, device: str, report: dict[str, object], progress: Progress
) -> StitchMesh:
    """Make the stitches with their patterns and edits, and relax them on the surface."""
    shaped = shape_stage(mesh, options, report, progress) if options.finds_rows else None
    if shaped is None:
        surface = whole_mesh(mesh)
        fabric = tessellate_stage(label_stage(surface, options, report, progress), options, report, progress)
    else:
        fabric, surface = shaped.fabric, shaped.surface_mesh
    fabric = pattern_stage(fabric, options, report, progress)
    fabric = edit_stage(fabric, options, report, progress)
    fabric = mesh_stage(fabric, surface, options, device, report, progress)
    if shaped is not None:
        fabric = room_stage(fabric, shaped.given, options, report, progress)
    return fabric


def repair_entries(actions: Sequence[RepairAction]) -> list[dict[str, object]]:
    """Return what a repair changed, as it stands in the report: each action with its text and its places."""
    return [{**asdict(action), "text": f"{action.text}: {action.places}"} for action in actions]
