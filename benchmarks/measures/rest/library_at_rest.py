# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Whether the patterns of the library come to rest, and how far the sizes of two qualities lie apart.

Each pattern finds its size at each loop length and quality; knits come off the needles dry unless another state is
asked for. With ``--charts`` they are random charts (``random_charts.py``). ``--together`` is how many are made in one
call; a quality that is given twice is measured a second time, with compiled kernels. Writes rests.jsonl with a line for
each swatch, and a sheet of pictures for each quality, and prints a table: the sizes, whether they are at rest, and the
largest relative difference of width and height from the last quality. Where swatches are made one by one, sizes.png
shows their iterations and seconds against their control points; the first one loads the kernels and is left out.
"""

from __future__ import annotations

import logging
import time
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

import stitchmesh as sm
from benchmarks.json_lines import append
from benchmarks.measures.rest.true_rest import PROMISE
from benchmarks.measures.swatches.free_shapes import request_of, write_sheet
from benchmarks.measures.swatches.random_charts import random_chart
from benchmarks.table import Rows
from stitchmesh import __version__
from stitchmesh.periodic.swatch_options import COMPACT_LOOP, YARN_RADIUS, KnitState

CHARTS = dict[str, sm.Pattern]()
"""The random charts by their names."""


@dataclass(frozen=True)
class Options:
    """What is measured."""

    patterns: tuple[str, ...] = (*sm.pattern_names(), *sm.weave_names())
    charts: int | None = None
    """number of random charts in the place of patterns"""
    loops: tuple[float, ...] = (COMPACT_LOOP,)
    """loop lengths [yarn diameters]"""
    qualities: tuple[str, ...] = ("draft",)
    relaxation: KnitState | None = None
    """state of the knits"""
    device: str | None = None
    together: int = 1
    """swatches in one call"""
    out: Path = Path("out/library")
    no_pictures: bool = False


def library_at_rest(given: Options) -> Rows:
    """Relax, write, draw and print."""
    logging.getLogger("stitchmesh").setLevel(logging.ERROR)
    given.out.mkdir(parents=True, exist_ok=True)
    if given.charts is not None:
        CHARTS.update({chart.name: chart for chart in map(random_chart, range(given.charts))})
    patterns = CHARTS or given.patterns
    cases = [(pattern, loop) for pattern in patterns for loop in given.loops if is_made(pattern, loop)]
    rows: dict[tuple[str, float], list[dict[str, Any]]] = {case: [] for case in cases}
    for quality in given.qualities:
        began, made = time.perf_counter(), []
        for first in range(0, len(cases), given.together):
            some = cases[first : first + given.together]
            made += relaxed(some, quality, given)
            write(given.out / "rests.jsonl", some, made[first:], quality, rows)
        seconds = time.perf_counter() - began
        resting = sum(bool(rows[case][-1]["at_rest"]) for case in cases)
        yield f"{quality}: {resting} of {len(cases)} at rest, {seconds:.1f} s"
        if not given.no_pictures:
            drawn = [(f"{case[0]} {case[1]:g}", each) for case, each in zip(cases, made, strict=True)]
            write_sheet(given.out / f"{quality}.png", [pair for pair in drawn if isinstance(pair[1], sm.Swatch)])
    yield from shown(rows, given.qualities)
    if given.together == 1 and not given.no_pictures:
        plot_by_size(given.out / "sizes.png", rows, given.qualities)


def is_made(pattern: str, loop: float) -> bool:
    """Whether there is such a case: a weave has no loops, and is made once."""
    return pattern not in sm.weave_names() or loop == COMPACT_LOOP


def relaxed(
    cases: list[tuple[str, float]], quality: str, given: Options
) -> list[sm.Swatch | sm.StitchMeshError]:  # fmt: skip
    """The swatches of some cases."""
    requests = []
    for pattern, loop in cases:
        options = {} if pattern in sm.weave_names() else {"loop_length": 2.0 * loop * YARN_RADIUS}
        requests.append(request_of(CHARTS.get(pattern, pattern), quality, given.relaxation, **options))
    return sm.relax_swatches(requests, device=given.device, progress=False)


def write(
    path: Path, cases: list[tuple[str, float]], made: list[sm.Swatch | sm.StitchMeshError], quality: str,
    rows: dict[tuple[str, float], list[dict[str, Any]]],
) -> None:  # fmt: skip
    """Add a line of the file for each swatch, and its row."""
    for case, swatch in zip(cases, made, strict=True):
        row = {"pattern": case[0], "loop": case[1], "quality": quality, "version": __version__} | figures(swatch)
        rows[case].append(row)
        append(path, [row])


def figures(made: sm.Swatch | sm.StitchMeshError) -> dict[str, Any]:
    """The figures of a swatch."""
    if not isinstance(made, sm.Swatch):
        return {"at_rest": False, "error": str(made)}
    report = made.report
    names = ("width", "height", "iterations", "seconds", "residual", "shape", "relaxation", "control_points",
             "planes_pressure", "min_distance_over_radius")  # fmt: skip
    return {"at_rest": report["converged"], "remaining": report["remaining_change"]} | {
        name: report[name] for name in names
    }


def apart(row: dict[str, Any], last: dict[str, Any]) -> float:
    """Largest relative difference of width and height; not a number where one was not made."""
    if "error" in row or "error" in last:
        return float("nan")
    sizes = np.array([[each["width"], each["height"]] for each in (row, last)])
    return float(np.abs(np.log(sizes[0] / sizes[1])).max())


def shown(rows: dict[tuple[str, float], list[dict[str, Any]]], qualities: Sequence[str]) -> Rows:
    """Yield the sizes of all cases, and how many keep the promise of each quality."""
    yield f"Version {__version__}."
    yield "pattern", "loop / d", *(f"{name} [cm]" for name in qualities)
    for (pattern, loop), found in rows.items():
        cells = [cell_of(row, found[-1]) for row in found]
        yield pattern, f"{loop:g}", *cells
    for number, name in enumerate(qualities[:-1]):
        both = [apart(found[number], found[-1]) for found in rows.values()
                if found[number]["at_rest"] and found[-1]["at_rest"]]  # fmt: skip
        kept = sum(each <= PROMISE[name] for each in both)
        yield f"{name}: {kept} of {len(both)} that are at rest in both lie within {100 * PROMISE[name]:g} %"


def plot_by_size(path: Path, rows: dict[tuple[str, float], list[dict[str, Any]]], qualities: Sequence[str]) -> None:
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


def cell_of(row: dict[str, Any], last: dict[str, Any]) -> str:
    """A size in the table."""
    if "error" in row:
        return row["error"]
    rest = "" if row["at_rest"] else ", not at rest"
    difference = "" if row is last else f" ({100 * apart(row, last):.1f} %)"
    return f"{row['width']:.3f} x {row['height']:.3f}{difference}{rest}"
