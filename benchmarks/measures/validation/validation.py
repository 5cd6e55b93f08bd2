# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Comparison of swatches with published measurements: the tables and the pictures of docs/validation.md.

The script runs on one core of a CPU.
"""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path
from typing import Literal

from benchmarks.measures.validation import friction, knits, loads, plots, stretch, weaves
from benchmarks.table import Rows

Section = Literal["loops", "tiling", "knits", "stretch", "loads", "friction", "weave", "cells"]


def validation(
    sections: tuple[Section, ...] = (), /, *, pictures: Path | None = None, cells: Path | None = None
) -> Rows:
    """Yield the selected sections.

    Args:
        pictures: folder for the pictures
        cells: folder of stockinette.pyp and basket.pyp
    """
    tables = {
        "loops": _loops, "tiling": _tiling, "knits": _knits, "stretch": _stretch, "loads": _loads,
        "friction": _friction, "weave": _weave, "cells": _cells,
    }  # fmt: skip
    for section in sections or tables:
        yield from tables[section](cells if section == "cells" else pictures)


def _loops(pictures: Path | None) -> Rows:
    yield from _titled("Stockinette at loop length 16.67 d", knits.presets_table())
    found = knits.loops()
    yield from _titled("Stockinette by loop length", knits.loops_table(found))
    if pictures is not None:
        plots.draw_loops(found, pictures / "validation-loops.png")


def _tiling(_pictures: Path | None) -> Rows:
    yield from _titled("One stitch and its tilings", knits.tiling_table())


def _knits(_pictures: Path | None) -> Rows:
    yield from _titled("Knitted fabrics beside stockinette", knits.knits_table())
    yield from _titled("Shaken and relaxed again", knits.shaken_table())


def _stretch(pictures: Path | None) -> Rows:
    made = stretch.curves()
    yield from _titled("Tension at 20 % [dyn/cm]", stretch.stiffness_table(made))
    yield from _titled("Orders of stiffness", stretch.orders_table(made))
    yield ""
    for line in (*stretch.spacing_lines(made), *stretch.hylc_lines(made)):
        yield f"- {line}"
    yield from _titled("Stockinette by quality [dyn/cm]", stretch.accuracy_table())
    if pictures is not None:
        plots.draw_curves(made, pictures / "validation-stretch.png")


def _loads(_pictures: Path | None) -> Rows:
    yield from _titled("Modulus at rest by loop length", loads.modulus_table())
    made = loads.curves()
    yield from _titled("Extension under one load, in %", loads.loads_table(made))
    yield from _titled("Slope along the wales under one load", loads.slopes_table(made))


def _friction(_pictures: Path | None) -> Rows:
    yield from _titled("Stockinette off the needles", friction.munden_table())
    yield from _titled("Dry stockinette by friction", friction.coefficients_table())
    yield from _titled("Stockinette of 16.67 d from several sizes on the needles", friction.paths_table())
    yield from _titled("Ribs off the needles, of stockinette", friction.rib_table())
    yield from _titled("Rows of garter to the width of a stitch", friction.garter_table())
    yield from _titled("Work of dry stockinette", friction.work_table())
    for title, rows in friction.stiffness_tables():
        yield from _titled(title, rows)


def _weave(pictures: Path | None) -> Rows:
    yield from _titled("Plain weave of taut yarns", weaves.peirce_table())
    yield from _titled("Below jamming", weaves.jam_table())
    if pictures is not None:
        states = [weaves.taut_weave(spacing) for spacing in (1.75, *weaves.SPACINGS)]
        plots.draw_crimp(states, pictures / "validation-crimp.png")


def _cells(folder: Path | None) -> Rows:
    from benchmarks.measures.validation import cells

    if folder is None or not all((folder / f"{name}.pyp").is_file() for name in cells.CELLS):
        yield "(cells: left out, give --cells the folder of stockinette.pyp and basket.pyp)"
        return
    yield from _titled("Periods of the cells of Sperl et al. 2021", cells.periods_table(folder))
    yield from _titled("Their yarn, from the balance of its forces", cells.constants_table(folder))
    yield from _titled("Cells relaxed here", cells.cells_table(folder))
    yield from _titled("Stress in their periods", cells.stress_table(folder))


def _titled(title: str, rows: Iterable[list[object]]) -> Rows:
    """Yield a table below its title."""
    yield f"### {title}"
    yield from rows
