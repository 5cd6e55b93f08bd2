# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The drawing of a scene before it runs: the cloth in the colours of its region, held vertices, bodies and a box."""

from __future__ import annotations

from itertools import chain
from typing import Literal

import numpy as np

from stitchmesh.app.controls.html_pieces import LegendEntry, colour_bar, legend
from stitchmesh.app.pages.drape.opened_scene import OpenedScene
from stitchmesh.app.pages.view.draped_view import draw_bodies
from stitchmesh.app.pages.view.thing_view import ClipBox
from stitchmesh.app.scene.drawing import Colour, Colours, Lines, Surface, point_marks
from stitchmesh.app.scene.scene import DrawingScene
from stitchmesh.markup import Markup
from stitchmesh.mesh import IntArray, Mesh
from stitchmesh.mesh.face_triangles import face_triangles
from stitchmesh.mixed.enrichment.region import HYBRID, TRIANGLES, YARNS
from stitchmesh.render.draped.colouring import ALPHA_SCALE
from stitchmesh.render.surface import lifted_corners

ClothColour = Literal["Region", "Alpha"]
COLOURS: tuple[ClothColour, ...] = ("Region", "Alpha")
KIND_COLOURS = ALPHA_SCALE.table(3)
"""Colours of triangles without yarns, in the hybrid region, and with yarns alone; sRGB."""
ALLOWED = np.array([170, 150, 190], dtype=np.uint8)
"""Colour of triangles that an automatic region may fill with yarns."""
ADDED: Colour = (222, 124, 20)
REMOVED: Colour = (20, 96, 170)
"""Colours of triangles that a drag adds to the region, and of triangles that it removes."""
HELD: Colour = (20, 96, 170)


class ClothDrawing:
    """Draws one scene; it sends positions again only for another cloth."""

    def __init__(self, scene: DrawingScene) -> None:
        """Draw nothing yet."""
        self._scene = scene
        self._mesh: Mesh | None = None
        self._bodies = 0
        self._loads: tuple[object, object] = (None, None)

    def show(self, opened: OpenedScene, colour: ClothColour, *, takes_strokes: bool) -> None:
        """Draw a scene; with ``takes_strokes`` a drag on the cloth paints, and otherwise it turns the view."""
        mesh = opened.mesh
        if self._mesh is not mesh:
            self._mesh, self._lifted = mesh, lifted_corners(mesh)
            self._corners = face_triangles(mesh).corners
            self._show_edges(mesh)
        loads = opened.prepared.held, opened.prepared.bodies
        if any(own is not known for own, known in zip(loads, self._loads, strict=True)):
            self._loads = loads
            self._show_held(opened)
            self._show_bodies(opened)
        if colour == "Alpha":
            at_corners = ALPHA_SCALE.of(opened.region.vertex_alpha[mesh.face_vertex])
            self._scene.show("cloth", Surface(
                mesh.corner_position, self._corners, Colours.of(at_corners), flat=False, takes_strokes=takes_strokes
            ))  # fmt: skip
            return
        of_faces = Colours.of(region_colours(opened))
        self._scene.show("cloth", Surface(mesh.corner_position, self._corners, of_faces, takes_strokes=takes_strokes))

    def preview(self, triangles: IntArray, *, adds: bool) -> None:
        """Mark the triangles that a drag covers; without any, remove the mark."""
        if self._mesh is None or not len(triangles):
            self._scene.remove("painted")
            return
        corners = np.arange(3 * len(triangles)).reshape(-1, 3)
        points = self._lifted[self._corners[triangles]].reshape(-1, 3)
        self._scene.show("painted", Surface(points, corners, ADDED if adds else REMOVED, opacity=0.6))

    def show_box(self, box: ClipBox | None) -> None:
        """Draw the box that the user is about to choose; None removes it."""
        self._scene.show("box", None if box is None else box.edges())

    def look(self) -> None:
        """Show the whole cloth."""
        if self._mesh is not None:
            self._scene.look_at(self._mesh.vertices.min(axis=0), self._mesh.vertices.max(axis=0))

    def clear(self) -> None:
        """Remove everything."""
        bodies = (f"body {number}" for number in range(self._bodies))
        for name in chain(("cloth", "cloth edges", "held", "held motion", "painted", "box"), bodies):
            self._scene.remove(name)
        self._mesh, self._loads = None, (None, None)

    def _show_edges(self, mesh: Mesh) -> None:
        if mesh.face_count <= 12_000:  # more edges hide the colours
            ends = np.stack([mesh.edge_side, mesh.side_next[mesh.edge_side]], axis=1)
            self._scene.show("cloth edges", Lines(self._lifted[ends], (60, 60, 66), 1.0))
        else:
            self._scene.remove("cloth edges")

    def _show_held(self, opened: OpenedScene) -> None:
        """Mark the held vertices, and draw lines from the moving ones to their places at the end."""
        mesh, parts = opened.mesh, opened.prepared.held
        held = np.unique(np.concatenate([np.zeros(0, dtype=np.int64), *(one.vertices for one in parts)]))
        size = 0.12 * float(mesh.side_length.mean())
        self._scene.show("held", point_marks(mesh.vertices[held], size, HELD))
        starts = [mesh.vertices[one.vertices] for one in parts]
        ends = [one.motion.places_at(at, opened.scene.duration) for one, at in zip(parts, starts, strict=True)]
        ways = np.concatenate([np.zeros((0, 2, 3)), *(np.stack(two, axis=1) for two in zip(starts, ends, strict=True))])
        ways = ways[np.any(ways[:, 0] != ways[:, 1], axis=1)]
        self._scene.show("held motion", Lines(ways[:: len(ways) // 200 + 1], HELD, 1.5))

    def _show_bodies(self, opened: OpenedScene) -> None:
        bodies = opened.prepared.bodies
        for number in range(len(bodies), self._bodies):
            self._scene.remove(f"body {number}")
        draw_bodies(self._scene, bodies, 0.0, "body")
        self._bodies = len(bodies)


def region_colours(opened: OpenedScene) -> np.ndarray:
    """Return the colour of each triangle (sRGB), shape (T, 3), which shows what is simulated there."""
    colours = KIND_COLOURS[opened.region.triangle_kind]
    if opened.scene.region.yarns == "automatic":
        colours[opened.marked] = ALLOWED
    return colours


def legend_of(opened: OpenedScene, colour: ClothColour) -> Markup:
    """Return the legend of the colours as HTML."""
    if colour == "Alpha":
        return colour_bar(ALPHA_SCALE.table(9), ("0 triangles", "0.5", "1 yarns"), "Alpha")
    names = {TRIANGLES: "triangles", HYBRID: "triangles and yarns (hybrid)", YARNS: "yarns"}
    entries = [LegendEntry(text, (_rgb(KIND_COLOURS[kind]),)) for kind, text in names.items()]
    if opened.scene.region.yarns == "automatic" and len(opened.marked):
        entries.append(LegendEntry("where the automatic region may be", (_rgb(ALLOWED),)))
    return legend(entries, "What is simulated")


def _rgb(colour: np.ndarray) -> Colour:
    red, green, blue = colour.tolist()
    return red, green, blue
