# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""A tool of the page Edit: what a click, a drag and a rectangle on the fabric do, and which side a click means."""

from __future__ import annotations

from typing import ClassVar

import numpy as np

from stitchmesh.app.controls.controls import Controls
from stitchmesh.app.pages.edit.edit_session import EditSession
from stitchmesh.app.scene.scene import Pick, Stroke
from stitchmesh.errors import ParameterError, StitchMeshError
from stitchmesh.mesh import BORDER, BOTTOM, TOP, IntArray, StitchMesh
from stitchmesh.mesh.picking import PickedPlace


class Tool:
    """A tool. By default, a rectangle on the screen selects stitches."""

    name: ClassVar[str]
    """Name of the tool."""
    hint: ClassVar[str]
    """One line that tells the user what to do with the mouse."""
    key: ClassVar[str]
    """Key that takes up the tool."""
    takes_strokes: ClassVar[bool] = True
    """Whether a drag on the fabric belongs to the tool; otherwise it turns the view."""

    def __init__(self, session: EditSession) -> None:
        """Keep the state that all tools share."""
        self.session = session

    def build(self, controls: Controls) -> None:
        """Make the controls of the tool."""

    def taken_up(self) -> None:
        """Begin, after the user has chosen the tool or opened the page with it."""

    def laid_down(self) -> None:
        """End, before the user takes up another tool or leaves the page."""

    def refresh(self) -> None:
        """Show the fabric after a change."""

    def clicked(self, place: PickedPlace, pick: Pick) -> None:
        """Handle a click on the fabric."""

    def stroked(self, stroke: Stroke) -> None:
        """Handle one moment of a drag on the fabric."""

    def boxed(self, faces: IntArray) -> None:
        """Handle the faces in a rectangle on the screen."""
        self.session.choose(faces)

    def side_at(self, place: PickedPlace, kind: str) -> int | None:
        """Return the side of a kind that is nearest to a place; if there is none, refuse the place and return None."""
        try:
            return nearest_side(self.session.fabric, place, kind)
        except StitchMeshError as error:
            self.session.refuse(np.array([place.face]), str(error))
            return None


def nearest_side(fabric: StitchMesh, place: PickedPlace, kind: str) -> int:
    """Return the side of a kind that is nearest to a place, among the sides of its face.

    Args:
        fabric: the fabric.
        place: the place.
        kind: ``course side``, ``wale side``, ``top side`` (of the face, or of the face below), or ``border side``.

    Raises:
        ParameterError: the face has no side of this kind.
    """
    sides = fabric.sides_of(np.array([place.face]))
    role = fabric.role_of(sides)
    if kind == "wale side":
        fitting = sides[role % 2 == 1]
    elif kind == "border side":
        fitting = sides[fabric.twin[sides] == BORDER]
    elif kind == "top side":
        return _nearest_top_side(fabric, place, sides, role)
    else:
        fitting = sides[role % 2 == 0]
    if not len(fitting):
        raise ParameterError(f"face {place.face}: has no {kind}; click another stitch")
    return _nearest(fabric, place, fitting)


def _nearest_top_side(fabric: StitchMesh, place: PickedPlace, sides: IntArray, role: IntArray) -> int:
    """Return the nearest top side: of the face, or of a face below across a bottom side."""
    below = sides[role == BOTTOM]
    below = below[fabric.twin[below] != BORDER]
    below = below[fabric.role_of(fabric.twin[below]) == TOP] if len(below) else below
    fitting = np.concatenate([sides[role == TOP], below])
    if not len(fitting):
        raise ParameterError(f"face {place.face}: has no loop above or below; click another stitch")
    side = _nearest(fabric, place, fitting)
    return side if fabric.role_of(side) == TOP else int(fabric.twin[side])


def _nearest(fabric: StitchMesh, place: PickedPlace, sides: IntArray) -> int:
    start, end = fabric.corner_position[sides], fabric.corner_position[fabric.side_next[sides]]
    along = end - start
    length = np.einsum("ij,ij->i", along, along)
    share = np.clip(np.einsum("ij,ij->i", place.point - start, along) / np.where(length > 0, length, 1.0), 0.0, 1.0)
    distance = np.linalg.norm(start + share[:, None] * along - place.point, axis=1)
    return int(sides[distance.argmin()])
