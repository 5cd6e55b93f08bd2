# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Options of the commands that open the application in the browser."""

from __future__ import annotations

import os
from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Annotated

from stitchmesh.app.guard import LOOPBACK, PORT
from stitchmesh.cli.words import Flag, help_entry

if TYPE_CHECKING:
    from stitchmesh.app.project.project import Project


@dataclass(frozen=True)
class Serving:
    """Where the application listens."""

    port: Annotated[int, help_entry("N")] = PORT
    """port of the address; the next free one is taken if it is in use, and any free one for 0"""
    host: Annotated[str, help_entry("ADDRESS")] = LOOPBACK
    """address of this machine on which to listen; other machines reach an address such as 0.0.0.0"""
    token: Annotated[str | None, help_entry("TEXT", "a new one")] = None
    """token that a browser needs; other users can see it here, and not in the variable STITCHMESH_TOKEN"""
    no_token: Flag = False
    """ask for no token; every user of this machine can then read and write files as you"""
    no_browser: Flag = False
    """print the address only, and open no browser"""

    def run(self, open_project: Callable[[], Project], page: str | None = None) -> None:
        """Run the application on a project until it is interrupted."""
        from stitchmesh.app.run import RunOptions, run_app

        token = self.token
        if token is None and not self.no_token:
            token = os.environ.get("STITCHMESH_TOKEN") or None
        options = RunOptions(
            host=self.host, port=self.port, token=token, needs_token=not self.no_token, browser=not self.no_browser
        )
        run_app(open_project, options, page=page)
