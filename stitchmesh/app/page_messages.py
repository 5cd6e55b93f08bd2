# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""What pages may send, and how much; a connection drops anything else before viser reads it.

Viser has handlers that our pages do not use. Some of them keep what a browser sends, and send it to every browser that
connects later; one opens a tunnel to another machine. The kinds below are those of viser 1.1.1. Viser also takes any
number of parts of any upload, into any control, sends the answer to each part to all browsers, and keeps the answers.
"""

from __future__ import annotations

import asyncio
from collections.abc import Callable
from dataclasses import dataclass
from typing import Annotated, Any, Literal

import msgspec
import viser
from viser import UploadedFile, _messages
from websockets.asyncio.server import ServerConnection

LARGEST_UPLOAD = 300 * 2**20
"""Largest file that the server takes [bytes]."""
MOST_UPLOADS = 4
"""Number of files that the server takes at once."""
PART = 512 * 2**10
"""Size of each part but the last [bytes]; viser's page divides files in this way."""
NO_FILE = UploadedFile("", b"")
"""Value of an upload button before there is a file, and after a page has taken it."""


@dataclass
class _RunningUpload:
    """An upload in progress."""

    client: int
    button: str
    left: int


class UploadGuard:
    """Decides which parts of uploads are taken."""

    def __init__(self) -> None:
        """Begin without uploads."""
        self._running: dict[str, _RunningUpload] = {}

    def may_start(self, upload: str, client: int, button: str, size: int, parts: int) -> bool:
        """Return whether an upload of a size [bytes] in a number of parts may start in a browser."""
        if upload in self._running or len(self._running) >= MOST_UPLOADS:
            return False
        if not 0 <= size <= LARGEST_UPLOAD or parts != -(-size // PART):
            return False
        if parts:
            self._running[upload] = _RunningUpload(client, button, size)
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


LARGEST_TEXT = 4 * 2**20
"""Largest number of characters in the value of a control, such as the text of a chart."""
MESSAGES = 2_000, 400.0
"""Number of messages that a browser may send at once, and afterwards in each second."""
BYTES = 64 * 2**20, 8.0 * 2**20
"""Number of bytes that a browser may send at once, and afterwards in each second, without the parts of uploads."""
UPLOADED = 1024 * 2**20, 32.0 * 2**20
"""The same of the bytes of uploads."""
BAD_REQUEST = b"HTTP/1.1 400 Bad Request\r\nContent-Length: 0\r\nConnection: close\r\n\r\n"
"""Answer to data that are no HTTP request."""
Name = Annotated[str, msgspec.Meta(max_length=1_000)]
"""Identity or name of a control, a file or an object of the scene."""
Point = tuple[float, float, float]
Place = tuple[float, float]


class _Message(msgspec.Struct, tag_field="type", forbid_unknown_fields=True):
    """A message; its tag is viser's name for this kind of message."""


class _NewValue(msgspec.Struct, forbid_unknown_fields=True):
    """The property of a control that a page sets."""

    value: bool | int | float | Annotated[str, msgspec.Meta(max_length=LARGEST_TEXT)] | list[float] | None


class _Value(_Message, tag="GuiUpdateMessage"):
    uuid: Name
    updates: _NewValue


class _Command(_Message, tag="CommandTriggerMessage"):
    uuid: Name


class _Camera(_Message, tag="ViewerCameraMessage"):
    wxyz: tuple[float, float, float, float]
    position: Point
    fov: float
    near: float
    far: float
    image_height: Annotated[float, msgspec.Meta(gt=0)]
    image_width: Annotated[float, msgspec.Meta(gt=0)]
    look_at: Point
    up_direction: Point


class _Pointer(_Message, tag="ScenePointerMessage"):
    event_type: Literal["click", "rect-select"]
    ray_origin: Point | None
    ray_direction: Point | None
    screen_pos: Annotated[list[Place], msgspec.Meta(min_length=1, max_length=2)]
    modifier: Name | None


class _Drag(_Message, tag="SceneNodeDragMessage"):
    phase: Literal["start", "update", "end"]
    name: Name
    instance_index: int | None
    start_position: Point
    start_screen_pos: Place
    end_position: Point
    end_screen_pos: Place
    button: Literal["left", "middle", "right"]
    modifier: Name | None
    owner: Name = ""


class _Picture(_Message, tag="GetRenderResponseMessage"):
    payload: bytes
    render_uuid: Name


class _Upload(_Message, tag="FileTransferStartUpload"):
    source_component_uuid: Name
    transfer_uuid: Name
    filename: Name
    mime_type: Name
    part_count: int
    size_bytes: int


class Part(_Message, tag="FileTransferPart"):
    """A part of an upload."""

    source_component_uuid: Name
    transfer_uuid: Name
    part_index: int
    content: Annotated[bytes, msgspec.Meta(max_length=PART)]


_decoder = msgspec.msgpack.Decoder(_Value | _Command | _Camera | _Pointer | _Drag | _Picture | _Upload | Part)


def page_message(raw: bytes | str) -> Any:
    """Return a message as an object; None if no page sends such a message."""
    if isinstance(raw, str):
        return None
    try:
        return _decoder.decode(raw)
    except (msgspec.MsgspecError, UnicodeDecodeError, RecursionError):
        return None


@dataclass
class Allowance:
    """The amount that may still be used at once; it grows with time up to a bound."""

    most: float
    """Largest value."""
    rate: float
    """Growth [1/s]."""
    left: float
    """Amount at a given time; it is negative after too much was used."""
    at: float
    """The time [s]."""

    def use(self, amount: float, now: float) -> float:
        """Use an amount; return the time [s] after which more may be used."""
        self.left = min(self.most, self.left + self.rate * (now - self.at)) - amount
        self.at = now
        return max(0.0, -self.left / self.rate)


class GuardedConnection(ServerConnection):
    """A connection that checks its messages before it passes them on; it drops all messages that no page sends."""

    def __init__(self, *arguments: Any, **options: Any) -> None:
        """Start with the full allowance of a browser."""
        super().__init__(*arguments, **options)
        now = self.loop.time()
        self._messages, self._bytes, self._uploaded = (
            Allowance(most, rate, most, now) for most, rate in (MESSAGES, BYTES, UPLOADED)
        )
        self._pause = 0.0
        self._has_answered = False

    async def recv(self, decode: bool | None = None) -> Any:
        """Return the next message that a page can have sent."""
        while True:
            await asyncio.sleep(self._pause)  # The sender waits meanwhile, because nobody reads its messages.
            raw = await super().recv(decode)
            message, now = page_message(raw), self.loop.time()
            used = self._uploaded if isinstance(message, Part) else self._bytes
            self._pause = max(self._messages.use(1, now), used.use(len(raw), now))
            if message is not None:
                return raw

    def send_data(self) -> None:
        """Send the waiting data; an unreadable request gets an answer before the connection ends."""
        if self.request is None and self.protocol.handshake_exc is not None and not self._has_answered:
            self._has_answered = True
            self.transport.write(BAD_REQUEST)
        super().send_data()
