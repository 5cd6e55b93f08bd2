# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The command ``stretch``."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from tyro.conf import Positional

from stitchmesh.cli.arguments import shown
from stitchmesh.cli.options import Device, Material, QualityName, SwatchFabric
from stitchmesh.errors import ParameterError
from stitchmesh.periodic.swatch_options import STRETCH_STEPS
from stitchmesh.quality import DEFAULT_QUALITY
from stitchmesh.yarnrelax.model.material import DEFAULT_MATERIAL

if TYPE_CHECKING:
    from stitchmesh.periodic.stretch import StretchPoint

FREE, HELD = "free", "held"
"""What a direction may be along which the swatch is not stretched."""
STRAINS = "0:40% or 0:0.4 (=-10:40% for strains that begin below 0); free or held if it is stretched along the other"


@dataclass(frozen=True)
class Stretch:
    """Stretch a swatch in one direction: tension against strain."""

    pattern: Annotated[Positional[str], shown("PATTERN")]
    """name of a pattern or weave, or a file of one"""
    output: Annotated[str, shown("DIR", short="-o")]
    """folder for stretch.csv and stretch.png"""
    course: Annotated[str, shown("FROM:TO", help=f"strains along the courses, {STRAINS}")] = FREE
    wale: Annotated[str, shown("FROM:TO", help=f"strains along the wales, {STRAINS}")] = FREE
    steps: Annotated[int, shown("N")] = STRETCH_STEPS
    """strains, the first and the last included"""
    material: Material = DEFAULT_MATERIAL
    quality: QualityName = DEFAULT_QUALITY
    device: Device = None
    fabric: SwatchFabric = field(default_factory=SwatchFabric)

    def run(self) -> None:
        """A stretch curve, its table and its picture."""
        directions = stretched_directions(self.course, self.wale)
        from stitchmesh.periodic.stretch import stretch_test
        from stitchmesh.periodic.stretch_table import write_stretch
        from stitchmesh.render.stretch_plot import plot_stretch
        from stitchmesh.yarnrelax import REFERENCE_RADIUS, YarnMaterial

        material = YarnMaterial.named(self.material).scaled(self.fabric.yarn_radius / REFERENCE_RADIUS)
        curve = stretch_test(
            self.pattern, **directions, steps=self.steps, quality=self.quality, device=self.device, material=material,
            progress=_print_state, **self.fabric.options(),
        )  # fmt: skip
        write_stretch(Path(self.output) / "stretch.csv", curve)
        plot_stretch(curve, Path(self.output) / "stretch.png")


def stretched_directions(course: str, wale: str) -> dict[str, Any]:
    """Arguments of ``stretch`` for what is asked of both directions.

    Raises:
        ParameterError: not one of them is a range, or one is neither a range nor free nor held.
    """
    given = {"course": course, "wale": wale}
    ranges = {name: strains(name, text) for name, text in given.items() if text not in (FREE, HELD)}
    if len(ranges) != 1:
        got = " and ".join(f"--{name} {text}" for name, text in given.items())
        expected = "a range such as 0:40% of one, and free or held of the other"
        raise ParameterError(f"stretch: got {got}; expected {expected}")
    other = next(text for name, text in given.items() if name not in ranges)
    return {**ranges, "other": other}


def strains(name: str, text: str) -> tuple[float, float]:
    """First and last strain of ``0:40%`` or ``0:0.4``; a percent sign holds for both.

    Raises:
        ParameterError: it is neither.
    """
    words = text.split(":")
    try:
        first, last = (float(word.strip().removesuffix("%")) for word in words)
    except ValueError:
        first = last = math.nan
    if not (math.isfinite(first) and math.isfinite(last)):
        raise ParameterError(f"--{name}: got {text!r}; expected two strains such as 0:40% or 0:0.4, free or held")
    unit = 0.01 if "%" in text else 1.0
    return first * unit, last * unit


def _print_state(point: StretchPoint) -> None:
    """A line for each state."""
    tension = f"tension {point.course_tension:.4g} dyn/cm along the courses, {point.wale_tension:.4g} along the wales"
    rest = "" if point.converged else ", not at rest"
    size = f"{point.width:.4g} x {point.height:.4g} cm"
    print(f"{100 * point.strain:g} %: {size}, {tension}{rest}", flush=True)
