# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Painting of the region: a brush adds or removes triangles by clicks, drags and rectangles on the screen."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Literal, get_args

import numpy as np

from stitchmesh.app.controls.controls import Controls
from stitchmesh.app.pages.drape.cloth_drawing import ClothDrawing
from stitchmesh.app.pages.drape.drape_session import DrapeSession
from stitchmesh.app.pages.drape.opened_scene import NO_TRIANGLES
from stitchmesh.app.scene.pointer import DragPath, Pointer, visible_faces
from stitchmesh.app.scene.scene import Pick, ScreenBox, Stroke
from stitchmesh.mesh import BORDER, FloatArray, IntArray
from stitchmesh.mesh.picking import PickedPlace
from stitchmesh.mixed.cloth.cloth import Cloth, border_sides
from stitchmesh.mixed.scene.region_section import with_triangles, without_triangles

ClothBrush = Literal["Circle", "Triangle", "Border", "Panel"]
BRUSHES: tuple[ClothBrush, ...] = get_args(ClothBrush)


def covered_triangles(
    cloth: Cloth, vertices: FloatArray, brush: ClothBrush, path: Sequence[PickedPlace], radius: float
) -> IntArray:
    """Return the triangles that a brush covers, ascending.

    Args:
        cloth: the cloth.
        vertices: present positions of the vertices of the cloth [cm], shape (V, 3).
        brush: ``Triangle``, the ``Panel`` of each triangle, the side of the ``Border`` nearest to each place, or a
            ``Circle`` around each place. A circle stays on its layer: it does not paint another layer behind it.
        path: places under the pointer.
        radius: radius of the circle [cm].
    """
    faces = np.unique(np.array([place.face for place in path], dtype=np.int64))
    if brush == "Triangle":
        return faces
    if brush == "Panel":
        return np.flatnonzero(np.isin(cloth.panel, cloth.panel[faces]))
    if brush == "Border":
        return _along_border(cloth, vertices, path)
    centre = vertices[cloth.triangles].mean(axis=1)
    covered: set[int] = set()
    for place in path:
        covered.update(_connected_within(cloth, centre, place, radius))
    return np.array(sorted(covered), dtype=np.int64)


def _along_border(cloth: Cloth, vertices: FloatArray, path: Sequence[PickedPlace]) -> IntArray:
    """Return the triangles with an edge on the border side nearest to each place; none without a border."""
    parts = border_sides(cloth)
    found = [np.zeros(0, dtype=np.int64)]
    for place in path if parts else ():
        distance = [
            np.linalg.norm(vertices[cloth.side_vertices[part]].mean(axis=1) - place.point, axis=1).min()
            for part in parts
        ]
        found.append(parts[int(np.argmin(distance))] // 3)
    return np.unique(np.concatenate(found))


def _connected_within(cloth: Cloth, centre: FloatArray, place: PickedPlace, radius: float) -> set[int]:
    """Return the triangle at a place, and those it leads to across edges within a ball around the place."""
    near = np.linalg.norm(centre - place.point, axis=1) <= radius
    found, edge = {place.face}, [place.face]
    while edge:
        beside = cloth.twin.reshape(-1, 3)[np.array(edge)].ravel()
        beside = np.unique(beside[beside != BORDER] // 3)
        edge = [face for face in beside[near[beside]].tolist() if face not in found]
        found.update(edge)
    return found


LOOK, ADD, REMOVE = "turns the view", "adds to the region", "takes out of the region"
HOLD, FREE = "holds the cloth", "lets go of the cloth"
DRAGS = (LOOK, ADD, REMOVE, HOLD, FREE)
"""The choices of what a drag on the cloth does."""


class PaintTool:
    """The brush; a drag paints at once and is one change."""

    def __init__(self, session: DrapeSession, drawing: ClothDrawing) -> None:
        """Begin with drags that turn the view."""
        self._session, self._drawing = session, drawing
        self.hold: Callable[..., object] = lambda triangles, holds: None
        """Called with triangles, and whether to hold them or let them go, when a drag does so."""
        self._does, self._brush = LOOK, BRUSHES[0]
        self._drag, self._covered, self._seen = DragPath(), NO_TRIANGLES, 0
        self._pointer: Pointer | None = None
        self._stroking = -1

    def build(self, controls: Controls) -> None:
        """Make the controls."""
        hint = "What a drag on the cloth does; shift+drag takes a rectangle of the screen."
        controls.choice("A drag", hint, DRAGS, self._does, self._set_drag)
        self._brush_choice = controls.choice(
            "Brush", "What the brush covers: a circle on the cloth, one triangle, a side of the border, or a panel.",
            BRUSHES, self._brush, self._set_brush,
        )  # fmt: skip
        self._radius = controls.number(
            "Radius", "Radius of the brush Circle [cm].", 1.0, least=0.01, most=1000.0, step=0.1
        )
        self._show_controls()

    @property
    def paints(self) -> bool:
        """Whether a drag on the cloth paints."""
        return self._does != LOOK

    def refresh(self) -> None:
        """Follow a changed scene; another cloth gets a circle that fits its size."""
        opened = self._session.opened
        if opened is not None and (self._pointer is None or self._pointer.mesh is not opened.mesh):
            self._pointer = Pointer(opened.mesh)
            self._radius.value = round(0.8 * float(opened.mesh.side_length.mean()), 2)
        self._end()

    def clicked(self, pick: Pick) -> None:
        """Paint at a click."""
        place = None if self._pointer is None else self._pointer.place(pick)
        if self.paints and place is not None:
            self._take(self._covered_by([place]))

    def stroked(self, stroke: Stroke) -> None:
        """Show the triangles that a drag has covered so far, and paint them at its end."""
        if stroke.phase == "start":
            self._end()
            self._stroking = stroke.client
        if self._pointer is None or stroke.client != self._stroking or not self.paints:
            return  # Another browser has begun a drag since then.
        places = self._drag.follow(stroke, self._pointer)
        self._covered = np.union1d(self._covered, self._covered_by(places[self._seen :]))
        # The next place may replace the last one, if both are on one triangle.
        self._seen = max(len(places) - 1, 0)
        if stroke.phase == "end":
            covered = self._covered
            self._end()
            self._take(covered)
        else:
            self._drawing.preview(self._covered, adds=self._does in (ADD, HOLD))

    def boxed(self, box: ScreenBox) -> None:
        """Paint the triangles in a rectangle of the screen that face the camera."""
        opened = self._session.opened
        if opened is not None:
            self._take(visible_faces(opened.mesh, box))

    def _covered_by(self, places: list[PickedPlace]) -> IntArray:
        opened = self._session.opened
        if opened is None or not places:
            return NO_TRIANGLES
        return covered_triangles(
            opened.cloth, opened.mesh.vertices, self._brush, places, float(self._radius.value)
        )

    def _take(self, triangles: IntArray) -> None:
        if not len(triangles):
            return
        if self._does in (HOLD, FREE):
            self.hold(triangles, holds=self._does == HOLD)
            return
        paint = without_triangles if self._does == REMOVE else with_triangles
        self._session.change_region(lambda section, cloth: paint(section, cloth, triangles))

    def _end(self) -> None:
        self._drag.clear()
        self._covered, self._seen = NO_TRIANGLES, 0
        self._drawing.preview(NO_TRIANGLES, adds=True)

    def _set_drag(self, does: str) -> None:
        self._does = does
        self._show_controls()
        self._session.show()

    def _set_brush(self, brush: str) -> None:
        self._brush = next(known for known in BRUSHES if known == brush)
        self._show_controls()

    def _show_controls(self) -> None:
        self._brush_choice.visible = self.paints
        self._radius.visible = self.paints and self._brush == "Circle"
