# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Comparison of swatches with published measurements: the tables and the pictures of docs/validation.md.

    python benchmarks/validation.py --pictures docs
    python benchmarks/validation.py cells --cells FOLDER      # with stockinette.pyp and basket.pyp

The script runs on one core of a CPU.
"""

from __future__ import annotations

import argparse
from collections.abc import Iterable
from pathlib import Path

import validation_friction
import validation_knits
import validation_loads
import validation_plots
import validation_stretch
import validation_weaves

SECTIONS = ("loops", "tiling", "knits", "stretch", "loads", "friction", "weave", "cells")


def main() -> None:
    """Print the selected sections."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("sections", nargs="*", metavar="SECTION", help=f"some of {', '.join(SECTIONS)} (default: all)")
    parser.add_argument("--pictures", type=Path, metavar="DIR", help="folder for the pictures")
    parser.add_argument("--cells", type=Path, metavar="DIR", help="folder of stockinette.pyp and basket.pyp")
    given = parser.parse_args()
    if unknown := set(given.sections) - set(SECTIONS):
        parser.error(f"got {', '.join(sorted(unknown))}; expected some of {', '.join(SECTIONS)}")
    for section in given.sections or SECTIONS:
        if section == "cells":
            _cells(given.cells)
        else:
            draw = {"loops": _loops, "tiling": _tiling, "knits": _knits, "stretch": _stretch, "loads": _loads,
                    "friction": _friction}  # fmt: skip
            draw.get(section, _weave)(given.pictures)


def _loops(pictures: Path | None) -> None:
    print_table("Stockinette at loop length 16.67 d", validation_knits.presets_table())
    found = validation_knits.loops()
    print_table("Stockinette by loop length", validation_knits.loops_table(found))
    if pictures is not None:
        validation_plots.draw_loops(found, pictures / "validation-loops.png")


def _tiling(_pictures: Path | None) -> None:
    print_table("One stitch and its tilings", validation_knits.tiling_table())


def _knits(_pictures: Path | None) -> None:
    print_table("Knitted fabrics beside stockinette", validation_knits.knits_table())
    print_table("Shaken and relaxed again", validation_knits.shaken_table())


def _stretch(pictures: Path | None) -> None:
    made = validation_stretch.curves()
    print_table("Tension at 20 % [dyn/cm]", validation_stretch.stiffness_table(made))
    print_table("Orders of stiffness", validation_stretch.orders_table(made))
    print()
    for line in (*validation_stretch.spacing_lines(made), *validation_stretch.hylc_lines(made)):
        print(f"- {line}")
    print_table("Stockinette by quality [dyn/cm]", validation_stretch.accuracy_table())
    if pictures is not None:
        validation_plots.draw_curves(made, pictures / "validation-stretch.png")


def _loads(_pictures: Path | None) -> None:
    print_table("Modulus at rest by loop length", validation_loads.modulus_table())
    made = validation_loads.curves()
    print_table("Extension under one load, in %", validation_loads.loads_table(made))
    print_table("Slope along the wales under one load", validation_loads.slopes_table(made))


def _friction(_pictures: Path | None) -> None:
    print_table("Stockinette off the needles", validation_friction.munden_table())
    print_table("Dry stockinette by friction", validation_friction.coefficients_table())
    print_table("Stockinette of 16.67 d from several sizes on the needles", validation_friction.paths_table())
    print_table("Ribs off the needles, of stockinette", validation_friction.rib_table())
    print_table("Rows of garter to the width of a stitch", validation_friction.garter_table())
    print_table("Work of dry stockinette", validation_friction.work_table())
    for title, rows in validation_friction.stiffness_tables():
        print_table(title, rows)


def _weave(pictures: Path | None) -> None:
    print_table("Plain weave of taut yarns", validation_weaves.peirce_table())
    print_table("Below jamming", validation_weaves.jam_table())
    if pictures is not None:
        states = [validation_weaves.taut_weave(spacing) for spacing in (1.75, *validation_weaves.SPACINGS)]
        validation_plots.draw_crimp(states, pictures / "validation-crimp.png")


def _cells(folder: Path | None) -> None:
    import validation_cells

    if folder is None or not all((folder / f"{name}.pyp").is_file() for name in validation_cells.CELLS):
        print("\n(cells: left out, give --cells the folder of stockinette.pyp and basket.pyp)")
        return
    print_table("Periods of the cells of Sperl et al. 2021", validation_cells.periods_table(folder))
    print_table("Their yarn, from the balance of its forces", validation_cells.constants_table(folder))
    print_table("Cells relaxed here", validation_cells.cells_table(folder))
    print_table("Stress in their periods", validation_cells.stress_table(folder))


def print_table(title: str, rows: Iterable[list[object]]) -> None:
    """Return a Markdown table; the first row holds the titles."""
    print(f"\n### {title}\n")
    for number, row in enumerate(rows):
        print("| " + " | ".join(map(str, row)) + " |", flush=True)
        if number == 0:
            print("|" + "---|" * len(row))


if __name__ == "__main__":
    main()
