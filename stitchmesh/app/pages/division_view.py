# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The drawing of the page Divide: the labeled mesh or its stitches, edges with numbers or marks, and the estimate."""

from __future__ import annotations

import numpy as np

from stitchmesh.app.controls.html_pieces import figures
from stitchmesh.app.controls.legend import LegendEntry
from stitchmesh.app.pages.gauge_panel import gauge_words
from stitchmesh.app.project.division import Division
from stitchmesh.app.scene.drawing import Colour, Labels
from stitchmesh.app.scene.mesh_drawing import INK, STITCH_DRAWINGS, MeshDrawing, show_stitches
from stitchmesh.app.scene.scene import Scene
from stitchmesh.markup import Markup, markup
from stitchmesh.mesh import IntArray, StitchMesh
from stitchmesh.mesh.stitch import Stitch
from stitchmesh.recipe.estimate import GarmentEstimate
from stitchmesh.render.palette import STITCH_COLOURS
from stitchmesh.tessellate.counts import edge_named
from stitchmesh.yarn.colours import row_colours
from stitchmesh.yarn.yarn_presets import Gauge, Yarn

CHOSEN_COLOUR: Colour = (232, 140, 20)
"""Colour of the chosen edge."""
COUNTED_COLOUR: Colour = (31, 86, 115)
"""Colour of edges whose number the user has given."""
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
"""Stitches of a divided mesh, by their purpose."""


def estimate_table(estimate: GarmentEstimate, width: float, height: float, yarn: Yarn | None) -> Markup:
    """Return the estimate as a table; possible faults stand below it."""
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
    stages = ", ".join(f"{STAGE_WORDS[name]} {_time(cost.seconds)}" for name, cost in estimate.stages.items())
    doubt = markup('<p role="status" style="{}"><strong>Please note:</strong> {}</p>', _NOTE, estimate.doubt)
    return markup(
        '{}<p style="margin:.2em 0 0;font-size:.8em">{}; half or twice that on other machines</p>{}',
        figures(rows.items()), stages, doubt if estimate.doubt else "",
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
        by_hand: whether the user has given the number.
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
    """Return the legend of the colours of the stitches, with the number of stitches of each."""
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


def _time(seconds: float) -> str:
    """A duration in words."""
    if seconds < 1.0:
        return "1 s" if seconds >= 0.5 else "less than 1 s"
    if seconds < 100.0:
        return f"{seconds:.0f} s"
    return f"{seconds / 60.0:.0f} min" if seconds < 6000.0 else f"{seconds / 3600.0:.1f} h"


def _memory(size: float) -> str:
    return f"{size / 1e9:.1f} GB" if size >= 1e9 else f"{size / 1e6:.0f} MB"


MOST_NUMBERS = 150
"""Largest number of edges whose numbers are shown."""
EDGE_MARKS = (
    ("counted", COUNTED_COLOUR, 6.0, "number given by hand"),
    ("marked", MARKED_COLOUR, 6.0, "marked: increases and decreases stand here"),
    ("chosen", CHOSEN_COLOUR, 8.0, "chosen edge"),
)
"""Name, colour, width [pixels] and meaning of the lines along edges."""


class DivisionView:
    """Draws one labeled mesh and its divisions."""

    def __init__(self, scene: Scene, labeled: StitchMesh) -> None:
        """Draw nothing yet."""
        self._scene, self._labeled = scene, labeled
        self._drawing = MeshDrawing(scene, labeled)
        self._colours = row_colours(labeled.row)
        self._shown: StitchMesh | None = None

    def look(self) -> None:
        """Show the whole mesh."""
        self._drawing.look()

    def show_mesh(self) -> list[LegendEntry]:
        """Draw the faces of the mesh in the colours of their rows, and return the legend."""
        if self._shown is not self._labeled:
            self._shown = self._labeled
            for name in STITCH_DRAWINGS:
                self._scene.remove(name)
            self._drawing.show_faces("faces", self._colours)
            self._drawing.show_sides("edges", self._labeled.edge_side, INK, 1.0)
        rows = np.unique(self._labeled.row, return_index=True)[1]
        samples = self._colours[rows[np.unique(np.linspace(0, len(rows) - 1, 6).astype(np.int64))]]
        return [LegendEntry("rows of faces", tuple((int(r), int(g), int(b)) for r, g, b in samples))]

    def show_stitches(self, fabric: StitchMesh) -> list[LegendEntry]:
        """Draw stitches in their colours, and return the legend."""
        if self._shown is not fabric:
            self._shown = fabric
            for name in ("faces", "edges"):
                self._scene.remove(name)
            show_stitches(self._scene, fabric)
        return legend_of_stitches(fabric)

    def show_edges(self, division: Division, chosen: int | None, along: IntArray | None) -> list[LegendEntry]:
        """Draw the edges with numbers or marks, and the chosen edge, and return the legend.

        Args:
            division: the division.
            chosen: a side of the chosen edge; None if there is none.
            along: number of stitches along each edge, shape (E,); None if such stitches are not possible.
        """
        labeled = self._labeled
        edges = {
            "counted": [edge_named(labeled, edge) for edge in division.counts],
            "marked": [edge_named(labeled, edge) for edge in division.marked],
            "chosen": [] if chosen is None else [int(labeled.side_edge[chosen])],
        }
        for name, colour, width, _ in EDGE_MARKS:
            self._drawing.show_sides(name, labeled.edge_side[edges[name]], colour, width)
        self._show_numbers(np.array(edges["counted"] + edges["chosen"], dtype=np.int64), along)
        return [LegendEntry(words, (colour,), line=True) for name, colour, _, words in EDGE_MARKS if edges[name]]

    def _show_numbers(self, edges: IntArray, along: IntArray | None) -> None:
        """Write the numbers of some edges beside them."""
        edges = np.unique(edges)[:MOST_NUMBERS]
        if along is None or not len(edges):
            self._scene.remove("numbers")
            return
        mesh, sides = self._labeled, self._labeled.edge_side[edges]
        middles = (mesh.corner_position[sides] + mesh.corner_position[mesh.side_next[sides]]) / 2
        self._scene.show("numbers", Labels(middles, tuple(str(count) for count in along[edges].tolist())))
