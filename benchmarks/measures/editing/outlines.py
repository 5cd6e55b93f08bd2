# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Natural outlines of patterns: a sheet of pictures, and the time for large fabrics.

Draws the patterns of ``docs/outlines.md`` and prints their sizes. With --faces, prints the seconds of the mesh
relaxation of some patterns at these numbers of stitches; the targets are 10 s for 5,000 and 20 s for 20,000 on a CPU.
"""

from __future__ import annotations

import time
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

import stitchmesh as sm
from benchmarks.table import Rows
from stitchmesh.patterns import Pattern
from stitchmesh.render.plots.outline_picture import draw_outline
from stitchmesh.run import QUIET

LIBRARY = (
    "stockinette", "rib2x2", "garter", "seed", "feather-and-fan", "flame-ribbing", "openwork-trellis", "left-diagonal",
)  # fmt: skip
"""Patterns of the library that the sheet shows."""
OWN = {
    "lace that leans right": 'pattern "a"\nsource "own"\nrow 1 RS: yo k6 ssk\nrow 2 WS: p8',
    "chevron": 'pattern "a"\nsource "own"\nrow 1 RS: k yo k5 s2kp k5 yo\nrow 2 WS: p14',
}
"""Patterns of the sheet that the library does not hold."""
STITCHES, ROWS = 32, 32
"""Size of the pieces of the sheet, at least."""
COLUMNS, WIDTH, HEIGHT = 5, 3.8, 4.2
"""Pictures in a row, and size of a picture [inch]."""
LARGE = ("rib2x2", "eyelet-lace", "flame-ribbing", "feather-and-fan", "ridged-feather")
"""Patterns whose relaxation is timed."""


@dataclass(frozen=True)
class Options:
    """What is measured."""

    faces: tuple[int, ...] = ()
    """numbers of stitches of the fabrics that are timed"""
    out: Path = Path("out/outlines.png")


def outlines(arguments: Options) -> Rows:
    """Draw the sheet, or measure times."""
    if not arguments.faces:
        yield from draw_sheet(arguments.out)
        return
    yield "pattern", "form", "stitches", "seconds", "of one processor", "iterations", "residual"
    for faces in arguments.faces:
        for name in LARGE:
            for form in ("flat", "tube"):
                yield from times_of(name, form, faces)


def draw_sheet(path: Path) -> Rows:
    """Draw all patterns side by side, and print their sizes."""
    patterns = [sm.read_pattern(name) for name in LIBRARY] + [sm.parse_pattern(text) for text in OWN.values()]
    names = [*LIBRARY, *OWN]
    figure = Figure(figsize=(COLUMNS * WIDTH, -(-len(names) // COLUMNS) * HEIGHT), dpi=90, layout="constrained")
    panels = figure.subplots(-(-len(names) // COLUMNS), COLUMNS).ravel()
    yield "pattern", "size [cm]", "of plain knit", "lean", "waves below, side [cm]", "seconds"
    for axes, name, pattern in zip(panels, names, patterns, strict=True):
        shape = sm.natural_outline(pattern, **repeats(pattern, STITCHES, ROWS), run=QUIET)
        draw_outline(axes, shape, name)
        figures = shape.measures()
        plain = f"{figures['width_over_plain']:.2f} x {figures['height_over_plain']:.2f}"
        waves = f"{figures['wave_below']:.1f}, {figures['wave_left']:.1f}"
        size = f"{shape.width:.1f} x {shape.height:.1f}"
        yield name, size, plain, f"{shape.slant:.0f}°", waves, f"{shape.report.seconds:.1f}"
    path.parent.mkdir(parents=True, exist_ok=True)
    FigureCanvasAgg(figure).print_png(str(path))


def times_of(name: str, form: str, faces: int) -> Rows:
    """Yield the time of a run, with the making of the stitch mesh."""
    pattern = sm.read_pattern(name)
    side = int(np.ceil(np.sqrt(faces * (1.3 if form == "flat" else 1.0))))
    size = repeats(pattern, faces // side, side)
    began, processor = time.perf_counter(), time.process_time()
    shape = sm.natural_outline(pattern, "tube" if form == "tube" else "flat", **size, run=QUIET)
    times = f"{time.perf_counter() - began:.1f}", f"{time.process_time() - processor:.1f}"
    report = shape.report
    yield name, form, f"{shape.fabric.face_count:,}", *times, report.iterations, f"{report.residual:.0e}"


def repeats(pattern: Pattern, stitches: int, rows: int) -> dict[str, int]:
    """Return the numbers of repeats of a piece with at least so many stitches and rows."""
    return {"columns": -(-stitches // pattern.width), "rows": -(-rows // pattern.height)}
