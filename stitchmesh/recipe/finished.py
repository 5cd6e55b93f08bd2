# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""A garment whose finished measures come true: its stitches are as many as its fabrics need when nothing holds them.

A surface holds each stitch at the size of its place. Off the surface rib draws in, garter stitch draws together, and
every stitch goes to the size of its fabric at rest. A swatch of each pattern of the recipe, and of stockinette, is
relaxed with the yarn and the loop length of the recipe. A girth of the finished garment is the sum of the widths at
rest of the stitches of its ring, and a length the sum of the heights at rest of its rows. The numbers of stitches and
rows follow from measures m of the mesh that are corrected until the finished measures f are the asked ones a:

    m  <-  m a / f

Patterns keep whole repeats, so that the correction ends with the nearest numbers. If they miss a girth, the loop length
changes until they give it. The mesh has the asked measures.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any, Literal

import numpy as np

from stitchmesh.errors import ParameterError, StitchMeshError
from stitchmesh.labeling import label
from stitchmesh.mesh import FloatArray, Mesh, StitchMesh
from stitchmesh.patterns import Pattern, read_pattern
from stitchmesh.periodic.swatch import SwatchRequest, relax_swatches
from stitchmesh.periodic.swatch_options import KnitState
from stitchmesh.pipeline.garment import whole_mesh
from stitchmesh.pipeline.options import KnitOptions
from stitchmesh.progress import Progress, shown_stages
from stitchmesh.quality import DEFAULT_QUALITY
from stitchmesh.recipe.garment_measures import GarmentMeasures, Girth, row_heights
from stitchmesh.recipe.grade import check_gradable, recipe_of_size
from stitchmesh.recipe.recipe import Recipe, recipe_options
from stitchmesh.recipe.size_counts import EdgeCounts, edge_name, size_counts
from stitchmesh.recipe.sizes import parse_ease
from stitchmesh.selection import select
from stitchmesh.tessellate import tessellate
from stitchmesh.tessellate.planned_stitches import planned_stitches
from stitchmesh.yarn.yarn_presets import LOOP_OVER_WIDTH, WIDTH_OVER_CORE, Gauge

STATE: KnitState = "wet"
"""The default state of the swatches: a finished garment has been washed."""
GROUND = "stockinette"
"""The fabric of stitches in no pattern."""
CLOSE = 0.002
"""Relative error of all finished measures at which the corrections end."""
TRUE = 0.02
"""Relative error up to which a measure counts as reached."""
HALF = 0.01
"""Relative error of a girth from which the loop length changes, because whole repeats do not give it."""
LOOPS_TRIED, WIDTH_BY_LOOP = 3, 1.4
"""Largest number of loop lengths, and the relative change of a width over that of the loop length: it is 1 by Munden's
law and 1.8 for stockinette without friction."""
ROUNDS = 6
"""Largest number of corrections."""


@dataclass(frozen=True, eq=False)
class FinishedGarment:
    """A recipe whose garment has the asked measures when nothing holds it."""

    recipe: Recipe
    """The recipe, with the sizes and the numbers of stitches; its mesh is the path of the given recipe."""
    mesh: Mesh
    """The mesh at the asked measures [cm]."""
    asked: Mapping[str, float]
    """The asked measures [cm]."""
    measures: Mapping[str, float]
    """All finished measures of the garment [cm]."""
    gauges: Mapping[str, Gauge]
    """The gauge at rest of each pattern, and of stockinette."""
    notes: tuple[str, ...]
    """What is not possible, each in one line."""

    def report(self) -> dict[str, Any]:
        """Return the figures as plain numbers and words."""
        gauges = {name: {"stitches": gauge.stitches, "rows": gauge.rows} for name, gauge in self.gauges.items()}
        return {
            "asked": dict(self.asked), "measures": dict(self.measures), "gauges": gauges, "notes": list(self.notes)
        }  # fmt: skip


def parse_measures(text: str) -> dict[str, float]:
    """Parse measures as a user writes them: ``chest=96,length=62`` [cm], or with units, ``chest=38in``.

    Raises:
        ParameterError: the text has another form, a measure occurs twice, or a size is not positive.
    """
    measures: dict[str, float] = {}
    for part in text.split(","):
        try:
            found = parse_ease(part)
        except ParameterError:
            found = None
        if found is None or found.part or found.length <= 0.0 or found.measure in measures:
            raise ParameterError(f"finished: got {part[:60]!r}; expected each measure once: chest=96,length=62")
        measures[found.measure] = found.length
    return measures


def finished_garment(
    recipe: Recipe, asked: Mapping[str, float], *, quality: str = DEFAULT_QUALITY,
    relaxation: KnitState = STATE, progress: Progress | Literal[False] | None = None,
) -> FinishedGarment:  # fmt: skip
    """Return a recipe whose garment has finished measures when nothing holds it (module docstring).

    Args:
        recipe: a recipe whose mesh has modelled rows. Its yarn, gauge or stitch width gives the loop length.
        asked: the measures by name [cm]: chest, length, sleeve length ...
        quality: preset of the swatches.
        relaxation: state of the swatches, ``frictionless`` to compare the plan with yarns that relax without friction.
        progress: as for ``swatch``.

    Raises:
        FileError: the recipe, its mesh or a pattern cannot be read.
        ParameterError: as for ``grade``, or nothing is asked for.
        SolverError: a swatch cannot be relaxed.
    """
    check_gradable(recipe)
    if not asked:
        raise ParameterError("finished: got no measures; expected for example chest=96,length=62")
    found = recipe.read_mesh()
    mesh, options = whole_mesh(found.mesh), recipe_options(recipe, found.up)
    radius = options.yarn_radius or options.stitch_width / WIDTH_OVER_CORE
    loop = options.relaxation.rest_lengths.loop_length or LOOP_OVER_WIDTH * options.stitch_width
    measures = GarmentMeasures(label(mesh, borders=options.borders, seeds=options.seeds, flip=options.flip))
    for name in asked:
        measures.measure(name)
    with shown_stages(progress) as shown:
        for left in reversed(range(LOOPS_TRIED)):
            gauges = _gauges(recipe, options, (radius, loop), (quality, relaxation), shown)
            ground = gauges[GROUND]
            own = replace(options, stitch_width=ground.stitch_width, stitch_height=ground.stitch_height)
            counts, finished = _best_counts(measures, asked, own, gauges)
            wider = _missing_girth(measures, asked, finished)
            if left == 0 or abs(wider - 1.0) <= HALF:
                break
            loop *= wider ** (1.0 / WIDTH_BY_LOOP)
    labeled = measures.scaled(asked)
    made = recipe_of_size(recipe, counts)
    return FinishedGarment(
        recipe=replace(
            made, gauge=None, stitch_width=ground.stitch_width, yarn_radius=radius,
            stitches=replace(made.stitches, course_height=ground.stitch_height),
            rest_lengths=replace(made.rest_lengths, loop_length=loop),
        ),
        mesh=replace(mesh, vertices=labeled.vertices),
        asked=dict(asked),
        measures=finished,
        gauges=gauges,
        notes=tuple(
            f"{name} {value:g} cm: the finished garment has {finished[name]:.4g} cm, "
            f"{100 * (finished[name] / value - 1.0):+.2g} %, because patterns keep whole repeats"
            for name, value in asked.items() if abs(finished[name] / value - 1.0) > TRUE
        ),
    )  # fmt: skip


def _missing_girth(measures: GarmentMeasures, asked: Mapping[str, float], finished: Mapping[str, float]) -> float:
    """Return an asked girth over the finished one, of the girth that whole repeats miss most; 1 without a girth."""
    girths = [asked[name] / finished[name] for name in asked if isinstance(measures.measure(name), Girth)]
    return max(girths, key=lambda each: abs(np.log(each)), default=1.0)


def _gauges(
    recipe: Recipe, options: KnitOptions, yarn: tuple[float, float], rest: tuple[str, KnitState],
    shown: Progress,
) -> dict[str, Gauge]:
    """Relax a swatch of each pattern, and return the gauges at rest.

    Raises:
        StitchMeshError: a swatch cannot be made.
    """
    (radius, loop), (quality, state) = yarn, rest
    patterns: dict[str, Pattern] = {GROUND: read_pattern(GROUND)}
    patterns |= {region.pattern.name: region.pattern for region in options.patterns}
    given = {"yarn_radius": radius, "loop_length": loop, "relaxation": state}
    made = relax_swatches(
        [
            SwatchRequest(
                pattern, material=options.relaxation.material_of_radius(radius), quality=quality, relax_cell=True,
                options=given,
            )
            for pattern in patterns.values()
        ],
        device=recipe.device, progress=lambda done, count: shown("swatches", done / count, f"{done} of {count}"),
    )  # fmt: skip
    gauges = {}
    for name, swatch in zip(patterns, made, strict=True):
        if isinstance(swatch, StitchMeshError):
            raise type(swatch)(f"finished: swatch of {name}: {swatch}") from swatch
        gauges[name] = Gauge.of_stitch(swatch.report["wale_spacing"], swatch.report["course_spacing"])
    return gauges


def _best_counts(
    measures: GarmentMeasures, asked: Mapping[str, float], options: KnitOptions, gauges: Mapping[str, Gauge]
) -> tuple[EdgeCounts, dict[str, float]]:
    """Return the numbers of all edges with the nearest finished measures, and these measures."""
    wanted, least = dict(asked), np.inf
    best: tuple[EdgeCounts, dict[str, float]] = ({}, {})
    for _ in range(ROUNDS):
        labeled = measures.scaled(wanted)
        counts = _all_counts(measures, labeled, wanted, options)
        fabric = tessellate(
            labeled, stitch_width=options.stitch_width, stitch_height=options.stitch_height, counts=dict(counts)
        )
        finished = finished_measures(fabric, options, gauges)
        ratio = {name: asked[name] / finished[name] for name in asked}
        error = max(abs(value - 1.0) for value in ratio.values())
        if error < least:
            best, least = (counts, finished), error
        if error <= CLOSE:
            break
        wanted = {name: wanted[name] * ratio[name] for name in asked}
    return best


def _all_counts(
    measures: GarmentMeasures, labeled: StitchMesh, wanted: Mapping[str, float], options: KnitOptions
) -> EdgeCounts:
    """Return the numbers of stitches or courses of all edges, so that they hold on a mesh of another size too."""
    width, height = options.stitch_width, options.stitch_height
    counts = size_counts(measures, labeled, wanted, options.patterns, stitch_width=width, stitch_height=height)
    planned = planned_stitches(labeled, stitch_width=width, stitch_height=height, counts=dict(counts))
    along = planned.along
    return {edge_name(labeled, edge): int(along[edge]) for edge in range(len(along))}


def finished_measures(fabric: StitchMesh, options: KnitOptions, gauges: Mapping[str, Gauge]) -> dict[str, float]:
    """Return the measures of a fabric of plain stitches when nothing holds it and its patterns are knitted [cm].

    Args:
        fabric: the stitches before the patterns are laid.
        options: the patterns and their parts.
        gauges: the gauge at rest of each pattern, by name, and of stockinette.
    """
    width, height = natural_sizes(fabric, options, gauges)
    measures = GarmentMeasures(fabric)
    rows, found = len(measures.parts.row_numbers), {}
    natural = np.bincount(measures.row_index, height, rows) / np.bincount(measures.row_index, minlength=rows)
    drawn = row_heights(fabric, measures.row_index)
    for name, measure in measures.known.items():
        if isinstance(measure, Girth):
            found[name] = float(np.mean([width[fabric.side_face[ring]].sum() for ring in measure.rings]))
            continue
        if measure.axis is None:
            found[name] = float(np.mean([natural[list(tube)].sum() for tube in measure.tubes]))
            continue
        own = sorted({row for tube in measure.tubes for row in tube})
        part = np.ones(len(own)) if measure.part is None else measure.part[own]
        found[name] = measures.value(name) * float(part @ natural[own]) / float(part @ drawn[own])
    return found


def natural_sizes(
    fabric: StitchMesh, options: KnitOptions, gauges: Mapping[str, Gauge]
) -> tuple[FloatArray, FloatArray]:
    """Return the width and the height at rest of each stitch [cm], shape (F,) each."""
    width = np.full(fabric.face_count, gauges[GROUND].stitch_width)
    height = np.full(fabric.face_count, gauges[GROUND].stitch_height)
    for region in options.patterns:
        faces = np.arange(fabric.face_count) if region.on is None else select(fabric, region.on)
        gauge = gauges[region.pattern.name]
        width[faces], height[faces] = gauge.stitch_width, gauge.stitch_height
    return width, height
