# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""What the page Divide says of a division, as HTML: the estimate, the chosen edge and the legend of stitches."""

from __future__ import annotations

import numpy as np

from stitchmesh.app.controls.legend import LegendEntry
from stitchmesh.app.pages.gauge_panel import gauge_words
from stitchmesh.app.scene.drawing import Colour
from stitchmesh.markup import Markup, joined, markup
from stitchmesh.mesh import StitchMesh
from stitchmesh.mesh.stitch import Stitch
from stitchmesh.recipe.estimate import GarmentEstimate
from stitchmesh.render.palette import STITCH_COLOURS
from stitchmesh.yarn.yarn_presets import Gauge, Yarn

CHOSEN_COLOUR: Colour = (232, 140, 20)
"""Colour of the chosen edge."""
COUNTED_COLOUR: Colour = (31, 86, 115)
"""Colour of edges whose number is given by hand."""
MARKED_COLOUR: Colour = (150, 40, 140)
"""Colour of marked edges."""
STAGE_WORDS = {
    "tessellate": "divide", "meshrelax": "even out", "yarngen": "make yarns", "yarnrelax": "relax yarns",
}  # fmt: skip
"""Words for the stages of an estimate."""
KINDS = {
    "cast on": (Stitch.CAST_ON,),
    "knit": (Stitch.KNIT,),
    "increase": (Stitch.KY, Stitch.YK, Stitch.YKY, Stitch.KS, Stitch.SK, Stitch.KYK, Stitch.PK, Stitch.KPK),
    "decrease": (Stitch.D12K, Stitch.D21K, Stitch.D213K),
    "drawn through the last loops": (Stitch.DRAW_THROUGH,),
}
"""Stitches of a divided mesh, by what they do."""


def estimate_table(estimate: GarmentEstimate, width: float, height: float, yarn: Yarn | None) -> Markup:
    """Return the estimate as a table, with what may be wrong below it."""
    length = f"{estimate.yarn_length / 100.0:,.0f} m"
    if yarn is not None:
        length += f", about {estimate.yarn_length / 100.0 * yarn.grams_per_metre:,.0f} g"
    rows = {
        "Gauge": gauge_words(Gauge.of_stitch(width, height)),
        "Stitches": f"{estimate.stitches:,} in {estimate.rows:,} rows",
        "Yarn": length,
        "Control points": f"{estimate.control_points:,}",
        "Time": f"about {_time(estimate.seconds)}",
        "Memory": f"about {_memory(estimate.memory)}",
    }
    body = joined(_row(name, value) for name, value in rows.items())
    stages = ", ".join(f"{STAGE_WORDS[name]} {_time(cost.seconds)}" for name, cost in estimate.stages.items())
    doubt = markup('<p role="status" style="{}"><strong>Please note:</strong> {}</p>', _NOTE, estimate.doubt)
    return markup(
        '<table aria-label="Estimate" style="font-size:.88em;border-spacing:0">{}</table>'
        '<p style="margin:.2em 0 0;font-size:.8em">{}; half or twice that on other machines</p>{}',
        body, stages, doubt if estimate.doubt else "",
    )


def refusal(message: str) -> Markup:
    """Return why there is no estimate."""
    return markup('<p role="alert" style="{}"><strong>Not possible:</strong> {}</p>', _NOTE, message)


def edge_text(labeled: StitchMesh, side: int, count: int, *, by_hand: bool, marked: bool) -> Markup:
    """Return a description of the chosen edge.

    Args:
        labeled: the labeled mesh.
        side: a side of the edge.
        count: its number of stitches.
        by_hand: whether the number is given by hand.
        marked: whether the edge is marked.
    """
    start, end = labeled.face_vertex[side], labeled.face_vertex[labeled.side_next[side]]
    length = float(labeled.side_length[side])
    origin = "given by hand" if by_hand else "by its length"
    if labeled.is_wale[side]:
        what = f"wale edge of row {labeled.row[labeled.side_face[side]] + 1}: {count} rows of stitches, {origin}"
        what += "; marked" if marked else ""
    else:
        what = f"course edge: {count} stitches, {origin}"
    return markup(
        '<p style="margin:0;font-size:.88em"><strong>Edge {},{}</strong>, {} cm, {}</p>',
        start, end, f"{length:.1f}", what,
    )


def no_edge_text() -> Markup:
    """Return how to choose an edge."""
    return markup('<p style="margin:0;font-size:.88em">Click an edge to set its number of stitches.</p>')


def legend_of_stitches(fabric: StitchMesh) -> list[LegendEntry]:
    """Return what the colours of the stitches mean, with their numbers."""
    counts = np.bincount(fabric.stitch, minlength=max(Stitch) + 1)
    entries = []
    for words, codes in KINDS.items():
        present = [code for code in codes if counts[code]]
        if present:
            number = sum(int(counts[code]) for code in present)
            entries.append(LegendEntry(f"{words}: {number:,}", tuple(STITCH_COLOURS[code] for code in present)))
    return entries


_NOTE = (
    "margin:.4em 0 0;font-size:.86em;padding:.35em .5em;border-left:4px solid rgb(201,125,16);"
    "background:rgba(201,125,16,.12);overflow-wrap:anywhere"
)


def _row(name: str, value: str) -> Markup:
    return markup(
        '<tr><th scope="row" style="text-align:left;font-weight:500;padding:0 .8em 0 0">{}</th>'
        "<td>{}</td></tr>",
        name, value,
    )


def _time(seconds: float) -> str:
    """A duration in words."""
    if seconds < 1.0:
        return "1 s" if seconds >= 0.5 else "less than 1 s"
    if seconds < 100.0:
        return f"{seconds:.0f} s"
    return f"{seconds / 60.0:.0f} min" if seconds < 6000.0 else f"{seconds / 3600.0:.1f} h"


def _memory(size: float) -> str:
    return f"{size / 1e9:.1f} GB" if size >= 1e9 else f"{size / 1e6:.0f} MB"
