# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The corpus of Leaf et al. 2018 (L), table 3, as periodic cells: relaxation, times and pictures.

The corpus has 29 knits and 8 weaves. Their periods are those of the generated cells; the users of Leaf et al. set them
by hand. The cells are relaxed one by one and all in one batch, with the stiffness of Leaf et al. (material "leaf"). The
times [s] are those of the solver in the second run, when the kernels are compiled. The times of Leaf et al. are for a
GeForce GTX TITAN X and their convergence test (5): a gradient that does not change between steps and is at most a tenth
of the first gradient.
"""

from __future__ import annotations

import json
import time
from collections.abc import Generator
from dataclasses import replace
from pathlib import Path
from typing import Literal

import stitchmesh as sm
from benchmarks.places import DOCS
from benchmarks.table import Rows
from stitchmesh.periodic.repeat.drawn_swatch import draw_swatch
from stitchmesh.periodic.resolve_pattern import resolve_pattern
from stitchmesh.periodic.swatch_options import SwatchOptions
from stitchmesh.periodic.weave.library import weave_names
from stitchmesh.periodic.weave.weave import Weave
from stitchmesh.quality import quality_named
from stitchmesh.yarn import YarnSet
from stitchmesh.yarnrelax.solvers.solver import ASSESSMENT_INTERVAL
from stitchmesh.yarnrelax.together.relax_cells import relax_cells

PICTURES = DOCS / "gallery"
LEAF: dict[str, tuple[float, float, int]] = {
    "alternating-diagonals": (2.18, 0.95, 3794), "basketweave-rib-stitch": (0.79, 0.58, 1714),
    "block1": (0.09, 1.17, 5686), "block2": (0.06, 0.78, 2054), "cartridge-belt-rib": (0.45, 0.44, 423),
    "double-basket-pattern": (3.00, 0.88, 4860), "garter-block": (0.13, 0.61, 2054), "honeycomb": (0.33, 0.77, 3392),
    "jacquard1": (0.38, 0.50, 1504), "jacquard2": (0.18, 0.54, 1433), "jacquard3": (0.29, 0.59, 2106),
    "king-charles-brocade": (1.36, 0.58, 2394), "lattice-with-seed-stitch": (0.55, 1.12, 7280),
    "left-diagonal": (0.05, 0.50, 723), "left-diagonal-rib": (0.68, 0.58, 1374),
    "long-slip-textured": (0.10, 0.42, 456), "parallelograms": (0.19, 0.64, 2732),
    "pie-crust-basketweave": (0.15, 0.65, 986), "pyramid-stitch": (0.68, 0.58, 2198),
    "rhombus-texture": (1.30, 0.60, 2394), "right-diagonal": (0.37, 0.44, 723),
    "right-diagonal-rib": (0.45, 0.55, 1374), "seersucker": (1.09, 0.49, 1230),
    "slip-stitch-honeycomb": (0.27, 0.43, 284), "slip-stitch-rib": (0.43, 0.41, 248),
    "stockinette-and-garter": (26.54, 1.52, 10890), "thunderbird": (10.91, 1.08, 7280),
    "tumbling-moss-blocks": (0.02, 1.14, 3214), "woven-transverse-herringbone": (0.61, 0.59, 1996),
    "basket-2x2": (0.09, 0.49, 180), "basket-3x3": (0.11, 0.50, 304), "plain": (0.16, 0.42, 88),
    "satin-2x3": (0.25, 0.48, 238), "satin-3x2": (0.23, 0.44, 238), "twill-2x1": (0.19, 0.44, 130),
    "twill-3x2": (0.12, 0.51, 238), "twill-4x1": (0.38, 0.45, 238),
}  # fmt: skip
"""Seconds until convergence, milliseconds per step, and number of control points in L's table 3."""
SIZE, JPEG_QUALITY = 420, 84
"""Pixels of the longer side of a picture."""
STITCHES_SEEN, CROSSINGS_SEEN = 20, 12
"""Approximate width of a picture in stitches, or in crossings of a weave."""


def cell(name: str, quality: str) -> YarnSet:
    """The cell of a pattern as generated."""
    return draw_swatch(resolve_pattern(name), SwatchOptions(), quality_named(quality))[1]


def relax(folder: Path, quality: str, device: str | None, *, alone: bool) -> Rows:
    """Relax the corpus one by one and in one batch; write the results and print the tables."""
    folder.mkdir(parents=True, exist_ok=True)
    others = [name for name in weave_names() if name not in LEAF]
    cells = {name: cell(name, quality) for name in [*LEAF, *others]}
    leaf = sm.YarnMaterial.named("leaf")
    gradients = yield from together([cells[name] for name in LEAF], leaf, quality, device, runs=2 if alone else 1)
    yield ""
    yield (
        "pattern", "points", "iterations", "s", "us per iteration", "ns per point", "residual", "nearest [r]",
        "gradient at rest", "to a tenth", "L: points", "s", "ms per step",
    )  # fmt: skip
    total = 0.0
    for name, yarns in cells.items():
        for _ in range(2 if alone else 1):
            done = sm.relax_yarns(yarns, material=leaf, quality=quality, device=device)
        report = done.report
        sm.write_yarns(folder / f"{name}.h5", done.yarns)
        (folder / f"{name}.json").write_text(json.dumps(report))
        each = report["seconds"] / report["iterations"]
        leaf_seconds, leaf_step, leaf_points = LEAF.get(name, ("", "", ""))
        total += report["seconds"] if name in LEAF else 0.0
        rest = f"{report['residual']:.4f}" if report["converged"] else f"{report['residual']:.4f}, NOT at rest"
        gradient = gradients[list(LEAF).index(name)] if name in LEAF else ("", "")
        yield (
            name, len(yarns.points), report["iterations"], f"{report['seconds']:.3f}", f"{1e6 * each:.0f}",
            f"{1e9 * each / len(yarns.points):.0f}", rest, f"{report['min_distance_over_radius']:.2f}",
            *gradient, leaf_points, leaf_seconds, leaf_step,
        )  # fmt: skip
    yield f"one after another, 37 patterns: {total:.2f} s (L: {sum(s for s, _, _ in LEAF.values()):.0f} s)"


def together(
    cells: list[YarnSet], material: sm.YarnMaterial, name: str, device: str | None, *, runs: int
) -> Generator[str, None, list[tuple[str, object]]]:
    """Relax all cells in one batch, once to rest and once to the first condition of L's test.

    Returns:
        For each cell, two columns of the table: the gradient at rest over the first gradient, and the number of
        iterations until the gradient is a tenth of the first.
    """
    quality = quality_named(name)
    materials = [material] * len(cells)
    for _ in range(runs):
        batch = relax_cells(cells, materials=materials, quality=quality, device=device)
    report = batch.report
    points = sum(len(yarns.points) for yarns in cells)
    rest = f"{report['converged']} at rest, {report['launched']} iterations of the slowest"
    yield f"in one batch: {report['seconds']:.2f} s, {rest}, {points} control points, {report['device']}"
    tenths = [cell.report["tenth_iterations"] for cell in batch.cells]
    longest = max(tenth or cell.report["iterations"] for tenth, cell in zip(tenths, batch.cells, strict=True))
    rough = replace(quality, max_iterations=-(-longest // ASSESSMENT_INTERVAL) * ASSESSMENT_INTERVAL)
    seconds = relax_cells(cells, materials=materials, quality=rough, device=device).report["seconds"]
    tenth = "to a tenth of the first gradient (L's eq 5, first condition)"
    yield f"{tenth}: {seconds:.2f} s, {longest} iterations of the slowest"
    parts = [cell.report["gradient"] for cell in batch.cells]
    return [(f"{part:.1e}", tenth) for part, tenth in zip(parts, tenths, strict=True)]


def draw(folder: Path, name: str) -> None:
    """Write a picture of some tiles, seen from the front."""
    from benchmarks.sheet import drawn  # imported here, so that cells can be relaxed on machines without a renderer
    from stitchmesh.render import PictureOptions, render_swatch

    source = resolve_pattern(name)
    seen = CROSSINGS_SEEN if isinstance(source, Weave) else STITCHES_SEEN
    size = (len(source.warps), len(source.wefts)) if isinstance(source, Weave) else (source.width, source.height)
    tiles = max(1, round(seen / size[0])), max(1, round(seen * (1.0 if isinstance(source, Weave) else 1.3) / size[1]))
    yarns, options = sm.read_yarns(folder / f"{name}.h5"), PictureOptions(size=(SIZE, SIZE))
    picture = drawn(lambda path: render_swatch(yarns, path, tiles, options))
    picture.save(PICTURES / f"{name}.jpg", quality=JPEG_QUALITY, optimize=True)


def corpus(
    step: Literal["relax", "draw"],
    folder: Path,
    names: tuple[str, ...] = (),
    /,
    *,
    quality: str = "standard",
    device: str | None = None,
    once: bool = False,
) -> Rows:
    """Run the step given on the command line.

    Args:
        names: patterns to draw; default: the corpus and all other weaves
        once: relax each cell only once; times then include compilation
    """
    began = time.perf_counter()
    if step == "relax":
        yield from relax(folder, quality, device, alone=not once)
    else:
        for name in names or [*LEAF, *(name for name in weave_names() if name not in LEAF)]:
            draw(folder, name)
    yield f"{time.perf_counter() - began:.0f} s in total"
