# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The command ``stretch``: its arguments, and what it does."""

from __future__ import annotations

import argparse
import math
from argparse import Namespace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from stitchmesh.errors import ParameterError

if TYPE_CHECKING:
    from stitchmesh.periodic.stretch import StretchPoint

OTHER = ("free", "held")
"""What a direction may be that is not drawn."""


def add_stretch(commands: argparse._SubParsersAction) -> None:
    """Add the command to the parser."""
    what = "draw a swatch in one direction: tension against strain"
    command = commands.add_parser("stretch", help=what)
    command.add_argument("pattern", metavar="PATTERN", help="name of a pattern or weave, or a file of one")
    command.add_argument("-o", "--output", required=True, metavar="DIR", help="folder for stretch.csv and stretch.png")
    for name in ("course", "wale"):
        what = f"strains along the {name}s, 0:40%% or 0:0.4 (--{name}=-10:40%% where they begin below); free or held"
        command.add_argument(f"--{name}", metavar="FROM:TO", help=f"{what} if the other is drawn (free)")
    command.add_argument("--steps", type=int, default=9, metavar="N", help="strains, the first and last included (9)")
    command.add_argument("--yarn-radius", type=float, metavar="CM", help="yarn radius (0.125)")
    command.add_argument("--loop-length", type=float, metavar="CM", help="yarn of a plain stitch (16.67 diameters)")
    command.add_argument("--spacing", type=float, metavar="CM", help="distance of a weave's yarns (2.4 diameters)")
    command.add_argument("--gamma", type=float, default=1.0, metavar="G", help="yarn is taken up by this factor (1)")
    command.add_argument("--columns", type=int, default=1, metavar="N", help="repeats side by side (1)")
    command.add_argument("--rows", type=int, default=1, metavar="N", help="repeats above one another (1)")
    what = "stitchmesh (default), leaf, kaldor-simulation or kaldor-relaxation; scaled to the yarn's radius"
    command.add_argument("--material", default="stitchmesh", metavar="NAME", help=what)
    command.add_argument("--quality", default="standard", help="draft, standard (default) or reference")
    command.add_argument("--device", help="cpu or cuda:0 (the first GPU if there is one)")


def stretch(arguments: Namespace) -> None:
    """A stretch curve, its table and its picture."""
    directions = drawn_directions(arguments.course, arguments.wale)
    from stitchmesh.periodic.stretch import stretch_test as stretch_swatch
    from stitchmesh.periodic.stretch_table import write_stretch
    from stitchmesh.periodic.swatch import YARN_RADIUS
    from stitchmesh.render.stretch_plot import plot_stretch
    from stitchmesh.yarnrelax import REFERENCE_RADIUS, YarnMaterial

    radius = YARN_RADIUS if arguments.yarn_radius is None else arguments.yarn_radius
    named = YarnMaterial.named(arguments.material)
    curve = stretch_swatch(
        arguments.pattern, **directions, steps=arguments.steps, quality=arguments.quality, device=arguments.device,
        material=named.scaled(radius / REFERENCE_RADIUS), progress=_tell, yarn_radius=radius,
        loop_length=arguments.loop_length, spacing=arguments.spacing, gamma=arguments.gamma,
        columns=arguments.columns, rows=arguments.rows,
    )  # fmt: skip
    write_stretch(Path(arguments.output) / "stretch.csv", curve)
    plot_stretch(curve, Path(arguments.output) / "stretch.png")


def drawn_directions(course: str | None, wale: str | None) -> dict[str, Any]:
    """Arguments of ``stretch`` for what is asked of both directions.

    Raises:
        ParameterError: not one of them is a range, or one is neither a range nor free nor held.
    """
    given = {"course": course or "free", "wale": wale or "free"}
    ranges = {name: strains(name, text) for name, text in given.items() if text not in OTHER}
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


def _tell(point: StretchPoint) -> None:
    """A line for each state."""
    tension = f"tension {point.course_tension:.4g} dyn/cm along the courses, {point.wale_tension:.4g} along the wales"
    rest = "" if point.converged else ", not at rest"
    size = f"{point.width:.4g} x {point.height:.4g} cm"
    print(f"{100 * point.strain:g} %: {size}, {tension}{rest}", flush=True)
