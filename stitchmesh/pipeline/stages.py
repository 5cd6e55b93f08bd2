# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The stages of the pipeline up to yarns; each adds its figures to the report."""

from __future__ import annotations

import logging
import time
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import asdict, replace
from functools import partial
from typing import Any

from stitchmesh.editing.edge_forms import with_edge_forms
from stitchmesh.editing.edit import Edit, apply_edit
from stitchmesh.editing.pattern_regions import PatternRegion, lay_patterns
from stitchmesh.editing.spiral import make_spiral
from stitchmesh.errors import ParameterError, StitchMeshError, YarnError
from stitchmesh.labeling import label
from stitchmesh.mesh import Mesh, StitchMesh
from stitchmesh.mesh.change import PaletteChange, apply_change
from stitchmesh.mesh.palette import make_palette
from stitchmesh.mesh.shaping_stitches import stitch_counts, with_increases
from stitchmesh.meshrelax import relax_mesh_with_report
from stitchmesh.patterns import LaidPattern
from stitchmesh.patterns.placement.left_out import left_out_lines
from stitchmesh.pipeline.options import KnitOptions
from stitchmesh.pipeline.refused_yarns import with_place_and_remedy
from stitchmesh.progress import Progress
from stitchmesh.quality import Quality, quality_named
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
from stitchmesh.yarngen.room import make_room_with_report

logger = logging.getLogger(__name__)

SHARE_OF_MESH = 0.5
"""Largest part of the time of a budget for the relaxation of the stitch mesh; the other part is for the yarns."""


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
        marked=options.marked, increase=options.increase,
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
    return replace(found, fabric=with_increases(found.fabric, options.increase))


def room_stage(
    fabric: StitchMesh, surface: TriangleSurface, options: KnitOptions, report: dict[str, Any], progress: Progress
) -> StitchMesh:
    """Make room for the yarns of found rows where the surface has none, and measure how all stitches fit it."""
    progress("meshrelax", 1.0, "room for the yarns")
    with _refused(fabric, options, quality_named(options.quality), report["shape"]):
        roomy, room = make_room_with_report(
            fabric, yarn_radius=options.yarn_radius, quality=options.quality, finish=options.finish
        )  # fmt: skip
    farthest = room.farthest / options.stitch_width
    if room.faces:
        logger.warning(
            f"the surface has no room for the yarns of {len(room.faces)} stitches, such as stitch {room.faces[0]}; "
            f"stitches were moved there by up to {farthest:.1f} stitch widths"
        )
    shape = after_mesh_relaxation(roomy, surface, options.stitch_width, report["shape"])
    report["shape"] = {**shape, "crowded": len(room.faces), "farthest_moved": round(farthest, 3)}
    return roomy


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
        entries = [_pattern_entry(region, one, options) for region, one in zip(options.patterns, laid, strict=True)]
        report["patterns"] = {"seconds": clock.lap(), "laid": entries}
    return fabric


def _pattern_entry(region: PatternRegion, laid: LaidPattern, options: KnitOptions) -> dict[str, object]:
    left_out = [{"faces": len(part.faces), "rows": part.rows, "wales": part.wales, "reason": part.reason}
                for part in laid.left_out]  # fmt: skip
    on = None if region.on is None else str(region.on)
    words = [*left_out_lines(laid.left_out), *_multiple_line(region, laid, options)]
    return {"name": region.pattern.name, "on": on, "faces": laid.faces_laid, "summary": words, "left_out": left_out}


def _multiple_line(region: PatternRegion, laid: LaidPattern, options: KnitOptions) -> list[str]:
    """Return a line that proposes rounds of whole repeats, if rounds have stitches that are left over."""
    width = region.pattern.width
    made = options.shaping is not None and options.shaping.multiple % width == 0
    if made or not laid.breaks_rounds or options.panels is not None:
        return []
    found = f"--multiple {width}" if options.shaping else f"--auto --multiple {width}"
    return [f"rounds hold whole repeats of {width} stitches with {found}, or with --pattern-remainder stretch"]


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
            fabric, surface=mesh, device=device, run=Run(progress), **options.mesh_arguments,
        )  # fmt: skip
    report["meshrelax"] = {**asdict(how), "seconds": clock.lap()}
    report["gauge"] = asdict(fabric_gauge(relaxed))
    return relaxed


def edge_forms_stage(fabric: StitchMesh, options: KnitOptions, report: dict[str, object]) -> StitchMesh:
    """Add the rows of folded and rolled edges, if the options ask for some."""
    if not options.edge_forms:
        return fabric
    clock = _Clock()
    edged = with_edge_forms(fabric, options.edge_forms, checked_radius(fabric, options.yarn_radius))
    report["edge_forms"] = {"stitches": edged.face_count - fabric.face_count, "seconds": clock.lap()}
    return edged


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
        YarnError: as for ``generate_yarns``, and for panels also as for ``check_loops``; the message names the place,
            the panel, and a remedy.
    """
    clock = _Clock()
    progress("yarngen", 0.0, f"{fabric.face_count} stitches")
    with _refused(fabric, options, quality, shape):
        yarns = _generated(fabric, options, quality, options.yarn_radius)
    report["yarngen"] = {
        "seconds": clock.lap(),
        "yarns": yarns.yarn_count,
        "control_points": len(yarns.points),
        "length_cm": round(float(yarns.lengths.sum()), 3),
    }
    return yarns


def _generated(fabric: StitchMesh, options: KnitOptions, quality: Quality, radius: float | None) -> YarnSet:
    """Generate the yarns of a radius [cm], and check their loops on panels."""
    yarns = generate_yarns(
        fabric, yarn_radius=radius, drawn_radius=options.drawn_radius, mass_per_length=options.mass_per_length,
        quality=quality, **asdict(options.finish),
    )  # fmt: skip
    if options.panels is not None:
        check_loops(fabric, yarns, finish=options.finish)
    return yarns


@contextmanager
def _refused(
    fabric: StitchMesh, options: KnitOptions, quality: Quality, shape: Mapping[str, Any] | None
) -> Iterator[None]:
    """Give errors about yarns their place, their panel and a remedy."""
    try:
        yield
    except YarnError as error:
        panel = None if error.face is None else panel_of_face(error.face, fabric, shape or {})
        made = partial(_generated, fabric, options, quality)
        radius = checked_radius(fabric, options.yarn_radius)
        raise with_place_and_remedy(error, fabric, panel, made, radius) from error


class _Clock:
    """A stopwatch."""

    def __init__(self) -> None:
        self._last = time.perf_counter()

    def lap(self) -> float:
        """Return the seconds since the last call, or since the construction."""
        now = time.perf_counter()
        seconds, self._last = now - self._last, now
        return round(seconds, 4)
