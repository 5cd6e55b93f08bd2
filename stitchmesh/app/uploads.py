# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Files that browsers send, with limits so that no browser can fill the memory of the server.

Viser takes any number of parts of any upload, into any control. It sends the answer to each part to all browsers, and
keeps the answers for browsers that connect later.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import viser
from viser import UploadedFile, _messages

LARGEST_UPLOAD = 300 * 2**20
"""Largest file that the server takes [bytes]."""
MOST_UPLOADS = 4
"""Number of files that the server takes at once."""
PART = 512 * 2**10
"""Size of each part but the last [bytes]; viser's page divides files in this way."""
NO_FILE = UploadedFile("", b"")
"""Value of an upload button before there is a file, and after a page has taken it."""


@dataclass
class _Upload:
    """An upload in progress."""

    client: int
    button: str
    left: int


class UploadGuard:
    """Decides which parts of uploads are taken."""

    def __init__(self) -> None:
        """Begin without uploads."""
        self._running: dict[str, _Upload] = {}

    def may_start(self, upload: str, client: int, button: str, size: int, parts: int) -> bool:
        """Return whether an upload of a size [bytes] in a number of parts may start in a browser."""
        if upload in self._running or len(self._running) >= MOST_UPLOADS:
            return False
        if not 0 <= size <= LARGEST_UPLOAD or parts != -(-size // PART):
            return False
        if parts:
            self._running[upload] = _Upload(client, button, size)
        return True

    def may_go_on(self, upload: str, client: int, button: str, size: int) -> bool:
        """Return whether the server may keep a part of an upload; the last part ends the upload."""
        running = self._running.get(upload)
        if running is None or (running.client, running.button) != (client, button):
            return False
        running.left -= size
        if running.left <= 0:
            del self._running[upload]
        return running.left >= 0

    def is_running(self, upload: str) -> bool:
        """Return whether parts of an upload are still expected."""
        return upload in self._running

    def forget(self, client: int) -> None:
        """End the uploads of a browser that has disconnected."""
        self._running = {name: upload for name, upload in self._running.items() if upload.client != client}


def guard_uploads(server: viser.ViserServer) -> None:
    """Take only permitted uploads of a server's browsers, and answer only the browser that sends."""
    gui, connection, uploads = server.gui, server._websock_server, UploadGuard()
    sender: list[int] = []
    broadcast = connection.queue_message

    def start(client: Any, message: _messages.FileTransferStartUpload) -> None:
        button, upload = message.source_component_uuid, message.transfer_uuid
        if not isinstance(gui._gui_input_handle_from_uuid.get(button), viser.GuiUploadButtonHandle):
            return
        if uploads.may_start(upload, client, button, message.size_bytes, message.part_count):
            answer_sender(client, lambda: gui._handle_file_transfer_start(client, message))

    def part(client: Any, message: _messages.FileTransferPart) -> None:
        button, upload = str(message.source_component_uuid), message.transfer_uuid
        if uploads.may_go_on(upload, client, button, len(message.content)):
            answer_sender(client, lambda: gui._handle_file_transfer_part(client, message))
        if not uploads.is_running(upload):  # The parts of an incomplete upload that has ended are not kept.
            gui._current_file_upload_states.pop(upload, None)

    def answer_sender(client: int, call: Callable[[], None]) -> None:
        sender.append(client)
        try:
            call()
        finally:
            sender.clear()

    def queue_message(message: Any) -> None:
        if not isinstance(message, _messages.FileTransferPartAck):
            broadcast(message)
        elif sender and (browser := server.get_clients().get(sender[0])) is not None:
            browser._websock_connection.queue_message(message)

    _replace(connection, _messages.FileTransferStartUpload, gui._handle_file_transfer_start, start)
    _replace(connection, _messages.FileTransferPart, gui._handle_file_transfer_part, part)
    connection.queue_message = queue_message  # type: ignore[method-assign]
    server.on_client_disconnect(lambda client: uploads.forget(client.client_id))


def _replace(connection: Any, message: type, handler: Callable[..., Any], other: Callable[..., Any]) -> None:
    connection.unregister_handler(message, handler)
    connection.register_handler(message, other)
