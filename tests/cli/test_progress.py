# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The display of progress on a terminal and in a file."""

from __future__ import annotations

import io

from rich.console import Console

from stitchmesh.cli.progress import show_progress


def drawn(*, terminal: bool, seconds: float, monkeypatch) -> str:
    """Return the output of a relaxation that is half complete after some seconds."""
    now = [0.0]
    monkeypatch.setattr("stitchmesh.cli.progress.time.monotonic", lambda: now[0])
    text = io.StringIO()
    with show_progress(Console(file=text, force_terminal=terminal, width=100, color_system=None)) as progress:
        progress("yarnrelax", 0.0, "900 control points")
        now[0] = seconds
        progress("yarnrelax", 0.5, "iteration 20, residual 0.1\nas many as 900 points")
    return text.getvalue()


def test_a_terminal_shows_the_remaining_time_and_a_second_line(monkeypatch):
    text = drawn(terminal=True, seconds=40.0, monkeypatch=monkeypatch)
    assert "20 to 80 s left, iteration 20, residual 0.1" in text
    assert "as many as 900 points" in text
    assert "relaxing yarns: 40.0 s" in text


def test_a_file_gets_plain_lines_and_none_in_the_first_seconds(monkeypatch):
    line = "relaxing yarns: 50%, 20 to 80 s left (iteration 20, residual 0.1; as many as 900 points)\n"
    assert drawn(terminal=False, seconds=40.0, monkeypatch=monkeypatch) == line
    assert drawn(terminal=False, seconds=1.0, monkeypatch=monkeypatch) == ""
