# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Stitches that must not move; the user chooses them by clicks and rectangles."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING

import numpy as np

from stitchmesh.app.controls.html_pieces import paragraph
from stitchmesh.app.pages.yarns.settings import YarnSettings
from stitchmesh.app.pages.yarns.yarn_view import GarmentYarnView
from stitchmesh.app.scene.scene import Pick, ScreenBox
from stitchmesh.errors import ParameterError
from stitchmesh.markup import Markup
from stitchmesh.yarn import YarnSet
from stitchmesh.yarn.picking import pick_yarn, yarn_picking_table

if TYPE_CHECKING:
    from stitchmesh.app.application import App

HINT = "A click holds a stitch in its place or frees it; shift and drag holds all in a box"


class PinPanel:
    """Controls of the pins."""

    def __init__(
        self, app: App, view: GarmentYarnView, settings: Callable[[], YarnSettings], changed: Callable[..., None]
    ) -> None:
        """Make the controls.

        Args:
            app: the application.
            view: shows the yarns, and marks the pins.
            settings: returns the present settings.
            changed: called with the changed fields of the settings.
        """
        self._view, self._settings, self._changed = view, settings, changed
        controls = app.controls
        with controls.group("Pins", opened=False):
            self._text = controls.html(Markup())
            self._by_click = controls.toggle("Pin by clicking", HINT, False)
            self._remove = controls.button("Remove all pins", "No stitch is held", lambda: self._set([]))
        self._show()

    def picked(self, pick: Pick) -> None:
        """Pin the stitch under the pointer, or free it.

        Raises:
            ParameterError: the yarn under the pointer belongs to no stitch.
        """
        yarns = self._view.yarns
        if not self._by_click.value or yarns is None:
            return
        place = pick_yarn(yarn_picking_table(yarns), pick.ray_origin, pick.ray_direction)
        if place is None:
            return
        # A segment extends approximately from its second to its third control point.
        face = int(yarns.face[yarns.segment_points[place.segment, 1]])
        if face < 0:
            raise ParameterError(f"pin: this piece of yarn {place.yarn} belongs to no stitch; click a stitch beside it")
        self._set(set(self._settings().pins) ^ {face})

    def boxed(self, box: ScreenBox) -> None:
        """Pin all stitches in a rectangle."""
        yarns = self._view.yarns
        if self._by_click.value and yarns is not None:
            faces = np.unique(yarns.face[box.inside(yarns.points) & (yarns.face >= 0)])
            self._set({*self._settings().pins, *faces.tolist()})

    def _set(self, faces: Sequence[int] | set[int]) -> None:
        self._changed(pins=tuple(sorted(faces)))
        self._show()

    def _show(self) -> None:
        pins = self._settings().pins
        self._text.content = paragraph(f"{len(pins)} stitch{'' if len(pins) == 1 else 'es'} held")
        self._remove.visible = bool(pins)
        self._view.show_pins(pins)


def check_pins(faces: Sequence[int], yarns: YarnSet) -> None:
    """Check that pinned stitches have yarns.

    Raises:
        ParameterError: a stitch has no yarn, for example because the user has edited the fabric.
    """
    unknown = np.setdiff1d(faces, yarns.face)
    if len(unknown):
        raise ParameterError(f"pins: stitch {unknown[0]:g} does not exist any more; remove all pins, and pin again")
