# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The pipeline from a polygon mesh to files of relaxed yarns."""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, dataclass, field, replace
from os import PathLike
from pathlib import Path
from typing import Any, Literal, cast

from stitchmesh import __version__
from stitchmesh.budget.budget import Budget
from stitchmesh.budget.expectation import BudgetScene
from stitchmesh.budget.plan import limit_of, make_plan
from stitchmesh.compute.device import device_named
from stitchmesh.editing.edit import Edit, apply_edit
from stitchmesh.editing.pattern_regions import PatternRegion, lay_patterns
from stitchmesh.editing.spiral import make_spiral
from stitchmesh.errors import ParameterError, StitchMeshError, YarnError
from stitchmesh.io.contents import FilePath
from stitchmesh.io.history import HistoryEntry, write_history
from stitchmesh.io.state_saver import StateSaver, save_yarns
from stitchmesh.io.stitches import write_stitches
from stitchmesh.labeling import label
from stitchmesh.mesh import Mesh, StitchMesh
from stitchmesh.mesh.change import PaletteChange, apply_change
from stitchmesh.mesh.palette import make_palette
from stitchmesh.mesh.repair import RepairAction
from stitchmesh.mesh.stitch_counts import stitch_counts
from stitchmesh.meshrelax import MeshRelaxOptions, relax_mesh_with_report
from stitchmesh.meshrelax.relax import TOLERANCE as MESH_TOLERANCE
from stitchmesh.patterns import LaidPattern
from stitchmesh.patterns.placement.left_out import left_out_lines
from stitchmesh.progress import Progress, no_progress, relaxing_progress, shown_stages
from stitchmesh.quality import DEFAULT_QUALITY, Quality, quality_named
from stitchmesh.run_control import RunControl
from stitchmesh.shaping.found_rows import after_mesh_relaxation, found_on_mesh, found_on_panels, panel_of_face
from stitchmesh.shaping.found_stitches import FoundStitches
from stitchmesh.shaping.options import ShapingOptions
from stitchmesh.shaping.panels.options import PanelOptions
from stitchmesh.shaping.panels.panel_mesh import PanelMesh
from stitchmesh.shaping.triangle_surface import TriangleSurface
from stitchmesh.tessellate import COURSE_OVER_WALE_SPACING, STITCH_WIDTH, tessellate
from stitchmesh.tessellate.counts import EdgeName
from stitchmesh.tessellate.reached_size import reached_sizes
from stitchmesh.time_limit import limited_to, limited_to_share
from stitchmesh.yarn import YarnSet
from stitchmesh.yarn.fabric_gauge import fabric_gauge
from stitchmesh.yarn.rest_length import RestLengths, apply_rest_lengths
from stitchmesh.yarngen import YarnFinish, generate_yarns
from stitchmesh.yarngen.generate import checked_drawn_radius, checked_radius
from stitchmesh.yarngen.loop_check.loop_linking import check_loops
from stitchmesh.yarnrelax import REFERENCE_RADIUS, Relaxation, YarnMaterial, relax_yarns
from stitchmesh.yarnrelax.checkpoint import Checkpoints
from stitchmesh.yarnrelax.energies.term import ConstraintChoice, TermChoice
from stitchmesh.yarnrelax.model.material import DEFAULT_MATERIAL

SHARE_OF_MESH = 0.5
"""Largest part of the time of a budget for the relaxation of the stitch mesh; the other part is for the yarns."""
OF_LABELED_MESHES = {
    "borders": "start border", "seeds": "start edge", "flip": "flip", "counts": "count", "marked": "mark",
}  # fmt: skip
"""Fields of ``KnitOptions`` that name edges or faces of a labeled mesh, and their options on the command line."""
POINTS_OF_STITCH = 20
"""Control points of a plain stitch, for the number of stitches of yarns that name no stitches."""


@dataclass(frozen=True)
class RelaxOptions:
    """Options of the relaxation of yarns, except for quality and device.

    Raises:
        ParameterError: there is no material or no value of that name, or a value is out of bounds.
    """

    material: str = DEFAULT_MATERIAL
    """Name of a material, which is scaled to the radius of the yarns."""
    stiffness: Mapping[str, float] = field(default_factory=dict)
    """New values of single fields of the material, by name, for a yarn of ``REFERENCE_RADIUS``."""
    rest_lengths: RestLengths = field(default_factory=RestLengths)
    """Changes of the rest lengths."""
    terms: Sequence[TermChoice] = ()
    """Additional energy terms."""
    constraints: Sequence[ConstraintChoice] = ()
    """Constraints of control points."""
    checkpoint: Checkpoints | None = None
    """File and interval of checkpoints; None writes no checkpoints."""
    resume: FilePath | None = None
    """Checkpoint file from which the relaxation continues; None starts a new relaxation."""

    def __post_init__(self) -> None:
        YarnMaterial.named(self.material, self.stiffness)

    def yarn_material(self, yarn_radius: float) -> YarnMaterial:
        """Return the material of a yarn of some radius [cm]."""
        return YarnMaterial.named(self.material, self.stiffness).scaled(yarn_radius / REFERENCE_RADIUS)


@dataclass(frozen=True)
class KnitOptions:
    """Options of ``knit``.

    Raises:
        ParameterError: an option names edges or faces of a labeled mesh, and rows are found without one; or rows are
            found both on any mesh and on panels.
    """

    stitch_width: float = STITCH_WIDTH
    """Wale spacing [cm]."""
    stitch_height: float | None = None
    """Course spacing [cm]; by default 0.77 times the stitch width."""
    counts: Mapping[EdgeName, int] = field(default_factory=dict)
    """Number of stitches along single edges (``tessellate``)."""
    marked: Sequence[EdgeName] = ()
    """Wale edges at which all increases and decreases of their faces stand (``tessellate``)."""
    mesh_relaxation: MeshRelaxOptions = field(default_factory=MeshRelaxOptions)
    """Options of the relaxation of the stitch mesh."""
    yarn_radius: float | None = None
    """Yarn radius [cm]; by default an eighth of the stitch width."""
    drawn_radius: float | None = None
    """Radius of the yarn in pictures and files for renderers [cm]; by default 1.7 yarn radii (``generate_yarns``)."""
    quality: str | Quality = DEFAULT_QUALITY
    """Name of a preset of ``quality.py``, or a ``Quality``."""
    device: str | None = None
    """Warp's name of the device; None for the preferred device."""
    borders: Sequence[int | tuple[int, int]] = ()
    """Edges of borders from which rows start (``label``)."""
    seeds: Sequence[int | tuple[int, int]] = ()
    """Course edges from which rows start (``label``)."""
    flip: Sequence[int] = ()
    """Faces whose rows are reversed (``label``)."""
    shaping: ShapingOptions | None = None
    """How rows are found on a mesh of any kind (``shape_fabric``); None labels the modelled rows of the mesh."""
    panels: PanelOptions | None = None
    """How the panels of a sewing pattern are knitted (``knit_panels``); None if the mesh is no sewing pattern."""
    palette: Sequence[str] = ()
    """Colours of the yarns by number, as texts (``parse_colour``); stock colours for all other numbers."""
    patterns: Sequence[PatternRegion] = ()
    """Knitting patterns, each on its part of the fabric; plain knit elsewhere."""
    edits: Sequence[Edit] = ()
    """Edits of the stitch mesh, after the patterns and before the mesh relaxation."""
    spiral: bool = False
    """Whether the rings of tubes become turns of one spiral row."""
    finish: YarnFinish = field(default_factory=YarnFinish)
    """How rows are cast on and bound off, and which floats are cut."""
    relaxation: RelaxOptions = field(default_factory=RelaxOptions)
    """Options of the relaxation of yarns."""

    def __post_init__(self) -> None:
        if self.shaping is not None and self.panels is not None:
            raise ParameterError("panels: rows are also found on the whole mesh (--auto); leave one of the two out")
        flag = "--auto" if self.panels is None else "--panels"
        for name, words in OF_LABELED_MESHES.items() if self.finds_rows else ():
            if getattr(self, name):
                raise ParameterError(
                    f"{words}: names edges or faces of a labeled mesh, but rows are found without one ({flag}); leave "
                    "one of the two out"
                )

    @property
    def finds_rows(self) -> bool:
        """Whether rows are found, on a mesh of any kind or on panels, in the place of labeled rows."""
        return self.shaping is not None or self.panels is not None

    @property
    def mesh_arguments(self) -> dict[str, Any]:
        """Arguments of ``relax_mesh``; the aspect is that of the stitches where it is not given."""
        height = self.stitch_height
        aspect = COURSE_OVER_WALE_SPACING if height is None else height / self.stitch_width
        given = self.mesh_relaxation.aspect
        return {**asdict(self.mesh_relaxation), "aspect": aspect if given is None else given}


@dataclass(frozen=True)
class Knitted:
    """The results of ``knit``."""

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
    mesh: Mesh | PanelMesh, folder: str | PathLike[str], options: KnitOptions, *, budget: Budget | None = None,
    repair: Sequence[RepairAction] | None = None, progress: Progress | Literal[False] | None = None,
    seconds_after: Callable[[YarnSet], float] | None = None,
) -> Knitted:  # fmt: skip
    """Make relaxed yarns from a polygon mesh, and write them.

    The function writes ``stitches.h5``, ``yarns.h5``, ``yarns.bcc``, ``report.json`` and ``convergence.csv`` into the
    folder. During the relaxation of yarns, the last good state is written at intervals and when the user interrupts;
    ``report.json`` then says that the relaxation is unfinished.

    Args:
        mesh: the polygon mesh; the panels of a sewing pattern if the options have ``panels``.
        folder: output folder.
        options: options of all stages.
        budget: limits on the time of all stages and on the error; measured tables then choose the quality once the
            stitches are known, unless it is another than the default, and the report says what they chose. The
            stitches may take half of the time, and the yarns take what is left.
        repair: what was changed in the mesh before, for the report; None if the mesh was not repaired.
        progress: called with the progress of each stage; by default a line shows the progress on a terminal or in a
            notebook, and False shows nothing.
        seconds_after: function of the yarns that estimates the time of the caller's own work after this function [s];
            the progress of the last stage counts this time.

    Raises:
        StitchMeshError: a stage cannot continue; the error is that of the stage.
    """
    with limited_to(limit_of(budget)), shown_stages(progress) as report:
        return _knit(mesh, Path(folder), options, budget, repair, report, seconds_after)


def _knit(
    mesh: Mesh | PanelMesh, target: Path, options: KnitOptions, budget: Budget | None,
    repair: Sequence[RepairAction] | None, progress: Progress, seconds_after: Callable[[YarnSet], float] | None,
) -> Knitted:  # fmt: skip
    """Make and write relaxed yarns in the time that is left."""
    quality = quality_named(options.quality)
    device = str(device_named(options.device))
    quality_entry = options.quality if isinstance(options.quality, str) else asdict(options.quality)
    report: dict[str, object] = {"stitchmesh": __version__, "device": device, "quality": quality_entry}
    if repair is not None:
        report["repair"] = repair_entries(repair)
    fabric = _relaxed_stitches(mesh, options, device, report, progress)
    fabric = spiral_stage(fabric, options, report)
    if budget is not None:
        plan = make_plan(budget, BudgetScene(kind="garment", stitches=fabric.face_count), options.quality, device)
        quality, report["budget"] = plan.quality, plan.report()
        report["quality"] = plan.report()["quality"] or quality_entry
    shape = cast(Mapping[str, Any] | None, report.get("shape"))
    yarns = yarn_stage(fabric, options, quality, report, progress, shape)
    progress("yarnrelax", 0.0, f"{len(yarns.points)} control points")
    write_stitches(target / "stitches.h5", fabric)
    saver = StateSaver(target, report, yarns)
    try:
        relaxed = relax_with_options(
            yarns, options.relaxation, quality=quality, device=device, fabric=fabric, keep_shape=True,
            progress=progress, on_state=saver.keep, seconds_after=seconds_after(yarns) if seconds_after else 0.0,
        )  # fmt: skip
    except KeyboardInterrupt:
        saver.save()
        raise
    report["yarnrelax"] = relaxed.report
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
        measure_shape(fabric, shaped.given, options, report)
    return fabric


def repair_entries(actions: Sequence[RepairAction]) -> list[dict[str, object]]:
    """Return what a repair changed, as it stands in the report: each action with its text and its places."""
    return [{**asdict(action), "text": f"{action.text}: {action.places}"} for action in actions]


def relax_with_options(
    yarns: YarnSet, options: RelaxOptions, *, quality: str | Quality, device: str | None = None,
    fabric: StitchMesh | None = None, keep_shape: bool = False, start: YarnSet | None = None,
    progress: Progress = no_progress, on_state: Callable[[YarnSet], None] | None = None, seconds_after: float = 0.0,
    load_steps: bool = True, control: RunControl[YarnSet] | None = None,
) -> Relaxation:  # fmt: skip
    """Change the rest lengths of yarns, and relax the yarns.

    Args:
        yarns: the yarns.
        options: options of the relaxation.
        quality: name of a preset, or a ``Quality``.
        device: Warp's name of the device; None for the preferred device.
        fabric: the fabric from which the yarns were made, if it is known.
        keep_shape: whether the relaxation keeps the borders and the shape of the fabric.
        start: the same yarns at the positions from which the relaxation starts; ``yarns`` if None.
        progress: called with the progress of the relaxation.
        on_state: called with the last good state at intervals.
        load_steps: whether a load that the yarns cannot take at once is applied in steps.
        seconds_after: estimated time of work after the relaxation [s], which the progress counts.
        control: watches, pauses, steps and stops the relaxation from another thread.

    Raises:
        StitchMeshError: the rest lengths cannot be applied (``apply_rest_lengths``), or as for ``relax_yarns``.
    """
    quality = quality_named(quality)
    report_progress = relaxing_progress(
        "yarnrelax", quality.tolerance, progress, max_iterations=quality.max_iterations, seconds_after=seconds_after
    )
    return relax_yarns(
        apply_rest_lengths(yarns, options.rest_lengths, fabric=fabric),
        start=start,
        material=options.yarn_material(float(yarns.radius.mean())),
        quality=quality,
        device=device,
        keep_shape=fabric if keep_shape else None,
        terms=options.terms,
        constraints=options.constraints,
        progress=lambda entry: report_progress(entry["iteration"], entry["residual"], entry["energies"]),
        on_state=on_state,
        checkpoint=options.checkpoint,
        resume=options.resume,
        load_steps=load_steps,
        control=control,
    )


def relax_within_budget(
    budget: Budget, yarns: YarnSet, options: RelaxOptions, *, quality: str | Quality = DEFAULT_QUALITY,
    device: str | None = None, **arguments: Any,
) -> Relaxation:  # fmt: skip
    """Relax yarns as ``relax_with_options`` does, within limits on the time and on the error.

    Measured tables choose the quality, unless it is another than the default; the yarns keep their sampling.

    Args:
        budget: the limits.
        yarns: the yarns.
        options: options of the relaxation.
        quality: name of a preset, or a ``Quality``.
        device: Warp's name of the device; None for the preferred device.
        **arguments: the other arguments of ``relax_with_options``.

    Raises:
        StitchMeshError: a quality beside an error, a time that is over, or as for ``relax_with_options``.
    """
    stitches = max(round(len(yarns.points) / POINTS_OF_STITCH), 1)
    with limited_to(limit_of(budget)):
        scene = BudgetScene(kind="garment" if yarns.lattice is None else "given cell", stitches=stitches)
        plan = make_plan(budget, scene, quality, device)
        relaxed = relax_with_options(yarns, options, quality=plan.quality, device=device, **arguments)
    return replace(relaxed, report=relaxed.report | {"budget": plan.report()})


def label_stage(mesh: Mesh, options: KnitOptions, report: dict[str, object], progress: Progress) -> StitchMesh:
    """Find the knitting rows of a mesh."""
    clock = _Clock()
    progress("label", 0.0, f"{mesh.face_count} faces")
    labeled = label(mesh, borders=options.borders, seeds=options.seeds, flip=options.flip)
    report["label"] = {"seconds": clock.lap(), "rows": int(labeled.row.max()) + 1, "faces": labeled.face_count}
    return labeled


def tessellate_stage(
    labeled: StitchMesh, options: KnitOptions, report: dict[str, object], progress: Progress
) -> StitchMesh:
    """Divide a labeled mesh into stitches; the radii of the yarn are checked before the stages that take long."""
    clock = _Clock()
    progress("tessellate", 0.0, f"{int(labeled.row.max()) + 1} rows")
    fabric = tessellate(
        labeled, stitch_width=options.stitch_width, stitch_height=options.stitch_height, counts=options.counts,
        marked=options.marked,
    )  # fmt: skip
    checked_drawn_radius(checked_radius(fabric, options.yarn_radius), options.drawn_radius)
    report["tessellate"] = {"seconds": clock.lap(), **stitch_counts(fabric), **reached_sizes(fabric)}
    return fabric


def whole_mesh(mesh: Mesh | PanelMesh) -> Mesh:
    """Return the mesh of a garment whose rows are labeled or found on the whole of it.

    Raises:
        ParameterError: the garment is a sewing pattern, and the options do not say how its panels are knitted.
    """
    if isinstance(mesh, PanelMesh):
        raise ParameterError("mesh: got the panels of a sewing pattern; set panels=PanelOptions() in the options")
    return mesh


def shape_stage(
    mesh: Mesh | PanelMesh, options: KnitOptions, report: dict[str, object], progress: Progress
) -> FoundStitches:
    """Find rows and stitches on a mesh of any kind or on panels; radii are checked as in ``tessellate_stage``."""
    width, height = options.stitch_width, options.stitch_height
    if options.panels is None:
        shaping = ShapingOptions() if options.shaping is None else options.shaping
        found, report["shape"] = found_on_mesh(
            whole_mesh(mesh), shaping, stitch_width=width, stitch_height=height, progress=progress
        )
    elif isinstance(mesh, PanelMesh):
        found, report["shape"] = found_on_panels(
            mesh, options.panels, stitch_width=width, stitch_height=height, progress=progress
        )
    else:
        raise ParameterError("panels: got a mesh that is no sewing pattern; read it by sm.read_panels(path)")
    checked_drawn_radius(checked_radius(found.fabric, options.yarn_radius), options.drawn_radius)
    return found


def measure_shape(fabric: StitchMesh, surface: TriangleSurface, options: KnitOptions, report: dict[str, Any]) -> None:
    """Measure the relaxed stitches for the report of found rows."""
    report["shape"] = after_mesh_relaxation(fabric, surface, options.stitch_width, report["shape"])


def pattern_stage(
    fabric: StitchMesh, options: KnitOptions, report: dict[str, object], progress: Progress
) -> StitchMesh:
    """Give a fabric its colours and its patterns."""
    clock = _Clock()
    if options.palette:
        fabric = apply_change(fabric, PaletteChange(make_palette(options.palette)))
    if options.patterns:
        progress("pattern", 0.0, ", ".join(region.pattern.name for region in options.patterns))
        laid = lay_patterns(fabric, options.patterns)
        fabric = laid[-1].fabric
        entries = [_pattern_entry(region, one) for region, one in zip(options.patterns, laid, strict=True)]
        report["patterns"] = {"seconds": clock.lap(), "laid": entries}
    return fabric


def _pattern_entry(region: PatternRegion, laid: LaidPattern) -> dict[str, object]:
    left_out = [{"faces": len(part.faces), "rows": part.rows, "wales": part.wales, "reason": part.reason}
                for part in laid.left_out]  # fmt: skip
    on = None if region.on is None else str(region.on)
    words = left_out_lines(laid.left_out)
    return {"name": region.pattern.name, "on": on, "faces": laid.faces_laid, "summary": words, "left_out": left_out}


def edit_stage(fabric: StitchMesh, options: KnitOptions, report: dict[str, object], progress: Progress) -> StitchMesh:
    """Apply the edits of the options."""
    clock = _Clock()
    for number, edit in enumerate(options.edits):
        progress("edit", number / len(options.edits), edit.name)
        fabric = _edited(fabric, edit)
    if options.edits:
        report["edits"] = {"seconds": clock.lap(), "count": len(options.edits)}
    return fabric


def _edited(fabric: StitchMesh, edit: Edit) -> StitchMesh:
    """Return the fabric after an edit; an error names the edit."""
    try:
        return apply_edit(fabric, edit).fabric
    except StitchMeshError as error:
        raise type(error)(f"edit {edit.name}: {error}") from error


def mesh_stage(
    fabric: StitchMesh, mesh: Mesh, options: KnitOptions, device: str, report: dict[str, object], progress: Progress
) -> StitchMesh:
    """Relax the stitch mesh on the surface of its mesh, in a part of the time of a budget."""
    clock = _Clock()
    progress("meshrelax", 0.0, f"{fabric.face_count} stitches")
    with limited_to_share(SHARE_OF_MESH):
        relaxed, how = relax_mesh_with_report(
            fabric, surface=mesh, device=device, progress=relaxing_progress("meshrelax", MESH_TOLERANCE, progress),
            **options.mesh_arguments,
        )  # fmt: skip
    report["meshrelax"] = {**asdict(how), "seconds": clock.lap()}
    report["gauge"] = asdict(fabric_gauge(relaxed))
    return relaxed


def spiral_stage(fabric: StitchMesh, options: KnitOptions, report: dict[str, object]) -> StitchMesh:
    """Join the rings of tubes to one spiral row, if the options ask for it."""
    if not options.spiral:
        return fabric
    clock = _Clock()
    spiral = make_spiral(fabric)
    report["spiral"] = {"spirals": len(spiral.vertices) - len(fabric.vertices), "seconds": clock.lap()}
    return spiral


def yarn_stage(
    fabric: StitchMesh, options: KnitOptions, quality: Quality, report: dict[str, object], progress: Progress,
    shape: Mapping[str, Any] | None = None,
) -> YarnSet:  # fmt: skip
    """Generate the yarns of a fabric; ``shape`` is the entry of found rows in the report.

    Loops are checked on panels, because not every direction has room for the yarns at every seam and tip.

    Raises:
        YarnError: as for ``generate_yarns``; for panels also as for ``check_loops``, and the message names the panel.
    """
    clock = _Clock()
    progress("yarngen", 0.0, f"{fabric.face_count} stitches")
    try:
        yarns = generate_yarns(
            fabric, yarn_radius=options.yarn_radius, drawn_radius=options.drawn_radius, quality=quality,
            **asdict(options.finish),
        )  # fmt: skip
        if options.panels is not None:
            check_loops(fabric, yarns, finish=options.finish)
    except YarnError as error:
        raise _with_panel(error, fabric, shape or {}) from error
    report["yarngen"] = {
        "seconds": clock.lap(),
        "yarns": yarns.yarn_count,
        "control_points": len(yarns.points),
        "length_cm": round(float(yarns.lengths.sum()), 3),
    }
    return yarns


def _with_panel(error: YarnError, fabric: StitchMesh, shape: Mapping[str, Any]) -> YarnError:
    """Return an error about the yarns of a face with the panel of the face, and what helps there."""
    panel = None if error.face is None else panel_of_face(error.face, fabric, shape)
    if panel is None:
        return error
    return YarnError(
        f"panel {panel}: {error}; or choose another direction of this panel (--panel-direction), or leave its seams "
        "to be sewn (--sew)",
        face=error.face,
    )


class _Clock:
    """A stopwatch."""

    def __init__(self) -> None:
        self._last = time.perf_counter()

    def lap(self) -> float:
        """Return the seconds since the last call, or since the construction."""
        now = time.perf_counter()
        seconds, self._last = now - self._last, now
        return round(seconds, 4)
