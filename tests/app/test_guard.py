# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The server answers pages of its own address only, and beyond this machine only holders of its token."""

from __future__ import annotations

from collections.abc import Iterator
from http.client import HTTPConnection, HTTPResponse

import psutil
import pytest
from viser import _messages
from websockets.exceptions import ConnectionClosed, InvalidStatus
from websockets.sync.client import connect

from stitchmesh.app.guard import LARGEST_UPLOAD, MOST_UPLOADS, Guard, UploadGuard, is_loopback
from stitchmesh.app.server import OpenServer, address_of, free_port, open_server
from stitchmesh.errors import ParameterError

TOKEN = "correct-horse"


@pytest.fixture(scope="module")
def opened() -> Iterator[OpenServer]:
    server = open_server(port=0)
    yield server
    server.stop()


@pytest.fixture(scope="module")
def with_token() -> Iterator[OpenServer]:
    server = open_server(port=0, token=TOKEN)
    yield server
    server.stop()


def got(server: OpenServer, path: str = "/", **headers: str) -> HTTPResponse:
    connection = HTTPConnection("127.0.0.1", server.port, timeout=30)
    connection.request("GET", path, headers={"Host": f"127.0.0.1:{server.port}", **headers})
    return connection.getresponse()


def websocket_opens(server: OpenServer, origin: str | None, **headers: str) -> bool:
    """Whether a WebSocket opens for a page of an origin."""
    try:
        with connect(
            f"ws://127.0.0.1:{server.port}", origin=origin, subprotocols=["viser-v1.1.1"], additional_headers=headers,
            max_size=None,
        ):  # fmt: skip
            return True
    except InvalidStatus as error:
        assert error.response.status_code in (401, 403)
        return False


def test_the_server_listens_on_the_loopback_address_unless_told_otherwise(opened):
    sockets = psutil.Process().net_connections("inet")
    listening = {one.laddr.ip for one in sockets if one.status == psutil.CONN_LISTEN and one.laddr.port == opened.port}
    assert listening == {"127.0.0.1"}


def test_the_page_of_the_server_may_use_it(opened):
    answer = got(opened)
    assert answer.status == 200 and b"<html" in answer.read()
    assert answer.getheader("X-Frame-Options") == "DENY"
    assert websocket_opens(opened, f"http://127.0.0.1:{opened.port}")


@pytest.mark.parametrize(
    "origin",
    ["http://evil.example", "http://127.0.0.1", "http://127.0.0.1:1", "null", None, "http://127.0.0.1:{port}.evil.example",
     "http://evil.example/127.0.0.1:{port}", "http://user@127.0.0.1:{port}"],
)  # fmt: skip
def test_a_page_of_another_site_may_not(opened, origin):
    assert not websocket_opens(opened, origin and origin.format(port=opened.port))


@pytest.mark.parametrize("host", ["evil.example", "evil.example:8080", "127.0.0.1.evil.example", "10.1.2.3", "", "[::"])
def test_a_name_that_another_site_lets_point_here_is_refused(opened, host):
    assert got(opened, Host=host).status == 403


@pytest.mark.parametrize("host", ["localhost", "127.0.0.1:9", "[::1]:8080", "LOCALHOST:80"])
def test_the_names_of_this_machine_are_accepted(opened, host):
    assert got(opened, Host=host).status == 200


@pytest.mark.parametrize(
    "path", ["/../../etc/passwd", "/%2e%2e/%2e%2e/etc/passwd", "/..%5c..%5csecret", "/project.json"]
)
def test_no_file_outside_the_page_is_sent(opened, path):
    assert got(opened, path).status == 404


def test_a_token_is_asked_for_and_becomes_a_cookie(with_token):
    asked = got(with_token)
    assert asked.status == 401 and b'type="password"' in asked.read()
    assert got(with_token, "/?token=wrong").status == 401
    answer = got(with_token, f"/?token={TOKEN}&darkMode=1")
    assert (answer.status, answer.getheader("Location")) == (303, "/?darkMode=1")
    cookie = answer.getheader("Set-Cookie")
    assert "HttpOnly" in cookie and "SameSite=Strict" in cookie
    pair = cookie.split(";")[0]
    assert got(with_token, Cookie=pair).status == 200
    assert got(with_token, Cookie=pair + "x").status == 401
    own = f"http://127.0.0.1:{with_token.port}"
    assert websocket_opens(with_token, own, Cookie=pair)
    assert not websocket_opens(with_token, own)
    assert not websocket_opens(with_token, "http://evil.example", Cookie=pair)


def test_the_way_back_after_the_token_leads_to_no_other_site(with_token):
    answer = got(with_token, f"//evil.example/?token={TOKEN}")
    assert answer.getheader("Location") == "/evil.example/"


def test_a_server_beyond_this_machine_makes_a_token():
    server = open_server(host="0.0.0.0", port=0)
    try:
        assert "?token=" in server.address and len(server.address.split("token=")[1]) >= 32
        assert got(server).status == 401
    finally:
        server.stop()


def test_only_loopback_hosts_need_no_token():
    assert all(map(is_loopback, ["127.0.0.1", "localhost", "127.8.9.1", "::1"]))
    assert not any(map(is_loopback, ["0.0.0.0", "::", "192.168.0.4", "example.org", ""]))


@pytest.mark.parametrize("message", [b"", b"no message", b"\xff" * 1000, "a text", b"\x81\xa4type\xa3abc"])
def test_a_message_that_no_page_sends_ends_its_own_connection_at_most(opened, message):
    own = f"http://127.0.0.1:{opened.port}"
    address = f"ws://127.0.0.1:{opened.port}"
    with connect(address, origin=own, subprotocols=["viser-v1.1.1"], max_size=None) as connection:
        connection.send(message)
    assert got(opened).status == 200 and websocket_opens(opened, own)


def test_a_page_of_another_version_is_refused(opened):
    own, address = f"http://127.0.0.1:{opened.port}", f"ws://127.0.0.1:{opened.port}"
    with connect(address, origin=own, subprotocols=["viser-v0.0.1"], max_size=None) as connection:
        with pytest.raises(ConnectionClosed):
            connection.recv(timeout=30)


def test_a_short_token_is_refused():
    with pytest.raises(ParameterError, match="at least 8"):
        Guard("abc")


def test_no_browser_can_open_a_tunnel_to_another_machine(opened):
    handlers = opened.server._websock_server._incoming_handlers
    assert _messages.ShareUrlRequest not in handlers and _messages.ShareUrlDisconnect not in handlers


def test_the_next_free_port_is_taken(opened):
    other = open_server(port=opened.port)
    try:
        assert other.port > opened.port
        assert other.address == f"http://127.0.0.1:{other.port}/"
    finally:
        other.stop()


@pytest.mark.parametrize(
    ("host", "port", "message"),
    [
        ("127.0.0.1", -1, "port: got -1"),
        ("127.0.0.1", 70000, "port: got 70000"),
        ("203.0.113.7", 8080, "address of this machine"),
        ("no such host", 8080, "address of this machine"),
        ("a" * 70, 8080, "address of this machine"),
    ],
)
def test_a_wrong_address_is_refused(host, port, message):
    with pytest.raises(ParameterError, match=message):
        free_port(host, port)


def test_an_address_that_holds_colons_is_in_brackets():
    assert address_of("::1", 8080, None) == "http://[::1]:8080/"


def test_an_upload_sends_no_more_than_it_announced():
    uploads = UploadGuard()
    assert uploads.may_start("a", 1, 10, 2)
    assert uploads.may_go_on("a", 6) and uploads.may_go_on("a", 4)
    assert not uploads.may_go_on("a", 1)
    assert uploads.may_start("b", 1, 10, 2) and not uploads.may_go_on("b", 11) and not uploads.may_go_on("b", 1)
    assert not uploads.may_start("c", 1, LARGEST_UPLOAD + 1, 3)
    assert not uploads.may_start("c", 1, -1, 3) and not uploads.may_start("c", 1, 10, 1000)
    assert uploads.may_start("empty", 1, 0, 0)


def test_a_browser_that_leaves_makes_room_for_other_uploads():
    uploads = UploadGuard()
    assert all(uploads.may_start(str(number), 7, 10, 2) for number in range(MOST_UPLOADS))
    assert not uploads.may_start("more", 8, 10, 2)
    uploads.forget(7)
    assert uploads.may_start("more", 8, 10, 2)
