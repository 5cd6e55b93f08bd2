# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The gallery: a relaxed swatch and a picture of each pattern of the library, and the tables of docs/gallery.md.

- ``corpus``: the corpus of Leaf et al. 2018 (L), table 3, 29 knits and 8 weaves, and all other weaves as periodic
  cells, whose periods are those of the generated cells. They are relaxed one by one and all in one batch, with the
  stiffness of Leaf et al. (material "leaf"). Times [s] are those of the solver in the second run, when the kernels are
  compiled. The times of L are for a GeForce GTX TITAN X and their convergence test (5): a gradient that does not change
  between steps and is at most a tenth of the first gradient.
- ``library``: swatches of all other patterns, whose edges are held, as when a knitter blocks them.
- ``draw``: a picture of each of them, and the tables.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Generator
from dataclasses import replace
from pathlib import Path

import numpy as np

import stitchmesh as sm
from benchmarks.places import DOCS
from benchmarks.scenes.swatches import CELLS, LEAF, cell_of
from benchmarks.table import Rows
from stitchmesh.mesh import Mesh
from stitchmesh.mesh.palette import colours_of
from stitchmesh.mesh.tube_mesh import tubes_around
from stitchmesh.patterns import Pattern, pattern_names
from stitchmesh.periodic.resolve_pattern import resolve_pattern
from stitchmesh.periodic.weave.library import read_weave, weave_names
from stitchmesh.periodic.weave.weave import Weave
from stitchmesh.quality import quality_named
from stitchmesh.yarn import YarnSet
from stitchmesh.yarn.polyline import polylines_of_segments
from stitchmesh.yarnrelax.constraints.borders import KeepBorders
from stitchmesh.yarnrelax.solvers.solver import ASSESSMENT_INTERVAL
from stitchmesh.yarnrelax.together.relax_cells import relax_cells

PICTURES = DOCS / "gallery"
SIZE, JPEG_QUALITY = 420, 84
"""Pixels of the longer side of a picture."""
STITCHES_SEEN, CROSSINGS_SEEN = 20, 12
"""Approximate width of the picture of a cell in stitches, or in crossings of a weave."""
SEEN = 0.74
"""Visible fraction of the smaller side of a swatch; its borders are outside the picture."""
STITCH_WIDTH, STITCH_HEIGHT, RADIUS = 0.8, 0.62, 0.1
"""Gauge of the swatches and yarn radius [cm]."""
LOOPS = 28
"""Approximate numbers of loops and of rows of a swatch."""
MOST_ITERATIONS = 6000
"""Iterations of a swatch."""


def corpus(folder: Path, /, *, quality: str = "standard", device: str | None = None, once: bool = False) -> Rows:
    """Relax the corpus one by one and in one batch.

    Args:
        once: relax each cell only once; times then include compilation
    """
    folder.mkdir(parents=True, exist_ok=True)
    runs = 1 if once else 2
    leaf = sm.YarnMaterial.named("leaf")
    cells = {name: cell_of(name, quality) for name in CELLS}
    gradients = yield from _together([cells[name] for name in LEAF], leaf, quality, device, runs)
    yield ""
    yield (
        "pattern", "points", "iterations", "s", "us per iteration", "ns per point", "residual", "nearest [r]",
        "gradient at rest", "to a tenth", "L: points", "s", "ms per step",
    )  # fmt: skip
    total = 0.0
    for name, yarns in cells.items():
        for _ in range(runs):
            done = sm.relax_yarns(yarns, material=leaf, quality=quality, device=device)
        report = done.report
        _write(folder, name, done.yarns, report)
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


def _together(
    cells: list[YarnSet], material: sm.YarnMaterial, name: str, device: str | None, runs: int
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


def library(folder: Path, patterns: tuple[str, ...] = (), /, *, device: str | None = None) -> Rows:
    """Relax swatches of patterns.

    Args:
        patterns: all that are not in the corpus if none
    """
    folder.mkdir(parents=True, exist_ok=True)
    quality = replace(quality_named("standard"), max_iterations=MOST_ITERATIONS)
    yield "pattern", "stitches", "control points", "iterations", "seconds", "at rest", "residual", "nearest [r]"
    for name in patterns or [name for name in pattern_names() if name not in LEAF]:
        fabric = _swatch_of(sm.read_pattern(name), device)
        yarns = sm.generate_yarns(fabric, yarn_radius=RADIUS, quality=quality)
        done = sm.relax_yarns(yarns, quality=quality, device=device, terms=[KeepBorders(fabric)])
        report = {**done.report, "stitches": fabric.face_count}
        _write(folder, name, done.yarns, report)
        yield (
            name, fabric.face_count, len(yarns.points), report["iterations"], f"{report['seconds']:.1f}",
            "yes" if report["converged"] else "no", f"{report['residual']:.4f}",
            f"{report['min_distance_over_radius']:.2f}",
        )  # fmt: skip


def _swatch_of(pattern: Pattern, device: str | None) -> sm.StitchMesh:
    """Return whole tiles of a pattern, approximately square, relaxed in their plane."""
    inner = max(LOOPS - pattern.rows[0].bottoms[0] - pattern.rows[0].bottoms[2], 1)
    columns, rows = max(1, round(inner / pattern.width)), max(1, round(LOOPS / pattern.height))
    fabric = sm.pattern_mesh(pattern, columns, rows, stitch_width=STITCH_WIDTH, stitch_height=STITCH_HEIGHT)
    width, height = fabric.vertices[:, :2].max(axis=0)
    sheet = Mesh.from_polygons([[0, 0, 0], [width, 0, 0], [width, height, 0], [0, height, 0]], [[0, 1, 2, 3]])
    return sm.relax_mesh(fabric, surface=sheet, device=device).fabric


def _write(folder: Path, name: str, yarns: YarnSet, report: dict[str, object]) -> None:
    sm.write_yarns(folder / f"{name}.h5", yarns)
    (folder / f"{name}.json").write_text(json.dumps(report))


def draw(folder: Path, names: tuple[str, ...] = (), /) -> Rows:
    """Draw patterns and weaves that are in the folder, and yield the tables of all.

    Args:
        names: all if none
    """
    from benchmarks.sheet import drawn  # Cells can be relaxed on machines without a renderer.

    for name in names or (*pattern_names(), *weave_names()):
        yarns = sm.read_yarns(folder / f"{name}.h5")
        picture = _cell_picture(name, yarns) if name in CELLS else _swatch_picture(yarns)
        drawn(picture).save(PICTURES / f"{name}.jpg", quality=JPEG_QUALITY, optimize=True)
    if not names:
        yield from _tables(folder)


def _cell_picture(name: str, yarns: YarnSet) -> Callable[[Path], object]:
    """The function that draws some tiles of a cell, seen from the front."""
    from stitchmesh.render import PictureOptions, render_swatch

    source = resolve_pattern(name)
    if isinstance(source, Weave):
        tiles = CROSSINGS_SEEN / len(source.warps), CROSSINGS_SEEN / len(source.wefts)
    else:
        tiles = STITCHES_SEEN / source.width, 1.3 * STITCHES_SEEN / source.height
    counts = max(1, round(tiles[0])), max(1, round(tiles[1]))
    return lambda path: render_swatch(yarns, path, counts, PictureOptions(size=(SIZE, SIZE)))


def _swatch_picture(yarns: YarnSet) -> Callable[[Path], object]:
    """The function that draws a swatch from the right side, without its edges."""
    from stitchmesh.render.camera import camera_at
    from stitchmesh.render.options import PictureOptions
    from stitchmesh.render.stage import add_tubes, dim_colours, look, picture, shade_hollows

    options = PictureOptions(size=(SIZE, SIZE))
    colours = dim_colours(colours_of(yarns.colour, yarns.palette))[yarns.point_yarn]
    curves = polylines_of_segments(yarns, np.arange(len(yarns.segment_points)), 3)
    tubes = tubes_around(curves.points, curves.closed, yarns.drawn_radius[curves.yarn], sides=12)
    low, high = yarns.points.min(axis=0), yarns.points.max(axis=0)
    height = SEEN * float(np.min((high - low)[:2]))

    def draw_into(path: Path) -> None:
        with picture(path, options) as plotter:
            add_tubes(plotter, tubes, colours[curves.control_point][tubes.ring])
            middle, front, up = 0.5 * (low + high), np.array([0.0, 0.0, 1.0]), np.array([0.0, 1.0, 0.0])
            look(plotter, camera_at(middle, front, up, height))
            shade_hollows(plotter, 3 * RADIUS, options)

    return draw_into


def _tables(folder: Path) -> Rows:
    """Yield the tables of docs/gallery.md."""
    yield "## All patterns"
    yield "", "pattern", "tile", "yarn", "relaxed", "source"
    for name in pattern_names():
        pattern = sm.read_pattern(name)
        tile = f"{pattern.width} x {pattern.height}"
        yield *_named(name), tile, pattern.yarn_count, _rest_of(folder, name), pattern.source
    yield "## Weaves"
    yield "", "weave", "repeat", "layers", "relaxed", "source"
    for name in weave_names():
        weave = read_weave(name)
        repeat = f"{len(weave.warps)} x {len(weave.wefts)}"
        yield *_named(name), repeat, weave.layer_count, _rest_of(folder, name), weave.source


def _named(name: str) -> tuple[str, str]:
    """Return the cells with the picture and the name of a pattern or a weave."""
    return f"![{name}](gallery/{name}.jpg)", f"`{name}`"


def _rest_of(folder: Path, name: str) -> str:
    """Return the number of iterations of a swatch, and whether it is at rest."""
    report = json.loads((folder / f"{name}.json").read_text())
    rest = "at rest" if report["converged"] else f"NOT at rest, residual {report['residual']:.3f}"
    return f"{report['iterations']} iterations, {rest}"


ACTIONS = (corpus, library, draw)
