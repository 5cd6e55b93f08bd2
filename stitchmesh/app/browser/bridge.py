# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The bridge between the server and the scripts in the browser.

A message to the server is a new value of a hidden text, which holds JSON: the name of the receiver, a number that no
other message has, and the content. Viser keeps scripts for all browsers and sends them again to every browser that
connects later. Viser sends the bridge itself in this way, before all controls; everything else goes to each browser
separately.
"""

from __future__ import annotations

import base64
import json
from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import viser
from numpy.typing import NDArray
from viser import _messages

from stitchmesh.app.scene.drawing import Colours
from stitchmesh.mesh.palette import linear_colour

FOLDER = Path(__file__).parent
SCRIPTS = (
    "bridge.js", "yarn_shapes.js", "yarn_levels.js", "yarn_tubes.js", "frame_rate.js", "chart_messages.js",
    "chart_drawing.js", "chart_text.js", "chart.js", "drop.js", "names.js",
)  # fmt: skip
"""Files of scripts for each page, in the order in which they run."""
Receiver = Callable[[dict[str, Any], int | None], None]
"""Takes the content of a message and the number of the browser that sent it; the thread of the server runs it."""


class Bridge:
    """Sends scripts to the browsers, and passes on their messages."""

    def __init__(self, server: viser.ViserServer, scripts: tuple[str, ...] = SCRIPTS) -> None:
        """Install the scripts in each present and future browser.

        Args:
            server: the server.
            scripts: names of files in this folder, in the order in which they run.
        """
        self.acting_client: int | None = None
        """Number of the browser that asked for the call that runs now in the event thread."""
        self._server = server
        self._receivers: dict[str, Receiver] = {}
        self._hints: dict[str, str] = {}
        self._after_connect: list[Callable[[viser.ClientHandle], None]] = []
        installation = _messages.RunJavascriptMessage(source="\n".join(map(script_text, scripts)))
        server.gui._websock_interface.queue_message(installation)
        self._inbox = server.gui.add_text("messages of the browser", "", visible=False)
        self._inbox._impl.sync_cb = None  # Viser would send the messages of a browser to the others.
        self._inbox.on_update(self._receive)
        server.on_client_connect(self._install)

    @property
    def inbox(self) -> str:
        """Identity of the hidden text."""
        return str(self._inbox._impl.uuid)

    def on_connect(self, function: Callable[[viser.ClientHandle], None]) -> None:
        """Call a function with each browser, after the browser has got the scripts."""
        self._after_connect.append(function)

    def receive(self, target: str, receiver: Receiver) -> None:
        """Pass the messages for a target to a receiver."""
        self._receivers[target] = receiver

    def forget(self, target: str) -> None:
        """Pass messages for a target to nobody."""
        self._receivers.pop(target, None)

    def set_hint(self, identity: str, hint: str) -> None:
        """Set the hint of a button, by its identity in the page."""
        self._hints[identity] = hint
        self.run(f"stitchmesh.hints[{json.dumps(identity)}]={json.dumps(hint)};stitchmesh.applyHints();")

    def run(self, script: str, client: viser.ClientHandle | None = None) -> None:
        """Run a script in one browser, or in all connected browsers."""
        clients = [client] if client is not None else list(self._server.get_clients().values())
        for each in clients:
            each._websock_connection.queue_message(_messages.RunJavascriptMessage(source=script))

    def _install(self, client: viser.ClientHandle) -> None:
        start = f"stitchmesh.inbox={json.dumps(self.inbox)};Object.assign(stitchmesh.hints,{json.dumps(self._hints)});"
        self.run(start, client)
        for function in self._after_connect:
            function(client)

    async def _receive(self, event: viser.GuiEvent) -> None:
        if event.client_id is None:
            return
        try:
            message = json.loads(event.target.value)
            receiver = self._receivers[message["target"]]
        except (ValueError, TypeError, KeyError):
            return  # A browser may send anything, and may name a control that was removed just before.
        receiver(message, event.client_id)


@cache
def script_text(name: str) -> str:
    """Return the text of a script."""
    return (FOLDER / name).read_text(encoding="utf-8")


def colour_script(name: str, colours: Colours, *, flat: bool) -> str:
    """Return the script that colours a mesh."""
    arguments = [name, _text_of(_linear_palette(colours.palette)), _text_of(colours.index), flat]
    return f"stitchmesh.colour({','.join(map(json.dumps, arguments))});"


def _linear_palette(palette: NDArray[np.uint8]) -> NDArray[np.uint8]:
    """Return a palette as bytes red, green, blue and opacity in linear light, in which WebGL mixes colours."""
    linear = np.rint(255.0 * linear_colour(palette / 255.0)).astype(np.uint8)
    return np.concatenate([linear, np.full((len(linear), 1), 255, dtype=np.uint8)], axis=1)


def _text_of(array: NDArray[np.uint8]) -> str:
    return base64.b64encode(array.astype(np.uint8).tobytes()).decode("ascii")
