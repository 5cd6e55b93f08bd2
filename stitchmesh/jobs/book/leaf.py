# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""A leaf of the swatch book: what the page shows of one pattern, and the files that it offers.

A page that is opened from a folder may load scripts and pictures, but no data. A leaf is therefore a script, which
hands its content to the page. The centre lines of one repeat stand in it as 16-bit numbers over the box around them. In
a repeat of 10 cm a step is 0.00015 cm, less than a three-hundredth of the radius of ``dk``. The page builds tubes from
them and repeats these.
"""

from __future__ import annotations

import base64
import json
from collections.abc import Mapping
from dataclasses import dataclass
from io import BytesIO
from pathlib import Path
from typing import Any

import numpy as np

from stitchmesh.io.atomic import write_bytes, write_text
from stitchmesh.io.yarns import write_yarns
from stitchmesh.patterns import Pattern
from stitchmesh.patterns.library import family_of
from stitchmesh.periodic.charts.chart_files import chart_of, write_chart
from stitchmesh.periodic.charts.chart_picture import chart_picture
from stitchmesh.periodic.resolve_pattern import Source
from stitchmesh.periodic.stretch import NEWTONS_PER_METRE
from stitchmesh.render.colouring import colour_yarns
from stitchmesh.render.pattern_sheet import written_repeat
from stitchmesh.render.swatch_picture import swatch_image
from stitchmesh.yarn import YarnSet
from stitchmesh.yarn.polyline import polylines_of_segments
from stitchmesh.yarn.tiling import tile_yarns
from stitchmesh.yarn.yarn_presets import Gauge

LEAVES, PICTURES, CHARTS, FILES = FOLDERS = ("leaves", "pictures", "charts", "files")
"""Folders of a book: scripts, pictures of the relaxed yarns, charts, and files to take."""
WOVEN = "Woven"
"""Family of the weaves."""
STITCHES = 12
"""Stitches along the shorter side of a picture and of the fabric that turns; at least one repeat is shown."""
LARGE, SMALL = 800, 320
"""Longer side of a picture on a leaf, and of one in the list [pixels]."""
SAMPLES = 3
"""Points of a centre line for each segment of a yarn."""
STEPS = 32_767
"""Steps of a coordinate from the middle of its box to the border."""


@dataclass(frozen=True, eq=False)
class Leaf:
    """One pattern of a book."""

    name: str
    """Name in the library."""
    title: str
    """Name as people say it."""
    family: str
    """Family of the pattern (``family_of``), or ``Woven``."""
    gauge: str
    """Stitches, or warps, in 10 cm, in words."""
    content: Mapping[str, Any]
    """What the script of the leaf holds."""


def leaf_of(
    name: str, source: Source, yarns: YarnSet, row: Mapping[str, Any], reference: float | None, folder: Path
) -> Leaf:
    """Write the pictures and the files of a pattern, and return its leaf.

    Args:
        name: name of the pattern.
        source: the pattern or the weave.
        yarns: the relaxed yarns of one repeat on their lattice.
        row: measures of the swatch, as in the table of a sweep.
        reference: wale spacing of stockinette in the same yarn [cm]; None for a book without it.
        folder: folder of the book.

    Raises:
        DisplayError: this machine cannot draw pictures.
        FileError: a file cannot be written.
    """
    tiles = _tiles(row)
    _draw(yarns, tiles, folder / PICTURES / name)
    chart = chart_of(source)
    write_bytes(folder / CHARTS / f"{name}.png", chart_picture(chart))
    text = write_chart(chart).text
    suffix = ".knit" if isinstance(source, Pattern) else ".weave"
    write_text(folder / FILES / f"{name}{suffix}", text)
    write_yarns(folder / FILES / f"{name}.h5", yarns)
    write_yarns(folder / FILES / f"{name}.bcc", tile_yarns(yarns, *tiles))
    gauge = Gauge.of_stitch(row["wale_spacing"], row["course_spacing"])
    content = {
        "name": name, "title": source.name, "source": source.source, "figures": figures_of(row, reference),
        "written": written_repeat(source, gauge), "fabric": _fabric(yarns, tiles),
        "files": [f"{FILES}/{name}{ending}" for ending in (suffix, ".h5", ".bcc")],
    }  # fmt: skip
    family, threads = (family_of(source), "stitches") if isinstance(source, Pattern) else (WOVEN, "warps")
    return Leaf(name, source.name, family, f"{row['gauge.stitches']:.1f} {threads} in 10 cm", content)


def script_of(leaf: Leaf) -> str:
    """Return the script that hands a leaf to the page."""
    return f"show({json.dumps(leaf.content, separators=(',', ':'), ensure_ascii=True)});\n"


def figures_of(row: Mapping[str, Any], reference: float | None) -> list[tuple[str, str]]:
    """Return the names and values of the measures of a swatch, with their units."""
    figures = [
        ("Repeat", f"{row['wales']:g} x {row['courses']:g}, {row['width']:.3g} x {row['height']:.3g} cm"),
        ("Gauge", f"{row['gauge.stitches']:.1f} x {row['gauge.rows']:.1f} in 10 cm"),
        ("Thickness", f"{10.0 * row['thickness']:.1f} mm"),
        ("Weight", f"{1e4 * row['areal_density']:.0f} g/m²"),
        ("Yarn of a stitch or crossing", f"{10.0 * row['loop_length']:.1f} mm"),
    ]
    if reference is not None:
        figures.append(("Width beside stockinette", f"{row['wale_spacing'] / reference:.2f}"))
    for direction, name in (("course", "along the courses"), ("wale", "along the wales")):
        strains, tensions = (row.get(f"stretch_{direction}.{what}") for what in ("strain", "tension"))
        if strains and tensions:
            tension = NEWTONS_PER_METRE * tensions[-1]
            figures.append((f"Drawn {100.0 * strains[-1]:.0f} % {name}", f"{tension:.3g} N/m"))
    if not row["converged"]:
        figures.append(("Rest", f"not at rest, residual {row['residual']:.2g}"))
    return figures


def _tiles(row: Mapping[str, Any]) -> tuple[int, int]:
    """Return how many repeats are shown, side by side and above one another, in about a square."""
    side = max(row["width"], row["height"], STITCHES * min(row["wale_spacing"], row["course_spacing"]))
    return max(round(side / row["width"]), 1), max(round(side / row["height"]), 1)


def _draw(yarns: YarnSet, tiles: tuple[int, int], stem: Path) -> None:
    """Write a large and a small picture of the right side."""
    image = swatch_image(yarns, tiles, LARGE)
    for side, ending in ((LARGE, ""), (SMALL, "-small")):
        image.thumbnail((side, side))
        content = BytesIO()
        image.save(content, "JPEG", quality=82, optimize=True)
        write_bytes(stem.with_name(f"{stem.name}{ending}.jpg"), content.getvalue())


def _fabric(yarns: YarnSet, tiles: tuple[int, int]) -> dict[str, Any]:
    """Return the centre lines of one repeat, and how they repeat."""
    assert yarns.lattice is not None
    curves = polylines_of_segments(yarns, np.arange(len(yarns.segment_points)), SAMPLES)
    points = np.concatenate(curves.points)
    colours = colour_yarns(yarns, "yarn").points
    starts = np.cumsum([0, *map(len, curves.points)])
    low, high = points.min(axis=0), points.max(axis=0)
    middle, half = 0.5 * (low + high), np.maximum(0.5 * (high - low), 1e-9)
    steps = np.rint((points - middle) / half * STEPS).astype("<i2")
    return {
        "points": base64.b64encode(steps.tobytes()).decode("ascii"), "middle": _short(middle), "half": _short(half),
        "counts": [len(curve) for curve in curves.points], "closed": [bool(ring) for ring in curves.closed],
        "colours": [colours[curves.control_point[first]].tolist() for first in starts[:-1].tolist()],
        "radius": _short(yarns.drawn_radius[:1])[0], "periods": [_short(own) for own in yarns.lattice.periods],
        "tiles": list(tiles),
    }  # fmt: skip


def _short(values: Any) -> list[float]:
    """Return numbers with as many digits as the page can show."""
    return [float(f"{value:.6g}") for value in values]
