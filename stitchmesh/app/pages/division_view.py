# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""What the page Divide draws: the labeled mesh or its stitches, and the edges with numbers or marks."""

from __future__ import annotations

import numpy as np

from stitchmesh.app.controls.legend import LegendEntry
from stitchmesh.app.pages.divide_text import CHOSEN_COLOUR, COUNTED_COLOUR, MARKED_COLOUR, legend_of_stitches
from stitchmesh.app.pages.label_text import INK
from stitchmesh.app.project.division import Division
from stitchmesh.app.scene.drawing import Colour, Labels
from stitchmesh.app.scene.mesh_drawing import MeshDrawing
from stitchmesh.app.scene.scene import Scene
from stitchmesh.mesh import IntArray, StitchMesh
from stitchmesh.render.palette import stitch_colours
from stitchmesh.tessellate.counts import edge_named
from stitchmesh.yarn.colours import row_colours

STITCH_EDGE_COLOUR: Colour = (128, 120, 110)
"""Colour of the edges of stitches."""
MOST_NUMBERS = 150
"""Number of edges whose numbers are shown."""
MOST_EDGES_DRAWN = 12_000
"""Number of stitches up to which their edges are drawn; the lines of more stitches hide the colours."""
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
            for name in ("stitches", "stitch edges"):
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
            drawing = MeshDrawing(self._scene, fabric)
            drawing.show_faces("stitches", stitch_colours(fabric.stitch, fabric.row))
            if fabric.face_count <= MOST_EDGES_DRAWN:
                drawing.show_sides("stitch edges", fabric.edge_side, STITCH_EDGE_COLOUR, 1.0)
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
