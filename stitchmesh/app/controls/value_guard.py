# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Values that browsers send, checked before viser takes them.

Viser casts a value to the type of the old one, and an error of this cast reaches no user. A number beyond its bounds
is often one that a user still types: whoever types 800 sends 8 and 80 first. It is therefore refused only if no other
value follows soon. As a refused value never becomes the value of its control, the control still has the last good one,
and shows it again.
"""

from __future__ import annotations

import asyncio
import math

import viser
from viser import _messages

from stitchmesh.app.controls.controls import Bounds
from stitchmesh.app.event_queue import EventQueue
from stitchmesh.errors import ParameterError

PAUSE_SECONDS = 1.5
"""Time without another value after which a wrong number is refused."""


class ValueGuard:
    """Decides about the values that browsers send. Values arrive in the thread of the server."""

    def __init__(self, server: viser.ViserServer, queue: EventQueue) -> None:
        """Stand before a server; refusals are raised in the thread of the queue, which reports them."""
        self._gui, self._connection, self._queue = server.gui, server._websock_server, queue
        self._bounds: dict[str, Bounds] = {}
        self._waiting: dict[str, asyncio.TimerHandle] = {}
        self._connection.unregister_handler(_messages.GuiUpdateMessage, self._gui._handle_gui_updates)
        self._connection.register_handler(_messages.GuiUpdateMessage, self._take)

    def bound(self, identity: str, bounds: Bounds) -> None:
        """Check the values of a control from now on."""
        self._bounds[identity] = bounds

    def forget(self, identity: str) -> None:
        """Check the values of a control no more."""
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
            self._waiting[message.uuid] = loop.call_later(PAUSE_SECONDS, self._refuse, message.uuid, error)
        else:
            await self._gui._handle_gui_updates(client, message)  # type: ignore[arg-type]

    def _fits(self, identity: str, value: object) -> bool:
        """Whether a value has the shape of that of its control: three numbers for a colour, one value for others."""
        handle = self._gui._gui_input_handle_from_uuid.get(identity)
        if handle is None or isinstance(handle, viser.GuiUploadButtonHandle):
            return False
        if not isinstance(handle.value, tuple):
            return True
        return isinstance(value, list) and len(value) == len(handle.value) and all(map(math.isfinite, value))

    def _refuse(self, identity: str, error: ParameterError) -> None:
        """Show the last good value of a control again, and report the refusal, unless the control is gone."""
        self._waiting.pop(identity, None)
        handle = self._gui._gui_input_handle_from_uuid.get(identity)
        if handle is not None and identity in self._bounds:
            self._connection.queue_message(_messages.GuiUpdateMessage(identity, {"value": handle.value}))
            self._queue.post(_report, error)


def _report(error: ParameterError) -> None:
    raise error
