# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Free swatches of all patterns of the library, lying on nothing and between planes: size, thickness and shape.

Yields a row for each pattern, and draws sheets of pictures. Knits are let go off the needles dry, unless
another state is asked for. The pressure is the force on one plane over the area of the repeat; the weight is that of
the fabric over the same area.
"""

from __future__ import annotations

import logging
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from PIL import Image, ImageDraw
from tyro.conf import Positional

import stitchmesh as sm
from benchmarks.table import Rows
from stitchmesh import __version__
from stitchmesh.periodic.swatch_options import KnitState
from stitchmesh.quality import Quality, quality_named
from stitchmesh.render import render_swatch

SIDE, COLUMNS, SHOWN = 220, 8, 11.0
"""Pixels of a picture, pictures in a row of a sheet, and width of the fabric in a picture [cm]."""
FALL = 981.0
"""Acceleration on Earth [cm / s^2]."""
LOOPS = (14.0, 16.67, 20.0, 24.0, 30.0, 40.0)
"""Loop lengths of stockinette [yarn diameters]."""
MOST_ITERATIONS = 40_000
"""Iterations with a given tolerance."""
HEAD = (
    "pattern", "lying on nothing [cm]", "thickness", "shape", "between planes [cm]", "thickness", "shape",
    "energies [erg]", "pressure, weight [dyn/cm²]",
)  # fmt: skip


@dataclass(frozen=True)
class Options:
    """What is measured."""

    patterns: Positional[tuple[str, ...]] = ()
    device: str | None = None
    quality: str = "standard"
    tolerance: float | None = None
    """relax to this residual in double precision"""
    relaxation: KnitState | None = None
    """state of the knits"""
    out: Path = Path("out/free-shapes")
    no_pictures: bool = False


def free_shapes(chosen: Options) -> Rows:
    """Relax, measure and draw."""
    logging.getLogger("stitchmesh").setLevel(logging.ERROR)
    chosen.out.mkdir(parents=True, exist_ok=True)
    made = []
    yield f"Version {__version__}, quality {chosen.quality}."
    yield HEAD
    for name in chosen.patterns or [*sm.pattern_names(), *sm.weave_names()]:
        pair = relaxed(chosen, [(name, {"unsupported": True}), (name, {})])
        made.append((name, pair))
        yield row_of(name, *pair)
    yield from loop_lines(chosen)
    for place, kind in enumerate(() if chosen.no_pictures else ("nothing", "planes")):
        write_sheet(chosen.out / f"{kind}.png", [(name, pair[place]) for name, pair in made])


def relaxed(chosen: Options, asked: Sequence[tuple[str, dict[str, Any]]]) -> list[sm.Swatch]:
    """Free swatches of patterns with further options, relaxed together."""
    quality = quality_named(chosen.quality)
    if chosen.tolerance is not None:
        quality = replace(quality, precision="float64", tolerance=chosen.tolerance, max_iterations=MOST_ITERATIONS)
    requests = [request_of(name, quality, chosen.relaxation, **options) for name, options in asked]
    return [raised(made) for made in sm.relax_swatches(requests, device=chosen.device, progress=False)]


def request_of(
    name: str | sm.Pattern, quality: str | Quality, relaxation: KnitState | None, **options: Any
) -> sm.SwatchRequest:
    """A free swatch of a pattern, where it is a knit in a state."""
    state = None if name in sm.weave_names() else relaxation
    return sm.SwatchRequest(name, relax_cell=True, quality=quality, options=options | {"relaxation": state})


def raised(made: sm.Swatch | sm.StitchMeshError) -> sm.Swatch:
    """A swatch, or its error as an exception."""
    if isinstance(made, sm.Swatch):
        return made
    raise made


def row_of(name: str, alone: sm.Swatch, lying: sm.Swatch) -> tuple[str, ...]:
    """One row of the table."""
    parts = [name]
    for made in (alone, lying):
        report = made.report
        mark = "" if report["converged"] else " (not at rest)"
        parts += [f"{report['wale_spacing']:.3f} x {report['course_spacing']:.3f}{mark}",
                  f"{report['thickness_ratio']:.2f}", report["shape"]]  # fmt: skip
    energies = (yarn_energy(made) for made in (alone, lying))
    pressure, weight = lying.report["planes_pressure"], lying.report["areal_density"] * FALL
    parts += [", ".join(f"{energy:.1f}" for energy in energies), f"{pressure:.1f}, {weight:.0f}"]
    return tuple(parts)


def yarn_energy(made: sm.Swatch) -> float:
    """Energy of the yarns of a stitch, without that of the planes [erg]."""
    energies = {name: value for name, value in made.report["energies"].items() if name != "confinement"}
    return float(sum(energies.values())) / float(made.report["stitches"])


def loop_lines(chosen: Options) -> Rows:
    """How much thicker stockinette rests than it is generated, for loops of several lengths."""
    asked = [("stockinette", {"unsupported": True, "loop_length": 0.25 * loop}) for loop in LOOPS]
    for loop, made in zip(LOOPS, relaxed(chosen, asked), strict=True):
        report = made.report
        more = report["thickness"] * (1.0 - 1.0 / report["thickness_ratio"]) / 0.25
        thicker = f"{more:.2f} diameters thicker than generated, {more / loop:.4f} of the loop"
        yield f"Stockinette, loops of {loop:g} diameters: {thicker}."


def write_sheet(path: Path, made: Sequence[tuple[str, sm.Swatch]]) -> None:
    """Draw swatches side by side, each with its name, spacings and shape."""
    rows = -(-len(made) // COLUMNS)
    sheet = Image.new("RGB", (COLUMNS * (SIDE + 6), rows * (SIDE + 32)), "white")
    write = ImageDraw.Draw(sheet)
    for number, (name, swatch) in enumerate(made):
        width, height = (swatch.report[key] for key in ("width", "height"))
        picture = path.parent / f"{path.stem}-{name}.png"
        render_swatch(swatch.yarns, picture, (max(1, round(SHOWN / width)), max(1, round(SHOWN / height))))
        corner = (number % COLUMNS * (SIDE + 6), number // COLUMNS * (SIDE + 32))
        with Image.open(picture) as drawn:
            small = drawn.convert("RGB")
            small.thumbnail((SIDE, SIDE))
        picture.unlink()
        sheet.paste(small, (corner[0], corner[1] + 28))
        report = swatch.report
        size = f"{report['wale_spacing']:.2f} x {report['course_spacing']:.2f} cm"
        rest = "" if report["converged"] else ", not at rest"
        write.text(corner, f"{name}\n{size}, {report['shape']}{rest}", fill="black")
    sheet.save(path)
