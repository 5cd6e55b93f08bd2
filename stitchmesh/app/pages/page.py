# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""A page: the controls and the drawings of one task of the user."""

from __future__ import annotations

from typing import TYPE_CHECKING, ClassVar

from stitchmesh.app.scene.scene import Pick, ScreenBox, Stroke

if TYPE_CHECKING:
    from stitchmesh.app.application import App


class Page:
    """A page of the application. All methods run in the event thread.

    A page is a state and a view of it. The state is one frozen value: what the user has chosen. An action of the user
    makes the next state, by ``dataclasses.replace`` or by a method of the state, and the page shows it. A value with
    undo is an ``UndoHistory`` in the state. What lasts of the state stands in the settings of the project. Beside its
    state, a page keeps only its controls, its drawings and what runs.
    """

    name: ClassVar[str]
    """Name in the navigation."""
    hint: ClassVar[str]
    """One line that says what to do on this page."""

    needs: ClassVar[str] = "Project"
    """Name of the page that makes what this page needs."""
    left_title: ClassVar[str] = "Chart"
    """Title of the panel on the left, if the page has controls there."""
    left_width: ClassVar[int] = 350
    """Width of the panel on the left [pixels]."""

    def __init__(self, app: App) -> None:
        """Make the page; nothing is shown yet."""
        self.app = app

    def unavailable(self) -> str | None:
        """Return why the page has nothing to show yet and what to do first; None if it can be built."""
        return None

    def build(self) -> None:
        """Make the controls and draw; both are empty before."""

    def refresh(self) -> None:
        """Show the project after it changed."""

    def leave(self) -> None:
        """End what belongs to the open page; controls and drawings are removed afterwards."""

    def picked(self, pick: Pick) -> None:
        """Handle a click in the scene."""

    def stroked(self, stroke: Stroke) -> None:
        """Handle a drag that began on a surface that takes strokes."""

    def boxed(self, box: ScreenBox) -> None:
        """Handle a rectangle that was drawn with the shift key."""

    def camera_moved(self) -> None:
        """Handle a camera that moved; called at most ten times a second."""
