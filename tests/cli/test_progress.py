# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""What is told while a relaxation runs."""

from __future__ import annotations

import io
import math

import pytest
from rich.console import Console

from stitchmesh.cli.progress import seconds_left, show_progress
from stitchmesh.pipeline import relaxing_progress

ENERGIES = {"stretch": 12.5, "bend": 345.0}


def told(*entries: tuple, max_iterations: float = math.inf) -> list[tuple[str, float, str]]:
    """What reports of a solver become, at a tolerance of 0.01."""
    reports: list[tuple[str, float, str]] = []
    tell = relaxing_progress("yarnrelax", 0.01, lambda *report: reports.append(report), max_iterations=max_iterations)
    for entry in entries:
        tell(*entry)
    return reports


def test_the_part_done_is_the_fall_of_the_logarithm():
    done = [part for _, part, _ in told((0, 1.0), (20, 0.1), (40, 0.01), (60, 0.001))]
    assert done == pytest.approx([0.0, 0.5, 1.0, 1.0], abs=1e-12)  # logarithms in float64


def test_a_residual_that_rises_or_is_not_finite_is_nothing_done():
    assert [part for _, part, _ in told((0, math.inf), (20, 1.0), (40, 3.0))] == [0.0, 0.0, 0.0]


def test_iterations_count_where_they_run_out_first():
    done = [part for _, part, _ in told((100, 1.0), (150, 0.9), (200, 0.8), max_iterations=200)]
    assert done == [0.0, 0.5, 1.0]


def test_energies_stand_in_a_second_line():
    (_, _, mesh), (_, _, yarns) = told((3, 0.5), (20, 0.1, ENERGIES))
    assert mesh == "iteration 3, residual 0.5"
    assert yarns == "iteration 20, residual 0.1\nstretch 12, bend 3.4e+02 erg"


def test_time_left_follows_from_the_part_done():
    assert seconds_left(30.0, 0.75) == pytest.approx(10.0)
    assert seconds_left(30.0, 0.01) is None and seconds_left(30.0, 1.0) is None


def drawn(*, terminal: bool, seconds: float, monkeypatch) -> str:
    """What a relaxation half done after some seconds prints."""
    now = [0.0]
    monkeypatch.setattr("stitchmesh.cli.progress.time.monotonic", lambda: now[0])
    text = io.StringIO()
    with show_progress(Console(file=text, force_terminal=terminal, width=100, color_system=None)) as progress:
        progress("yarnrelax", 0.0, "900 control points")
        now[0] = seconds
        progress("yarnrelax", 0.5, "iteration 20, residual 0.1\nstretch 12, bend 3.4e+02 erg")
    return text.getvalue()


def test_a_terminal_shows_what_is_left_and_the_energies(monkeypatch):
    text = drawn(terminal=True, seconds=40.0, monkeypatch=monkeypatch)
    assert "about 0:00:40 left, iteration 20, residual 0.1" in text
    assert "stretch 12, bend 3.4e+02 erg" in text
    assert "relaxing yarns: 40.0 s" in text


def test_a_file_gets_plain_lines_and_none_of_what_is_soon_done(monkeypatch):
    line = "relaxing yarns: 50%, about 40 s left (iteration 20, residual 0.1; stretch 12, bend 3.4e+02 erg)\n"
    assert drawn(terminal=False, seconds=40.0, monkeypatch=monkeypatch) == line
    assert drawn(terminal=False, seconds=1.0, monkeypatch=monkeypatch) == ""
