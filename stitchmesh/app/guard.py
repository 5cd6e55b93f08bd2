# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Who may use the server: pages of its own address, and beyond this machine only holders of its token.

A browser lets every web page open a WebSocket to every address, so a page of another site could use the application in
the name of the user. It cannot change the header ``Origin``, which names the page's own site; the server therefore
accepts a WebSocket only if ``Origin`` is the address that the request names in ``Host``. A site can also let its name
point to 127.0.0.1; on this machine ``Host`` must therefore be a name of this machine. Beyond this machine, every
request needs the token, first in the address and then as a cookie.
"""

from __future__ import annotations

import hashlib
import hmac
import ipaddress
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from html import escape
from http import HTTPStatus
from http.cookies import CookieError, SimpleCookie
from typing import Any
from urllib.parse import parse_qsl, urlencode, urlsplit

from stitchmesh.errors import ParameterError

LOOPBACK = "127.0.0.1"
"""Host that only this machine reaches."""
PORT = 8080
"""Port where none is asked for."""
LOOPBACK_NAMES = frozenset({LOOPBACK, "localhost", "::1"})
"""Names of this machine in the header ``Host``."""
LARGEST_UPLOAD = 300 * 2**20
"""Largest file that the server takes [bytes]."""
MOST_UPLOADS = 4
"""Number of files that the server takes at once."""
SAFE_HEADERS = {
    "X-Frame-Options": "DENY",
    "Content-Security-Policy": "frame-ancestors 'none'",
    "X-Content-Type-Options": "nosniff",
    "Referrer-Policy": "no-referrer",
}
"""Headers of every response; no other page may show the application in a frame, where clicks could be stolen."""
TOKEN_PAGE = """<!doctype html><html lang="en"><meta charset="utf-8"><title>StitchMesh</title>
<meta name="viewport" content="width=device-width"><style>body{{font:16px/1.5 sans-serif;max-width:34em;margin:4em auto;
padding:0 1em;color-scheme:light dark}}input,button{{font:inherit;padding:.3em .6em}}</style>
<h1>StitchMesh</h1><p>{0}</p><form method="get" action="/"><label>Token: <input name="token" type="password" autofocus
autocomplete="off" required></label> <button>Open</button></form></html>"""


@dataclass(frozen=True)
class Refusal:
    """A response in place of what was asked for."""

    status: HTTPStatus
    text: str
    headers: Mapping[str, str]


def is_loopback(host: str) -> bool:
    """Return whether a server on this host is reached from this machine only."""
    if host == "localhost":
        return True
    try:
        return ipaddress.ip_address(host).is_loopback
    except ValueError:
        return False


@dataclass(frozen=True)
class Guard:
    """Decides about requests.

    Raises:
        ParameterError: the token is shorter than 8 characters.
    """

    token: str | None = None
    """Token that every request needs; None on a server that only this machine reaches."""

    def __post_init__(self) -> None:
        if self.token is not None and len(self.token) < 8:
            raise ParameterError(f"token: got {len(self.token)} characters; expected at least 8")

    @property
    def cookie(self) -> str:
        """Name of the cookie, which differs between servers on one machine."""
        return "stitchmesh-" + hashlib.sha256((self.token or "").encode()).hexdigest()[:12]

    def refusal(self, target: str, headers: Mapping[str, str]) -> Refusal | None:
        """Return why a request is not answered as usual; None if it is.

        Args:
            target: path and query of the request.
            headers: headers of the request; names are compared without their case by the caller.
        """
        host = headers.get("Host", "")
        if self.token is None and _name(host) not in LOOPBACK_NAMES:
            return _plain(HTTPStatus.FORBIDDEN, f"host {host!r}: is not this machine; open http://127.0.0.1 instead")
        if self.token is not None and (refusal := self._token_refusal(target, headers)) is not None:
            return refusal
        if headers.get("Upgrade", "").lower() != "websocket":
            return None
        origin = headers.get("Origin", "")
        if not origin or urlsplit(origin).netloc != host:
            return _plain(HTTPStatus.FORBIDDEN, f"origin {origin!r}: pages of other sites may not use this server")
        return None

    def _token_refusal(self, target: str, headers: Mapping[str, str]) -> Refusal | None:
        """Return the response to a request without the cookie: the cookie for the right token, else a question."""
        if self._is_token(_cookies(headers.get("Cookie", "")).get(self.cookie, "")):
            return None
        path, _, query = target.partition("?")
        words = dict(parse_qsl(query))
        given = words.pop("token", None)
        if given is None:
            return _page("This server asks for the token that the program printed when it started.")
        if not self._is_token(given):
            return _page("The token is wrong. Copy the whole address that the program printed.")
        rest = f"{path}?{urlencode(words)}" if words else path
        location = "/" + rest.lstrip("/\\")  # A path that begins with two slashes would name another site.
        cookie = f"{self.cookie}={self.token}; Path=/; HttpOnly; SameSite=Strict"
        return Refusal(HTTPStatus.SEE_OTHER, "", {**SAFE_HEADERS, "Location": location, "Set-Cookie": cookie})

    def _is_token(self, given: str) -> bool:
        assert self.token is not None
        return hmac.compare_digest(given.encode(), self.token.encode())


class UploadGuard:
    """Decides about the parts of uploads, so that no browser can fill the memory of the server."""

    def __init__(self) -> None:
        """Start without uploads."""
        self._left: dict[str, int] = {}
        """Number of bytes that each upload may still send."""
        self._client: dict[str, int] = {}
        """Number of the browser of each upload."""

    def may_start(self, upload: str, client: int, size: int, parts: int) -> bool:
        """Return whether an upload of a size [bytes] in a number of parts may start in a browser."""
        if not (0 <= size <= LARGEST_UPLOAD and 0 <= parts <= size + 1 and len(self._left) < MOST_UPLOADS):
            return False
        if parts:
            self._left[upload], self._client[upload] = size, client
        return True

    def may_go_on(self, upload: str, size: int) -> bool:
        """Return whether a part of an upload may be kept; the last part ends the upload."""
        left = self._left.get(upload, -1) - size
        if left <= 0:
            self._end(upload)
        else:
            self._left[upload] = left
        return left >= 0

    def forget(self, client: int) -> None:
        """End the uploads of a browser that has left."""
        for upload in [upload for upload, owner in self._client.items() if owner == client]:
            self._end(upload)

    def _end(self, upload: str) -> None:
        self._left.pop(upload, None)
        self._client.pop(upload, None)


def guarded(answer: Callable[..., Any], guard: Guard, make_response: Callable[..., Any]) -> Callable[..., Any]:
    """Return a function that answers HTTP requests, and opens WebSockets, for permitted requests only.

    Args:
        answer: answers permitted requests: it is called with a connection and a request.
        guard: decides about requests.
        make_response: makes a response of a status, headers and a body.
    """

    def answer_permitted(connection: object, request: Any) -> object:
        """Return the response to a request; None opens a WebSocket."""
        refusal = guard.refusal(request.path, request.headers)
        if refusal is not None:
            return make_response(refusal.status, refusal.headers, refusal.text.encode())
        response = answer(connection, request)
        if response is not None:
            for name, value in SAFE_HEADERS.items():
                response.headers[name] = value
        return response

    return answer_permitted


def _name(host: str) -> str:
    """Return the name in a header ``Host``, without the port."""
    try:
        return urlsplit(f"//{host}").hostname or ""
    except ValueError:
        return ""


def _cookies(header: str) -> dict[str, str]:
    try:
        return {name: morsel.value for name, morsel in SimpleCookie(header).items()}
    except CookieError:
        return {}


def _plain(status: HTTPStatus, text: str) -> Refusal:
    return Refusal(status, f"{text}\n", {**SAFE_HEADERS, "Content-Type": "text/plain; charset=utf-8"})


def _page(text: str) -> Refusal:
    content = TOKEN_PAGE.format(escape(text))
    headers = {"Content-Type": "text/html; charset=utf-8", "Cache-Control": "no-store"}
    return Refusal(HTTPStatus.UNAUTHORIZED, content, {**SAFE_HEADERS, **headers})
