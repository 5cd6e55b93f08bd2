# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The gallery: a relaxed swatch and a picture of each pattern of the library, and the tables of docs/gallery.md.

The edges of a swatch are held, as when a knitter blocks it, and the other yarns are free. The corpus of Leaf et al.
2018 and the weaves are periodic cells; ``corpus.py`` relaxes them into the same folder and draws them.
"""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Literal

import numpy as np

import stitchmesh as sm
from benchmarks.measures.swatches.corpus import LEAF
from benchmarks.places import DOCS
from benchmarks.table import Rows
from stitchmesh.mesh import Mesh
from stitchmesh.mesh.palette import colours_of
from stitchmesh.mesh.tube_mesh import tubes_around
from stitchmesh.patterns import Pattern, pattern_names
from stitchmesh.periodic.weave.library import read_weave, weave_names
from stitchmesh.quality import quality_named
from stitchmesh.yarn.polyline import polylines_of_segments
from stitchmesh.yarnrelax.constraints.borders import KeepBorders

PICTURES = DOCS / "gallery"
STITCH_WIDTH, STITCH_HEIGHT, RADIUS = 0.8, 0.62, 0.1
"""Gauge of the swatches and yarn radius [cm]."""
LOOPS = 28
"""Approximate numbers of loops and of rows of a swatch."""
MOST_ITERATIONS = 6000
SIZE, JPEG_QUALITY = 420, 84
"""Pixels of a picture."""
SEEN = 0.74
"""Visible fraction of the smaller side of a swatch; its borders are outside the picture."""


def swatch_of(pattern: Pattern, device: str | None) -> sm.StitchMesh:
    """Return whole tiles of a pattern, approximately square, relaxed in their plane."""
    inner = max(LOOPS - pattern.rows[0].bottoms[0] - pattern.rows[0].bottoms[2], 1)
    columns, rows = max(1, round(inner / pattern.width)), max(1, round(LOOPS / pattern.height))
    fabric = sm.pattern_mesh(pattern, columns, rows, stitch_width=STITCH_WIDTH, stitch_height=STITCH_HEIGHT)
    width, height = fabric.vertices[:, :2].max(axis=0)
    sheet = Mesh.from_polygons([[0, 0, 0], [width, 0, 0], [width, height, 0], [0, height, 0]], [[0, 1, 2, 3]])
    return sm.relax_mesh(fabric, surface=sheet, device=device).fabric


def relax(folder: Path, names: Sequence[str], device: str | None) -> Rows:
    """Relax the swatches of some patterns into a folder."""
    folder.mkdir(parents=True, exist_ok=True)
    quality = replace(quality_named("standard"), max_iterations=MOST_ITERATIONS)
    yield "pattern", "stitches", "control points", "iterations", "seconds", "at rest", "residual", "nearest [r]"
    for name in names:
        fabric = swatch_of(sm.read_pattern(name), device)
        yarns = sm.generate_yarns(fabric, yarn_radius=RADIUS, quality=quality)
        done = sm.relax_yarns(yarns, quality=quality, device=device, terms=[KeepBorders(fabric)])
        sm.write_yarns(folder / f"{name}.h5", done.yarns)
        report = {**done.report, "stitches": fabric.face_count}
        (folder / f"{name}.json").write_text(json.dumps(report))
        yield (
            name, fabric.face_count, len(yarns.points), report["iterations"], f"{report['seconds']:.1f}",
            "yes" if report["converged"] else "no", f"{report['residual']:.4f}",
            f"{report['min_distance_over_radius']:.2f}",
        )  # fmt: skip


def draw(folder: Path, name: str) -> None:
    """The picture of one swatch from the right side, without its edges."""
    from PIL import Image  # here, so that swatches can be relaxed where nothing can be drawn

    from stitchmesh.render.camera import camera_at
    from stitchmesh.render.options import PictureOptions
    from stitchmesh.render.stage import add_tubes, dim_colours, look, picture, shade_hollows

    yarns = sm.read_yarns(folder / f"{name}.h5")
    colours = dim_colours(colours_of(yarns.colour, yarns.palette))[yarns.point_yarn]
    options = PictureOptions(size=(SIZE, SIZE))
    curves = polylines_of_segments(yarns, np.arange(len(yarns.segment_points)), 3)
    tubes = tubes_around(curves.points, curves.closed, yarns.drawn_radius[curves.yarn], sides=12)
    low, high = yarns.points.min(axis=0), yarns.points.max(axis=0)
    focus = 0.5 * (low + high)
    path = PICTURES / f"{name}.png"
    with picture(path, options) as plotter:
        add_tubes(plotter, tubes, colours[curves.control_point][tubes.ring])
        height = SEEN * float(np.min((high - low)[:2]))
        look(plotter, camera_at(focus, np.array([0.0, 0.0, 1.0]), np.array([0.0, 1.0, 0.0]), height))
        shade_hollows(plotter, 3 * RADIUS, options)
    Image.open(path).convert("RGB").save(path.with_suffix(".jpg"), quality=JPEG_QUALITY, optimize=True)
    path.unlink()


def tables(folder: Path) -> Rows:
    """Yield the tables of docs/gallery.md."""
    yield "## All patterns"
    yield "", "pattern", "tile", "yarn", "relaxed", "source"
    for name in pattern_names():
        pattern = sm.read_pattern(name)
        tile = f"{pattern.width} x {pattern.height}"
        yield *named(name), tile, pattern.yarn_count, rest_of(folder, name), pattern.source
    yield "## Weaves"
    yield "", "weave", "repeat", "layers", "relaxed", "source"
    for name in weave_names():
        weave = read_weave(name)
        repeat = f"{len(weave.warps)} x {len(weave.wefts)}"
        yield *named(name), repeat, weave.layer_count, rest_of(folder, name), weave.source


def named(name: str) -> tuple[str, str]:
    """Return the cells with the picture and the name of a pattern or a weave."""
    return f"![{name}](gallery/{name}.jpg)", f"`{name}`"


def rest_of(folder: Path, name: str) -> str:
    """Return the number of iterations of a swatch, and whether it is at rest."""
    report = json.loads((folder / f"{name}.json").read_text())
    rest = "at rest" if report["converged"] else f"NOT at rest, residual {report['residual']:.3f}"
    return f"{report['iterations']} iterations, {rest}"


def gallery(
    step: Literal["relax", "draw"], folder: Path, patterns: tuple[str, ...] = (), /, *, device: str | None = None
) -> Rows:
    """Relax or draw.

    Args:
        patterns: all if none
    """
    names = patterns or [name for name in pattern_names() if name not in LEAF]
    if step == "relax":
        yield from relax(folder, names, device)
        return
    for name in names:
        draw(folder, name)
    if not patterns:
        yield from tables(folder)
