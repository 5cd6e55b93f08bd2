# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Random stranded charts of two and three colours, up to 12 by 12 stitches, each relaxed as a swatch.

    python -m tests.periodic.charts.stranded_charts --count 1000 --device cpu

Each chart is relaxed in a cell of constant size and in a free cell. The outcome of a chart is "at rest", "refused" with
the message, or "not at rest". A refusal is allowed only if a float is too long; the exit status is 1 if there is any
other refusal, or a chart that is not at rest. The yarns of many charts are relaxed together.
"""

from __future__ import annotations

import logging
import sys
import time
from collections import Counter
from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from benchmarks.options import begun
from benchmarks.table import Rows, note, show
from stitchmesh.errors import SolverError, StitchMeshError
from stitchmesh.linking.certificate import refuse_pull_through
from stitchmesh.mesh.stitch import Stitch
from stitchmesh.patterns.pattern import Cell, Pattern, Row
from stitchmesh.periodic.repeat.drawn_swatch import draw_swatch
from stitchmesh.periodic.sampling.sampling import close_contacts
from stitchmesh.periodic.swatch_options import SwatchOptions
from stitchmesh.quality import Quality, quality_named
from stitchmesh.yarn import YarnSet
from stitchmesh.yarnrelax import RelaxCell, YarnMaterial
from stitchmesh.yarnrelax.together.relax_cells import relax_cells

LARGEST = 12
"""Largest number of stitches and of rows of a chart."""
FLOAT_TOO_LONG = "floats behind"
"""Words of the message that refuses a chart because a float is too long."""
Random = np.random.Generator
Chart = NDArray[np.int64]


def lone_pixels(random: Random, height: int, width: int, colours: int) -> Chart:
    """Return a chart of one colour with a single stitch of each other colour."""
    chart = np.zeros((height, width), dtype=np.int64)
    places = random.choice(chart.size, size=colours - 1, replace=False)
    chart.flat[places] = np.arange(1, colours)
    return chart


def sparse(random: Random, height: int, width: int, colours: int) -> Chart:
    """Return a chart of one colour in which one stitch of six has another colour."""
    chart = random.integers(1, colours, size=(height, width))
    return np.where(random.random((height, width)) < 1 / 6, chart, 0)


def even(random: Random, height: int, width: int, colours: int) -> Chart:
    """Return a chart in which each stitch has any colour."""
    return random.integers(0, colours, size=(height, width))


def checks(random: Random, height: int, width: int, colours: int) -> Chart:
    """Return a chart of rectangles of one size."""
    high, wide = random.integers(1, height + 1), random.integers(1, width + 1)
    row, column = np.indices((height, width))
    return (row // high + column // wide) % colours


def standing_columns(random: Random, height: int, width: int, colours: int) -> Chart:
    """Return a chart whose rows are equal."""
    return np.tile(random.integers(0, colours, size=width), (height, 1))


def diagonals(random: Random, height: int, width: int, colours: int) -> Chart:
    """Return a chart of diagonal stripes."""
    row, column = np.indices((height, width))
    return (row + column) // random.integers(1, 4) % colours


KINDS: dict[str, Callable[[Random, int, int, int], Chart]] = {
    "lone pixels": lone_pixels, "sparse": sparse, "even": even, "checks": checks, "columns": standing_columns,
    "diagonals": diagonals,
}  # fmt: skip
CELLS: dict[str, RelaxCell | None] = {"held": None, "free": RelaxCell(shear=False)}


def random_chart(seed: int, number: int) -> tuple[str, Chart]:
    """Return the kind and the yarns of a chart, the lower row first; it depends on ``seed`` and ``number`` alone."""
    random = np.random.default_rng([seed, number])
    kind = list(KINDS)[number % len(KINDS)]
    while True:
        height, width = random.integers(1, LARGEST + 1, size=2)
        colours = int(random.integers(2, 4))
        if height * width >= colours:
            chart = KINDS[kind](random, height, width, colours)
            if len(np.unique(chart)) > 1:
                return kind, chart


def pattern_of(chart: Chart) -> Pattern:
    """Return a chart as a pattern of knit stitches."""
    rows = tuple(Row(tuple(Cell(Stitch.KNIT, yarn=yarn) for yarn in row)) for row in chart.tolist())
    return Pattern("random chart", "", rows)


def written(chart: Chart) -> str:
    """Return a chart as it is written: the upper row first."""
    return "/".join("".join(map(str, row)) for row in chart[::-1].tolist())


def relaxed_batch(drawn: dict[int, YarnSet], cell: str, quality: Quality, device: str | None) -> dict[int, Any]:
    """Relax the drawn charts in one kind of cell, and return the outcome of each by its number."""
    free = CELLS[cell]
    material = YarnMaterial.named().of_radius(SwatchOptions.yarn_radius)
    cells = relax_cells(
        list(drawn.values()), materials=[material] * len(drawn), free=None if free is None else [free] * len(drawn),
        quality=quality, device=device, progress=False,
    ).cells  # fmt: skip
    outcomes = {}
    for (number, yarns), relaxed in zip(drawn.items(), cells, strict=True):
        report, message = relaxed.report, relaxed.report["error"]
        if message is None:
            try:
                refuse_pull_through(yarns, relaxed.yarns, device)
            except SolverError as error:
                message = str(error)
        names = ("iterations", "residual", "max_strain", "min_distance_over_radius")
        state = "refused" if message else "at rest" if report["converged"] else "not at rest"
        outcomes[number] = {"outcome": state, "message": message} | {name: report[name] for name in names}
    return outcomes


def batch(seed: int, numbers: list[int], quality: Quality, device: str | None) -> dict[int, Any]:
    """Draw and relax charts, and return the results by the number of the chart."""
    options = SwatchOptions()
    results: dict[int, Any] = {}
    drawn: dict[int, YarnSet] = {}
    for number in numbers:
        kind, chart = random_chart(seed, number)
        results[number] = {"kind": kind, "colours": len(np.unique(chart)), "chart": written(chart)}
        try:
            _fabric, drawn[number] = draw_swatch(pattern_of(chart), options, quality)
        except StitchMeshError as error:
            refused = {"outcome": "refused", "message": str(error)}
            results[number] |= dict.fromkeys(CELLS, refused)
    for cell in CELLS if drawn else ():
        for number, outcome in relaxed_batch(drawn, cell, close_contacts(quality, options), device).items():
            results[number][cell] = outcome
    return results


def is_allowed(outcome: dict[str, Any]) -> bool:
    """Whether the swatch is at rest, or was refused for a float that is too long."""
    return outcome["outcome"] == "at rest" or FLOAT_TOO_LONG in (outcome["message"] or "")


def table(results: dict[int, Any]) -> Rows:
    """Yield the numbers of outcomes for each kind of chart."""
    columns = ["at rest", "float too long", "not at rest", "other refusal"]
    yield "charts", "cell", "number", *columns
    for kind in [*KINDS, "all"]:
        for cell in CELLS:
            own = [each[cell] for each in results.values() if kind in (each["kind"], "all")]
            found = Counter(
                "float too long" if is_allowed(each) and each["outcome"] == "refused"
                else "other refusal" if each["outcome"] == "refused" else each["outcome"] for each in own
            )  # fmt: skip
            yield kind, cell, len(own), *(found[name] for name in columns)


def stranded_charts(
    *, count: int = 60, seed: int = 1, quality: str = "draft", device: str | None = None, together: int = 100
) -> Rows:
    """Relax the charts, print the table, and return 1 if an outcome is not allowed.

    Args:
        device: cpu, cuda:0 ...; the first GPU, else the CPU
        together: charts that are relaxed together
    """
    logging.getLogger("stitchmesh").setLevel(logging.ERROR)
    results: dict[int, Any] = {}
    began = time.perf_counter()
    for first in range(0, count, together):
        numbers = list(range(first, min(first + together, count)))
        results |= batch(seed, numbers, quality_named(quality), device)
        note(f"{len(results)} of {count} charts, {time.perf_counter() - began:.0f} s")
    yield from table(results)
    faults = 0
    for number, each in results.items():
        for cell in CELLS:
            if not is_allowed(each[cell]):
                faults += 1
                why = each[cell]["message"] or f"residual {each[cell]['residual']:.2g}"
                yield f"chart {number} ({each['kind']}, {cell}): {each[cell]['outcome']}: {each['chart']}: {why}"
    return int(faults > 0)


if __name__ == "__main__":
    program = "python -m tests.periodic.charts.stranded_charts"
    sys.exit(show(begun((stranded_charts,), program, sys.argv[1:], __doc__ or "")))
