# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Progress reports of a relaxation."""

from __future__ import annotations

import io
import math

import pytest
from rich.console import Console

from stitchmesh.cli.progress import seconds_left, show_progress
from stitchmesh.pipeline import relaxing_progress

ENERGIES = {"stretch": 12.5, "bend": 345.0}


def reports_of(*entries: tuple, max_iterations: float = math.inf) -> list[tuple[str, float, str]]:
    """Return the reports of a stage for the given assessments of a solver, at a tolerance of 0.01."""
    reports: list[tuple[str, float, str]] = []
    report_progress = relaxing_progress(
        "yarnrelax", 0.01, lambda *report: reports.append(report), max_iterations=max_iterations
    )
    for entry in entries:
        report_progress(*entry)
    return reports


def test_the_completed_part_follows_from_the_logarithm_of_the_residual():
    done = [part for _, part, _ in reports_of((0, 1.0), (20, 0.1), (40, 0.01), (60, 0.001))]
    assert done == pytest.approx([0.0, 0.5, 1.0, 1.0], abs=1e-12)  # Logarithms in float64.


def test_the_completed_part_is_0_if_the_residual_rises_or_is_infinite():
    assert [part for _, part, _ in reports_of((0, math.inf), (20, 1.0), (40, 3.0))] == [0.0, 0.0, 0.0]


def test_the_completed_part_follows_from_the_iterations_if_these_end_first():
    done = [part for _, part, _ in reports_of((100, 1.0), (150, 0.9), (200, 0.8), max_iterations=200)]
    assert done == [0.0, 0.5, 1.0]


def test_energies_are_in_a_second_line():
    (_, _, mesh), (_, _, yarns) = reports_of((3, 0.5), (20, 0.1, ENERGIES))
    assert mesh == "iteration 3, residual 0.5"
    assert yarns == "iteration 20, residual 0.1\nstretch 12, bend 3.4e+02 erg"


def test_the_remaining_time_follows_from_the_completed_part():
    assert seconds_left(30.0, 0.75) == pytest.approx(10.0)
    assert seconds_left(30.0, 0.01) is None and seconds_left(30.0, 1.0) is None


def drawn(*, terminal: bool, seconds: float, monkeypatch) -> str:
    """Return the output of a relaxation that is half complete after some seconds."""
    now = [0.0]
    monkeypatch.setattr("stitchmesh.cli.progress.time.monotonic", lambda: now[0])
    text = io.StringIO()
    with show_progress(Console(file=text, force_terminal=terminal, width=100, color_system=None)) as progress:
        progress("yarnrelax", 0.0, "900 control points")
        now[0] = seconds
        progress("yarnrelax", 0.5, "iteration 20, residual 0.1\nstretch 12, bend 3.4e+02 erg")
    return text.getvalue()


def test_a_terminal_shows_the_remaining_time_and_the_energies(monkeypatch):
    text = drawn(terminal=True, seconds=40.0, monkeypatch=monkeypatch)
    assert "about 0:00:40 left, iteration 20, residual 0.1" in text
    assert "stretch 12, bend 3.4e+02 erg" in text
    assert "relaxing yarns: 40.0 s" in text


def test_a_file_gets_plain_lines_and_none_in_the_first_seconds(monkeypatch):
    line = "relaxing yarns: 50%, about 40 s left (iteration 20, residual 0.1; stretch 12, bend 3.4e+02 erg)\n"
    assert drawn(terminal=False, seconds=40.0, monkeypatch=monkeypatch) == line
    assert drawn(terminal=False, seconds=1.0, monkeypatch=monkeypatch) == ""
