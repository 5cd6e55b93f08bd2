# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""A scene that draws nothing and only keeps its drawings, for pages without a browser."""

from __future__ import annotations

from stitchmesh.app.scene.camera_view import CameraView
from stitchmesh.app.scene.drawing import Drawing, shows_nothing
from stitchmesh.app.scene.scene import ViewName
from stitchmesh.errors import DisplayError
from stitchmesh.mesh import FloatArray


class NullScene:
    """A ``Scene`` without a screen."""

    def __init__(self) -> None:
        """Start empty."""
        self.drawings: dict[str, Drawing] = {}
        """The present drawings, by name."""
        self.shown: tuple[FloatArray, FloatArray, ViewName] | None = None
        """The box and the view of the last ``look_at``."""
        self.views: list[CameraView] = []
        """The cameras that ``cameras`` returns."""

    def show(self, name: str, drawing: Drawing | None) -> None:
        """Remember a drawing."""
        if drawing is None or shows_nothing(drawing):
            self.remove(name)
        else:
            self.drawings[name] = drawing

    def remove(self, name: str) -> None:
        """Forget a drawing."""
        self.drawings.pop(name, None)

    def clear(self) -> None:
        """Forget all drawings."""
        self.drawings.clear()

    def look_at(self, low: FloatArray, high: FloatArray, view: ViewName | None = None) -> None:
        """Remember the box."""
        self.shown = low, high, view or "front"

    def cameras(self) -> list[CameraView]:
        """Return the cameras that were set."""
        return self.views

    def screenshot(self, width: int, height: int) -> bytes:
        """Raise DisplayError: there is no browser."""
        raise DisplayError(f"screenshot: no browser draws {width} x {height} pixels; open the page first")
