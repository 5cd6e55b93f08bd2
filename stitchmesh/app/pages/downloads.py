# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The files that a project can send to the user: each value in each format that can hold it, as buttons."""

from __future__ import annotations

import threading
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from itertools import groupby
from pathlib import Path
from typing import TYPE_CHECKING, Any

from stitchmesh.app.controls.html_pieces import action_button
from stitchmesh.app.project.project import Project
from stitchmesh.editing.history import write_log
from stitchmesh.errors import ParameterError, StitchMeshError
from stitchmesh.hand_knitting import knitting_instructions
from stitchmesh.io.atomic import temporary_file, write_json, write_text
from stitchmesh.io.history import write_history
from stitchmesh.io.meshes import FORMATS as MESH_FORMATS
from stitchmesh.io.meshes import write_mesh
from stitchmesh.io.stitches import WRITABLE as STITCH_SUFFIXES
from stitchmesh.io.stitches import write_stitches
from stitchmesh.io.yarns import FORMATS as YARN_FORMATS
from stitchmesh.io.yarns import write_yarns
from stitchmesh.labeling import write_labeling
from stitchmesh.labeling.steps import write_label_steps
from stitchmesh.markup import Markup, joined, markup
from stitchmesh.mesh import StitchMesh
from stitchmesh.yarn import YarnSet

if TYPE_CHECKING:
    from stitchmesh.app.application import App

PATTERN_FILE = "pattern.pdf"
"""Name of the pattern to take home."""


@dataclass(frozen=True)
class Export:
    """A file that a project can send."""

    what: str
    """Description of the content, such as ``Relaxed yarns``."""
    name: str
    """Name of the file, with its suffix."""
    write: Callable[[Path], object]
    """Writes the file."""

    @property
    def suffix(self) -> str:
        """Suffix of the file."""
        return Path(self.name).suffix

    def content(self) -> bytes:
        """Return the bytes of the file.

        Raises:
            StitchMeshError: the format cannot hold the value.
        """
        with temporary_file(self.name) as path:
            self.write(path)
            return path.read_bytes()


def exports(project: Project, picture: bytes | None = None) -> list[Export]:
    """Return the files that a project can send at present, in the order of the stages.

    Args:
        project: the project.
        picture: a PNG for the first page of the pattern to take home.
    """
    return [*_of_mesh(project), *_of_stitches(project, picture), *_of_yarns(project), *_of_relaxation(project)]


def _of_mesh(project: Project) -> Iterator[Export]:
    if project.mesh is not None:
        yield from _formats("Mesh", "mesh", MESH_FORMATS, write_mesh, project.mesh)
    if project.label_steps:
        yield _file("Steps of the labeling", "labeling.jsonl", write_label_steps, project.label_steps)
    if project.labeling is not None and project.labeled is None:
        yield _file("Partly labeled mesh", "labeling.h5", write_labeling, project.labeling)
    if project.labeled is not None:
        yield from _formats("Labeled mesh", "labeled", (".h5", ".smobj"), write_stitches, project.labeled)


def _of_stitches(project: Project, picture: bytes | None) -> Iterator[Export]:
    if project.fabric is not None:
        yield _pattern(project.evened or project.fabric, project.relaxed or project.yarns, project.name, picture)
        yield from _formats("Stitches", "stitches", STITCH_SUFFIXES, write_stitches, project.fabric)
        yield _file("Knitting instructions", "instructions.txt", _write_instructions, project.fabric)
    if project.edits:
        yield _file("Edits", "edits.jsonl", write_log, project.edits)
    if project.evened is not None:
        yield from _formats("Evened stitches", "evened", STITCH_SUFFIXES, write_stitches, project.evened)


def _of_yarns(project: Project) -> Iterator[Export]:
    suffixes = [suffix for suffix in YARN_FORMATS if suffix != ".pyp"]
    for what, name, yarns in (("Yarns", "yarns", project.yarns), ("Relaxed yarns", "relaxed", project.relaxed)):
        if yarns is not None:
            yield from _formats(what, name, suffixes, write_yarns, yarns)


def _of_relaxation(project: Project) -> Iterator[Export]:
    if project.report is not None:
        yield _file("Report of the relaxation", "report.json", write_json, project.report)
    if project.history:
        yield _file("Convergence", "convergence.csv", write_history, project.history)


def _formats(what: str, name: str, suffixes: Any, write: Callable[..., object], value: object) -> Iterator[Export]:
    for suffix in suffixes:
        yield _file(what, f"{name}{suffix}", write, value)


def _file(what: str, name: str, write: Callable[[Path, Any], object], value: object) -> Export:
    return Export(what, name, lambda path: write(path, value))


def _pattern(fabric: StitchMesh, yarns: YarnSet | None, title: str, picture: bytes | None) -> Export:
    def write(path: Path) -> None:
        from stitchmesh.render.pattern_sheet import garment_sheet, write_pattern_sheet

        write_pattern_sheet(path, garment_sheet(fabric, yarns, title=title, picture=picture))

    return Export("Pattern to knit", PATTERN_FILE, write)


def _write_instructions(path: Path, fabric: StitchMesh) -> None:
    write_text(path, knitting_instructions(fabric))


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
