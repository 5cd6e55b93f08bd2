# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The command ``measure``."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from tyro.conf import Positional, UseAppendAction, arg

from stitchmesh.cli.options import Device, Overwrite, SwatchFabric, Threads
from stitchmesh.cli.output_folder import output_folder
from stitchmesh.cli.say import say
from stitchmesh.cli.setting_flags import flag_of
from stitchmesh.cli.summary import AsJson
from stitchmesh.cli.words import Period, help_entry
from stitchmesh.errors import ParameterError
from stitchmesh.jobs.sections import SwatchTable
from stitchmesh.periodic.swatch_options import StateSettings, SwatchOptions
from stitchmesh.quality import PRESETS
from stitchmesh.recipe.sections import MaterialSection

if TYPE_CHECKING:
    from stitchmesh.measuring import Measured, PresetMeasure

FIGURES, PLOT = "measure.json", "measure.png"
"""Files that the command writes."""
HEADS = (
    "quality", "seconds", "peak MB", "points", "iterations", "at rest", "residual", "strain", "nearest", "rms",
    "largest", "width", "height", "energy",
)  # fmt: skip
"""Heads of the columns; the last five are differences from the finest preset."""


@dataclass(frozen=True)
class MeasureCommand:
    """Measure what each quality costs, and its error, on your garment or swatch."""

    piece: Annotated[Positional[str], help_entry("RECIPE|PATTERN")]
    """recipe (.toml) of a garment; or a pattern or weave of a swatch: a name of `stitchmesh patterns`, or a file"""
    output: Annotated[str | None, help_entry("DIR", "none", short="-o")] = None
    """output folder for the figures, measure.json, and their plot, measure.png"""
    quality: Annotated[UseAppendAction[tuple[str, ...]], help_entry("NAME", ", ".join(PRESETS))] = ()
    """preset to measure; may be repeated; the finest one is the yardstick of the others"""
    fabric: SwatchFabric = field(default_factory=SwatchFabric)
    period: Annotated[Period, flag_of(SwatchTable, "period")] = SwatchOptions.period
    state: Annotated[StateSettings, arg(name="")] = field(default_factory=StateSettings)
    material: MaterialSection = field(default_factory=MaterialSection)
    device: Device = None
    threads: Threads = None
    json: AsJson = False
    overwrite: Overwrite = False

    def run(self) -> None:
        """Measure, write the figures and their plot after each preset, and print a table.

        Raises:
            ParameterError: an option of a swatch is given for a recipe.
        """
        from stitchmesh.cli.progress import show_progress
        from stitchmesh.measuring import measure

        given = self._swatch_options()
        names = self.quality or tuple(PRESETS)
        if self.output is None:
            with show_progress() as progress:
                made = measure(self.piece, qualities=names, device=self.device, progress=progress, **given)
        else:
            with output_folder(self.output, (FIGURES, PLOT)) as folder, show_progress() as progress:
                made = measure(
                    self.piece, qualities=names, device=self.device, progress=progress,
                    on_measure=lambda measured: _write(folder, measured), **given,
                )  # fmt: skip
        if self.json:
            from json import dumps

            say(dumps(made.report(), indent=2))
            return
        say("\n".join(_lines(made)))
        if self.output is not None:
            say(f"Open {Path(self.output) / PLOT}; {Path(self.output) / FIGURES} holds all numbers.")

    def _swatch_options(self) -> dict[str, Any]:
        """Return the arguments of ``measure`` for a swatch; none for a recipe.

        Raises:
            ParameterError: an option of a swatch is given for a recipe.
        """
        own = MeasureCommand(self.piece)
        if self.piece.lower().endswith(".toml"):
            for name in ("fabric", "period", "state", "material"):
                if getattr(self, name) != getattr(own, name):
                    raise ParameterError(f"measure: an option of a swatch is given; write it into {self.piece}")
            return {}
        from stitchmesh.periodic.resolve_pattern import resolve_pattern
        from stitchmesh.periodic.weave.weave import Weave

        fabric = self.fabric.options(woven=isinstance(resolve_pattern(self.piece), Weave))
        material = self.material.yarn_material(fabric["yarn_radius"], fabric["mass_per_length"], self.fabric.yarn.yarn)
        return {"material": material, "period": self.period, **vars(self.state), **fabric}


def _write(folder: Path, measured: Measured) -> None:
    from stitchmesh.io.atomic import write_json
    from stitchmesh.render.plots.measure_plot import plot_measures

    write_json(folder / FIGURES, measured.report())
    if measured.presets:
        plot_measures(measured, folder / PLOT)


def _lines(measured: Measured) -> list[str]:
    """Return the table, with the differences from the finest preset."""
    table = [HEADS, *map(_cells, measured.presets)]
    widths = [max(len(row[column]) for row in table) for column in range(len(HEADS))]
    lines = ["  ".join(cell.rjust(width) for cell, width in zip(row, widths, strict=True)) for row in table]
    stages = [f"{each.quality}: " + ", ".join(f"{name} {seconds:.2f} s" for name, seconds in each.stages.items())
              for each in measured.presets]  # fmt: skip
    *others, finest = measured.presets
    said = f"From rms on: differences from {finest.quality}, in yarn radii (rms and largest distance) and in percent."
    size = f"A stitch of {finest.quality} is {finest.wale_spacing:.4g} x {finest.course_spacing:.4g} cm."
    failures = [f"{name} has failed: {error}" for name, error in measured.failures.items()]
    return [*lines, f"{said} {size}" if others else size, *stages, *failures]


def _cells(measure: PresetMeasure) -> tuple[str, ...]:
    error = measure.error
    differences = ["-"] * 5
    if error is not None:
        places = ["-" if value is None else f"{value:.3g}" for value in (error.rms, error.largest)]
        parts = [f"{100.0 * value:.2g}%" for value in (error.wale_spacing, error.course_spacing, error.energy)]
        differences = [*places, *parts]
    return (
        measure.quality, f"{measure.seconds:.3g}", f"{measure.memory_bytes / 1e6:.0f}", f"{measure.control_points:,}",
        f"{measure.iterations:,}", "yes" if measure.at_rest else "no", f"{measure.residual:.2g}",
        f"{100.0 * measure.max_strain:.2g}%", f"{measure.nearest:.3g}", *differences,
    )  # fmt: skip
