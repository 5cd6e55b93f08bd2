# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""What the page Project says, as HTML: the state of each stage, the downloads and the recent projects."""

from __future__ import annotations

from html import escape
from itertools import groupby
from pathlib import Path

from stitchmesh.app.project.exports import Export
from stitchmesh.app.project.project import Project
from stitchmesh.app.project.recent import RecentProject

STYLE = """<style>
.sm-project{margin:0 .75em;font-size:.86em;line-height:1.4;color:var(--mantine-color-text)}
.sm-project table{border-collapse:collapse;width:100%}
.sm-project th{text-align:left;font-weight:600;padding:.12em .6em .12em 0;vertical-align:top;white-space:nowrap}
.sm-project td{padding:.12em 0;overflow-wrap:anywhere}
.sm-project p{margin:.3em 0}
.sm-project button{font:inherit;cursor:pointer;padding:.15em .45em;margin:0 .25em .25em 0;border-radius:5px;
 border:1px solid var(--mantine-color-default-border);background:var(--mantine-color-default);
 color:var(--mantine-color-text)}
.sm-project button:focus-visible{outline:3px solid #e08a1e;outline-offset:1px}
.sm-project .wide{display:block;width:100%;text-align:left}
.sm-project .trouble{border-left:4px solid #96233c;padding-left:.5em;font-weight:600}
</style>"""
NOT_YET = "not yet"


def project_summary(project: Project) -> str:
    """Return the name, the place and the stages of a project."""
    rows = "".join(f"<tr><th scope='row'>{escape(name)}</th><td>{escape(text)}</td></tr>"
                   for name, text in stage_lines(project))  # fmt: skip
    notes = "".join(f'<p class="trouble">{escape(note)}</p>' for note in project.notes)
    return f'{STYLE}<div class="sm-project">{saving_line(project)}{notes}<table>{rows}</table></div>'


def saving_line(project: Project) -> str:
    """Return one line that says where the project is, or why it cannot be saved."""
    trouble = project.autosave.trouble
    if trouble is not None:
        return f'<p class="trouble" role="alert">{escape(trouble)}. It is tried again every few seconds.</p>'
    return f"<p>Every change is saved at once in <b>{escape(_short(project.folder))}</b>.</p>"


def stage_lines(project: Project) -> list[tuple[str, str]]:
    """Return the name of each stage, and in words what it holds."""
    return [
        ("Mesh", _mesh(project)),
        ("Rows", _rows(project)),
        ("Stitches", _stitches(project)),
        ("Edits", str(len(project.edits)) if project.edits else NOT_YET),
        ("Evened out", "yes" if project.evened is not None else NOT_YET),
        ("Yarns", NOT_YET if project.yarns is None else f"{len(project.yarns.points):,} control points"),
        ("Relaxed", NOT_YET if project.relaxed is None else _relaxed(project)),
    ]


def download_list(files: list[Export]) -> str:
    """Return a button for each file that the project can send; ``data-value`` is the name of the file."""
    rows = []
    for what, group in groupby(files, key=lambda file: file.what):
        buttons = "".join(
            f'<button type="button" data-action="download" data-value="{escape(file.name)}"'
            f' aria-label="Download {escape(what.lower())} as {escape(file.suffix)}" title="{escape(file.name)}">'
            f"{escape(file.suffix)}</button>"
            for file in group
        )
        rows.append(f"<tr><th scope='row'>{escape(what)}</th><td>{buttons}</td></tr>")
    text = f"<table>{''.join(rows)}</table>" if rows else "<p>There is nothing to download yet.</p>"
    return f'{STYLE}<div class="sm-project">{text}</div>'


def recent_list(projects: list[RecentProject], present: Path) -> str:
    """Return a button for each recent project except the present one; ``data-value`` is its place in the list."""
    buttons = "".join(
        f'<button type="button" class="wide" data-action="open" data-value="{number}"'
        f' aria-label="Open the project {escape(one.name)}">{escape(one.name)}'
        f"<br><small>{escape(_short(one.folder))}</small></button>"
        for number, one in enumerate(projects)
        if one.folder != present
    )
    return f'{STYLE}<div class="sm-project">{buttons or "<p>No other project was open yet.</p>"}</div>'


def _mesh(project: Project) -> str:
    if project.source is None:
        return "none yet: import one, or take an example"
    if project.mesh is None:
        return f"{project.source.name}, which holds stitches"
    return f"{project.source.name}, {project.mesh.face_count:,} faces"


def _rows(project: Project) -> str:
    labeling = project.labeling
    if labeling is None:
        return NOT_YET if project.fabric is None else "in the stitches"
    if project.shaping is not None:
        return "found on the mesh"
    if project.labeled is not None:
        return f"{labeling.row_count:,}"
    done = int(labeling.labeled.sum())
    return f"{labeling.row_count:,}; {done:,} of {labeling.mesh.face_count:,} faces" if done else NOT_YET


def _stitches(project: Project) -> str:
    return NOT_YET if project.fabric is None else f"{project.fabric.face_count:,}"


def _relaxed(project: Project) -> str:
    report = project.report or {}
    if report.get("unfinished"):
        return "stopped before rest"
    return "at rest" if report.get("converged", True) else "not at rest"


def _short(folder: Path) -> str:
    """Return a path, with ~ for the home."""
    home = Path.home()
    return f"~/{folder.relative_to(home)}" if folder.is_relative_to(home) and folder != home else str(folder)
