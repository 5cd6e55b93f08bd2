# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The front of the application in the browsers."""

from __future__ import annotations

import contextlib
import io
from typing import Any

import numpy as np
import viser

from stitchmesh.app.browser.bridge import Bridge
from stitchmesh.app.controls.value_guard import ValueGuard
from stitchmesh.app.controls.viser_controls import BLUE, ViserControls
from stitchmesh.app.event_queue import EventQueue
from stitchmesh.app.front import Listener, NoticeKind
from stitchmesh.app.page_messages import LARGEST_UPLOAD
from stitchmesh.app.scene.scene import Pick, ScreenBox
from stitchmesh.app.scene.viser_scene import ViserScene, modifier_of, view_of

FILE_PROBLEMS = {
    "suffix": "no upload of this page takes such a file",
    "page": "this page takes no files; open the page Project and drop the file there",
    "size": f"is larger than {LARGEST_UPLOAD // 2**20} MiB; give its path to the program at the start",
}
"""Reasons why a browser refuses a file."""
NOTICE_COLOURS: dict[NoticeKind, tuple[int, int, int]] = {
    "info": BLUE, "warning": (201, 125, 16), "error": (150, 35, 60),
}  # fmt: skip
NOTICE_SECONDS: dict[NoticeKind, float | None] = {"info": 6.0, "warning": 12.0, "error": 20.0}
"""Time for which a notice is visible."""


class ViserFront:
    """A ``Front`` in the browsers that are connected to a server of viser."""

    def __init__(self, server: viser.ViserServer) -> None:
        """Set up panels and scene."""
        self.server, self.queue = server, EventQueue()
        self._listener: Listener | None = None
        self.set_dark(False)
        server.gui.set_panel_label("StitchMesh")
        server.gui.main_panel.dock_right()
        server.gui.main_panel.set_width(350.0)  # CSS pixels
        self.bridge = Bridge(server)
        self.bridge.receive("drop", lambda message, client: self.queue.post(self._refuse_file, message))
        self.bridge.on_connect(lambda client: self.bridge.run(f"stitchmeshDrop.largest={LARGEST_UPLOAD};", client))
        self.scene = ViserScene(server, self.bridge, lambda stroke: self._post("stroked", stroke))
        guard = ValueGuard(server, self.queue)
        self.navigation = ViserControls(server, self.bridge, self.queue, guard)
        self.controls = ViserControls(server, self.bridge, self.queue, guard)
        self._left_panel = server.gui.add_panel(visible=False)
        self._left_tab = left = self._left_panel.add_tab("Chart")
        self._left_panel.dock_left()
        self._left_width = 0
        self.left_controls = ViserControls(
            server, self.bridge, self.queue, guard, container=lambda: left, on_change=self._show_left_panel
        )
        scene: Any = server.scene  # Viser's annotations leave out asynchronous functions, whose order viser keeps.
        scene.on_click()(self._click)
        scene.on_click(modifier="shift")(self._click)
        scene.on_click(modifier="cmd/ctrl")(self._click)
        scene.on_rect_select(modifier="shift")(self._box)
        server.on_client_connect(self._watch_camera)

    def _refuse_file(self, message: dict[str, Any]) -> None:
        """Report why a dropped or chosen file is refused."""
        name, reason = str(message.get("name", ""))[:200], FILE_PROBLEMS.get(str(message.get("problem")), "is refused")
        self.notice("Not possible", f"{name}: {reason}", "error")

    def listen(self, listener: Listener) -> None:
        """Call the functions of a listener from now on."""
        self._listener = listener

    def notice(self, title: str, text: str, kind: NoticeKind) -> None:
        """Show a message in each browser."""
        for client in self.server.get_clients().values():
            client.add_notification(
                title, text, color=NOTICE_COLOURS[kind], auto_close_seconds=NOTICE_SECONDS[kind], with_close_button=True
            )

    @property
    def acting_client(self) -> int | None:
        """Number of the browser that asked for the call that the event thread runs now."""
        return self.bridge.acting_client

    def download(self, name: str, content: bytes, client: int | None = None) -> None:
        """Send a file to a browser, by default to the one that asked for it; to all browsers if none did."""
        clients = self.server.get_clients()
        wanted = self.acting_client if client is None else client
        if wanted is not None:
            clients = {number: each for number, each in clients.items() if number == wanted}
        for each in clients.values():
            each.send_file_download(name, content, save_immediately=True)

    def set_dark(self, dark: bool) -> None:
        """Show dark or light colours."""
        self.server.gui.configure_theme(dark_mode=dark, show_logo=False, show_share_button=False, brand_color=BLUE)

    def close(self) -> None:
        """End all connections."""
        with contextlib.redirect_stdout(io.StringIO()):  # Viser prints a line.
            self.server.stop()

    def _post(self, name: str, *arguments: object) -> None:
        """Call a function of the listener in the event thread."""
        if self._listener is not None:
            self.queue.post(getattr(self._listener, name), *arguments)

    async def _click(self, event: viser.SceneClickEvent) -> None:
        ray = np.array(event.ray_origin), np.array(event.ray_direction)
        self._post("picked", Pick(*ray, modifier_of(event.modifier), event.client_id))

    async def _box(self, event: viser.SceneRectSelectEvent) -> None:
        self._post("boxed", ScreenBox(view_of(event.client), event.screen_min, event.screen_max))

    def _watch_camera(self, client: viser.ClientHandle) -> None:
        """Report the movements of a camera; at most the newest one waits in the queue."""

        async def moved(camera: viser.CameraHandle) -> None:
            self.scene.fit_again(client)
            if self._listener is not None:
                self.queue.post_newest("camera", self._listener.camera_moved)

        client.camera.on_update(moved)
        self._post("camera_moved")

    def name_left_panel(self, title: str, width: int) -> None:
        """Give the left panel a title and a width; viser names a tab when it is made, and the name stays."""
        if self._left_width != width:
            self._left_width = width
            self._left_panel.set_width(float(width))
        if self._left_tab._label != title:
            self._left_tab._label = title
            self._left_panel._rebuild_tab_props()

    def _show_left_panel(self, count: int) -> None:
        """Show the left panel while it has controls."""
        self._left_panel.visible = count > 0
