# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Published measurements of yarns and fabrics beside ours, and checks of the model: the tables of docs/validation.md.

    python benchmarks/run.py published                  # all sections: about half an hour
    python benchmarks/run.py published V2 V6            # two tables
    python benchmarks/run.py published page             # the page again from what is kept

What a section finds is kept as JSON lines in ``benchmarks/published/results``, and the page and its pictures are made
from all files that are kept. A section runs on the CPU.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from functools import partial
from pathlib import Path

from benchmarks.published import (
    acrylic_patterns,
    cells,
    curl,
    cycles,
    drape_meter,
    friction,
    industrial_patterns,
    knits,
    laboratory_patterns,
    loads,
    loose_monofilament,
    measured_knits,
    munden,
    plots,
    ribs,
    stretch,
    validation_page,
    weaves,
    yarn_figures,
)
from benchmarks.published.comparison import Item, Items, Section, Title, cells_of
from benchmarks.table import Rows, note

Tables = dict[str, Callable[[], Iterable[str | list[object]]]]
"""Functions of tables by their titles."""


def titled(tables: Tables) -> Items:
    """Yield the tables of a section with their titles."""
    for title, table in tables.items():
        yield Title(title)
        yield from table()


def check_of(
    name: str, title: str, tables: Tables, picture: str = "", draw: Callable[[Path], None] | None = None
) -> Section:  # fmt: skip
    """Return a section of plain tables, which check the model."""
    return Section(name=name, title=title, run=partial(titled, tables), picture=picture, draw=draw)


TABLES = (
    munden.TABLE, loose_monofilament.TABLE, laboratory_patterns.TABLE, acrylic_patterns.TABLE,
    industrial_patterns.TABLE, measured_knits.TABLE, drape_meter.TABLE, yarn_figures.TABLE, cycles.TABLE, ribs.TABLE,
    curl.TABLE,
)  # fmt: skip
"""Published tables."""
CHECKS = (
    check_of("loops", "Stockinette by loop length", {
        "Stockinette at loop length 16.67 d": knits.presets_table,
        "Stockinette by loop length": knits.loops_table,
    }, "validation-loops.png", plots.draw_loops),
    check_of("tiling", "One stitch and its tilings", {"One stitch and its tilings": knits.tiling_table}),
    check_of("knits", "Widths and curl", {
        "Knitted fabrics beside stockinette": knits.knits_table,
        "Shaken and relaxed again": knits.shaken_table,
    }),
    check_of("stretch", "Stiffness", {
        "Tension at 20 %": stretch.stiffness_table,
        "Orders of stiffness": stretch.orders_table,
        "Spacings, and another yarn": stretch.ratios_table,
        "Stockinette by quality": stretch.accuracy_table,
        "Plain weave and stockinette by control points": stretch.sampling_table,
    }, "validation-stretch.png", plots.draw_curves),
    check_of("loads", "Stiffness by loop length", {
        "Modulus at rest by loop length": loads.modulus_table,
        "Extension under one load": loads.loads_table,
        "Slope along the wales under one load": loads.slopes_table,
    }),
    check_of("friction", "Friction", {
        "Stockinette off the needles": friction.munden_table,
        "Dry stockinette by friction": friction.coefficients_table,
        "Stockinette of 16.67 d from several sizes on the needles": friction.paths_table,
        "Ribs off the needles, of stockinette": friction.rib_table,
        "Rows of garter to the width of a stitch": friction.garter_table,
        "Work of dry stockinette": friction.work_table,
        "Extension of dry fabrics": friction.stiffness_table,
    }),
    check_of("weave", "Plain weave", {
        "Plain weave of taut yarns": weaves.peirce_table,
        "Below jamming": weaves.jam_table,
    }, "validation-crimp.png", plots.draw_crimp),
)  # fmt: skip
"""Checks of the model against theory and against itself."""
SECTIONS = {section.name: section for section in TABLES + CHECKS}
"""All sections by name."""
CELL_TABLES: dict[str, Callable[[Path], Iterable[list[object]]]] = {
    "Periods of the cells of Sperl et al. 2021": cells.periods_table,
    "Their yarn, from the balance of its forces": cells.constants_table,
    "Cells relaxed here": cells.cells_table,
    "Stress in their periods": cells.stress_table,
}
"""Tables of cells in a folder."""


def published(sections: tuple[str, ...] = tuple(SECTIONS), /, *, cells: Path | None = None) -> Rows:
    """Run the selected sections, keep what they find, and write the page.

    Args:
        sections: V1 to V11, loops, tiling, knits, stretch, loads, friction, weave; or page, which runs none of them
        cells: folder of stockinette.pyp and basket.pyp of Sperl et al. 2021, whose tables the page then has
    """
    chosen = [name for name in sections if name != "page"]
    unknown = [name for name in chosen if name not in SECTIONS]
    if unknown:
        raise SystemExit(f"got {unknown[0]!r}; expected page, or sections among {', '.join(SECTIONS)}")
    ran = [SECTIONS[name] for name in chosen]
    if cells is not None:
        of_folder: Tables = {title: partial(table, cells) for title, table in CELL_TABLES.items()}
        ran.append(check_of(validation_page.CELLS, "Cells of Sperl et al. 2021", of_folder))
    for section in ran:
        note(f"{section.name}: {section.title}")
        yield f"## {section.name}: {section.title}"
        items: list[Item] = list(section.run())
        yield from cells_of(items)
        validation_page.keep(section.name, items)
        if section.draw is not None:
            section.draw(validation_page.PICTURES / section.picture)
    validation_page.write_page(TABLES, SECTIONS)
    yield from ("", "### Summary")
    yield from validation_page.summary(TABLES)
