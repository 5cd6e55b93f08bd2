# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""A page: the controls and the drawings of one task of the user."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Any, ClassVar, TypeVar

from stitchmesh.app.scene.scene import Pick, ScreenBox, Stroke
from stitchmesh.errors import StitchMeshError

if TYPE_CHECKING:
    from stitchmesh.app.application import App
S = TypeVar("S")
NO_MESH = "There is no mesh yet. Open the page Project and import one, or choose an example."
NO_STITCHES = "There are no stitches yet. Divide the labeled mesh into stitches first, on the page Divide."
HAS_STITCHES = "The imported file holds stitches already. Go on with Edit."
"""The reason why pages that work on a mesh are not available."""


class Page:
    """A page of the application. All methods run in the event thread.

    A page is a state and a view of it. The state is one frozen value, which holds the user's choices. An action of the
    user makes the next state, by ``dataclasses.replace`` or by a method of the state, and the page shows it. A value
    with undo is an ``UndoHistory`` in the state. The settings of the project hold the lasting part of the state. Beside
    its state, a page keeps only its controls, its drawings and its running work.
    """

    name: ClassVar[str]
    """Name in the navigation."""
    hint: ClassVar[str]
    """One line that tells the user what to do on this page."""

    needs: ClassVar[str] = "Project"
    """Name of the page that makes what this page needs."""
    left_title: ClassVar[str] = "Chart"
    """Title of the left panel, if the page has controls there."""
    left_width: ClassVar[int] = 350
    """Width of the panel on the left [pixels]."""

    def __init__(self, app: App) -> None:
        """Make the page; nothing is shown yet."""
        self.app = app

    def keep_settings(self, **values: Any) -> None:
        """Keep values in the settings that the project has for this page."""
        self.app.project.set_settings(self.name, {**self.app.project.settings(self.name), **values})

    def saved_state(self, read: Callable[[Mapping[str, Any]], S], what: str) -> S:
        """Return the state that the project has kept for this page; if it is damaged, say so and begin anew.

        Args:
            read: returns the state from a table of settings; from an empty table, the state of a new project.
            what: name of the thing that the state describes.
        """
        try:
            return read(self.app.project.settings(self.name))
        except StitchMeshError as error:
            self.app.notice(f"the saved {what} cannot be shown ({error}); a new one begins", "warning")
            return read({})

    def unavailable(self) -> str | None:
        """Return what the user must do first, and why, while the page has nothing to show; None if it can be built."""
        return None

    def build(self) -> None:
        """Make the controls and the drawings; there are none before."""

    def refresh(self) -> None:
        """Show the project after a change."""

    def leave(self) -> None:
        """End the work of the open page; controls and drawings are removed afterwards."""

    def picked(self, pick: Pick) -> None:
        """Handle a click in the scene."""

    def stroked(self, stroke: Stroke) -> None:
        """Handle a drag that began on a surface that takes strokes."""

    def boxed(self, box: ScreenBox) -> None:
        """Handle a rectangle that the user drew with the shift key."""

    def camera_moved(self) -> None:
        """Handle a movement of the camera; called at most ten times a second."""
