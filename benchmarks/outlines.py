# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Natural outlines of patterns: a sheet of pictures, and the time for large fabrics.

    python benchmarks/outlines.py
    python benchmarks/outlines.py --faces 5000 20000 --repeats 3

Draws the patterns of ``docs/outlines.md`` and prints their sizes. With --faces, prints the seconds of the mesh
relaxation of some patterns at these numbers of stitches; the targets are 10 s for 5,000 and 20 s for 20,000 on a CPU.
"""

from __future__ import annotations

import argparse
import time
from pathlib import Path

import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

import stitchmesh as sm
from stitchmesh.patterns import Pattern
from stitchmesh.render.plots.outline_picture import draw_outline

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


def main() -> None:
    """Draw the sheet, or measure times."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--faces", type=int, nargs="*", help="numbers of stitches of the fabrics that are timed")
    parser.add_argument("--repeats", type=int, default=1, help="runs of each fabric; the fastest counts")
    parser.add_argument("--out", type=Path, default=Path("out/outlines.png"))
    arguments = parser.parse_args()
    if arguments.faces is None:
        draw_sheet(arguments.out)
        return
    print("| pattern | form | stitches | seconds | of one processor | iterations | residual |")
    print("|---|---|---:|---:|---:|---:|---:|")
    for faces in arguments.faces:
        for name in LARGE:
            for form in ("flat", "tube"):
                print_time(name, form, faces, arguments.repeats)


def draw_sheet(path: Path) -> None:
    """Draw all patterns side by side, and print their sizes."""
    patterns = [sm.read_pattern(name) for name in LIBRARY] + [sm.parse_pattern(text) for text in OWN.values()]
    names = [*LIBRARY, *OWN]
    figure = Figure(figsize=(COLUMNS * WIDTH, -(-len(names) // COLUMNS) * HEIGHT), dpi=90, layout="constrained")
    panels = figure.subplots(-(-len(names) // COLUMNS), COLUMNS).ravel()
    print("| pattern | size [cm] | of plain knit | lean | waves below, side [cm] | seconds |")
    print("|---|---|---|---:|---|---:|")
    for axes, name, pattern in zip(panels, names, patterns, strict=True):
        shape = sm.natural_outline(pattern, **repeats(pattern, STITCHES, ROWS), progress=False)
        draw_outline(axes, shape, name)
        figures = shape.measures()
        plain = f"{figures['width_over_plain']:.2f} x {figures['height_over_plain']:.2f}"
        waves = f"{figures['wave_below']:.1f}, {figures['wave_left']:.1f}"
        size = f"{shape.width:.1f} x {shape.height:.1f}"
        print(f"| {name} | {size} | {plain} | {shape.slant:.0f}° | {waves} | {shape.report.seconds:.1f} |")
    path.parent.mkdir(parents=True, exist_ok=True)
    FigureCanvasAgg(figure).print_png(str(path))


def print_time(name: str, form: str, faces: int, runs: int) -> None:
    """Print the fastest time of some runs, with the making of the stitch mesh."""
    pattern = sm.read_pattern(name)
    side = int(np.ceil(np.sqrt(faces * (1.3 if form == "flat" else 1.0))))
    size = repeats(pattern, faces // side, side)
    best, spent, shape = np.inf, np.inf, None
    for _ in range(runs):
        start, begun = time.perf_counter(), time.process_time()
        shape = sm.natural_outline(pattern, "tube" if form == "tube" else "flat", **size, progress=False)
        best, spent = min(best, time.perf_counter() - start), min(spent, time.process_time() - begun)
    assert shape is not None
    report = shape.report
    figures = f"{best:.1f} | {spent:.1f} | {report.iterations} | {report.residual:.0e}"
    print(f"| {name} | {form} | {shape.fabric.face_count:,} | {figures} |", flush=True)


def repeats(pattern: Pattern, stitches: int, rows: int) -> dict[str, int]:
    """Return the numbers of repeats of a piece with at least so many stitches and rows."""
    return {"columns": -(-stitches // pattern.width), "rows": -(-rows // pattern.height)}


if __name__ == "__main__":
    main()
