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
import subprocess
import sys
from collections.abc import Callable
from functools import partial
from pathlib import Path
from urllib.parse import urlsplit
from urllib.request import url2pathname

import psutil
import pytest

from stitchmesh.app.entrance import entrance
from stitchmesh.app.project.project import Project
from stitchmesh.app.run import NO_TOKEN, RunOptions, run_app
from tests.app.app_process import app_process
from tests.gallery import ROOT


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
        run_app(partial(Project.create, tmp_path / "project"), RunOptions(port=0, **options), say=say)
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


def test_what_is_no_request_is_answered_and_no_fault_of_the_program(tmp_path):
    with app_process(tmp_path / "project") as running:
        with socket.create_connection(("127.0.0.1", running.port), timeout=30) as connection:
            connection.sendall(b"\x16\x03\x01\r\n\r\n")
            assert connection.makefile().readline().startswith("HTTP/1.1 400 ")
        assert running.terminate() == 0
        assert "Traceback" not in running.output()


def test_no_list_of_processes_holds_the_token(tmp_path):
    """A browser that is a program of its own is started with the page, as any browser of a user is."""
    browser = tmp_path / "browser"
    os.mkfifo(tmp_path / "given")
    browser.write_text(f'#!/bin/sh\necho "$@" > {tmp_path}/given\n')
    browser.chmod(0o700)
    process = subprocess.Popen(
        [sys.executable, "-m", "stitchmesh", "app", "--project", str(tmp_path / "project"), "--port", "0"], cwd=ROOT,
        env={**os.environ, "BROWSER": f"{browser} %s", "STITCHMESH_PROJECTS": str(tmp_path), "PYTHONUNBUFFERED": "1",
             "XDG_STATE_HOME": str(tmp_path / "state"), "STITCHMESH_TOKEN": "correct-horse"},
        stdout=subprocess.PIPE, text=True,
    )  # fmt: skip
    assert process.stdout is not None
    assert any("?token=correct-horse" in line for line in process.stdout)
    given = (tmp_path / "given").read_text()
    words = psutil.Process(process.pid).cmdline()
    process.terminate()
    process.wait(60)
    assert given.startswith(f"file://{tmp_path}/browser~") and "correct-horse" not in f"{given} {words}"
