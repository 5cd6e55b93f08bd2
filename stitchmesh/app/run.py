# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Runs the application until the user ends it."""

from __future__ import annotations

import signal
import threading
import webbrowser
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass
from types import FrameType

from stitchmesh.app.application import App
from stitchmesh.app.guard import LOOPBACK, PORT, entrance
from stitchmesh.app.project.opening import projects_folder, remember
from stitchmesh.app.project.project import Project
from stitchmesh.app.server import OpenServer, open_server
from stitchmesh.app.viser_front import ViserFront
from stitchmesh.errors import FileError, StitchMeshError

NO_TOKEN = "no token: every user of this machine, and whoever else reaches the port, can read and write files as you"
"""The consequence of a server without a token."""


@dataclass(frozen=True, kw_only=True)
class RunOptions:
    """Where the application listens, and whether it opens a browser."""

    host: str = LOOPBACK
    """Address of this machine on which the server listens."""
    port: int = PORT
    """Port; if it is in use, the server takes the next free one."""
    token: str | None = None
    """Token that browsers need; None for a new one."""
    needs_token: bool = True
    """Whether browsers need a token."""
    browser: bool = True
    """Whether to open the address in the user's browser."""


def run_app(
    open_project: Callable[[], Project], options: RunOptions, *, page: str | None = None,
    say: Callable[[str], object] = print,
) -> None:  # fmt: skip
    """Run the application on a project until a signal interrupts or terminates it; then save the project.

    Args:
        open_project: opens or makes the project, after the application has found that it can listen.
        options: where the application listens.
        page: page to open first; None for the page that was open last in the project.
        say: called with each line for the user.

    Raises:
        ParameterError: an error of ``open_server``, or there is no such page.
        StitchMeshError: the project cannot be opened.
    """
    opened = open_server(options.host, options.port, options.token, needs_token=options.needs_token)
    try:
        project = open_project()
    except StitchMeshError:
        opened.stop()
        raise
    app = App(project, ViserFront(opened.server))
    remember(project)
    app.post(lambda: app.open_page(page or app.last_page()))
    try:
        with _asked_to_end() as end:
            for line in opening_lines(opened, options, project):
                say(line)
            with _browser(opened, options, say):
                end.wait()
    finally:
        app.close()
        opened.stop()
    say(f"the application has ended; {app.project.name} is saved")


def opening_lines(opened: OpenServer, options: RunOptions, project: Project) -> list[str]:
    """Return the lines for the user after the server has opened."""
    lines = [f"{project.name}: {project.folder}", *project.notes]
    if options.port not in (0, opened.port):
        lines.append(f"port {options.port} is in use; took {opened.port}")
    if not options.needs_token:
        lines.append(NO_TOKEN)
    return [*lines, f"open {opened.address} (Ctrl+C ends the application; everything is saved)"]


@contextmanager
def _browser(opened: OpenServer, options: RunOptions, say: Callable[[str], object]) -> Iterator[None]:
    """Open the address in the user's browser, if wanted; a page that leads to it stays until the end."""
    with ExitStack() as stack:
        if options.browser and not options.needs_token:
            webbrowser.open(opened.address)
        elif options.browser:
            try:
                page = stack.enter_context(entrance(opened.address, projects_folder()))
            except FileError as error:
                say(f"no browser is opened: {error}")
            else:
                webbrowser.open(page.as_uri())
        yield


@contextmanager
def _asked_to_end() -> Iterator[threading.Event]:
    """Make Ctrl+C and SIGTERM set an event instead of ending the process."""
    end = threading.Event()

    def ask(number: int, frame: FrameType | None) -> None:
        end.set()

    before = {number: signal.signal(number, ask) for number in (signal.SIGINT, signal.SIGTERM)}
    try:
        yield end
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)
