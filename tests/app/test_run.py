# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The application tells its user the address; its browser gets the token through a page that only the user reads."""

from __future__ import annotations

import html
import os
import re
import signal
import socket
import stat
from collections.abc import Callable
from functools import partial
from pathlib import Path
from urllib.parse import urlsplit
from urllib.request import url2pathname

import pytest

from stitchmesh.app.guard import entrance
from stitchmesh.app.project.project import Project
from stitchmesh.app.run import NO_TOKEN, RunOptions, run_app


@pytest.fixture
def run(tmp_path, monkeypatch) -> Callable[..., list[str]]:
    """A function that runs the application until its browser has opened, or cannot open; it returns what was said."""
    monkeypatch.setenv("STITCHMESH_PROJECTS", str(tmp_path / "projects"))
    monkeypatch.setenv("XDG_STATE_HOME", str(tmp_path / "state"))

    def run(look: Callable[[str], object], **options: object) -> list[str]:
        lines: list[str] = []

        def open_and_end(address: str) -> None:
            look(address)
            signal.raise_signal(signal.SIGTERM)

        def say(line: str) -> None:
            lines.append(line)
            if line.startswith("no browser"):
                signal.raise_signal(signal.SIGTERM)

        monkeypatch.setattr("webbrowser.open", open_and_end)
        run_app(partial(Project.create, tmp_path / "project"), RunOptions(**{"port": 0, **options}), say=say)
        return lines

    return run


def test_the_browser_gets_the_token_through_a_page_for_the_user_alone(run, tmp_path):
    seen = []

    def look(address: str) -> None:
        page = Path(url2pathname(urlsplit(address).path))
        seen.extend([address, page.read_text(), *(one.stat().st_mode for one in (page, page.parent))])

    lines = run(look, token="correct horse \"é")
    address, text, *modes = seen
    assert address.startswith("file://") and "correct" not in address
    printed = re.search(r"open (http://\S+)", "\n".join(lines))[1]
    assert printed.endswith("?token=correct%20horse%20%22%C3%A9")
    assert html.unescape(re.search(r"url=([^\"]*)", text)[1]) == printed
    assert [stat.S_IMODE(mode) for mode in modes] == [0o600, 0o700]
    assert list((tmp_path / "projects").iterdir()) == []


def test_the_page_of_a_program_that_was_killed_is_removed_by_the_next_one(run, tmp_path):
    projects = tmp_path / "projects"
    with entrance("http://127.0.0.1/", projects) as other:
        killed = projects / "browser~killed"
        killed.mkdir()
        (killed / "open.html").write_text("a token")
        victim = projects / "victim"
        victim.mkdir()
        (victim / "open.html").write_text("mine")
        (projects / "browser~link").symlink_to(victim)
        run(lambda address: None)
        assert sorted(os.listdir(projects)) == sorted([other.parent.name, "browser~link", "victim"])
        assert os.listdir(victim) == ["open.html"] and other.exists()


def test_a_page_that_others_could_read_is_not_made(run, monkeypatch, tmp_path):
    real = os.fstat
    monkeypatch.setattr("os.fstat", lambda file: os.stat_result([real(file).st_mode | 0o044, *real(file)[1:]]))
    seen = []
    lines = run(seen.append)
    assert seen == [] and any("lets other users read" in line for line in lines)
    assert list((tmp_path / "projects").iterdir()) == []


def test_without_a_token_the_user_is_told_what_it_means(run):
    seen = []
    lines = run(seen.append, needs_token=False)
    assert NO_TOKEN in lines and "\n" not in NO_TOKEN and "every user of this machine" in NO_TOKEN
    assert seen[0].startswith("http://127.0.0.1:") and "token" not in seen[0]


def test_a_port_in_use_is_said(run):
    with socket.create_server(("127.0.0.1", 0)) as other:
        port = other.getsockname()[1]
        lines = run(lambda address: None, port=port)
    assert any(line.startswith(f"port {port} is in use; took ") for line in lines)
