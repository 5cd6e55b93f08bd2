# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The display of the application: the scene, two panels, notices and downloads."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Literal, Protocol

from stitchmesh.app.controls.controls import Controls
from stitchmesh.app.event_queue import EventQueue
from stitchmesh.app.scene.scene import DrawingScene, Pick, ScreenBox, Stroke

NoticeKind = Literal["info", "warning", "error"]


@dataclass(frozen=True)
class Listener:
    """Functions that the front calls, in the event thread."""

    picked: Callable[[Pick], object]
    stroked: Callable[[Stroke], object]
    boxed: Callable[[ScreenBox], object]
    camera_moved: Callable[[], object]


class Front(Protocol):
    """The browser side of the application; tests have a stand-in without a browser."""

    queue: EventQueue
    """The queue in which all functions are called."""

    @property
    def scene(self) -> DrawingScene:
        """The scene."""

    @property
    def navigation(self) -> Controls:
        """Controls above the controls of the page."""

    @property
    def controls(self) -> Controls:
        """Controls of the page, in the right panel."""

    @property
    def left_controls(self) -> Controls:
        """Controls in the left panel, which is visible while it has any."""

    def listen(self, listener: Listener) -> None:
        """Call the functions of a listener from now on."""

    def notice(self, title: str, text: str, kind: NoticeKind) -> None:
        """Show a message in each browser."""

    @property
    def acting_client(self) -> int | None:
        """Number of the browser that asked for the call that the event thread runs now; None if no browser did."""

    def download(self, name: str, content: bytes, client: int | None = None) -> None:
        """Send a file to a browser, by default to that of the current event; without one, to all browsers."""

    def set_dark(self, dark: bool) -> None:
        """Show dark or light colours."""

    def name_left_panel(self, title: str, width: int) -> None:
        """Give the panel on the left a title and a width [pixels]."""

    def close(self) -> None:
        """End all connections."""
