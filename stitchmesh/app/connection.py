# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""A connection to a browser, which passes on the messages of pages at a limited rate."""

from __future__ import annotations

import asyncio
from typing import Any

from websockets.asyncio.server import ServerConnection

from stitchmesh.app.page_messages import Allowance, Part, page_message

MESSAGES = 2_000, 400.0
"""Number of messages that a browser may send at once, and afterwards in each second."""
BYTES = 64 * 2**20, 8.0 * 2**20
"""Number of bytes that a browser may send at once, and afterwards in each second, without the parts of uploads."""
UPLOADED = 1024 * 2**20, 32.0 * 2**20
"""The same of the bytes of uploads."""
BAD_REQUEST = b"HTTP/1.1 400 Bad Request\r\nContent-Length: 0\r\nConnection: close\r\n\r\n"
"""Answer to data that are no HTTP request."""


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
