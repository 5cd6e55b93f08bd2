# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Cost of accuracy: time against distance to ``reference``, for the presets and for changes of one parameter.

``run`` writes a row after each run; with ``--resume`` it skips the runs that the file already contains. The reference
of each scene is computed once and stored beside the file as NAME-SCENE.npz. The times [s] are those of ``relax_yarns``
with the linking certificates and with loaded kernels. ``plot`` draws the picture and prints the tables of
``docs/accuracy.md``.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Literal

import numpy as np

from benchmarks.json_lines import append, read
from benchmarks.measures.rest.tradeoff_plot import draw, tables
from benchmarks.measures.rest.tradeoff_scenes import PLAIN, RIB, Scene, cell, garment, tube, yarn_file
from benchmarks.table import Rows
from benchmarks.timing import relaxed
from stitchmesh.errors import SolverError
from stitchmesh.quality import PRESETS, Quality
from stitchmesh.yarn import YarnSet
from stitchmesh.yarnrelax.model.material import YarnMaterial
from stitchmesh.yarnrelax.state_difference import (
    AdjacentLoops,
    Freedom,
    Places,
    distances,
    energy_of,
    places_of,
    spacings,
)

SWEEPS: dict[str, tuple[Any, ...]] = {
    "precision": ("float32", "float64"),
    "quadrature_points": (2, 3, 4, 5, 7, 11),
    "contact_samples": (1, 2, 3, 5, 7, 11),
    "control_points_per_stitch": (8, 10, 12, 16, 20, 24),
    "step_fraction": (0.05, 0.1, 0.2, 0.3, 0.4),
    "tolerance": (0.05, 0.02, 0.01, 0.005, 0.002, 0.001, 5e-4, 2e-4, 1e-4),
    "solver": ("quasistatic", "dynamics"),
}
"""Values of each varied parameter; the other parameters are those of ``standard``."""
KEPT = ("tolerance", "device", "seconds", "iterations", "residual", "converged", "max_strain")
"""Entries of the report that a row contains; the tolerance is added to them."""


@dataclass(frozen=True)
class Difference:
    """Difference of a relaxation from the reference."""

    rms: float
    """Root mean square distance of corresponding positions, in yarn radii."""
    largest: float
    """Largest distance of corresponding positions, in yarn radii."""
    wale_error: float
    """Relative error of the wale spacing."""
    course_error: float
    """Relative error of the course spacing."""


def difference(places: Places, reference: Places, gauge: AdjacentLoops, freedom: Freedom, radius: float) -> Difference:
    """Return the differences of positions from those of the reference.

    Raises:
        YarnError: the two are not places of one scene.
    """
    rms, largest = distances(places, reference, freedom, radius)
    here, there = spacings(gauge, places.points), spacings(gauge, reference.points)
    errors = [abs(one / other - 1.0) for one, other in zip(here, there, strict=True)]
    return Difference(rms, largest, *errors)


@dataclass(frozen=True, eq=False)
class Yardstick:
    """The reference of a scene."""

    yarns: YarnSet
    report: dict[str, Any]
    material: YarnMaterial
    gauge: AdjacentLoops
    places: Places
    energy: float
    """Energy of the reference [erg]."""

    @classmethod
    def of(cls, scene: Scene, yarns: YarnSet, report: dict[str, Any], device: str | None) -> Yardstick:
        """Make the reference from a relaxed state."""
        material = YarnMaterial.named("stitchmesh").of_radius(float(yarns.radius.mean()))
        start = scene.make(PRESETS["reference"].control_points_per_stitch)
        gauge, places = scene.gauge(places_of(start, scene.per_run)), places_of(yarns, scene.per_run)
        return cls(yarns, report, material, gauge, places, energy_of(yarns, material, device))

    def row(self, scene: Scene, yarns: YarnSet, report: dict[str, Any], device: str | None) -> dict[str, Any]:
        """Return the entries of a row for a relaxation."""
        radius = float(yarns.radius.mean())
        found = difference(places_of(yarns, scene.per_run), self.places, self.gauge, scene.freedom, radius)
        energy = energy_of(yarns, self.material, device)
        return {
            **{name: report[name] for name in KEPT},
            **vars(found),
            **dict.fromkeys(scene.given),
            "control_points": len(yarns.points),
            "energy": energy,
            "energy_error": abs(energy / self.energy - 1.0),
            "reference_converged": self.report["converged"],
            "reference_residual": self.report["residual"],
        }


def relax(scene: Scene, quality: Quality, device: str | None) -> tuple[YarnSet, dict[str, Any]]:
    """Relax yarns, and return them with their report; a short run loads the kernels first."""
    yarns = scene.make(quality.control_points_per_stitch)
    result, _seconds = relaxed(yarns, quality, device=device, keep_shape=scene.fabric)
    return result.yarns, {**result.report, "tolerance": quality.tolerance}


def runs(scene: Scene, given: Options) -> Iterator[tuple[str, Any, Quality]]:
    """Return parameter, value and quality of every run except the reference, starting with the presets."""
    if "preset" in given.knob:
        for name in ("draft", "standard"):
            yield "preset", name, PRESETS[name]
    standard = PRESETS["standard"]
    for knob in given.knob:
        if knob == "preset" or (knob == "control_points_per_stitch" and not scene.generated):
            continue
        for value in SWEEPS[knob]:
            yield knob, value, replace(standard, **{knob: value}, max_iterations=given.max_iterations)


def measure_scene(scene: Scene, given: Options) -> Rows:
    """Make all runs of one scene, and write a row after each run."""
    output = given.output
    rows = [row for row in read(output) if row["scene"] == scene.name]
    done = {(row["knob"], str(row["value"])): row for row in rows}
    reference = _reference(scene, output, given)
    if ("preset", "reference") not in done:
        measured = reference.row(scene, reference.yarns, reference.report, given.device)
        yield from _write(output, {"scene": scene.name, "knob": "preset", "value": "reference", **measured})
    known: dict[Quality, dict[str, Any]] = {}  # every sweep has standard in it
    for knob, value, quality in runs(scene, given):
        if (knob, str(value)) not in done:
            row = known[quality] if quality in known else _row(scene, quality, reference, given.device)
            known[quality] = {**row, "scene": scene.name, "knob": knob, "value": value}
            yield from _write(output, known[quality])
        else:
            known[quality] = done[knob, str(value)]


def _row(scene: Scene, quality: Quality, reference: Yardstick, device: str | None) -> dict[str, Any]:
    """Return the entries of a row for a relaxation with this quality, or the reason of its failure."""
    try:
        return reference.row(scene, *relax(scene, quality, device), device)
    except SolverError as error:
        return {"failure": str(error), "converged": False}


def _reference(scene: Scene, output: Path, given: Options) -> Yardstick:
    """Read the reference, or compute it if it does not exist."""
    path = output.with_name(f"{output.stem}-{scene.name}.npz")
    quality = replace(
        PRESETS["reference"], tolerance=given.reference_tolerance, max_iterations=given.reference_iterations
    )
    if not (given.resume and path.exists()):
        yarns, report = relax(scene, quality, given.device)
        path.parent.mkdir(parents=True, exist_ok=True)
        np.savez_compressed(path, points=yarns.points, **{name: report[name] for name in KEPT})
    with np.load(path) as file:
        report = {name: file[name].item() for name in KEPT}
        yarns = replace(scene.make(quality.control_points_per_stitch), points=file["points"])
    return Yardstick.of(scene, yarns, report, given.device)


def _write(path: Path, row: dict[str, Any]) -> Rows:
    """Add a row to the file, and print it."""
    append(path, [row])
    said = (f"{name} {row[name]:.4g}" if isinstance(row[name], float) else f"{name} {row[name]}"
            for name in ("seconds", "iterations", "residual", "rms", "largest", "wale_error", "course_error",
                         "energy_error", "failure") if name in row)  # fmt: skip
    yield f"{row['scene']} {row['knob']} {row['value']}: " + ", ".join(said)


def scene_named(name: str, given: Options) -> Scene:
    """Make a scene."""
    size = given.rows, given.stitches
    makers = {
        "stockinette": lambda: tube(name, PLAIN, *size),
        "rib": lambda: tube(name, RIB, *size),
        "stockinette-cell": lambda: cell(name, PLAIN, *size),
        "rib-cell": lambda: cell(name, RIB, *size),
        "glove": lambda: yarn_file(name, given.glove),
        "skirt": lambda: garment(name, given.skirt, given.unit, given.skirt_width, given.device),
    }
    return makers[name]()


@dataclass(frozen=True)
class Options:
    """The scenes and the runs that are measured."""

    scene: tuple[Literal["stockinette", "rib", "stockinette-cell", "rib-cell", "glove", "skirt"], ...] = (
        "stockinette", "rib",
    )  # fmt: skip
    knob: tuple[str, ...] = ("preset", *SWEEPS)
    output: Path = Path("out/accuracy.jsonl")
    resume: bool = False
    """skip runs that the file already contains"""
    device: str | None = None
    rows: int = 8
    """rows of stockinette and rib"""
    stitches: int = 24
    """stitches of a row of stockinette and rib"""
    glove: str = "glove.bcc"
    skirt: str = "skirt.obj"
    unit: str = "dm"
    """unit of the file of the skirt"""
    skirt_width: float = 0.8
    """stitch width of the skirt [cm]"""
    max_iterations: int = PRESETS["standard"].max_iterations
    """of varied runs"""
    reference_tolerance: float = PRESETS["reference"].tolerance
    reference_iterations: int = PRESETS["reference"].max_iterations


def run(given: Options) -> Rows:
    """Measure, and write a row after each run."""
    if not given.resume:
        given.output.unlink(missing_ok=True)
    for name in given.scene:
        yield from measure_scene(scene_named(name, given), given)


def plot(file: Path, /, *, picture: str = "docs/accuracy.png") -> Rows:
    """Draw the rows of a file, and yield their tables."""
    rows = read(file)
    draw(rows, picture)
    yield from tables(rows)


ACTIONS = (run, plot)
