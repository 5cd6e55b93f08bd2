# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Sending the files of a project to the browser that asks for them."""

from __future__ import annotations

import threading
from collections.abc import Sequence
from typing import TYPE_CHECKING

from stitchmesh.app.project.exports import Export
from stitchmesh.errors import ParameterError, StitchMeshError

if TYPE_CHECKING:
    from stitchmesh.app.application import App


def send_file(app: App, files: Sequence[Export], name: str) -> None:
    """Send a file; it is written in a thread of its own, because large files take seconds.

    Args:
        app: the application; an error of the file becomes a notice there.
        files: the files that the project holds.
        name: name of one of them.

    Raises:
        ParameterError: none of them has this name.
    """
    found = [file for file in files if file.name == name]
    if not found:
        raise ParameterError(f"download {name!r}: the project does not hold it any more")
    asked = app, found[0], app.front.acting_client
    threading.Thread(target=_send, args=asked, name=f"download of {name}", daemon=True).start()


def _send(app: App, file: Export, client: int | None) -> None:
    try:
        content = file.content()
    except StitchMeshError as error:
        app.post(app.report, error)
    else:
        app.post(app.download, file.name, content, client)
