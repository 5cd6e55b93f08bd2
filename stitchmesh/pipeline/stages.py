# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The stages from a mesh to relaxed yarns, each a function from a garment to a value and its report.

``stage_table`` has their order. Each function also takes a run, and reports its progress to this run.
"""

from __future__ import annotations

import logging
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import asdict, replace
from functools import partial
from typing import Any

import numpy as np

from stitchmesh.budget.plan import Plan, make_plan
from stitchmesh.budget.tables import BudgetScene
from stitchmesh.editing.edge_forms import with_edge_forms
from stitchmesh.editing.edit import Edit, apply_edit
from stitchmesh.editing.pattern_regions import PatternRegion, lay_patterns
from stitchmesh.editing.spiral import make_spiral
from stitchmesh.errors import ParameterError, StitchMeshError, YarnError
from stitchmesh.labeling import label
from stitchmesh.mesh import StitchMesh
from stitchmesh.mesh.change import PaletteChange, apply_change
from stitchmesh.mesh.palette import make_palette
from stitchmesh.mesh.shaping_stitches import stitch_counts, with_increases
from stitchmesh.meshrelax import relax_mesh
from stitchmesh.patterns import LaidPattern
from stitchmesh.patterns.placement.left_out import left_out_lines
from stitchmesh.pipeline.garment import Garment, Made, whole_mesh
from stitchmesh.pipeline.options import KnitOptions
from stitchmesh.pipeline.yarn_relaxation import relax_with_options
from stitchmesh.progress import Progress, no_progress
from stitchmesh.quality import Quality
from stitchmesh.run import Run
from stitchmesh.shaping.found_rows import after_mesh_relaxation, found_on_mesh, found_on_panels, panel_of_face
from stitchmesh.shaping.found_stitches import FoundStitches
from stitchmesh.shaping.options import ShapingOptions
from stitchmesh.shaping.panels.panel_mesh import PanelMesh
from stitchmesh.shaping.triangle_surface import TriangleSurface
from stitchmesh.tessellate import tessellate
from stitchmesh.tessellate.counts import reached_sizes
from stitchmesh.time_limit import limited_to_share
from stitchmesh.yarn import YarnSet
from stitchmesh.yarn.stitch_size import fabric_gauge
from stitchmesh.yarngen import generate_yarns
from stitchmesh.yarngen.generate import checked_drawn_radius, checked_radius
from stitchmesh.yarngen.loop_check.loop_linking import check_loops
from stitchmesh.yarngen.room import make_room
from stitchmesh.yarnrelax import Relaxation

logger = logging.getLogger(__name__)

SHARE_OF_MESH = 0.5
"""Largest part of the time of a budget that the relaxation of the stitch mesh may take; the rest is for the yarns."""


def label_stage(garment: Garment, run: Run[YarnSet]) -> Made[StitchMesh]:
    """Find the knitting rows of a mesh."""
    began = time.perf_counter()
    mesh, options = whole_mesh(garment.mesh), garment.options
    _progress(run)("label", 0.0, f"{mesh.face_count} faces")
    labeled = label(mesh, borders=options.borders, seeds=options.seeds, flip=options.flip)
    figures = {"seconds": _since(began), "rows": int(labeled.row.max()) + 1, "faces": labeled.face_count}
    return Made(labeled, {"label": figures})


def auto_stitches_stage(garment: Garment, run: Run[YarnSet]) -> Made[FoundStitches]:
    """Find rows and stitches on a mesh of any kind, and check the radii of the yarn."""
    options = garment.options
    found, figures = found_on_mesh(
        whole_mesh(garment.mesh), options.shaping or ShapingOptions(), stitch_width=options.stitch_width,
        stitch_height=options.stitch_height, progress=_progress(run),
    )  # fmt: skip
    return Made(_checked(found, options), {"shape": figures})


def shape_panels_stage(garment: Garment, run: Run[YarnSet]) -> Made[FoundStitches]:
    """Find rows and stitches on the panels of a sewing pattern, and check the radii of the yarn."""
    options = garment.options
    if options.panels is None or not isinstance(garment.mesh, PanelMesh):
        raise ParameterError("panels: got a mesh that is no sewing pattern; read it by sm.read_panels(path)")
    found, figures = found_on_panels(
        garment.mesh, options.panels, stitch_width=options.stitch_width, stitch_height=options.stitch_height,
        progress=_progress(run),
    )  # fmt: skip
    return Made(_checked(found, options), {"shape": figures})


def _checked(found: FoundStitches, options: KnitOptions) -> FoundStitches:
    """Return found stitches with the increases of the options, if the yarn has possible radii."""
    _check_radii(found.fabric, options)
    return replace(found, fabric=with_increases(found.fabric, options.increase))


def tessellate_stage(garment: Garment, run: Run[YarnSet]) -> Made[StitchMesh]:
    """Divide a labeled mesh into stitches, and check the radii of the yarn."""
    began = time.perf_counter()
    labeled, options = garment.fabric, garment.options
    _progress(run)("tessellate", 0.0, f"{int(labeled.row.max()) + 1} rows")
    fabric = tessellate(
        labeled, stitch_width=options.stitch_width, stitch_height=options.stitch_height, counts=options.counts,
        marked=options.marked, increase=options.increase,
    )  # fmt: skip
    _check_radii(fabric, options)
    return Made(fabric, {"tessellate": {"seconds": _since(began), **stitch_counts(fabric), **reached_sizes(fabric)}})


def _check_radii(fabric: StitchMesh, options: KnitOptions) -> None:
    """Refuse radii of the yarn that are not possible, before the stages that take long."""
    checked_drawn_radius(checked_radius(fabric, options.yarn_radius), options.drawn_radius)


def apply_pattern_stage(garment: Garment, run: Run[YarnSet]) -> Made[StitchMesh]:
    """Give a fabric its colours and its patterns."""
    began = time.perf_counter()
    fabric, options = garment.fabric, garment.options
    if options.palette:
        fabric = apply_change(fabric, PaletteChange(make_palette(options.palette)))
    if not options.patterns:
        return Made(fabric, {})
    _progress(run)("pattern", 0.0, ", ".join(region.pattern.name for region in options.patterns))
    laid = lay_patterns(fabric, options.patterns)
    entries = [_pattern_entry(region, one, options) for region, one in zip(options.patterns, laid, strict=True)]
    return Made(laid[-1].fabric, {"patterns": {"seconds": _since(began), "laid": entries}})


def _pattern_entry(region: PatternRegion, laid: LaidPattern, options: KnitOptions) -> dict[str, object]:
    left_out = [{"faces": len(part.faces), "rows": part.rows, "wales": part.wales, "reason": part.reason}
                for part in laid.left_out]  # fmt: skip
    on = None if region.on is None else str(region.on)
    words = [*left_out_lines(laid.left_out), *_multiple_line(region, laid, options)]
    return {
        "name": region.pattern.name, "on": on, "faces": laid.faces_laid, "breaks_rounds": laid.breaks_rounds,
        "summary": words, "left_out": left_out,
    }  # fmt: skip


def _multiple_line(region: PatternRegion, laid: LaidPattern, options: KnitOptions) -> list[str]:
    """Return a line that proposes rounds of whole repeats, if the repeats leave stitches of rounds over."""
    width = region.pattern.width
    made = options.shaping is not None and options.shaping.multiple % width == 0
    if made or not laid.breaks_rounds or options.panels is not None:
        return []
    found = f"--multiple {width}" if options.shaping else f"--auto --multiple {width}"
    return [f"rounds hold whole repeats of {width} stitches with {found}, or with --pattern-remainder stretch"]


def apply_edit_stage(garment: Garment, run: Run[YarnSet]) -> Made[StitchMesh]:
    """Apply the edits of the options."""
    began = time.perf_counter()
    fabric, edits = garment.fabric, garment.options.edits
    for number, edit in enumerate(edits):
        _progress(run)("edit", number / len(edits), edit.name)
        fabric = _edited(fabric, edit)
    return Made(fabric, {"edits": {"seconds": _since(began), "count": len(edits)}})


def _edited(fabric: StitchMesh, edit: Edit) -> StitchMesh:
    """Return the fabric after an edit; an error names the edit."""
    try:
        return apply_edit(fabric, edit).fabric
    except StitchMeshError as error:
        raise type(error)(f"edit {edit.name}: {error}") from error


def relax_mesh_stage(garment: Garment, run: Run[StitchMesh]) -> Made[StitchMesh]:
    """Relax the stitch mesh on its surface, in a part of the time of a budget, and make room for yarns of found rows.

    Raises:
        YarnError: the yarns of found rows find no room; the message names the place, the panel, and a remedy.
    """
    began = time.perf_counter()
    fabric, options = garment.fabric, garment.options
    _progress(run)("meshrelax", 0.0, f"{fabric.face_count} stitches")
    with limited_to_share(SHARE_OF_MESH):
        relaxed = relax_mesh(
            fabric, surface=garment.surface, options=options.mesh_relax_options, device=garment.device, run=run
        )
    report = {
        "meshrelax": {**asdict(relaxed.report), "seconds": _since(began)},
        "gauge": asdict(fabric_gauge(relaxed.fabric)),
    }
    if garment.found is None:
        return Made(relaxed.fabric, report)
    _progress(run)("meshrelax", 1.0, "room for the yarns")
    roomy, shape = _with_room(garment, relaxed.fabric, garment.found.given)
    return Made(roomy, {**report, "shape": shape})


def _with_room(garment: Garment, fabric: StitchMesh, given: TriangleSurface) -> tuple[StitchMesh, dict[str, Any]]:
    """Make room for the yarns where a surface has none, and measure how all stitches fit it."""
    options, shape = garment.options, garment.report["shape"]
    with _refused(garment, fabric):
        room = make_room(
            fabric, yarn_radius=options.yarn_radius, quality=garment.quality, finish=options.finish
        )
    farthest = room.farthest / options.stitch_width
    if room.faces:
        logger.warning(
            f"the surface has no room for the yarns of {len(room.faces)} stitches, such as stitch {room.faces[0]}; "
            f"stitches were moved there by up to {farthest:.1f} stitch widths"
        )
    fit = after_mesh_relaxation(room.fabric, given, options.stitch_width, shape)
    return room.fabric, {**fit, "crowded": len(room.faces), "farthest_moved": round(farthest, 3)}


def edge_forms_stage(garment: Garment, run: Run[YarnSet]) -> Made[StitchMesh]:
    """Add the rows of folded and rolled edges."""
    began = time.perf_counter()
    fabric, options = garment.fabric, garment.options
    edged = with_edge_forms(fabric, options.edge_forms, checked_radius(fabric, options.yarn_radius))
    figures = {"stitches": edged.face_count - fabric.face_count, "seconds": _since(began)}
    return Made(edged, {"edge_forms": figures})


def make_spiral_stage(garment: Garment, run: Run[YarnSet]) -> Made[StitchMesh]:
    """Join the rings of tubes to one spiral row."""
    began = time.perf_counter()
    spiral = make_spiral(garment.fabric)
    count = len(spiral.vertices) - len(garment.fabric.vertices)
    return Made(spiral, {"spiral": {"spirals": count, "seconds": _since(began)}})


def budget_stage(garment: Garment, run: Run[YarnSet]) -> Made[Quality]:
    """Choose the quality by the budget and the number of stitches.

    Raises:
        ParameterError: the options state a quality, and the budget states an error.
    """
    assert garment.budget is not None
    scene = BudgetScene(kind="garment", stitches=garment.fabric.face_count)
    return planned_quality(
        make_plan(garment.budget, scene, garment.options.quality, garment.device), garment.quality_entry
    )


def planned_quality(plan: Plan, given: str | dict[str, Any]) -> Made[Quality]:
    """Return the quality of a plan; ``given`` is the quality of the options in the form of the report."""
    entry = plan.report()
    return Made(plan.quality, {"budget": entry, "quality": entry["quality"] or given})


def generate_yarns_stage(garment: Garment, run: Run[YarnSet]) -> Made[YarnSet]:
    """Generate the yarns of a fabric.

    The loops of panels are checked, because some directions of knitting leave no room for the yarns at a seam or tip.

    Raises:
        YarnError: as for ``generate_yarns``, and on panels as for ``check_loops`` too; the message names the place, the
            panel, and a remedy.
    """
    began = time.perf_counter()
    fabric = garment.fabric
    _progress(run)("yarngen", 0.0, f"{fabric.face_count} stitches")
    with _refused(garment, fabric):
        yarns = _generated(garment, fabric, garment.options.yarn_radius)
    figures = {
        "seconds": _since(began),
        "yarns": yarns.yarn_count,
        "control_points": len(yarns.points),
        "length_cm": round(float(yarns.lengths.sum()), 3),
    }
    return Made(yarns, {"yarngen": figures})


def _generated(garment: Garment, fabric: StitchMesh, radius: float | None) -> YarnSet:
    """Generate the yarns of a radius [cm], and check their loops on panels."""
    options = garment.options
    yarns = generate_yarns(
        fabric, yarn_radius=radius, drawn_radius=options.drawn_radius, mass_per_length=options.mass_per_length,
        quality=garment.quality, finish=options.finish, device=garment.device,
    )  # fmt: skip
    if options.panels is not None:
        check_loops(fabric, yarns, finish=options.finish)
    return replace(yarns, made_of=options.yarn)


@contextmanager
def _refused(garment: Garment, fabric: StitchMesh) -> Iterator[None]:
    """Give errors about yarns their place, their panel and a remedy."""
    try:
        yield
    except YarnError as error:
        panel = None if error.face is None else panel_of_face(error.face, fabric, garment.report.get("shape", {}))
        radius = checked_radius(fabric, garment.options.yarn_radius)
        raise _with_place_and_remedy(error, fabric, panel, partial(_generated, garment, fabric), radius) from error


def _with_place_and_remedy(
    error: YarnError, fabric: StitchMesh, panel: int | None, made: Callable[[float], YarnSet], radius: float
) -> YarnError:
    """Return an error about the yarns of a stitch with its place, and with a remedy for those who knit a garment.

    Numbers of stitches say nothing to a user who gave a mesh. A thinner yarn is proposed only after a trial.

    Args:
        error: the error; it is returned as it is if it names no stitch.
        fabric: the stitches.
        panel: the panel of the stitch, if it has one.
        made: function that generates and checks the yarns of a radius [cm].
        radius: the radius that failed [cm].
    """
    if error.face is None:
        return error
    corners = fabric.face_vertex[fabric.sides_of(np.array([error.face]))]
    place = ", ".join(f"{value:.1f}" for value in fabric.vertices[corners].mean(axis=0))
    named = "" if panel is None else f"panel {panel}: "
    thinner = _thinner(made, radius)
    if thinner is not None:
        remedy = f"a yarn radius of {thinner:g} cm works (--yarn-radius {thinner:g})"
    elif panel is not None:
        remedy = "choose another direction of this panel (--panel-direction), or leave its seams to be sewn (--sew)"
    else:
        remedy = (
            "thinner yarns fail there too: two parts of the mesh touch there or fold sharply; move them apart by a "
            "stitch, make the mesh smoother there, or choose another stitch width"
        )
    return YarnError(f"{named}near ({place}) cm: {error.found}", face=error.face, remedy=remedy)


def _thinner(made: Callable[[float], YarnSet], radius: float) -> float | None:
    """Return the largest tried radius whose yarns can be made, rounded as in the message; None if there is none."""
    for part in (0.8, 0.6, 0.45):  # A still thinner yarn would not look knitted.
        thinner = float(f"{part * radius:.2g}")
        try:
            made(thinner)
        except StitchMeshError:
            continue
        return thinner
    return None


def relax_yarns_stage(garment: Garment, run: Run[YarnSet]) -> Made[Relaxation]:
    """Relax the yarns, which keep the borders and the shape of the fabric."""
    relaxed = relax_with_options(
        garment.yarns, garment.options.relaxation, quality=garment.quality, device=garment.device,
        fabric=garment.fabric, run=run,
    )  # fmt: skip
    return Made(relaxed, {"yarnrelax": relaxed.report})


def _progress(run: Run[Any]) -> Progress:
    return run.progress or no_progress


def _since(began: float) -> float:
    """Return the seconds since a time of ``time.perf_counter``, as they stand in the report."""
    return round(time.perf_counter() - began, 4)
