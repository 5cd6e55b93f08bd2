# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Comparison of swatches with published measurements: the tables and the pictures of docs/validation.md.

The script runs on one core of a CPU.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Literal

from benchmarks.measures.validation import cells, friction, knits, loads, memory, plots, squeeze, stretch, weaves
from benchmarks.table import Rows

Section = Literal["loops", "tiling", "knits", "stretch", "loads", "friction", "memory", "squeeze", "weave", "cells"]
TABLES: dict[Section, dict[str, Callable[[], Iterable[str | list[object]]]]] = {
    "loops": {
        "Stockinette at loop length 16.67 d": knits.presets_table,
        "Stockinette by loop length": knits.loops_table,
    },
    "tiling": {"One stitch and its tilings": knits.tiling_table},
    "knits": {
        "Knitted fabrics beside stockinette": knits.knits_table,
        "Shaken and relaxed again": knits.shaken_table,
    },
    "stretch": {
        "Tension at 20 % [dyn/cm]": stretch.stiffness_table,
        "Orders of stiffness": stretch.orders_table,
        "Spacings, and another yarn": stretch.lines,
        "Stockinette by quality [dyn/cm]": stretch.accuracy_table,
        "Plain weave and stockinette by control points [dyn/cm]": stretch.sampling_table,
    },
    "loads": {
        "Modulus at rest by loop length": loads.modulus_table,
        "Extension under one load, in %": loads.loads_table,
        "Slope along the wales under one load": loads.slopes_table,
    },
    "friction": {
        "Stockinette off the needles": friction.munden_table,
        "Dry stockinette by friction": friction.coefficients_table,
        "Stockinette of 16.67 d from several sizes on the needles": friction.paths_table,
        "Ribs off the needles, of stockinette": friction.rib_table,
        "Rows of garter to the width of a stitch": friction.garter_table,
        "Work of dry stockinette": friction.work_table,
        "Extension of dry fabrics": friction.stiffness_tables,
    },
    "memory": {
        "Loops of a stretch test that turns": memory.memory_table,
        "1x1 rib along its courses in fewer and more steps": memory.rates_table,
    },
    "squeeze": {
        "Thickness against pressure": squeeze.squeeze_table,
        "Stockinette of soft yarn by quality": squeeze.sampling_table,
    },
    "weave": {"Plain weave of taut yarns": weaves.peirce_table, "Below jamming": weaves.jam_table},
}
"""The tables of each section, by their titles."""
CELL_TABLES: dict[str, Callable[[Path], Iterable[list[object]]]] = {
    "Periods of the cells of Sperl et al. 2021": cells.periods_table,
    "Their yarn, from the balance of its forces": cells.constants_table,
    "Cells relaxed here": cells.cells_table,
    "Stress in their periods": cells.stress_table,
}
"""Tables of cells in a folder."""
PICTURES: dict[Section, tuple[str, Callable[[Path], None]]] = {
    "loops": ("validation-loops.png", plots.draw_loops),
    "stretch": ("validation-stretch.png", plots.draw_curves),
    "memory": ("contact-memory.png", memory.draw_memory),
    "squeeze": ("contact-squeeze.png", squeeze.draw_squeeze),
    "weave": ("validation-crimp.png", plots.draw_crimp),
}
"""The picture of a section."""


def validation(
    sections: tuple[Section, ...] = (*TABLES, "cells"),
    /,
    *,
    pictures: Path | None = None,
    cells: Path | None = None,
) -> Rows:
    """Yield the selected sections.

    Args:
        pictures: folder for the pictures
        cells: folder of stockinette.pyp and basket.pyp
    """
    for section in sections:
        for title, table in TABLES.get(section, {}).items():
            yield f"### {title}"
            yield from table()
        if section == "cells":
            yield from _tables_of_cells(cells)
        if pictures is not None and section in PICTURES:
            name, draw = PICTURES[section]
            draw(pictures / name)


def _tables_of_cells(folder: Path | None) -> Rows:
    if folder is None:
        yield "(cells: left out, give --cells the folder of stockinette.pyp and basket.pyp)"
        return
    for title, table in CELL_TABLES.items():
        yield f"### {title}"
        yield from table(folder)
