# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The body on which the yarns lie; the project keeps its file."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

from stitchmesh.app.controls.html_pieces import paragraph
from stitchmesh.app.pages.yarns.settings import YarnSettings, body_path
from stitchmesh.app.pages.yarns.yarn_view import GarmentYarnView
from stitchmesh.io.atomic import temporary_file, write_bytes
from stitchmesh.io.garments import read_body
from stitchmesh.markup import Markup
from stitchmesh.yarnrelax.energies.body import Body

if TYPE_CHECKING:
    from stitchmesh.app.application import App

SUFFIXES = (".obj", ".ply", ".off", ".stl")
"""Suffixes of the files of bodies."""
HINT = "A mesh that the yarns lie on and do not enter"


class BodyPanel:
    """Controls of the body."""

    def __init__(
        self, app: App, view: GarmentYarnView, settings: Callable[[], YarnSettings], changed: Callable[..., None]
    ) -> None:
        """Make the controls, and draw the body.

        Args:
            app: the application.
            view: draws the body.
            settings: returns the present settings.
            changed: called with the changed fields of the settings.
        """
        self._app, self._view, self._settings, self._changed = app, view, settings, changed
        controls = app.controls
        with controls.group("Body", opened=False):
            self._text = controls.html(Markup())
            controls.upload("Choose a body", HINT, SUFFIXES, self._receive)
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
