# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Who may use the server: clients that have its token, from pages at its own address.

Other users of this machine can reach its ports too, and the application reads and writes files as its own user. Every
request therefore needs the token: first in the address, then as a cookie; a script gives it in a header. All users of a
machine can read the arguments of a process. The user's browser is therefore started with the path of a page on disk
that only the user can read, and not with the address.

A browser lets every web page open a WebSocket to every address, so a page of another site could use the application in
the name of the user. Such a page cannot change the header ``Origin``, which names the site of the page. The server
therefore accepts a WebSocket only if ``Origin`` is the address that the request names in ``Host``. A site can also make
its own name point to 127.0.0.1. For a server on this machine alone, ``Host`` must therefore be a name of this machine.
"""

from __future__ import annotations

import contextlib
import hmac
import ipaddress
import os
import tempfile
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from html import escape
from http import HTTPStatus
from pathlib import Path
from typing import Any
from urllib.parse import parse_qsl, urlencode, urlsplit

from stitchmesh.errors import FileError, ParameterError
from stitchmesh.io.folder_lock import NAME as LOCK
from stitchmesh.io.folder_lock import FolderLock, is_locked
from stitchmesh.markup import markup

PREFIX = "browser~"
"""First letters of the name of the page's folder; no folder of a project begins in this way."""
NAME = "open.html"
"""Name of the page."""
LEADING = """<!doctype html><html lang="en"><meta charset="utf-8"><title>StitchMesh</title>
<link rel="icon" href="data:,"><meta name="referrer" content="no-referrer">
<meta http-equiv="refresh" content="0; url={}">
<p><a href="{}">Open StitchMesh</a></p></html>
"""
"""Content of a page that leads to an address at once."""


@contextlib.contextmanager
def entrance(address: str, folder: Path) -> Iterator[Path]:
    """Make a page that leads to an address, in a new folder that only the user can enter; remove it at the end.

    Pages of killed programs are removed too.

    Args:
        address: the address.
        folder: the place for the new folder. Browsers in containers can read neither hidden folders nor temporary ones.

    Raises:
        FileError: the page cannot be written, or the file system cannot hide it from other users.
    """
    try:
        folder.mkdir(parents=True, exist_ok=True)
        own = Path(tempfile.mkdtemp(prefix=PREFIX, dir=folder))
    except OSError as error:
        raise FileError(f"{folder}: cannot be written ({error.strerror or error})") from error
    lock = FolderLock(own, "another program uses it")
    try:
        for other in folder.glob(f"{PREFIX}*"):
            if not other.is_symlink() and not is_locked(other):
                _remove(other)
        _write_for_owner(own / NAME, leading_page(address))
        yield own / NAME
    finally:
        lock.give_up()
        _remove(own)


def leading_page(address: str) -> str:
    """Return a page of HTML that leads to an address at once.

    A page that sets a cookie leads to its address in this way too: after an HTTP redirect, a browser that comes from a
    page on disk would not send a cookie that other sites must not see.
    """
    return markup(LEADING, address, address)


def _remove(own: Path) -> None:
    with contextlib.suppress(OSError):  # Another start removes what cannot be removed now.
        for name in (NAME, LOCK):
            (own / name).unlink(missing_ok=True)
        own.rmdir()


def _write_for_owner(path: Path, text: str) -> None:
    try:
        with open(os.open(path, os.O_WRONLY | os.O_CREAT | os.O_EXCL, 0o600), "w", encoding="utf-8") as file:
            if os.name == "posix" and os.fstat(file.fileno()).st_mode & 0o077:
                raise FileError(f"{path.parent}: its file system lets other users read the page with the token")
            file.write(text)
    except OSError as error:
        raise FileError(f"{path}: cannot be written ({error.strerror or error})") from error


LOOPBACK = "127.0.0.1"
"""Host for a server that only this machine can reach."""
PORT = 8080
"""Default port."""
SHORTEST_TOKEN = 8
"""Smallest number of characters of a token."""
SAFE_HEADERS = {
    "X-Frame-Options": "DENY",
    "Content-Security-Policy": "frame-ancestors 'none'",
    "X-Content-Type-Options": "nosniff",
    "Referrer-Policy": "no-referrer",
}
"""Headers of every response; they keep other pages from showing the application in a frame, where clicks could be
stolen."""
TOKEN_PAGE = """<!doctype html><html lang="en"><meta charset="utf-8"><title>StitchMesh</title>
<link rel="icon" href="data:,">
<meta name="viewport" content="width=device-width"><style>body{{font:16px/1.5 sans-serif;max-width:34em;margin:4em auto;
padding:0 1em;color-scheme:light dark}}input,button{{font:inherit;padding:.3em .6em}}</style>
<h1>StitchMesh</h1><p>{0}</p><form method="get" action="/"><label>Token: <input name="token" type="password" autofocus
autocomplete="off" required></label> <button>Open</button></form></html>"""


@dataclass(frozen=True)
class Refusal:
    """A response that refuses a request."""

    status: HTTPStatus
    text: str
    headers: Mapping[str, str]


def is_loopback(host: str) -> bool:
    """Return whether only this machine can reach a server on this host."""
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
        ParameterError: the token is too short, or it is missing on a server that other machines can reach.
    """

    token: str | None
    """Token that every request needs; None if requests need no token."""
    local: bool = True
    """Whether only this machine can reach the server."""

    def __post_init__(self) -> None:
        if self.token is None and not self.local:
            raise ParameterError("host: other machines reach it; expected a token, or a host such as 127.0.0.1")
        if self.token is not None and len(self.token) < SHORTEST_TOKEN:
            raise ParameterError(f"token: got {len(self.token)} characters; expected at least {SHORTEST_TOKEN}")

    def refusal(self, target: str, headers: Mapping[str, str]) -> Refusal | None:
        """Return the response that refuses a request; None for a permitted request.

        Args:
            target: path and query of the request.
            headers: headers of the request, each at most once; the caller compares names without their case.
        """
        host = headers.get("Host", "")
        if self.local and not is_loopback(_address(host)[0]):
            return _plain(HTTPStatus.FORBIDDEN, f"host {host!r}: is not this machine; open http://127.0.0.1 instead")
        words = parse_qsl(target.partition("?")[2], keep_blank_values=True, errors="surrogateescape")
        if self.token is not None and (refusal := self._token_refusal(words, headers)) is not None:
            return refusal
        # Viser's page would obey another server, or a recording.
        if {"websocket", "playbackPath"} & {name for name, _ in words}:
            return _plain(HTTPStatus.BAD_REQUEST, "the address names another server than that of the page")
        origin = headers.get("Origin", "")
        if _is_websocket(headers) and origin not in (f"http://{host}", f"https://{host}"):
            return _plain(HTTPStatus.FORBIDDEN, f"origin {origin!r}: pages of other sites may not use this server")
        return None

    def cookie(self, host: str) -> tuple[str, str]:
        """Return name and value of the cookie that stands for the token.

        A browser sends the cookie to all ports of a host. Its name therefore holds the port, and its value is not the
        token.
        """
        assert self.token is not None
        return f"stitchmesh-{_address(host)[1]}", hmac.digest(_bytes(self.token), b"cookie", "sha256").hex()

    def _token_refusal(self, words: list[tuple[str, str]], headers: Mapping[str, str]) -> Refusal | None:
        """Return the response to a request without the cookie: the cookie for the right token, otherwise a question."""
        given = [value for name, value in words if name == "token"]
        name, value = self.cookie(headers.get("Host", ""))
        if given and self._is_token(given[0]) and not _is_websocket(headers):
            rest = [pair for pair in words if pair[0] != "token"]
            query = f"?{urlencode(rest, errors='surrogateescape')}" if rest else ""
            cookie = {"Set-Cookie": f"{name}={value}; Path=/; HttpOnly; SameSite=Strict"}
            return _page(HTTPStatus.OK, leading_page(f"/{query}"), cookie)
        scheme, _, sent = headers.get("Authorization", "").partition(" ")
        if scheme.lower() == "bearer" and self._is_token(sent.strip()):
            return None
        if hmac.compare_digest(_bytes(_cookies(headers.get("Cookie", "")).get(name, "")), value.encode()):
            return None
        text = "This server asks for the token that the program printed when it started."
        if given:
            text = "The token is wrong. Copy the whole address that the program printed."
        return _page(HTTPStatus.UNAUTHORIZED, TOKEN_PAGE.format(escape(text)))

    def _is_token(self, given: str) -> bool:
        assert self.token is not None
        return hmac.compare_digest(_bytes(given), _bytes(self.token))


def guarded(answer: Callable[..., Any], guard: Guard, make_response: Callable[..., Any]) -> Callable[..., Any]:
    """Return a function that answers HTTP requests, and opens WebSockets, for permitted requests only.

    Args:
        answer: answers permitted requests; it is called with a connection and a request.
        guard: decides about requests.
        make_response: makes a response from a status, headers and a body.
    """

    def answer_permitted(connection: object, request: Any) -> object:
        """Return the response to a request; None opens a WebSocket."""
        refusal = _twice(request.headers) or guard.refusal(request.path, request.headers)
        if refusal is not None:
            return make_response(refusal.status, refusal.headers, refusal.text.encode())
        try:
            response = answer(connection, request)
        except (OSError, ValueError):  # Viser asks the file system for any path, but no file can have some paths.
            missing = _plain(HTTPStatus.NOT_FOUND, "there is no such page")
            return make_response(missing.status, missing.headers, missing.text.encode())
        if response is not None:
            for name, value in SAFE_HEADERS.items():
                response.headers[name] = value
        return response

    return answer_permitted


def _twice(headers: Any) -> Refusal | None:
    """Return the refusal of a request that repeats a header, as readers could take either value; None otherwise."""
    names = [name.lower() for name, _ in headers.raw_items()]
    if len(set(names)) == len(names):
        return None
    return _plain(HTTPStatus.BAD_REQUEST, "a header stands in the request twice")


def _is_websocket(headers: Mapping[str, str]) -> bool:
    return headers.get("Upgrade", "").lower() == "websocket"


def _address(host: str) -> tuple[str, int]:
    """Return the name and the port in a header ``Host``; an empty name if it is malformed."""
    try:
        parts = urlsplit(f"//{host}")
        return parts.hostname or "", parts.port or 80
    except ValueError:
        return "", 80


def _cookies(header: str) -> dict[str, str]:
    """Return the cookies; the standard parser may refuse the cookies of other programs on this machine."""
    pairs = (pair.strip().partition("=") for pair in header.split(";"))
    return {name: value for name, _, value in pairs}


def _bytes(text: str) -> bytes:
    """Return a text as bytes; the environment and requests may hold bytes that are not UTF-8."""
    return text.encode("utf-8", "surrogateescape")


def _plain(status: HTTPStatus, text: str) -> Refusal:
    return Refusal(status, f"{text}\n", {**SAFE_HEADERS, "Content-Type": "text/plain; charset=utf-8"})


def _page(status: HTTPStatus, content: str, more: Mapping[str, str] | None = None) -> Refusal:
    headers = {"Content-Type": "text/html; charset=utf-8", "Cache-Control": "no-store"}
    return Refusal(status, content, {**SAFE_HEADERS, **headers, **(more or {})})
