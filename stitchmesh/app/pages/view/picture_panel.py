# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The controls that save what the scene shows as a picture."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from stitchmesh.app.application import App

LARGEST = 4096
"""Largest side of a saved picture [pixels]."""


class PicturePanel:
    """The group Picture."""

    def __init__(self, app: App) -> None:
        """Make the controls."""
        self._app, controls = app, app.controls
        with controls.group("Picture", opened=False):
            self._width = controls.number(
                "Width", "Width of the picture [pixels].", 1600, _nothing, least=64, most=LARGEST, step=1
            )
            self._height = controls.number(
                "Height", "Height of the picture [pixels].", 1000, _nothing, least=64, most=LARGEST, step=1
            )
            controls.button("Save picture", "Save what the scene shows as a PNG file.", self._save)

    def _save(self) -> None:
        picture = self._app.scene.screenshot(int(self._width.value), int(self._height.value))
        self._app.download("view.png", picture)


def _nothing(value: float) -> None:
    """Do nothing; the value is read when it is needed."""
