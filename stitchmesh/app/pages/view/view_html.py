# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The texts of the page as HTML: the list of results, legends, pictures, texts, jobs and reports."""

from __future__ import annotations

import base64
from collections.abc import Mapping, Sequence
from typing import Any

from stitchmesh.app.controls.html_pieces import SMALL, action_button, colour_bar, figures, legend_of_key
from stitchmesh.app.pages.view.opened import Viewed
from stitchmesh.jobs.job_status import JobStatus
from stitchmesh.markup import Markup, joined, markup
from stitchmesh.render.colouring import Coloured

FRAMES = markup(
    '<div class="sm-frames" role="status" style="font-size:.86em;font-variant-numeric:tabular-nums"></div>'
)
"""The element that the script ``frame_rate.js`` fills."""
MOST = 0.99
"""Largest share of a running stage that is shown as completed."""


def list_of_results(names: Sequence[str], chosen: str) -> Markup:
    """Return the list of things to show, as buttons."""
    if not names:
        nothing = "There is nothing to see yet. Open a file, or make something on the other pages."
        return markup('<p style="font-size:.86em;margin:.2em 0">{}</p>', nothing)
    buttons = joined(
        action_button("show", name, name, current="true" if name == chosen else "")
        for name in names
    )
    return markup(
        '<nav class="sm-nav" style="flex-wrap:wrap" aria-label="What the scene shows">{}</nav>',
        buttons,
    )


def legend_of(coloured: Coloured) -> Markup:
    """Return the legend of colours as HTML: names, or a bar for numbers; an empty text if they need none."""
    if coloured.scale is None:
        return legend_of_key(coloured.key) if coloured.key else Markup()
    numbers, units = zip(*(text.split(" ", 1) for text, _ in reversed(coloured.key)), strict=True)
    return colour_bar(coloured.scale.table(9), numbers, units[0])


def shown_in_panel(viewed: Viewed) -> Markup:
    """Return a picture, or the text of a file, as HTML."""
    if viewed.picture:
        code = base64.b64encode(viewed.picture).decode("ascii")
        return markup('<img alt="{}" style="max-width:100%" src="data:image/png;base64,{}">', viewed.name, code)
    if viewed.text and viewed.thing is None:
        style = "font-size:.75em;max-height:24em;overflow:auto;white-space:pre-wrap"
        return markup('<pre tabindex="0" aria-label="{}" style="{}">{}</pre>', viewed.name, style, viewed.text)
    return Markup()


def job_html(status: JobStatus | None) -> Markup:
    """Return the state of a job; an empty text without a job."""
    if status is None:
        return Markup()
    rows = [(one.name, "kept" if one.kept else f"{one.seconds:.1f} s") for one in status.stages]
    title, bar = f"The job {_state(status)} after {status.seconds:,.0f} s", Markup()
    if status.state == "running" and (status.done < 1.0 or status.note):
        done = min(status.done, MOST)
        left = f", {status.outlook.words}" if status.outlook.words and done < MOST else ""
        rows.append((status.stage, f"{done:.0%}{left}"))
        frame = '<progress value="{}" aria-label="{}" style="width:100%"></progress>'
        bar = markup(frame, f"{done:.3f}", status.stage)
    note = markup('<p style="{};margin:.2em 0">{}</p>', SMALL, status.note) if status.note else Markup()
    return figures(rows, title) + bar + note


def report_html(report: Mapping[str, Any]) -> Markup:
    """Return the numbers of a report; an empty text for a report without an entry ``mixed``."""
    mixed = report.get("mixed")
    if not isinstance(mixed, dict):
        return Markup()
    unit = "dyn" if mixed.get("mode") == "static" else "cm/s"
    rows = [
        ("Converged", "yes" if mixed.get("converged") else "no"),
        ("Error", f"{_number(mixed, 'error'):.2g} {unit}"),
        ("Steps", f"{_number(mixed, 'steps'):,.0f}"),
        ("Time of a step", f"{_number(mixed, 'seconds_per_step'):.3g} s"),
        ("Newton iterations", f"{_number(mixed, 'newton_iterations'):,.0f}"),
        ("Products with the matrix", f"{_number(mixed, 'solve_iterations'):,.0f}"),
        ("Largest memory", f"{1e-6 * _number(mixed, 'memory_bytes'):,.0f} MB"),
        ("Energy", f"{_number(mixed, 'energy'):.4g} erg"),
    ]
    energies = mixed.get("energies")
    if isinstance(energies, dict):
        rows += [(f"of {name}", f"{_number(energies, name):.4g} erg") for name in energies]
    return figures(rows, "Report")


def _state(status: JobStatus) -> str:
    verbs = {"running": "is running", "finished": "has finished", "stopped": "was stopped", "failed": "has failed"}
    return verbs.get(status.state, "was killed")


def _number(table: Mapping[str, Any], name: str) -> float:
    """Return a number of a table; 0 if the table has none of this name."""
    value = table.get(name)
    return float(value) if isinstance(value, int | float) else 0.0
