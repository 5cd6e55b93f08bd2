# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""A recipe in several sizes: the mesh scaled to each size, its stitches, and one text of instructions for all."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from os import PathLike, fspath
from pathlib import Path
from typing import Any, Literal

import numpy as np

from stitchmesh import __version__
from stitchmesh.editing.on_selection import ON
from stitchmesh.errors import ParameterError, StitchMeshError, check_kind
from stitchmesh.hand_knitting.sizes import graded_instructions, graded_numbers
from stitchmesh.hand_knitting.yarn_amounts import YarnAmount, yarn_amounts, yarn_lengths
from stitchmesh.io.atomic import write_json, write_text
from stitchmesh.io.contents import FilePath
from stitchmesh.io.meshes import write_mesh
from stitchmesh.io.stitches import write_stitches
from stitchmesh.labeling import label
from stitchmesh.mesh import Mesh, StitchMesh
from stitchmesh.mesh.upright import Y
from stitchmesh.pipeline.garment import Garment, whole_mesh
from stitchmesh.pipeline.options import KnitOptions
from stitchmesh.pipeline.stage_table import LABEL, STITCHES, YARNS, run_stages
from stitchmesh.progress import Progress, shown_stages
from stitchmesh.recipe.garment_measures import GarmentMeasures, Girth, row_heights
from stitchmesh.recipe.recipe import Recipe, recipe_options
from stitchmesh.recipe.recipe_file import read_recipe, write_recipe
from stitchmesh.recipe.sections import RecipeColour, RecipePattern
from stitchmesh.recipe.size_counts import EdgeCounts, covered_rounds, size_counts
from stitchmesh.recipe.sizes import TABLE, Ease, GarmentSize, checked_sizes, read_sizes, standard_sizes
from stitchmesh.run import Run
from stitchmesh.tessellate import COURSE_OVER_WALE_SPACING
from stitchmesh.tessellate.planned_stitches import planned_stitches
from stitchmesh.yarn import YarnSet
from stitchmesh.yarn.rest_length import apply_rest_lengths
from stitchmesh.yarn.yarn_presets import Gauge, yarn_for_gauge

INSTRUCTIONS, REPORT = "instructions.txt", "report.json"
"""Files that ``write_graded`` writes for all sizes."""
SUFFIXES = (".obj", ".toml", ".h5")
"""Suffixes of the files of one size: its mesh, its recipe and its stitches."""
NUMBERED = frozenset({"face", "faces", "side", "sides", "first_side", "second_side", "seam", "rows"})
"""Arguments of edits that are numbers of a fabric, which differ from size to size."""


@dataclass(frozen=True, eq=False, kw_only=True)
class GradedSize:
    """One size of a garment."""

    size: GarmentSize
    """The asked measures."""
    finished: Mapping[str, float]
    """All measures of the knitted size at its gauge [cm], from the numbers of its stitches and rows."""
    mesh: Mesh
    """The polygon mesh [cm]."""
    fabric: StitchMesh
    """The stitches, after mesh relaxation."""
    yarns: YarnSet
    """The yarns with their rest lengths, not relaxed."""
    recipe: Recipe
    """The recipe of the size; its mesh is still that of the base size, as a path."""
    amounts: tuple[YarnAmount, ...]
    """Yarn of each colour."""
    cut: tuple[str, ...]
    """Patterns whose repeats do not fit into whole rounds."""

    @property
    def deviation(self) -> float:
        """Largest relative difference between a finished measure and the asked one."""
        return max(abs(self.finished[name] / value - 1.0) for name, value in self.size.measures.items())


@dataclass(frozen=True, eq=False, kw_only=True)
class Graded:
    """A recipe in several sizes."""

    sizes: tuple[GradedSize, ...]
    """The sizes in their order."""
    gauge: Gauge
    """Stitches and rows in 10 cm for which all sizes are made."""
    yarn: str
    """Name of the yarn."""
    instructions: str
    """One text for all sizes; ``parse_instructions(text, size=name)`` reads one of them."""

    def __repr__(self) -> str:
        """Return one line: the names of the sizes with their numbers of stitches."""
        return f"Graded({', '.join(f'{one.size.name}: {one.fabric.face_count:,} stitches' for one in self.sizes)})"

    def report(self) -> dict[str, Any]:
        """Return all figures as plain values, as in ``report.json``."""
        sizes = {}
        for one in self.sizes:
            rows = int(one.fabric.row.max()) + 1
            sizes[one.size.name] = {
                "asked_cm": dict(one.size.measures),
                "finished_cm": {name: round(value, 2) for name, value in one.finished.items()},
                "deviation": round(one.deviation, 4), "stitches": one.fabric.face_count, "rows": rows,
                "yarns": [asdict(amount) for amount in one.amounts], "cut_repeats": list(one.cut),
            }  # fmt: skip
        gauge = {"stitches": round(self.gauge.stitches, 3), "rows": round(self.gauge.rows, 3)}
        return {"stitchmesh": __version__, "grade": {"gauge": gauge, "yarn": self.yarn, "sizes": sizes}}


def grade(
    recipe: Recipe | FilePath, sizes: FilePath | Sequence[GarmentSize], *, ease: Sequence[Ease] = (),
    progress: Progress | Literal[False] | None = None,
) -> Graded:  # fmt: skip
    """Make the stitches of a garment in several sizes, and one text of instructions for all.

    The mesh of the recipe is scaled to the measures of each size (``garment_measures``), and the stages of the recipe
    run on it with the same stitch size. Rounds that a pattern covers hold whole repeats. No yarn is relaxed.

    Args:
        recipe: a recipe, or the path of its file; its mesh has modelled rows.
        sizes: sizes; the path of a table (``read_sizes``); or standard sizes such as ``women:S,M,L``, of which the
            measures are taken that the garment has.
        ease: additions to the measures of all sizes.
        progress: as for ``swatch``.

    Raises:
        FileError: the recipe, its mesh or the table cannot be read.
        ParameterError: the garment does not have a measure, a size is not possible, two sizes have one name, or the
            recipe names faces or edges by number, finds its rows, or knits panels.
        StitchMeshError: a stage cannot continue for a size; the message names the size.
    """
    given = recipe if isinstance(recipe, Recipe) else read_recipe(recipe)
    check_gradable(given)
    with shown_stages(progress) as tell:
        tell("grade", 0.0, given.mesh)
        found = given.read_mesh()
        mesh, options = whole_mesh(found.mesh), recipe_options(given, found.up)
        measures = GarmentMeasures(label(mesh, borders=options.borders, seeds=options.seeds, flip=options.flip))
        wanted = _with_ease(_sizes(sizes, measures), ease)
        made = []
        for number, size in enumerate(wanted):
            tell("grade", number / len(wanted), f"size {size.name}")
            try:
                made.append(_graded_size(given, replace(options, quality=given.quality), mesh, measures, size))
            except StitchMeshError as error:
                raise type(error)(f"size {size.name}: {error}") from error
    height = options.stitch_height or COURSE_OVER_WALE_SPACING * options.stitch_width
    gauge = Gauge.of_stitch(options.stitch_width, height)
    yarn = (given.named() or yarn_for_gauge(gauge)).name
    text = graded_instructions({one.size.name: one.fabric for one in made}, _facts(made, gauge, yarn, measures))
    return Graded(sizes=tuple(made), gauge=gauge, yarn=yarn, instructions=text)


def output_names(sizes: Sequence[str]) -> list[str]:
    """Return the names of the files that ``write_graded`` writes for sizes of these names."""
    return [INSTRUCTIONS, REPORT, *(f"{name}{suffix}" for name in sizes for suffix in SUFFIXES)]


def write_graded(folder: str | PathLike[str], graded: Graded) -> None:
    """Write the instructions and a report, and of each size its mesh, its recipe and its stitches.

    ``knit_recipe`` of the written recipe of a size makes the same stitches, and relaxes their yarns.

    Raises:
        FileError: a file cannot be written.
    """
    place = Path(folder)
    for one in graded.sizes:
        mesh, recipe, stitches = (place / f"{one.size.name}{suffix}" for suffix in SUFFIXES)
        write_mesh(mesh, one.mesh)
        write_recipe(recipe, replace(one.recipe, mesh=fspath(mesh)))
        write_stitches(stitches, one.fabric)
    write_text(place / INSTRUCTIONS, graded.instructions)
    write_json(place / REPORT, graded.report())


def check_gradable(recipe: Recipe) -> None:
    """Refuse what holds for one size only.

    Raises:
        ParameterError: the recipe finds its rows, knits panels, or names faces or edges by number.
    """
    check_kind("grade", recipe, Recipe, "sm.read_recipe(path)")
    for name, asked in {"auto": recipe.rows.auto, "panels": recipe.panels.knit}.items():
        if asked:
            raise ParameterError(f"{name}: sizes need a mesh that is modelled in rows, from which measures follow")
    if recipe.stitches.counts or recipe.stitches.edges:
        raise ParameterError("counts: fix numbers of stitches, which differ from size to size; leave counts out")
    for number, edit in enumerate(recipe.edits):
        named = sorted(NUMBERED & set(edit.arguments))
        if named and ON not in edit.arguments:
            raise ParameterError(
                f"edits[{number}]: {named[0]}: numbers of a fabric differ from size to size; give a selection, such as "
                "on = 'hem 6'"
            )
    parts: dict[str, Sequence[RecipePattern | RecipeColour]]
    parts = {"patterns": recipe.patterns, "colours": recipe.colours}
    for part, places in parts.items():
        for number, one in enumerate(places):
            if '"' in (one.on or ""):
                raise ParameterError(f"{part}[{number}]: {one.on}: a file names faces of one size; give a selection")


def _sizes(sizes: FilePath | Sequence[GarmentSize], measures: GarmentMeasures) -> tuple[GarmentSize, ...]:
    """Return the sizes that the garment can have.

    Raises:
        FileError, ParameterError: as for ``grade``.
    """
    if isinstance(sizes, str | PathLike):
        name = fspath(sizes)
        is_table = name.lower().endswith(TABLE)
        found = read_sizes(sizes) if is_table else standard_sizes(name, list(measures.known))
    else:
        found = checked_sizes(list(sizes))
    names = [size.name.lower() for size in found]
    if len(set(names)) < len(names):
        raise ParameterError(f"sizes {', '.join(names)}: differ in capitals only; files of theirs would have one name")
    for measure in found[0].measures:
        measures.measure(measure)
    return found


def _with_ease(sizes: Sequence[GarmentSize], ease: Sequence[Ease]) -> tuple[GarmentSize, ...]:
    for one in ease:
        known = sizes[0].measures
        if one.measure not in known:
            raise ParameterError(f"ease: {one.measure[:40]!r} is no measure of the sizes; expected {', '.join(known)}")
        sizes = [one.added(size) for size in sizes]
    return tuple(sizes)


def _graded_size(
    recipe: Recipe, options: KnitOptions, mesh: Mesh, measures: GarmentMeasures, size: GarmentSize
) -> GradedSize:
    """Make one size."""
    labeled = measures.scaled(size.measures)
    counts = size_counts(
        measures, labeled, size.measures, options.patterns, stitch_width=options.stitch_width,
        stitch_height=options.stitch_height,
    )  # fmt: skip
    own = replace(options, counts=dict(counts))
    scaled = replace(mesh, vertices=labeled.vertices)
    garment = run_stages(
        (LABEL, *STITCHES, *YARNS), Garment.begin(scaled, own), lambda stage, done: stage.run(done, Run(None))
    )
    yarns = apply_rest_lengths(garment.yarns, options.relaxation.rest_lengths, fabric=garment.fabric)
    laid = garment.report.get("patterns", {}).get("laid", ())
    return GradedSize(
        size=size,
        finished=_finished(measures, labeled, own),
        mesh=scaled,
        fabric=garment.fabric,
        yarns=yarns,
        recipe=recipe_of_size(recipe, counts),
        amounts=yarn_amounts(
            yarn_lengths(yarns, at_rest=True), garment.fabric.palette, _grams_per_metre(recipe, options)
        ),
        cut=tuple(
            region.pattern.name
            for region, entry in zip(options.patterns, laid, strict=True)
            if entry["breaks_rounds"] and covered_rounds(garment.fabric, region)
        ),
    )


def recipe_of_size(recipe: Recipe, counts: EdgeCounts) -> Recipe:
    """Return the recipe of a size for a mesh that was read, scaled and written again, with its numbers of stitches."""
    return replace(
        recipe, unit="cm", up=Y, objects=(), layer="outer", label=replace(recipe.label, turn_inside_out=False),
        stitches=replace(recipe.stitches, counts=tuple(f"{a},{b}={count}" for (a, b), count in counts.items())),
    )  # fmt: skip


def _grams_per_metre(recipe: Recipe, options: KnitOptions) -> float:
    """Return the weight of the yarn, by default that of the named yarn that is usual for such stitches [g/m]."""
    if options.mass_per_length is not None:
        return 100.0 * options.mass_per_length
    usual = yarn_for_gauge(Gauge.of_stitch(options.stitch_width, COURSE_OVER_WALE_SPACING * options.stitch_width))
    return (recipe.named() or usual).grams_per_metre


def _finished(measures: GarmentMeasures, labeled: StitchMesh, options: KnitOptions) -> dict[str, float]:
    """Return all measures of a size, from its stitches and rows at the gauge [cm].

    An extent has the length of its rows at the gauge over the length of these rows on the mesh as a factor.
    """
    planned = planned_stitches(
        labeled, stitch_width=options.stitch_width, stitch_height=options.stitch_height, counts=options.counts
    )
    height = options.stitch_height or COURSE_OVER_WALE_SPACING * options.stitch_width
    courses_of = planned.courses[np.unique(measures.row_index, return_index=True)[1]]
    heights = row_heights(labeled, measures.row_index)
    found = {}
    for name, measure in measures.known.items():
        if isinstance(measure, Girth):
            loops = [int(planned.along[labeled.side_edge[ring]].sum()) for ring in measure.rings]
            found[name] = float(np.mean(loops)) * options.stitch_width
            continue
        rows = sorted({row for tube in measure.tubes for row in tube})
        weight = np.ones(len(rows)) if measure.part is None else measure.part[rows]
        courses, lengths = courses_of[rows], heights[rows]
        found[name] = measures.value(name, labeled) * float(weight @ courses) * height / float(weight @ lengths)
    return found


def _facts(made: Sequence[GradedSize], gauge: Gauge, yarn: str, measures: GarmentMeasures) -> list[str]:
    """Return the lines about finished measures, gauge and yarn."""
    asked = list(made[0].size.measures)
    names: dict[int, str] = {}
    for name in [*asked, *measures.known]:
        names.setdefault(id(measures.known[name]), name)
    finished = [
        f"{name} {graded_numbers([f'{one.finished[name]:.1f}' for one in made])} cm" for name in names.values()
    ]
    lines = [f"Finished measures: {'; '.join(finished)}.", f"Gauge: {gauge}."]
    amounts = [{amount.letter: amount for amount in one.amounts} for one in made]
    colours = {letter: amount.colour for own in amounts for letter, amount in own.items()}
    for letter, colour in sorted(colours.items(), key=lambda item: (len(item[0]), item[0])):
        own = [one.get(letter, YarnAmount(letter, colour, 0.0, 0.0)) for one in amounts]
        metres, grams = [f"{amount.metres:.0f}" for amount in own], [f"{amount.grams:.0f}" for amount in own]
        which = f" {letter} ({colour})" if len(colours) > 1 else ""
        lines.append(f"Yarn{which}: {yarn}, {graded_numbers(metres)} m, about {graded_numbers(grams)} g.")
    return lines
