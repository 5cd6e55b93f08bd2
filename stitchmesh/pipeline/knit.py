# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The whole pipeline: from a polygon mesh to files of relaxed yarns."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from os import PathLike
from pathlib import Path

from stitchmesh.budget.budget import Budget
from stitchmesh.budget.plan import limit_of
from stitchmesh.editing.pattern_regions import PatternRegion
from stitchmesh.errors import LabelError
from stitchmesh.io.history import HistoryEntry, write_history
from stitchmesh.io.library_meshes import MeshLike, as_mesh
from stitchmesh.io.state_saver import StateSaver, save_yarns
from stitchmesh.io.stitches import write_stitches
from stitchmesh.mesh import Mesh, StitchMesh
from stitchmesh.mesh.repair import RepairAction
from stitchmesh.patterns import Pattern
from stitchmesh.pipeline.garment import Garment
from stitchmesh.pipeline.options import KnitOptions
from stitchmesh.pipeline.stage_table import RELAX_YARNS, ROWS, STITCHES, YARNS, Work, run_stages
from stitchmesh.progress import no_progress, shown_stages, with_work_after
from stitchmesh.quality import DEFAULT_QUALITY, Quality
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

    ``knit_recipe`` makes a garment with all possible settings.

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
        StitchMeshError: another stage cannot continue; the stage raises the error.
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
            stitches are known, unless it differs from the default, and the report says what they chose. The stitches
            may take half of the time, and the yarns take the rest.
        repair: what was changed in the mesh before, for the report; None if the mesh was not repaired.
        run: progress of all stages; checkpoints and control of the relaxation of yarns.
        seconds_after: function of the yarns that estimates the time of the caller's own work after this function [s];
            the progress of the last stage counts this time.

    Raises:
        StitchMeshError: a stage cannot continue; the stage raises the error.
    """
    with limited_to(limit_of(budget)), shown_stages(run.progress) as progress:
        garment = Garment.begin(mesh, options, budget=budget, repair=repair)
        target = None if folder is None else Path(folder)
        return _knit(garment, target, replace(run, progress=progress), seconds_after)


def _knit(
    garment: Garment, target: Path | None, run: Run[YarnSet], seconds_after: Callable[[YarnSet], float] | None
) -> Knitted:
    """Make and write relaxed yarns in the time that is left."""
    garment = run_stages((*ROWS, *STITCHES, *YARNS), garment, _keeping_nothing(Run(run.progress)))
    progress = run.progress or no_progress
    progress("yarnrelax", 0.0, f"{len(garment.yarns.points)} control points")
    saver = None
    if target is not None:
        saver = StateSaver(target, garment.report, garment.yarns)
        write_stitches(target / "stitches.h5", garment.fabric)
        run = replace(run, on_state=saver.keep)
    if seconds_after is not None:
        run = replace(run, progress=with_work_after(progress, seconds_after(garment.yarns)))
    try:
        garment = run_stages((RELAX_YARNS,), garment, _keeping_nothing(run))
    except KeyboardInterrupt:
        if saver is not None:
            saver.save()
        raise
    relaxed, report = garment.relaxed, dict(garment.report)
    if target is not None:
        save_yarns(target, relaxed.yarns, report)
        write_history(target / "convergence.csv", relaxed.history)
    return Knitted(garment.fabric, relaxed.yarns, report, relaxed.history)


def _keeping_nothing(run: Run[YarnSet]) -> Work:
    """Return the function that runs each stage and keeps no value of it."""
    return lambda stage, garment: stage.run(garment, run)
