# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""How far a job is, as a table: the stages that have ended, and the present one with its remaining time."""

from __future__ import annotations

from stitchmesh.app.controls.html_pieces import SMALL, figures
from stitchmesh.jobs.job_status import JobStatus
from stitchmesh.markup import Markup, markup

MOST = 0.99
"""Largest part of a stage that is shown as completed while it runs."""


def job_html(status: JobStatus | None) -> Markup:
    """Return the state of a job; an empty text for what is no job."""
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


def _state(status: JobStatus) -> str:
    """Return the state as a verb."""
    verbs = {"running": "is running", "finished": "has finished", "stopped": "was stopped", "failed": "has failed"}
    return verbs.get(status.state, "was killed")
