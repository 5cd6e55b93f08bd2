# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Free swatches of the library: their sizes and shapes, whether they come to rest, and what their resolution changes.

Knits are let go off the needles dry, unless another state is asked for.

- ``shapes``: lying on nothing and between planes: size, thickness and shape. The pressure is the force on one plane
  over the area of the repeat; the weight is that of the fabric over the same area. Draws a sheet of pictures of each.
- ``library``: each pattern at each loop length and quality, or random charts. ``--together`` is how many are made in
  one call; a quality that is given twice is measured a second time, with compiled kernels. Writes rests.jsonl with a
  line for each swatch, and prints the sizes, whether they are at rest, and the largest relative difference of width and
  height from the last quality. Where swatches are made one by one, sizes.png shows their iterations and seconds against
  their control points; the first one loads the kernels and is left out.
- ``resolution``: each pattern as it is, with twice as many contact samples a segment, and with twice and with half as
  many steps in which the forces on its borders fall. A column has the size, its largest relative difference from the
  first one, and the time of the swatch.
"""

from __future__ import annotations

import logging
import time
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from PIL import Image, ImageDraw
from tyro.conf import Positional

import stitchmesh as sm
from benchmarks.json_lines import append
from benchmarks.measures.rest.true_rest import PROMISE
from benchmarks.scenes.random_charts import random_chart
from benchmarks.sheet import drawn
from benchmarks.table import Rows
from stitchmesh import __version__
from stitchmesh.periodic.relaxation import off_needles
from stitchmesh.periodic.sampling.sampling import CONTACTS_RELEASED
from stitchmesh.periodic.swatch_options import COMPACT_LOOP, YARN_RADIUS, KnitState
from stitchmesh.quality import PRESETS, Quality, quality_named
from stitchmesh.render import render_swatch

SIDE, COLUMNS, SHOWN = 220, 8, 11.0
"""Pixels of a picture, pictures in a row of a sheet, and width of the fabric in a picture [cm]."""
FALL = 981.0
"""Acceleration on Earth [cm / s^2]."""
LOOPS = (14.0, 16.67, 20.0, 24.0, 30.0, 40.0)
"""Loop lengths of stockinette [yarn diameters]."""
MOST_ITERATIONS = 40_000
"""Iterations with a given tolerance."""


@dataclass(frozen=True)
class Options:
    """What is made."""

    patterns: Positional[tuple[str, ...]] = ()
    """all of the library if none"""
    device: str | None = None
    relaxation: KnitState | None = None
    """state of the knits"""
    out: Path = Path("out/free-swatches")
    no_pictures: bool = False

    @property
    def names(self) -> tuple[str, ...]:
        """The patterns."""
        return self.patterns or (*sm.pattern_names(), *sm.weave_names())

    def requested(self, pattern: str | sm.Pattern, quality: str | Quality, **options: Any) -> sm.SwatchRequest:
        """A free swatch of a pattern, of a knit in the state that is asked for."""
        state = None if pattern in sm.weave_names() else self.relaxation
        return sm.SwatchRequest(
            pattern, relax_cell=True, quality=quality, options={"relaxation": state, **options}
        )


@dataclass(frozen=True)
class ShapeOptions(Options):
    """What is made, and how far it is relaxed."""

    quality: str = "standard"
    tolerance: float | None = None
    """relax to this residual in double precision"""

    def made(self, asked: Sequence[tuple[str, dict[str, Any]]]) -> list[sm.Swatch]:
        """Free swatches of patterns with further options, relaxed together."""
        quality = quality_named(self.quality)
        if self.tolerance is not None:
            quality = replace(quality, precision="float64", tolerance=self.tolerance, max_iterations=MOST_ITERATIONS)
        requests = [self.requested(name, quality, **options) for name, options in asked]
        swatches = []
        for found in sm.relax_swatches(requests, device=self.device, progress=False):
            if not isinstance(found, sm.Swatch):
                raise found
            swatches.append(found)
        return swatches


def shapes(chosen: ShapeOptions) -> Rows:
    """Relax on nothing and between planes."""
    logging.getLogger("stitchmesh").setLevel(logging.ERROR)
    made: list[tuple[str, list[sm.Swatch]]] = []
    yield f"Version {__version__}, quality {chosen.quality}."
    yield (
        "pattern", "lying on nothing [cm]", "thickness", "shape", "between planes [cm]", "thickness", "shape",
        "energies [erg]", "pressure, weight [dyn/cm²]",
    )  # fmt: skip
    for name in chosen.names:
        pair = chosen.made([(name, {"unsupported": True}), (name, {})])
        made.append((name, pair))
        yield name, *_shape_cells(*pair)
    asked = [("stockinette", {"unsupported": True, "loop_length": 0.25 * loop}) for loop in LOOPS]
    for loop, swatch in zip(LOOPS, chosen.made(asked), strict=True):
        report = swatch.report
        more = report["thickness"] * (1.0 - 1.0 / report["thickness_ratio"]) / 0.25
        thicker = f"{more:.2f} diameters thicker than generated, {more / loop:.4f} of the loop"
        yield f"Stockinette, loops of {loop:g} diameters: {thicker}."
    for place, kind in enumerate(() if chosen.no_pictures else ("nothing", "planes")):
        write_sheet(chosen.out / f"{kind}.png", [(name, pair[place]) for name, pair in made])


def _shape_cells(alone: sm.Swatch, lying: sm.Swatch) -> Iterator[str]:
    for made in (alone, lying):
        report = made.report
        mark = "" if report["converged"] else " (not at rest)"
        yield f"{report['wale_spacing']:.3f} x {report['course_spacing']:.3f}{mark}"
        yield f"{report['thickness_ratio']:.2f}"
        yield report["shape"]
    energies = []
    for made in (alone, lying):
        of_yarns = (value for name, value in made.report["energies"].items() if name != "confinement")
        energies.append(f"{sum(of_yarns) / made.report['stitches']:.1f}")
    yield ", ".join(energies)
    yield f"{lying.report['planes_pressure']:.1f}, {lying.report['areal_density'] * FALL:.0f}"


def write_sheet(path: Path, made: Sequence[tuple[str, sm.Swatch]]) -> None:
    """Draw swatches side by side, each with its name, spacings and shape."""
    path.parent.mkdir(parents=True, exist_ok=True)
    sheet = Image.new("RGB", (COLUMNS * (SIDE + 6), -(-len(made) // COLUMNS) * (SIDE + 32)), "white")
    write = ImageDraw.Draw(sheet)
    for number, (name, swatch) in enumerate(made):
        report = swatch.report
        tiles = max(1, round(SHOWN / report["width"])), max(1, round(SHOWN / report["height"]))
        corner = number % COLUMNS * (SIDE + 6), number // COLUMNS * (SIDE + 32)
        small = drawn(lambda file, swatch=swatch, tiles=tiles: render_swatch(swatch.yarns, file, tiles))  # type: ignore[misc]
        small.thumbnail((SIDE, SIDE))
        sheet.paste(small, (corner[0], corner[1] + 28))
        size = f"{report['wale_spacing']:.2f} x {report['course_spacing']:.2f} cm"
        rest = "" if report["converged"] else ", not at rest"
        write.text(corner, f"{name}\n{size}, {report['shape']}{rest}", fill="black")
    sheet.save(path)


@dataclass(frozen=True)
class LibraryOptions(Options):
    """What is made, at which loop lengths and qualities."""

    charts: int | None = None
    """number of random charts in the place of patterns"""
    loops: tuple[float, ...] = (COMPACT_LOOP,)
    """loop lengths [yarn diameters]"""
    qualities: tuple[str, ...] = ("draft",)
    together: int = 1
    """swatches in one call"""


Found = dict[str, Any]
"""The figures of a swatch, or its error."""


def library(given: LibraryOptions) -> Rows:
    """Relax at several qualities."""
    logging.getLogger("stitchmesh").setLevel(logging.ERROR)
    charts = {chart.name: chart for chart in map(random_chart, range(given.charts or 0))}
    # A weave has no loops, and is made once.
    cases = [(name, loop) for name in charts or given.names for loop in given.loops
             if name not in sm.weave_names() or loop == COMPACT_LOOP]  # fmt: skip
    rows: dict[tuple[str, float], list[Found]] = {case: [] for case in cases}
    for quality in given.qualities:
        shown: list[tuple[str, sm.Swatch]] = []
        began = time.perf_counter()
        for first in range(0, len(cases), given.together):
            some = cases[first : first + given.together]
            requests = [
                given.requested(charts.get(name, name), quality, **({} if name in sm.weave_names() else {
                    "loop_length": 2.0 * loop * YARN_RADIUS})) for name, loop in some
            ]  # fmt: skip
            made = sm.relax_swatches(requests, device=given.device, progress=False)
            for case, swatch in zip(some, made, strict=True):
                own = {"pattern": case[0], "loop": case[1], "quality": quality, "version": __version__}
                rows[case].append(own | figures(swatch))
                append(given.out / "rests.jsonl", rows[case][-1:])
                if isinstance(swatch, sm.Swatch):
                    shown.append((f"{case[0]} {case[1]:g}", swatch))
        resting = sum(bool(rows[case][-1]["at_rest"]) for case in cases)
        yield f"{quality}: {resting} of {len(cases)} at rest, {time.perf_counter() - began:.1f} s"
        if not given.no_pictures:
            write_sheet(given.out / f"{quality}.png", shown)
    yield from sizes(rows, given.qualities)
    if given.together == 1 and not given.no_pictures:
        plot_by_size(given.out / "sizes.png", rows, given.qualities)


def figures(made: sm.Swatch | sm.StitchMeshError) -> Found:
    """The figures of a swatch."""
    if not isinstance(made, sm.Swatch):
        return {"at_rest": False, "error": str(made)}
    report = made.report
    names = ("width", "height", "iterations", "seconds", "residual", "shape", "relaxation", "control_points",
             "planes_pressure", "min_distance_over_radius")  # fmt: skip
    of_rest = {"at_rest": report["converged"], "remaining": report["remaining_change"]}
    return of_rest | {name: report[name] for name in names}


def sizes(rows: dict[tuple[str, float], list[Found]], qualities: Sequence[str]) -> Rows:
    """Yield the sizes of all cases, and how many keep the promise of each quality."""
    yield f"Version {__version__}."
    yield "pattern", "loop / d", *(f"{name} [cm]" for name in qualities)
    for (pattern, loop), found in rows.items():
        yield pattern, f"{loop:g}", *(_size_cell(row, found[-1]) for row in found)
    for number, name in enumerate(qualities[:-1]):
        both = [apart(found[number], found[-1]) for found in rows.values()
                if found[number]["at_rest"] and found[-1]["at_rest"]]  # fmt: skip
        kept = sum(each <= PROMISE[name] for each in both)
        yield f"{name}: {kept} of {len(both)} that are at rest in both lie within {100 * PROMISE[name]:g} %"


def _size_cell(row: Found, last: Found) -> str:
    if "error" in row:
        return str(row["error"])
    rest = "" if row["at_rest"] else ", not at rest"
    difference = "" if row is last else f" ({100 * apart(row, last):.1f} %)"
    return f"{row['width']:.3f} x {row['height']:.3f}{difference}{rest}"


def apart(row: Found, last: Found) -> float:
    """Largest relative difference of width and height; not a number where one was not made."""
    if "error" in row or "error" in last:
        return float("nan")
    both = np.array([[each["width"], each["height"]] for each in (row, last)])
    return float(np.abs(np.log(both[0] / both[1])).max())


def plot_by_size(path: Path, rows: dict[tuple[str, float], list[Found]], qualities: Sequence[str]) -> None:
    """Plot iterations and seconds of all swatches against their control points."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(9.0, 3.6), layout="constrained")
    for axes, name in zip(figure.subplots(1, 2), ("iterations", "seconds"), strict=True):
        for number, quality in enumerate(qualities):
            found = [own[number] for own in list(rows.values())[1:] if "error" not in own[number]]
            points, values = [row["control_points"] for row in found], [row[name] for row in found]
            axes.loglog(points, values, "o", ms=3, label=quality)
        axes.set_xlabel("control points")
        axes.set_ylabel(name)
        axes.grid(alpha=0.3)
    figure.axes[0].legend()
    figure.savefig(path, dpi=150)


STEPS = off_needles.RELEASE_STEPS
"""Steps in which the forces on the borders of a knit fall."""
RESOLUTIONS = (
    (CONTACTS_RELEASED, STEPS), (2 * CONTACTS_RELEASED, STEPS), (CONTACTS_RELEASED, 2 * STEPS),
    (CONTACTS_RELEASED, STEPS // 2),
)  # fmt: skip
"""Contact samples of a segment, and steps."""


def resolution(patterns: tuple[str, ...], /, *, quality: str = "draft", device: str = "cpu") -> Rows:
    """Let knits go with other numbers of samples and steps."""
    yield "pattern", *(f"{samples} samples, {steps} steps [cm], s" for samples, steps in RESOLUTIONS)
    for pattern in patterns:
        found = []
        for samples, steps in RESOLUTIONS:
            off_needles.RELEASE_STEPS = steps
            sampled = replace(PRESETS[quality], contact_samples=samples)
            made = sm.swatch(pattern, quality=sampled, relaxation="dry", device=device, progress=False)
            found.append(figures(made))
        yield pattern, *(f"{_size_cell(row, found[0])}, {row['seconds']:.1f}" for row in found)


ACTIONS = (shapes, library, resolution)
