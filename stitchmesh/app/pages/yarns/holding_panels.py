# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""What holds the yarns: a body, whose file the project keeps, and stitches that the user pins by clicks or boxes."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING

import numpy as np

from stitchmesh.app.controls.html_pieces import paragraph
from stitchmesh.app.pages.typed import BODY_SUFFIXES
from stitchmesh.app.pages.yarns.settings import YarnSettings, body_path
from stitchmesh.app.pages.yarns.yarn_view import GarmentYarnView
from stitchmesh.app.scene.scene import Pick, ScreenBox
from stitchmesh.errors import ParameterError
from stitchmesh.io.atomic import temporary_file, write_bytes
from stitchmesh.io.garments import read_body
from stitchmesh.markup import Markup
from stitchmesh.yarn import YarnSet
from stitchmesh.yarnrelax.energies.body import Body

if TYPE_CHECKING:
    from stitchmesh.app.application import App



class BodyPanel:
    """Controls of the body."""

    def __init__(
        self, app: App, view: GarmentYarnView, settings: Callable[[], YarnSettings], changed: Callable[..., None]
    ) -> None:
        """Make the controls, and draw the body; ``changed`` is called with the changed fields of the settings."""
        self._app, self._view, self._settings, self._changed = app, view, settings, changed
        controls = app.controls
        with controls.group("Body", opened=False):
            self._text = controls.html(Markup())
            hint = "A mesh that the yarns lie on and do not enter"
            controls.upload("Choose a body", hint, BODY_SUFFIXES, self._receive)
            self._remove = controls.button("Remove the body", "Relax without a body", lambda: self._set(""))
        self._show()

    def _receive(self, name: str, content: bytes) -> None:
        """Keep the mesh of a body in the project if it is valid; otherwise a body of the same name stays."""
        path = body_path(self._app.project.folder, name)
        with temporary_file(name, content) as file:
            Body(read_body(file, unit=self._settings().body_unit, up=self._app.project.up))
        write_bytes(path, content)
        self._set(path.name)

    def _set(self, name: str) -> None:
        self._changed(body=name)
        self._show()

    def _show(self) -> None:
        settings = self._settings()
        self._text.content = paragraph(f"Body: {settings.body or 'none'}")
        self._remove.visible = bool(settings.body)
        path = body_path(self._app.project.folder, settings.body)
        if settings.body and not path.exists():  # Someone has changed the folder of the project by hand.
            self._changed(body="")
            self._app.notice(f"The body {settings.body} is not in the project any more; choose it again.", "warning")
            return self._show()
        up = self._app.project.up
        self._view.show_body(read_body(path, unit=settings.body_unit, up=up) if settings.body else None)


class PinPanel:
    """Controls of the pins."""

    def __init__(
        self, app: App, view: GarmentYarnView, settings: Callable[[], YarnSettings], changed: Callable[..., None]
    ) -> None:
        """Make the controls; ``changed`` is called with the changed fields of the settings."""
        self._view, self._settings, self._changed = view, settings, changed
        controls = app.controls
        with controls.group("Pins", opened=False):
            self._text = controls.html(Markup())
            hint = "A click holds a stitch in its place or frees it; shift and drag holds all in a box"
            self._by_click = controls.toggle("Pin by clicking", hint, False)
            self._remove = controls.button("Remove all pins", "No stitch is held", lambda: self._set([]))
        self._show()

    def picked(self, pick: Pick) -> None:
        """Pin the stitch under the pointer, or free it.

        Raises:
            ParameterError: the yarn under the pointer belongs to no stitch.
        """
        view = self._view.view
        met = None if view is None else view.pick(pick.ray_origin, pick.ray_direction, None)
        if not self._by_click.value or view is None or met is None or met.yarn is None:
            return
        # A segment extends approximately from its second to its third control point.
        face = int(view.yarns.face[view.yarns.segment_points[met.yarn.segment, 1]])
        if face < 0:
            found = f"this piece of yarn {met.yarn.yarn} belongs to no stitch"
            raise ParameterError(f"pin: {found}; click a stitch beside it")
        self._set(set(self._settings().pins) ^ {face})

    def boxed(self, box: ScreenBox) -> None:
        """Pin all stitches in a rectangle."""
        if self._by_click.value and self._view.view is not None:
            yarns = self._view.view.yarns
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
