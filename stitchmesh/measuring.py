# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The cost and the error of the presets of quality, measured on a garment or a swatch of the user.

The piece is made at each preset, from the coarsest to the finest, all stages from the mesh or the pattern on. The
result of the finest preset that has been made is the yardstick of the others. Times hold neither the compiling of
kernels, which is done before, nor pictures and files.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, dataclass, field, replace
from os import PathLike, fspath
from time import perf_counter
from typing import Any, Literal, cast

import numpy as np

from stitchmesh import __version__
from stitchmesh.compute.device import device_named
from stitchmesh.compute.free_memory import forget_peak_memory, peak_memory
from stitchmesh.errors import ParameterError, StitchMeshError
from stitchmesh.first_use import PRECISIONS, compile_imported
from stitchmesh.patterns import Pattern
from stitchmesh.periodic.resolve_pattern import resolve_pattern
from stitchmesh.periodic.swatch import swatch
from stitchmesh.periodic.weave.weave import Weave
from stitchmesh.pipeline.knit import knit_and_write
from stitchmesh.progress import Progress, shown_stages
from stitchmesh.quality import PRESETS
from stitchmesh.recipe.recipe import Recipe, RecipeMesh, recipe_options
from stitchmesh.recipe.recipe_file import read_recipe
from stitchmesh.run import Run
from stitchmesh.yarn import YarnSet
from stitchmesh.yarnrelax import YarnMaterial
from stitchmesh.yarnrelax.model.material import material_of
from stitchmesh.yarnrelax.state_difference import (
    cell_distances,
    distances,
    energy_of,
    loops_of_fabric,
    places_of,
    spacings,
)

PER_RUN, PER_POINT = 16, 4
"""Positions that are compared, in each run of control points of a garment, and for each control point of a swatch."""
RECIPE = ".toml"
"""Suffix of a recipe; every other name is that of a pattern."""


@dataclass(frozen=True)
class ErrorOfPreset:
    """How far the result of a preset is from that of the finest one."""

    rms: float | None
    """Root mean square distance of corresponding positions on the yarns, in yarn radii; None for garments whose rows
    were found with other stitches."""
    largest: float | None
    """Largest of these distances, in yarn radii."""
    wale_spacing: float
    """Relative error of the wale spacing, the width of a stitch."""
    course_spacing: float
    """Relative error of the course spacing, the height of a stitch."""
    energy: float
    """Relative error of the energy."""


@dataclass(frozen=True)
class PresetMeasure:
    """What a preset costs, and what it gives."""

    quality: str
    """Name of the preset."""
    seconds: float
    """Time of all stages [s]."""
    stages: Mapping[str, float]
    """Time of each stage that is timed by itself [s]."""
    memory_bytes: int
    """Largest memory of the process [bytes]."""
    control_points: int
    iterations: int
    at_rest: bool
    """Whether the yarns are at rest by the measure of the preset."""
    residual: float
    """Relative norm of the forces at the end, the gradient of the energy."""
    max_strain: float
    """Largest strain of a yarn."""
    nearest: float
    """Smallest distance of the axes of two yarns, in yarn radii; 2 is touching."""
    wale_spacing: float
    """Mean width of a stitch [cm]."""
    course_spacing: float
    """Mean height of a stitch [cm]."""
    energy: float
    """Energy of the yarns [erg], with the same fine sampling for all presets."""
    error: ErrorOfPreset | None = None
    """Distance from the finest preset; None for the finest preset itself."""


@dataclass(frozen=True)
class Measured:
    """The measures of the presets on one piece."""

    piece: str
    """Name of the recipe or the pattern."""
    device: str
    """Warp's name of the device."""
    presets: tuple[PresetMeasure, ...]
    """The measures, from the coarsest preset to the finest."""
    failures: Mapping[str, str] = field(default_factory=dict)
    """Errors of presets at which the piece cannot be made."""

    def report(self) -> dict[str, Any]:
        """Return the measures as plain numbers, as in ``measure.json``."""
        return {"stitchmesh": __version__, **asdict(self)}


@dataclass(frozen=True, eq=False)
class _Made:
    """A piece at one preset, and what is compared of it."""

    measure: PresetMeasure
    yarns: YarnSet


def measure(
    piece: str | PathLike[str] | Recipe | Pattern | Weave,
    *,
    qualities: Sequence[str] = tuple(PRESETS),
    device: str | None = None,
    material: YarnMaterial | None = None,
    on_measure: Callable[[Measured], None] | None = None,
    progress: Progress | Literal[False] | None = None,
    **options: Any,
) -> Measured:
    """Make a piece at each preset of quality, and return what each costs and how far it is from the finest one.

    A preset at which the piece cannot be made is noted in ``failures``.

    Args:
        piece: a recipe or the path of one (``.toml``); or a pattern or a weave, its name or its path, for a swatch.
        qualities: names of the presets.
        device: Warp's name of the device; that of the recipe, or else the first GPU or the CPU if None.
        material: material of the yarn of a swatch.
        on_measure: called after each preset with the measures so far; an interrupt thus loses the present preset only.
        progress: as for ``stitchmesh.progress``.
        options: fields of ``SwatchOptions``, for a swatch.

    Raises:
        ParameterError: there is no such preset or device, a preset is given twice, or an option is given for a recipe.
        FileError: the recipe or the pattern cannot be read.
        StitchMeshError: the piece cannot be made at any preset.
    """
    names = _sorted(qualities)
    source = _source(piece)
    if isinstance(source, Recipe) and (options or material is not None):
        given = next(iter(options), "material")
        raise ParameterError(f"measure: got {given} beside a recipe; write it into the recipe")
    own_device = source.device if isinstance(source, Recipe) else None
    measured = Measured(_name(piece, source), str(device_named(device or own_device)), ())
    found = source.read_mesh() if isinstance(source, Recipe) else None
    made: list[_Made] = []
    with shown_stages(progress) as report:
        compile_imported(measured.device, _forms(source, names), report)
        for number, name in enumerate(names):
            of_preset = _noting(report, f"{name}, {number + 1} of {len(names)} presets")
            try:
                if isinstance(source, Recipe):
                    assert found is not None
                    made.append(_garment(source, found, name, measured.device, of_preset))
                else:
                    made.append(_swatch(source, name, measured.device, material, of_preset, options))
            except StitchMeshError as error:
                if number + 1 == len(names) and not made:
                    raise
                measured = replace(measured, failures={**measured.failures, name: str(error)})
            measured = replace(measured, presets=_compared(made))
            if on_measure is not None:
                on_measure(measured)
    return measured


def _sorted(qualities: Sequence[str]) -> list[str]:
    """Return the names of the presets from the coarsest to the finest.

    Raises:
        ParameterError: there are none, there is no such preset, or one is given twice.
    """
    expected = f"expected names of {', '.join(PRESETS)}, each once"
    for name in qualities:
        if name not in PRESETS or list(qualities).count(name) > 1:
            raise ParameterError(f"qualities: got {', '.join(qualities)}; {expected}")
    if not qualities:
        raise ParameterError(f"qualities: got none; {expected}")
    return [name for name in PRESETS if name in qualities]


def _source(piece: str | PathLike[str] | Recipe | Pattern | Weave) -> Recipe | Pattern | Weave:
    if isinstance(piece, Recipe | Pattern | Weave):
        return piece
    path = fspath(piece)
    return read_recipe(path) if path.lower().endswith(RECIPE) else resolve_pattern(path)


def _name(piece: object, source: Recipe | Pattern | Weave) -> str:
    if isinstance(piece, str | PathLike):
        return fspath(piece)
    return source.mesh if isinstance(source, Recipe) else source.name


def _forms(source: Recipe | Pattern | Weave, names: Sequence[str]) -> tuple[tuple[str, bool], ...]:
    """Return the forms of the kernels; the stress of a swatch is found in both precisions."""
    if not isinstance(source, Recipe):
        return tuple((precision, True) for precision in PRECISIONS)
    return tuple((precision, False) for precision in sorted({PRESETS[name].precision for name in names}))


def _noting(progress: Progress, preset: str) -> Progress:
    """Return a progress function that names the preset first."""
    return lambda stage, done, note: progress(stage, done, f"{preset}: {note}")


def _garment(recipe: Recipe, found: RecipeMesh, name: str, device: str, progress: Progress) -> _Made:
    """Make a garment at a preset."""
    options = recipe_options(replace(recipe, quality=name, device=device), found.up)
    forget_peak_memory()
    began = perf_counter()
    made = knit_and_write(found.mesh, None, options, repair=found.repairs, run=Run(progress))
    seconds, memory = perf_counter() - began, peak_memory()
    stages = {stage: entry["seconds"] for stage, entry in made.report.items()
              if isinstance(entry, dict) and "seconds" in entry}  # fmt: skip
    places = places_of(made.yarns, PER_RUN)
    report = cast(Mapping[str, Any], made.report["yarnrelax"])
    return _Made(_measure(
        name, report, seconds=seconds, stages=stages, memory_bytes=memory, control_points=len(made.yarns.points),
        spacing=spacings(loops_of_fabric(made.fabric, places), places.points),
        energy=energy_of(made.yarns, options.relaxation.yarn_material(made.yarns), device),
    ), made.yarns)  # fmt: skip


def _swatch(
    source: Pattern | Weave, name: str, device: str, material: YarnMaterial | None, progress: Progress,
    options: Mapping[str, Any],
) -> _Made:  # fmt: skip
    """Make a swatch at a preset."""
    forget_peak_memory()
    began = perf_counter()
    made = swatch(source, material=material, quality=name, device=device, progress=progress, **options)
    seconds, memory = perf_counter() - began, peak_memory()
    relaxing = made.report.get("solver_seconds", seconds)
    yarn = material or material_of(made.yarns)
    return _Made(_measure(
        name, made.report, seconds=seconds, stages={"yarnrelax": relaxing},
        memory_bytes=memory, control_points=len(made.yarns.points),
        spacing=(made.report["wale_spacing"], made.report["course_spacing"]),
        energy=energy_of(made.yarns, yarn, device),
    ), made.yarns)  # fmt: skip


def _measure(
    name: str, report: Mapping[str, Any], *, spacing: tuple[float, float], **costs: Any
) -> PresetMeasure:  # fmt: skip
    """Return the measure of a preset from the report of its relaxation."""
    return PresetMeasure(
        quality=name, iterations=report["iterations"], at_rest=report["converged"], residual=report["residual"],
        max_strain=report["max_strain"], nearest=report["min_distance_over_radius"], wale_spacing=spacing[0],
        course_spacing=spacing[1], **costs,
    )  # fmt: skip


def _compared(made: Sequence[_Made]) -> tuple[PresetMeasure, ...]:
    """Return the measures with their errors; the last of them is the finest."""
    if not made:
        return ()
    *others, finest = made
    return (*(replace(each.measure, error=_error(each, finest)) for each in others), finest.measure)


def _error(made: _Made, finest: _Made) -> ErrorOfPreset:
    """Return how far a piece is from the finest one."""
    here, there = made.measure, finest.measure
    rms, largest = _distances(made.yarns, finest.yarns)
    return ErrorOfPreset(
        rms=rms, largest=largest, wale_spacing=abs(here.wale_spacing / there.wale_spacing - 1.0),
        course_spacing=abs(here.course_spacing / there.course_spacing - 1.0),
        energy=abs(here.energy / there.energy - 1.0),
    )  # fmt: skip


def _distances(yarns: YarnSet, finest: YarnSet) -> tuple[float | None, float | None]:
    """Return the distances of positions in yarn radii; None for garments of other stitches, whose rows were found."""
    if finest.lattice is not None:
        return cell_distances(yarns, finest, PER_POINT)
    places, others = places_of(yarns, PER_RUN), places_of(finest, PER_RUN)
    if not np.array_equal(places.face, others.face):
        return None, None
    return distances(places, others, "none", float(finest.radius.mean()))
