# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The server answers holders of its token only, from pages of its own address."""

from __future__ import annotations

import html
import re
import socket
from collections.abc import Iterator
from http.client import HTTPConnection, HTTPResponse
from urllib.parse import quote, urlsplit

import psutil
import pytest
from websockets.exceptions import InvalidStatus
from websockets.sync.client import connect

from stitchmesh.app.guard import Guard, is_loopback
from stitchmesh.app.server import OpenServer, address_of, free_port, open_server
from stitchmesh.errors import ParameterError

TOKEN = "correct horse; \"battery\" & #staple=1?é"
"""A token of characters that have a meaning in addresses, cookies and HTML."""


@pytest.fixture(scope="module")
def opened() -> Iterator[OpenServer]:
    """A server that asks for no token."""
    server = open_server(port=0, needs_token=False)
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
     "http://evil.example/127.0.0.1:{port}", "http://user@127.0.0.1:{port}", "http://["],
)  # fmt: skip
def test_a_page_of_another_site_may_not(opened, origin):
    assert not websocket_opens(opened, origin and origin.format(port=opened.port))


@pytest.mark.parametrize(
    ("status", "hosts"),
    [
        (200, ["localhost", "127.0.0.1:9", "127.8.9.1", "[::1]:8080", "LOCALHOST:80"]),
        (403, ["evil.example", "evil.example:8080", "127.0.0.1.evil.example", "10.1.2.3", "", "[::"]),
    ],
)
def test_only_names_of_this_machine_are_accepted(opened, status, hosts):
    """Another site can let a name of its own point here."""
    assert [got(opened, Host=host).status for host in hosts] == [status] * len(hosts)


def test_no_file_outside_the_page_is_sent(opened):
    for path in ("/../../etc/passwd", "/%2e%2e/%2e%2e/etc/passwd", "/..%5c..%5csecret", "/project.json", "/%00"):
        assert got(opened, path).status == 404


def leads_to(answer: HTTPResponse) -> str:
    """The address to which a page of HTML leads at once."""
    found = re.search(r'http-equiv="refresh" content="0; url=([^"]*)"', answer.read().decode())
    assert found is not None
    return html.unescape(found[1])


def cookie_of(server: OpenServer) -> str:
    """The cookie that a browser gets at the printed address."""
    target = urlsplit(server.address)
    assert target.fragment == ""
    return got(server, f"{target.path}?{target.query}").getheader("Set-Cookie").split(";")[0]


def test_a_server_makes_a_token_unless_none_is_wanted(opened):
    assert "?" not in opened.address
    for host in ("127.0.0.1", "0.0.0.0"):
        server = open_server(host=host, port=0)
        assert len(server.address.split("?token=")[1]) >= 32 and got(server).status == 401
        server.stop()


def test_no_path_is_answered_without_the_token(with_token):
    for path in ("/", "/index.html", "/assets/a.js", "/nothing", "//", "/" + "a" * 5_000, "/?a=b"):
        assert got(with_token, path).status == 401


def test_a_token_is_asked_for_and_becomes_a_cookie(with_token):
    asked = got(with_token)
    assert asked.status == 401 and b'type="password"' in asked.read()
    assert got(with_token, "/?token=wrong").status == 401
    answer = got(with_token, f"/?token={quote(TOKEN)}&darkMode=1")
    assert answer.status == 200 and leads_to(answer) == "/?darkMode=1"
    cookie = answer.getheader("Set-Cookie")
    assert "HttpOnly" in cookie and "SameSite=Strict" in cookie and "correct" not in cookie
    pair = cookie.split(";")[0]
    assert got(with_token, Cookie=pair).status == 200
    assert got(with_token, Cookie=f'username="2|1:0|é"; {pair}').status == 200
    assert got(with_token, Cookie=pair + "x").status == 401
    own = f"http://127.0.0.1:{with_token.port}"
    assert websocket_opens(with_token, own, Cookie=pair)
    assert not websocket_opens(with_token, own)
    assert not websocket_opens(with_token, "http://evil.example", Cookie=pair)


def test_a_script_gives_the_token_in_a_header():
    server = open_server(port=0, token="correct-horse")
    own, bearer = f"http://127.0.0.1:{server.port}", "Bearer correct-horse"
    assert got(server, Authorization=bearer).status == 200
    assert websocket_opens(server, own, Authorization=bearer)
    for wrong in ("Bearer correct-horsy", "Basic correct-horse", "Bearer", ""):
        assert got(server, Authorization=wrong).status == 401
        assert not websocket_opens(server, own, Authorization=wrong)
    server.stop()


def test_the_cookie_of_one_server_opens_no_other_one(with_token):
    other = open_server(port=0)
    assert got(with_token, Cookie=cookie_of(with_token)).status == 200
    name, value = cookie_of(with_token).split("=")
    assert name == f"stitchmesh-{with_token.port}"
    assert got(other, Cookie=f"stitchmesh-{other.port}={value}").status == 401
    other.stop()


def test_the_way_back_after_the_token_leads_to_no_other_site(with_token):
    assert leads_to(got(with_token, f"//evil.example/?token={quote(TOKEN)}&a=%22%3E")) == "/?a=%22%3E"


def test_no_link_makes_the_page_obey_another_server(opened):
    address = "ws://evil.example"
    for query in (f"websocket={address}", f"w%65bsocket={address}", "a=1&playbackPath=data:x", "websocket"):
        assert got(opened, f"/?{query}").status == 400


def first_line(server: OpenServer, *lines: str) -> str:
    """The first line of the answer to a request of these lines."""
    with socket.create_connection(("127.0.0.1", server.port), timeout=30) as connection:
        connection.sendall("".join(f"{line}\r\n" for line in (*lines, "")).encode())
        return connection.makefile().readline().strip()


def test_a_header_that_is_given_twice_is_refused(opened, capfd):
    needed = ["GET / HTTP/1.1", f"Host: 127.0.0.1:{opened.port}"]
    assert first_line(opened, *needed).startswith("HTTP/1.1 200 ")
    assert first_line(opened, *needed, needed[1].lower()).startswith("HTTP/1.1 400 ")
    values = {"Content-Length": "0"}
    for name in ("Origin", "Upgrade", "Cookie", "Authorization", "Accept-Encoding", "Content-Length", "Connection"):
        twice = [f"{name}: {values.get(name, 'a')}"] * 2
        assert first_line(opened, *needed, *twice).startswith("HTTP/1.1 400 "), name
    assert capfd.readouterr().err == ""


@pytest.mark.parametrize(
    "lines",
    [["POST / HTTP/1.1"], ["GET / HTTP/1.0"], ["GET / HTTP/1.1", "no header"], ["\x16\x03\x01"], [""],
     ["GET / HTTP/1.1", "Content-Length: x"], ["GET / HTTP/1.1", "Transfer-Encoding: chunked"]],
)  # fmt: skip
def test_what_is_no_request_is_refused(with_token, capfd, lines):
    assert first_line(with_token, *lines).startswith("HTTP/1.1 400 ")
    assert capfd.readouterr().err == ""


def test_a_server_on_a_loopback_host_is_reached_from_this_machine_only():
    assert all(map(is_loopback, ["127.0.0.1", "localhost", "127.8.9.1", "::1"]))
    assert not any(map(is_loopback, ["0.0.0.0", "::", "192.168.0.4", "example.org", ""]))
    assert address_of("::1", 8080, None) == "http://[::1]:8080/"


def test_a_token_that_protects_nothing_is_refused():
    with pytest.raises(ParameterError, match="at least 8"):
        Guard("abc")
    with pytest.raises(ParameterError, match="other machines reach it"):
        open_server(host="0.0.0.0", port=0, needs_token=False)
    with pytest.raises(ParameterError, match="one of both"):
        open_server(port=0, token="correct-horse", needs_token=False)


@pytest.mark.parametrize(
    ("host", "port", "message"),
    [
        ("127.0.0.1", -1, "port: got -1"),
        ("127.0.0.1", 70000, "port: got 70000"),
        ("203.0.113.7", 8080, "address of this machine"),
        ("a" * 70, 8080, "address of this machine"),
    ],
)
def test_a_wrong_address_is_refused(host, port, message):
    with pytest.raises(ParameterError, match=message):
        free_port(host, port)
