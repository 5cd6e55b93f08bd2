# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The tables and pictures of ``docs/validation.md``, from the results that are kept.

On the page a table stands between markers, which name its section, and after a colon its title if the section has
several; text around them is written by hand:

    <!-- table V1 --> or <!-- table loops: Stockinette by loop length --> or <!-- table summary -->
    or <!-- table ranges -->, of ``periodic.validated_range``
    ...
    <!-- end of table -->
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path

from benchmarks.json_lines import append, read
from benchmarks.places import DOCS, ROOT
from benchmarks.published.comparison import (
    Curve,
    Item,
    Section,
    Title,
    cells_of,
    error_of,
    item_of,
    kept,
    passed,
)
from benchmarks.published.plots import draw_panels
from benchmarks.table import row
from stitchmesh.io.atomic import write_text
from stitchmesh.periodic.validated_range import RANGES, range_words

PAGE = DOCS / "validation.md"
PICTURES = DOCS
RESULTS = ROOT / "benchmarks" / "published" / "results"
CELLS = "cells"
"""Name of the section of the cells in a folder."""
END = "<!-- end of table -->"


def keep(name: str, items: Iterable[Item], folder: Path = RESULTS) -> None:
    """Replace what is kept of a section."""
    path = folder / f"{name}.jsonl"
    path.unlink(missing_ok=True)
    append(path, (kept(item) for item in items))


def found(name: str, folder: Path = RESULTS) -> list[Item]:
    """Return what is kept of a section; nothing if it has not run."""
    return [item_of(line) for line in read(folder / f"{name}.jsonl")]


def table_of(items: Sequence[Item], title: str | None = None) -> str:
    """Return the text of the items before the first title, or after a title up to the next one."""
    starts = [number for number, item in enumerate(items) if isinstance(item, Title)]
    if title is None:
        chosen = items[: starts[0]] if starts else items
    else:
        number = next(k for k in starts if items[k] == Title(title))
        chosen = items[number + 1 : next((k for k in starts if k > number), len(items))]
    lines: list[str] = []
    in_table = False
    for item in cells_of(chosen):
        if isinstance(item, str):
            in_table = False
            if item or (lines and lines[-1]):
                lines.append(item)
            continue
        lines.append(row(item))
        if not in_table:
            lines.append("|" + "---|" * len(item))
        in_table = True
    return "\n".join(lines).strip("\n")


def summary(tables: Iterable[Section]) -> Iterable[Sequence[object]]:
    """Yield a row for each published table: its error beside what the literature accepts."""
    yield ["table", "what", "RMS error", "accepted", "passed", "misses"]
    for section in tables:
        items = found(section.name)
        error, (good, count) = error_of(items), passed(items)
        number = "no number" if error is None else f"{100 * error:.0f} %"
        if not items:
            yield [section.name, section.title, "not run", section.accepted, "", section.verdict]
            continue
        anchor = anchor_of(f"{section.name}: {section.title}")
        yield [f"[{section.name}](#{anchor})", section.title, number, section.accepted, f"{good} of {count}",
               section.verdict]  # fmt: skip


def ranges() -> Iterable[Sequence[object]]:
    """Yield a row for each comparison that the library knows: where it was made, and the error to expect there."""
    yield ["what", "fabric", "loops / d", "strain", "yarn [N/tex]", "error to expect", "source"]
    for each in RANGES:
        along = "" if each.direction is None else f", {each.direction}s"
        strain = "" if each.strains is None else f"{range_words([100.0 * end for end in each.strains])} %{along}"
        state = f" ({', '.join(each.states)})" if each.states else ""
        rubs = "" if each.friction is None else f", friction {range_words(each.friction)}"
        loops, stretch = ("" if ends is None else range_words(ends) for ends in (each.loops, each.stretch))
        page = "" if each.page == PAGE.name else each.page
        source = f"[{each.section}]({page}#{anchor_of(each.heading)})"
        yield [f"{each.quantity}{state}", f"{', '.join(each.fabrics)}{rubs}", loops, strain, stretch, each.off, source]


def anchor_of(heading: str) -> str:
    """Return the anchor of a heading."""
    return re.sub(r"[^a-z0-9 -]", "", heading.lower()).replace(" ", "-")


def _plain_table(rows: Iterable[Sequence[object]]) -> str:
    return "\n".join(row(cells) + ("\n|" + "---|" * len(cells) if k == 0 else "") for k, cells in enumerate(rows))


def page_with_tables(page: str, tables: Iterable[Section]) -> str:
    """Return a page with its tables up to date.

    Raises:
        StopIteration: a marker names a title that its section does not have.
    """

    def made(match: re.Match[str]) -> str:
        name, _, title = match["name"].partition(": ")
        if name == "summary":
            text = _plain_table(summary(tables))
        elif name == "ranges":
            text = _plain_table(ranges())
        else:
            items = found(name)
            text = table_of(items, title or None) if items else match["old"].strip("\n")
        return f"<!-- table {match['name']} -->\n\n{text}\n\n{END}"

    return re.sub(rf"<!-- table (?P<name>.*?) -->(?P<old>.*?){END}", made, page, flags=re.DOTALL)


def write_page(tables: Iterable[Section], sections: Mapping[str, Section]) -> None:
    """Write the tables of the page, and the pictures of the curves that are kept."""
    for name, section in sections.items():
        curves = [item for item in found(name) if isinstance(item, Curve)]
        if curves and section.picture:
            draw_panels(curves, section.axes, PICTURES / section.picture)
    write_text(PAGE, page_with_tables(PAGE.read_text(encoding="utf-8"), tables))
