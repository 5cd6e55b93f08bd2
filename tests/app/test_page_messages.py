# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""What no page sends is dropped before viser reads it, and nothing that one browser sends is kept for another one."""

from __future__ import annotations

import contextlib
import threading
from collections.abc import Callable, Iterator

import msgspec
import pytest
from viser import _messages
from websockets.sync.client import connect

from stitchmesh.app.application import App
from stitchmesh.app.page_messages import BYTES, LARGEST_TEXT, MESSAGES, PART, UPLOADED, Allowance, page_message
from stitchmesh.app.server import OpenServer
from tests.app.browser import running_app

CAMERA = {
    "type": "ViewerCameraMessage", "wxyz": [1.0, 0.0, 0.0, 0.0], "position": [0, 0, 1], "fov": 1.0, "near": 0.1,
    "far": 10, "image_height": 10, "image_width": 10, "look_at": [0, 0, 0], "up_direction": [0, 1, 0],
}  # fmt: skip
"""The first message of a page."""


@pytest.fixture(scope="module")
def running(tmp_path_factory: pytest.TempPathFactory) -> Iterator[tuple[OpenServer, App]]:
    with running_app(tmp_path_factory.mktemp("folder") / "project") as running:
        yield running


@contextlib.contextmanager
def page(running: tuple[OpenServer, App]) -> Iterator[Callable[..., None]]:
    """A function that sends messages as a page would, and waits until the server has handled them."""
    opened, _ = running
    handled = threading.Event()
    last = opened.server.gui.add_command("last")
    last.on_trigger(lambda event: handled.set())
    headers = {"Authorization": f"Bearer {opened.address.split('token=')[1]}"}
    with connect(
        f"ws://127.0.0.1:{opened.port}", origin=f"http://127.0.0.1:{opened.port}", subprotocols=["viser-v1.1.1"],
        additional_headers=headers, max_size=None,
    ) as connection:  # fmt: skip

        def send(*messages: object) -> None:
            handled.clear()
            for message in (CAMERA, *messages, {"type": "CommandTriggerMessage", "uuid": last._impl.uuid}):
                connection.send(message if isinstance(message, bytes | str) else msgspec.msgpack.encode(message))
            assert handled.wait(30)

        yield send
    last.remove()


def kept(running: tuple[OpenServer, App]) -> set[int]:
    """The messages that a browser which connects later is sent, without the command of ``page``."""
    buffer = running[0].server._websock_server._broadcast_buffer
    return {
        number for number, message in list(buffer.message_from_id.items())
        if not isinstance(message, _messages.RegisterCommandMessage | _messages.RemoveCommandMessage)
    }  # fmt: skip


def button_of(running: tuple[OpenServer, App]) -> str:
    """The identity of the upload of the page Project."""
    handles = running[0].server.gui._gui_input_handle_from_uuid
    return next(uuid for uuid, handle in handles.items() if type(handle).__name__ == "GuiUploadButtonHandle")


def upload(button: str, name: str, content: bytes) -> list[dict[str, object]]:
    """The messages of an upload."""
    same = {"source_component_uuid": button, "transfer_uuid": name}
    contents = [content[place : place + PART] for place in range(0, len(content), PART)]
    start = {"filename": name, "mime_type": "", "part_count": len(contents), "size_bytes": len(content)}
    parts = [{"part_index": place, "content": part} for place, part in enumerate(contents)]
    return [
        {"type": "FileTransferStartUpload", **same, **start},
        *({"type": "FileTransferPart", **same, **part} for part in parts),
    ]


UNUSED = [
    {"type": "GuiFormDirtyMessage", "uuid": "a"}, {"type": "GuiFormSubmitMessage", "uuid": "a"},
    {"type": "ShareUrlRequest"}, {"type": "ShareUrlDisconnect"},
    {"type": "GuiButtonHoldMessage", "uuid": "a", "frequency": 1.0},
    {"type": "RunJavascriptMessage", "source": "alert(1)"},
    {"type": "GuiUpdateMessage", "uuid": "a", "updates": {"update_cb": 3}},
    {"type": "GuiUpdateMessage", "uuid": "a", "updates": {"value": 1, "visible": False}},
    {"type": "GuiUpdateMessage", "uuid": ["a"], "updates": {"value": 1}},
    {"type": "GuiUpdateMessage", "uuid": "a", "updates": {"value": {"a": 1}}},
    {"type": "GuiUpdateMessage", "uuid": "a", "updates": {"value": [[1]]}},
    {"type": "GuiUpdateMessage", "uuid": "a", "updates": {"value": "x" * (LARGEST_TEXT + 1)}},
    {"type": "CommandTriggerMessage", "uuid": "a" * 1_001}, {"type": "CommandTriggerMessage"},
    {**CAMERA, "wxyz": [1.0, 0.0]}, {**CAMERA, "more": 1}, {**CAMERA, "image_height": 0},
    {"type": "FileTransferPart", "source_component_uuid": "a", "transfer_uuid": "a", "part_index": 0,
     "content": bytes(PART + 1)},
    {"type": "FileTransferPartAck", "source_component_uuid": "a", "transfer_uuid": "a", "transferred_bytes": 1,
     "total_bytes": 1},
    b"", b"no message", b"\xff" * 1_000, b"\x81\xa4type\xa3abc", b"\x81\xa4type\xa3\xff\xff\xff", b"\x91" * 100_000,
    "a text", 7, [CAMERA],
]  # fmt: skip


def test_what_no_page_sends_is_no_message():
    for number, message in enumerate(UNUSED):
        sent = message if isinstance(message, bytes | str) else msgspec.msgpack.encode(message)
        assert page_message(sent) is None, number


def test_what_no_page_sends_is_dropped_and_kept_for_nobody(running, capfd):
    before = kept(running)
    with page(running) as send:
        send(*UNUSED)
        assert kept(running) <= before
    assert capfd.readouterr().err == ""


def test_an_upload_is_answered_to_its_browser_only(running, monkeypatch):
    taken = threading.Semaphore(0)
    monkeypatch.setattr(running[1].queue, "on_error", lambda error: taken.release())  # None of them is a mesh.
    before = kept(running)
    with page(running) as send:
        send(*upload(button_of(running), "a.obj", b""), *upload(button_of(running), "b.obj", bytes(PART + 1)))
        assert taken.acquire(timeout=30) and taken.acquire(timeout=30)
    assert kept(running) <= before
    assert running[0].server.gui._gui_input_handle_from_uuid[button_of(running)].value.content == b""


def test_an_upload_that_lies_about_its_parts_is_not_kept(running):
    start, first, second = upload(button_of(running), "a", bytes(PART + 9))
    large = {**second, "content": bytes(PART)}
    with page(running) as send:
        send(start, large, large)
        assert running[0].server.gui._current_file_upload_states == {}
        send(start, first)
        assert len(running[0].server.gui._current_file_upload_states) == 1


def test_a_message_of_a_script_of_the_page_is_not_sent_to_others(running):
    before = kept(running)
    with page(running) as send:
        inbox = running[1].front.bridge.inbox
        send({"type": "GuiUpdateMessage", "uuid": inbox, "updates": {"value": '{"target": "a"}'}})
        assert kept(running) <= before


def test_a_browser_that_sends_too_much_is_slowed():
    for most, rate in (MESSAGES, BYTES, UPLOADED):
        allowance = Allowance(most, rate, most, 10.0)
        assert allowance.use(most, 10.0) == 0.0
        assert allowance.use(rate, 10.0) == 1.0
        assert allowance.use(0.0, 11.0) == 0.0
        assert allowance.use(most, 1e6) == 0.0 and allowance.use(rate, 1e6) == 1.0
