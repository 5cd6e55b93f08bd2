# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The files of a project as buttons, and the sending of a file to the browser that asks for it."""

from __future__ import annotations

import threading
from collections.abc import Sequence
from itertools import groupby
from typing import TYPE_CHECKING

from stitchmesh.app.controls.html_pieces import action_button
from stitchmesh.app.project.exports import Export
from stitchmesh.errors import ParameterError, StitchMeshError
from stitchmesh.markup import Markup, joined, markup

if TYPE_CHECKING:
    from stitchmesh.app.application import App


STYLE = markup("""<style>
.sm-project{margin:0 .75em;font-size:.86em;line-height:1.4;color:var(--mantine-color-text)}
.sm-project table{border-collapse:collapse;width:100%}
.sm-project th{text-align:left;font-weight:600;padding:.12em .6em .12em 0;vertical-align:top;white-space:nowrap}
.sm-project td{padding:.12em 0;overflow-wrap:anywhere}
.sm-project p{margin:.3em 0}
.sm-project button{font:inherit;cursor:pointer;padding:.15em .45em;margin:0 .25em .25em 0;border-radius:5px;
 border:1px solid var(--mantine-color-default-border);background:var(--mantine-color-default);
 color:var(--mantine-color-text)}
.sm-project button:focus-visible{outline:3px solid #e08a1e;outline-offset:1px}
.sm-project svg{flex:none}
.sm-project .one{display:flex;align-items:center;gap:.2em}
.sm-project .wide{display:flex;flex:1 1 auto;gap:.5em;align-items:center;text-align:left;overflow-wrap:anywhere}
.sm-project .trouble{border-left:4px solid #96233c;padding-left:.5em;font-weight:600}
</style>""")


def download_list(files: list[Export]) -> Markup:
    """Return a button for each file that the project can send; ``data-value`` is the name of the file."""
    rows = []
    for what, group in groupby(files, key=lambda file: file.what):
        buttons = joined(
            action_button(
                "download", file.name, file.suffix, name=f"Download {what.lower()} as {file.suffix}", hint=file.name
            )
            for file in group
        )
        rows.append(markup("<tr><th scope='row'>{}</th><td>{}</td></tr>", what, buttons))
    text = markup("<table>{}</table>", joined(rows)) if rows else markup("<p>There is nothing to download yet.</p>")
    return markup('{}<div class="sm-project">{}</div>', STYLE, text)


def send_file(app: App, files: Sequence[Export], name: str) -> None:
    """Send a file; a thread of its own writes it, because large files take seconds.

    Args:
        app: the application, which shows an error of the file as a notice.
        files: the files that the project holds.
        name: name of one of these files.

    Raises:
        ParameterError: no file has this name.
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
