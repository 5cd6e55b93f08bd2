# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The server of the application: viser for holders of a token, on this machine alone unless the user asks for more."""

from __future__ import annotations

import contextlib
import errno
import io
import logging
import secrets
import socket
import threading
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any
from urllib.parse import quote

import viser
import websockets.asyncio.server as websocket_server
from websockets import Headers
from websockets.http11 import Response

from stitchmesh.app.guard import LOOPBACK, PORT, Guard, guarded, is_loopback
from stitchmesh.app.page_messages import GuardedConnection, guard_uploads
from stitchmesh.errors import ParameterError

_starting = threading.Lock()
logging.getLogger("websockets").setLevel(logging.WARNING)  # It reports each connection, which no user needs.
# A malformed request gets an answer, and is no fault of the server.
logging.getLogger("websockets.server").addFilter(lambda record: record.getMessage() != "opening handshake failed")


@dataclass(frozen=True)
class OpenServer:
    """A server that listens."""

    server: viser.ViserServer
    address: str
    """Address to open in a browser; it holds the token if the server needs one."""
    port: int
    """Port on which the server listens; it differs from the requested port if that was in use."""

    def stop(self) -> None:
        """End all connections."""
        with contextlib.redirect_stdout(io.StringIO()):  # Viser prints a line.
            self.server.stop()


def open_server(
    host: str = LOOPBACK, port: int = PORT, token: str | None = None, *, needs_token: bool = True
) -> OpenServer:
    """Open a server.

    Args:
        host: address of this machine on which the server listens.
        port: port; if it is in use, the next free one is taken. 0 takes any free port.
        token: token that browsers need; None for a new one.
        needs_token: whether browsers need a token; otherwise every user of this machine can use the server.

    Raises:
        ParameterError: the host is no address of this machine, the port is out of range or not permitted, no port is
            free, the token is too short, a token is given although none is needed, or other machines can reach a server
            without one.
    """
    if token is not None and not needs_token:
        raise ParameterError("token: there is one, and browsers shall need none; expected one of both")
    if token is None and needs_token:
        token = secrets.token_urlsafe(24)
    guard = Guard(token if needs_token else None, is_loopback(host))
    with _starting, _guarding_websockets(guard), contextlib.redirect_stdout(io.StringIO()):
        server = viser.ViserServer(host=host, port=free_port(host, port), verbose=False)
    guard_uploads(server)
    found = server.get_port()
    return OpenServer(server, address_of(host, found, guard.token), found)


def address_of(host: str, port: int, token: str | None) -> str:
    """Return the address that the user opens."""
    name = socket.gethostname() if host in ("0.0.0.0", "::") else host
    name = f"[{name}]" if ":" in name else name
    query = "" if token is None else f"?token={quote(token, safe='', errors='surrogateescape')}"
    return f"http://{name}:{port}/{query}"


def free_port(host: str, port: int) -> int:
    """Return a port on which a server can listen: the given port or the next free one.

    Raises:
        ParameterError: the host is no address of this machine, the port is out of range or not permitted, or no port is
            free.
    """
    if not 0 <= port <= 65535:
        raise ParameterError(f"port: got {port}; expected 0 (any free port) to 65535")
    last = min(port + 100, 65536)
    for candidate in range(port, last):
        reason = _why_not(host, candidate)
        if reason is None:
            return candidate
        if reason.errno not in (errno.EADDRINUSE, None):
            what = "host" if reason.errno != errno.EACCES else "port"
            raise ParameterError(
                f"{what}: cannot listen on {host!r} port {candidate} ({reason.strerror}); expected an address of this "
                f"machine such as {LOOPBACK}, and a port from 1024"
            )
    raise ParameterError(f"port: {port} to {last - 1} are in use; give another one, or 0 for any free port")


def _why_not(host: str, port: int) -> OSError | None:
    """Return the error with which a server would fail; None if it can listen."""
    try:
        family, kind, protocol, _, address = socket.getaddrinfo(host, port, type=socket.SOCK_STREAM)[0]
        with socket.socket(family, kind, protocol) as probe:
            probe.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
            probe.bind(address)
            probe.listen(1)
    except OSError as error:
        return error
    except UnicodeError:
        return OSError(errno.EINVAL, "is no name of a host")
    return None


@contextlib.contextmanager
def _guarding_websockets(guard: Guard) -> Iterator[None]:
    """Make the WebSocket server that starts in the block answer only permitted requests.

    Viser has no setting for this. It calls the function ``serve`` of the module, which the block replaces.
    """
    serve = websocket_server.serve

    def serve_guarded(*arguments: Any, **options: Any) -> Any:
        options["process_request"] = guarded(options["process_request"], guard, _response)
        # Memory must hold as many waiting messages of the largest size for each browser.
        options |= {"create_connection": GuardedConnection, "max_queue": 2}
        return serve(*arguments, **options)

    websocket_server.serve = serve_guarded  # type: ignore[misc, assignment]
    try:
        yield
    finally:
        websocket_server.serve = serve  # type: ignore[misc]


def _response(status: Any, headers: Any, body: bytes) -> Response:
    return Response(status.value, status.phrase, Headers({**headers, "Content-Length": str(len(body))}), body)
