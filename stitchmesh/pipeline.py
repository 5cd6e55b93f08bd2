# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The whole line from a polygon mesh to relaxed yarns on disk."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, dataclass, field
from os import PathLike
from pathlib import Path

import numpy as np

from stitchmesh import __version__
from stitchmesh.compute.device import device_named
from stitchmesh.description import stitch_counts
from stitchmesh.editing.spiral import make_spiral
from stitchmesh.io.atomic import write_json
from stitchmesh.io.contents import FilePath
from stitchmesh.io.history import HistoryEntry, write_history
from stitchmesh.io.stitches import write_stitches
from stitchmesh.io.yarns import write_yarns
from stitchmesh.labeling import label
from stitchmesh.mesh import Mesh, StitchMesh
from stitchmesh.mesh.change import apply_change
from stitchmesh.meshrelax import relax_mesh_with_report
from stitchmesh.meshrelax.relax import TOLERANCE as MESH_TOLERANCE
from stitchmesh.patterns import Pattern
from stitchmesh.patterns.placement.apply import changed_face_count, pattern_changes
from stitchmesh.patterns.placement.columns import Remainder
from stitchmesh.quality import Quality, quality_named
from stitchmesh.tessellate import tessellate
from stitchmesh.yarn import YarnSet
from stitchmesh.yarn.rest_length import RestLengths, apply_rest_lengths
from stitchmesh.yarngen import YarnFinish, generate_yarns
from stitchmesh.yarngen.generate import checked_radius
from stitchmesh.yarnrelax import REFERENCE_RADIUS, Relaxation, YarnMaterial, relax_yarns
from stitchmesh.yarnrelax.checkpoint import Checkpoints
from stitchmesh.yarnrelax.energies.term import ConstraintChoice, TermChoice

STITCH_WIDTH = 0.8
"""Default wale spacing [cm]: worsted yarn by hand, about 13 stitches in 10 cm."""

Progress = Callable[[str, float, str], None]
"""Called with the stage, the part of it that is done (0 to 1), and a line or two on how it goes."""


@dataclass(frozen=True)
class RelaxOptions:
    """What the relaxation of yarns may be told, beside its quality and device.

    Raises:
        ParameterError: there is no material of that name.
    """

    material: str = "stitchmesh"
    """Name of a material, which is scaled to the yarns' radius."""
    rest_lengths: RestLengths = field(default_factory=RestLengths)
    """How much yarn goes where."""
    terms: Sequence[TermChoice] = ()
    """More energies."""
    constraints: Sequence[ConstraintChoice] = ()
    """What holds control points."""
    checkpoint: Checkpoints | None = None
    """Where and how often what it takes to resume is written."""
    resume: FilePath | None = None
    """A checkpoint to go on from."""

    def __post_init__(self) -> None:
        YarnMaterial.named(self.material)


@dataclass(frozen=True)
class KnitOptions:
    """What ``knit`` may be told."""

    stitch_width: float = STITCH_WIDTH
    """Wale spacing [cm]."""
    yarn_radius: float | None = None
    """Yarn radius [cm]; an eighth of the stitch width unless given."""
    quality: str | Quality = "standard"
    """Preset of ``quality.py``, or a value of one's own."""
    device: str | None = None
    """Warp's name of the device; its preferred one unless given."""
    seeds: Sequence[int | tuple[int, int]] = ()
    """Course edges that rows start from."""
    flip: Sequence[int] = ()
    """Faces whose rows are turned over."""
    pattern: Pattern | None = None
    """What the stitches are worked in, if not all knit."""
    pattern_remainder: Remainder = "centre"
    """What is done with stitches that whole tiles of the pattern leave over, as in ``apply_pattern``."""
    spiral: bool = False
    """Whether the rings of tubes become turns of one row that climbs."""
    finish: YarnFinish = field(default_factory=YarnFinish)
    """How rows are cast on and bound off, and which floats are cut."""
    relaxation: RelaxOptions = field(default_factory=RelaxOptions)
    """How the yarns are relaxed."""


@dataclass(frozen=True)
class Knitted:
    """What ``knit`` made."""

    fabric: StitchMesh
    yarns: YarnSet
    report: dict[str, object]
    history: Sequence[HistoryEntry]
    """How the yarns came to rest."""


def silent(stage: str, done: float, note: str) -> None:
    """A progress that tells nobody."""


def knit(
    mesh: Mesh, folder: str | PathLike[str], options: KnitOptions, *, progress: Progress = silent
) -> Knitted:
    """Turn a polygon mesh into relaxed yarns and write them.

    Writes ``stitches.h5``, ``yarns.h5``, ``yarns.bcc``, ``report.json`` and ``convergence.csv`` into the folder. While
    yarns relax, the last good state is saved now and then and when the user interrupts, and ``report.json`` says that
    it is unfinished.

    Raises:
        StitchMeshError: from the stage that cannot go on.
    """
    quality = quality_named(options.quality)
    device = str(device_named(options.device))
    told = options.quality if isinstance(options.quality, str) else asdict(options.quality)
    report: dict[str, object] = {"stitchmesh": __version__, "device": device, "quality": told}
    target = Path(folder)
    fabric = _stitches(mesh, options, device, report, progress)
    yarns = _yarns(fabric, options, quality, report, progress)
    write_stitches(target / "stitches.h5", fabric)
    saver = _StateSaver(target, report, yarns)
    try:
        relaxed = relax_as_told(
            yarns, options.relaxation, quality=quality, device=device, fabric=fabric, keep_shape=True,
            progress=progress, on_state=saver.keep,
        )  # fmt: skip
    except KeyboardInterrupt:
        saver.save()
        raise
    report["yarnrelax"] = relaxed.report
    save_yarns(target, relaxed.yarns, report)
    write_history(target / "convergence.csv", relaxed.history)
    return Knitted(fabric, relaxed.yarns, report, relaxed.history)


def relax_as_told(
    yarns: YarnSet, options: RelaxOptions, *, quality: str | Quality, device: str | None = None,
    fabric: StitchMesh | None = None, keep_shape: bool = False, start: YarnSet | None = None,
    progress: Progress = silent, on_state: Callable[[YarnSet], None] | None = None,
) -> Relaxation:  # fmt: skip
    """Give yarns their rest lengths and relax them.

    Args:
        yarns: the yarns.
        options: what to relax and how.
        quality: a preset or a ``Quality``.
        device: Warp's name of the device; its preferred one unless given.
        fabric: the fabric that the yarns were made from, if it is known.
        keep_shape: whether the fabric's borders and shape are to be kept.
        start: the same yarns in another place to start from.
        progress: told how far the relaxation is.
        on_state: called now and then with the last good state.

    Raises:
        StitchMeshError: the rest lengths do not fit, or as for ``relax_yarns``.
    """
    quality = quality_named(quality)
    tell = relaxing_progress("yarnrelax", quality.tolerance, progress, max_iterations=quality.max_iterations)
    return relax_yarns(
        apply_rest_lengths(yarns, options.rest_lengths, fabric=fabric),
        start=start,
        material=YarnMaterial.named(options.material).scaled(float(yarns.radius.mean()) / REFERENCE_RADIUS),
        quality=quality,
        device=device,
        keep_shape=fabric if keep_shape else None,
        terms=options.terms,
        constraints=options.constraints,
        progress=lambda entry: tell(entry["iteration"], entry["residual"], entry["energies"]),
        on_state=on_state,
        checkpoint=options.checkpoint,
        resume=options.resume,
    )


def save_yarns(folder: Path, yarns: YarnSet, report: dict[str, object]) -> None:
    """Write yarns and their report, each file atomically."""
    write_yarns(folder / "yarns.h5", yarns)
    write_yarns(folder / "yarns.bcc", yarns)
    write_json(folder / "report.json", report)


class _StateSaver:
    """Saves the relaxation's last good state now and then; the yarns as generated are the first."""

    EVERY_SECONDS = 60.0

    def __init__(self, folder: Path, report: dict[str, object], start: YarnSet) -> None:
        self._folder, self._report, self._state = folder, report, start
        self._saved = time.monotonic()

    def keep(self, state: YarnSet) -> None:
        """Take a good state; write it if the last one on disk is old."""
        self._state = state
        if time.monotonic() - self._saved > self.EVERY_SECONDS:
            self.save()

    def save(self) -> None:
        """Write the last good state, marked as unfinished."""
        save_yarns(self._folder, self._state, {**self._report, "yarnrelax": {"unfinished": True}})
        self._saved = time.monotonic()


def _stitches(
    mesh: Mesh, options: KnitOptions, device: str, report: dict[str, object], progress: Progress
) -> StitchMesh:
    clock = _Clock()
    progress("label", 0.0, f"{mesh.face_count} faces")
    labeled = label(mesh, seeds=options.seeds, flip=options.flip)
    report["label"] = {"seconds": clock.lap(), "rows": int(labeled.row.max()) + 1, "faces": labeled.face_count}
    progress("tessellate", 0.0, f"{int(labeled.row.max()) + 1} rows")
    fabric = tessellate(labeled, stitch_width=options.stitch_width)
    checked_radius(fabric, options.yarn_radius)  # before the long work, not after it
    report["tessellate"] = {"seconds": clock.lap(), **stitch_counts(fabric)}
    if options.pattern is not None:
        progress("pattern", 0.0, options.pattern.name)
        fabric, faces = with_pattern(fabric, options.pattern, options.pattern_remainder)
        report["pattern"] = {"name": options.pattern.name, "faces": faces, "seconds": clock.lap()}
    progress("meshrelax", 0.0, f"{fabric.face_count} stitches")
    relaxed, how = relax_mesh_with_report(
        fabric, surface=mesh, device=device, progress=relaxing_progress("meshrelax", MESH_TOLERANCE, progress)
    )
    report["meshrelax"] = {**asdict(how), "seconds": clock.lap()}
    if options.spiral:
        rings, relaxed = relaxed, make_spiral(relaxed)
        report["spiral"] = {"spirals": len(relaxed.vertices) - len(rings.vertices), "seconds": clock.lap()}
    return relaxed


def with_pattern(
    fabric: StitchMesh, pattern: Pattern, remainder: Remainder, *, face: int | None = None
) -> tuple[StitchMesh, int]:
    """A fabric in a pattern, and how many faces the pattern made others.

    Raises:
        StitchMeshError: as for ``apply_pattern``.
    """
    changes = pattern_changes(fabric, pattern, face=face, remainder=remainder)
    for change in changes:
        fabric = apply_change(fabric, change)
    return fabric, changed_face_count(changes)


def _yarns(
    fabric: StitchMesh, options: KnitOptions, quality: Quality, report: dict[str, object], progress: Progress
) -> YarnSet:
    clock = _Clock()
    progress("yarngen", 0.0, f"{fabric.face_count} stitches")
    yarns = generate_yarns(fabric, yarn_radius=options.yarn_radius, quality=quality, **asdict(options.finish))
    report["yarngen"] = {
        "seconds": clock.lap(),
        "yarns": yarns.yarn_count,
        "control_points": len(yarns.points),
        "length_cm": round(float(yarns.lengths.sum()), 3),
    }
    progress("yarnrelax", 0.0, f"{len(yarns.points)} control points")
    return yarns


def relaxing_progress(
    stage: str, tolerance: float, progress: Progress, *, max_iterations: float = math.inf
) -> Callable[..., None]:
    """Turn what a solver tells into the part done: its iteration, its residual and, if it knows, energies by term.

    Residuals fall by a factor a turn, so their logarithm counts; the iterations do where they run out sooner.
    """
    start: list[tuple[int, float]] = []

    def tell(iteration: int, residual: float, energies: Mapping[str, float] | None = None) -> None:
        """Report one assessment."""
        if not start and residual > tolerance and math.isfinite(residual):
            start.append((iteration, residual))
        done = 0.0
        if start and residual > 0.0:
            first, highest = start[0]
            fallen = math.log(highest / residual) / math.log(highest / tolerance)
            done = max(fallen, (iteration - first) / max(max_iterations - first, 1.0))
        progress(stage, float(np.clip(done, 0.0, 1.0)), _note(iteration, residual, energies or {}))

    return tell


def _note(iteration: int, residual: float, energies: Mapping[str, float]) -> str:
    """A relaxation's figures, energies in a second line."""
    line = f"iteration {iteration}, residual {residual:.3g}"
    if not energies:
        return line
    return f"{line}\n{', '.join(f'{term} {energy:.2g}' for term, energy in energies.items())} erg"


class _Clock:
    """Seconds between laps."""

    def __init__(self) -> None:
        self._last = time.perf_counter()

    def lap(self) -> float:
        """Seconds since the last lap."""
        now = time.perf_counter()
        seconds, self._last = now - self._last, now
        return round(seconds, 4)
