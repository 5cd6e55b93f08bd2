# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Checks of the values that browsers send, before viser takes them.

Viser casts a value to the type of the old one, and no user sees an error of this cast. A number beyond its bounds is
often incomplete: a user who types 800 sends 8 and 80 first. The guard therefore refuses it only if no other value
follows soon. A refused value never becomes the value of its control, so the control still has the last good value and
shows it again.
"""

from __future__ import annotations

import asyncio
import math

import viser
from viser import _messages

from stitchmesh.app.controls.controls import Bounds
from stitchmesh.app.event_queue import EventQueue
from stitchmesh.errors import ParameterError


class ValueGuard:
    """Decides which values of browsers viser takes. Values arrive in the thread of the server."""

    def __init__(self, server: viser.ViserServer, queue: EventQueue) -> None:
        """Check all values for a server. The guard raises refusals in the thread of the queue, which reports them."""
        self._gui, self._connection, self._queue = server.gui, server._websock_server, queue
        self._bounds: dict[str, Bounds] = {}
        self._waiting: dict[str, asyncio.TimerHandle] = {}
        self._connection.unregister_handler(_messages.GuiUpdateMessage, self._gui._handle_gui_updates)
        self._connection.register_handler(_messages.GuiUpdateMessage, self._take)

    def bound(self, identity: str, bounds: Bounds) -> None:
        """Check the values of a control from now on."""
        self._bounds[identity] = bounds

    def forget(self, identity: str) -> None:
        """Stop checking the values of a control."""
        self._bounds.pop(identity, None)

    async def _take(self, client: int, message: _messages.GuiUpdateMessage) -> None:
        """Pass a value on to viser, or refuse it after a pause."""
        if not self._fits(message.uuid, message.updates["value"]):
            return  # No page sends this.
        if (waiting := self._waiting.pop(message.uuid, None)) is not None:
            waiting.cancel()
        try:
            if (bounds := self._bounds.get(message.uuid)) is not None:
                bounds.check(message.updates["value"])
        except ParameterError as error:
            loop = asyncio.get_running_loop()
            self._waiting[message.uuid] = loop.call_later(1.5, self._refuse, message.uuid, error)
        else:
            await self._gui._handle_gui_updates(client, message)  # type: ignore[arg-type]

    def _fits(self, identity: str, value: object) -> bool:
        """Return whether a value has the form that its control needs: three numbers for a colour, else one value."""
        handle = self._gui._gui_input_handle_from_uuid.get(identity)
        if handle is None or isinstance(handle, viser.GuiUploadButtonHandle):
            return False
        if not isinstance(handle.value, tuple):
            return True
        return isinstance(value, list) and len(value) == len(handle.value) and all(map(math.isfinite, value))

    def _refuse(self, identity: str, error: ParameterError) -> None:
        """Show the last good value of a control again and report the refusal, unless the control is gone."""
        self._waiting.pop(identity, None)
        handle = self._gui._gui_input_handle_from_uuid.get(identity)
        if handle is not None and identity in self._bounds:
            self._connection.queue_message(_messages.GuiUpdateMessage(identity, {"value": handle.value}))
            self._queue.post(_report, error)


def _report(error: ParameterError) -> None:
    raise error
