# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""What the page Project says, as HTML: the state of each stage, the downloads and the recent projects."""

from __future__ import annotations

from itertools import groupby
from pathlib import Path

from stitchmesh.app.controls.html_pieces import action_button
from stitchmesh.app.project.exports import Export
from stitchmesh.app.project.project import Project
from stitchmesh.app.project.recent import RecentProject
from stitchmesh.io.garments import doubt_of_unit
from stitchmesh.io.meshes import stated_unit
from stitchmesh.io.units import other_units
from stitchmesh.markup import Markup, joined, markup
from stitchmesh.mesh import extent
from stitchmesh.mesh.upright import Y

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
NOT_YET = "not yet"


def project_summary(project: Project) -> Markup:
    """Return the name, the place and the stages of a project."""
    rows = joined(markup("<tr><th scope='row'>{}</th><td>{}</td></tr>", name, text)
                   for name, text in stage_lines(project))  # fmt: skip
    notes = joined(markup('<p class="trouble">{}</p>', note) for note in project.notes)
    taken = joined(markup("<p>{}.</p>", _sentence(note)) for note in _taken(project))
    return markup(
        '{}<div class="sm-project">{}{}<table>{}</table>{}</div>',
        STYLE, saving_line(project), notes, rows, taken,
    )


def saving_line(project: Project) -> Markup:
    """Return one line that says where the project is, or why it cannot be saved."""
    trouble = project.autosave.trouble
    if trouble is not None:
        return markup('<p class="trouble" role="alert">{}. It is tried again every few seconds.</p>', trouble)
    return markup("<p>Every change is saved at once in <b>{}</b>.</p>", _short(project.folder))


def stage_lines(project: Project) -> list[tuple[str, str]]:
    """Return the name of each stage, and in words what it holds."""
    return [
        ("Mesh", _mesh(project)),
        *([("Repaired", " ".join(f"{action.text}: {action.places}." for action in project.repairs))]
          if project.repairs else []),
        ("Rows", _rows(project)),
        ("Stitches", _stitches(project)),
        ("Edits", str(len(project.edits)) if project.edits else NOT_YET),
        ("Evened out", "yes" if project.evened is not None else NOT_YET),
        ("Yarns", NOT_YET if project.yarns is None else f"{len(project.yarns.points):,} control points"),
        ("Relaxed", NOT_YET if project.relaxed is None else _relaxed(project)),
    ]


def unit_offer(project: Project) -> Markup:
    """Return what is odd about the size of the mesh, and a button for each unit in which it would be a garment.

    The action is ``unit``, and ``data-value`` is the unit; there is nothing to show for the size of a garment.
    """
    mesh, source = project.mesh, project.source
    doubt = "" if mesh is None or source is None else doubt_of_unit(source.name, mesh, source.unit)
    if mesh is None or source is None or not doubt:
        return Markup()
    others = {} if stated_unit(source.name) else other_units(mesh.vertices, source.unit)
    buttons = joined(
        action_button("unit", unit, f"Read it in {unit}: {size}", wide=True) for unit, size in others.items()
    )
    # The sentence names the option of the command line for each unit, for which there is a button here.
    said = doubt.partition(";")[0] if others else doubt
    return markup('{}<div class="sm-project"><p class="trouble">{}.</p>{}</div>', STYLE, _sentence(said), buttons)


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


def recent_list(projects: list[RecentProject], present: Path, doomed: Path | None) -> Markup:
    """Return two buttons for each recent project except the present one, which open and delete it.

    Args:
        projects: the projects; ``data-value`` of a button is the place in this list.
        present: folder of the present project.
        doomed: folder of the project of which the user is asked whether it shall be deleted; None if of none.
    """
    buttons = joined(
        _question(number, one) if one.folder == doomed else _recent(number, one)
        for number, one in enumerate(projects)
        if one.folder != present
    )
    others = buttons or markup("<p>No other project was open yet.</p>")
    return markup('{}<div class="sm-project">{}</div>', STYLE, others)


def _recent(number: int, one: RecentProject) -> Markup:
    """Return the buttons that open and delete a project."""
    picture = markup(
        '<svg viewBox="-4 -4 108 108" width="44" height="44" aria-hidden="true">'
        '<path d="{}" stroke="currentColor" stroke-width="2" fill="none"/></svg>',
        one.outline,
    )
    content = markup(
        "{}<span>{}<br><small>{}<br>{}</small></span>",
        picture, one.name, f"{one.changed:%d %b %Y, %H:%M}", _short(one.folder),
    )
    return markup(
        '<div class="one">{}{}</div>',
        action_button("open", number, content, name=f"Open the project {one.name}", wide=True),
        action_button("delete", number, "Delete", name=f"Delete the project {one.name}"),
    )


def _question(number: int, one: RecentProject) -> Markup:
    """Return the question whether a project shall be deleted."""
    return markup(
        '<div class="one" role="alert"><span>Delete <b>{}</b> for ever? </span>{}{}</div>',
        one.name, action_button("delete-now", number, "Delete it"), action_button("keep", number, "Keep it"),
    )


def _mesh(project: Project) -> str:
    if project.source is None:
        return "none yet: import one, or take an example"
    if project.mesh is None:
        return f"{project.source.name}, which holds stitches"
    turned = "" if project.up == Y else ", turned upright"
    return f"{project.source.name}, {project.mesh.face_count:,} faces, {extent(project.mesh.vertices)}{turned}"


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


def _taken(project: Project) -> list[str]:
    """Return what was taken of the file, without the options of the command line, for which there are choices here."""
    if project.garment is None or project.source is None:
        return []
    doubt = doubt_of_unit(project.source.name, project.garment.mesh, project.source.unit)
    return [note.rpartition(";")[0] for note in project.garment.notes if note != doubt]


def _sentence(clause: str) -> str:
    """Return a clause with a capital letter first."""
    return clause[:1].upper() + clause[1:]


def _short(folder: Path) -> str:
    """Return a path, with ~ for the home."""
    home = Path.home()
    return f"~/{folder.relative_to(home)}" if folder.is_relative_to(home) and folder != home else str(folder)
