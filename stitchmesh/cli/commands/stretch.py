# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The command ``stretch``."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Annotated, Any

from tyro.conf import Positional, arg

from stitchmesh.cli.budget_options import OUT_OF_TIME, TimeOption
from stitchmesh.cli.options import Device, Overwrite, QualityName, SwatchFabric, Threads
from stitchmesh.cli.output_folder import output_folder
from stitchmesh.cli.say import say
from stitchmesh.cli.words import help_entry
from stitchmesh.errors import ParameterError
from stitchmesh.periodic.swatch_options import StretchSettings
from stitchmesh.quality import DEFAULT_QUALITY
from stitchmesh.recipe.sections import MaterialSection

if TYPE_CHECKING:
    from stitchmesh.periodic.stretch import StretchPoint

FREE, HELD = "free", "held"
"""Words for the direction in which the swatch is not stretched: no tension, or constant size."""
STRAINS = (
    "0:40% or 0:0.4 (=-10:40% if the first is negative), 0:40:20:40% if the stretch turns; free or held if the swatch "
    "is stretched in the other"
)
TABLE, PLOT = "stretch.csv", "stretch.png"
"""Files in the output folder."""


@dataclass(frozen=True)
class StretchCommand:
    """Stretch a swatch in one direction, and measure tension against strain."""

    pattern: Annotated[Positional[str], help_entry("PATTERN")]
    """pattern or weave: a name of `stitchmesh patterns`, or a file"""
    output: Annotated[str, help_entry("DIR", short="-o")]
    """output folder for stretch.csv and stretch.png"""
    course: Annotated[str, help_entry("FROM:TO[:TO]", help=f"strains along the courses: {STRAINS} direction")] = FREE
    wale: Annotated[str, help_entry("FROM:TO[:TO]", help=f"strains along the wales: {STRAINS} direction")] = FREE
    way: Annotated[StretchSettings, arg(name="")] = field(default_factory=StretchSettings)
    material: MaterialSection = field(default_factory=MaterialSection)
    quality: QualityName = DEFAULT_QUALITY
    device: Device = None
    threads: Threads = None
    time: Annotated[TimeOption, arg(name="")] = field(default_factory=TimeOption)
    fabric: SwatchFabric = field(default_factory=SwatchFabric)
    overwrite: Overwrite = False

    def run(self) -> int | None:
        """Compute the stretch curve, and write its table and its plot.

        Returns:
            The exit status if the time ended the curve before its last strain, otherwise None.
        """
        directions = stretch_directions(self.course, self.wale)
        from stitchmesh.periodic.hysteresis import loop_texts
        from stitchmesh.periodic.resolve_pattern import resolve_pattern
        from stitchmesh.periodic.stretch import StretchPath, stretch_test, write_stretch
        from stitchmesh.periodic.weave.weave import Weave
        from stitchmesh.render.plots.stretch_plot import plot_stretch
        from stitchmesh.run import Run

        pattern = resolve_pattern(self.pattern)
        options = self.fabric.options(woven=isinstance(pattern, Weave))
        yarn = self.fabric.yarn.yarn
        material = self.material.yarn_material(options["yarn_radius"], options["mass_per_length"], yarn)
        path = StretchPath(**directions, **vars(self.way))
        with output_folder(self.output, (TABLE, PLOT)) as folder:
            run: Run[StretchPoint] = Run(on_state=_print_state)
            curve = stretch_test(
                pattern, path, quality=self.quality, device=self.device, material=material, budget=self.time.limit(),
                run=run, **options,
            )  # fmt: skip
            write_stretch(folder / TABLE, curve)
            plot_stretch(curve, folder / PLOT)
        if curve.friction:
            for text in loop_texts(curve.loops):
                say(f"Loop {text}.")
        if not curve.ranges.good:
            say(str(curve.ranges))
        if not curve.out_of_time:
            return None
        say(f"Not good: the time was over after {len(curve.points)} strains; allow more time.")
        return OUT_OF_TIME


def stretch_directions(course: str, wale: str) -> dict[str, Any]:
    """Return the fields of a ``StretchPath`` for the options of the two directions.

    Args:
        course: ``FROM:TO``, ``FROM:TO:TO``..., ``free`` or ``held``.
        wale: the same.

    Raises:
        ParameterError: not exactly one option is a range of strains, or a range is malformed.
    """
    given = {"course": course, "wale": wale}
    ranges = {name: strains(name, text) for name, text in given.items() if text not in (FREE, HELD)}
    if len(ranges) != 1:
        got = " and ".join(f"--{name} {text}" for name, text in given.items())
        expected = "a range such as 0:40% for one, and free or held for the other"
        raise ParameterError(f"stretch: got {got}; expected {expected}")
    other = next(text for name, text in given.items() if name not in ranges)
    return {**ranges, "other": other}


def strains(name: str, text: str) -> tuple[float, ...]:
    """Return the strains of a text such as ``0:40%``, ``0:0.4`` or ``0:40:20:40%``; a percent sign applies to all.

    Raises:
        ParameterError: the text is malformed.
    """
    words = text.split(":")
    try:
        found = [float(word.strip().removesuffix("%")) for word in words]
    except ValueError:
        found = []
    if len(found) < 2 or not all(math.isfinite(strain) for strain in found):
        raise ParameterError(f"--{name}: got {text!r}; expected two strains such as 0:40% or 0:0.4, free or held")
    unit = 0.01 if "%" in text else 1.0
    return tuple(strain * unit for strain in found)


def _print_state(point: StretchPoint) -> None:
    """Print one state of the stretch curve as a line."""
    tension = f"tension {point.course_tension:.4g} dyn/cm along the courses, {point.wale_tension:.4g} along the wales"
    convergence = "" if point.converged else ", not converged"
    size = f"{point.width:.4g} x {point.height:.4g} cm"
    say(f"{100 * point.strain:.4g} %, branch {point.branch}: {size}, {tension}{convergence}", flush=True)
