# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Progress reports of a relaxation, and the line that is shown by default."""

from __future__ import annotations

import builtins
import inspect
import io
import math
import sys
import threading

import pytest

import stitchmesh
from stitchmesh import progress
from stitchmesh.progress import (
    LARGEST_PART,
    output_stream,
    part_with_work_after,
    relaxing_progress,
    seconds_left,
    shown_progress,
)

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
    # Logarithms in float64; a residual below the tolerance does not end a relaxation.
    assert done == pytest.approx([0.0, 0.5, LARGEST_PART, LARGEST_PART], abs=1e-12)


def test_the_completed_part_is_0_if_the_residual_rises_or_is_infinite():
    assert [part for _, part, _ in reports_of((0, math.inf), (20, 1.0), (40, 3.0))] == [0.0, 0.0, 0.0]


def test_the_completed_part_follows_from_the_iterations_if_these_end_first():
    done = [part for _, part, _ in reports_of((100, 1.0), (150, 0.9), (200, 0.8), max_iterations=200)]
    assert done == [0.0, 0.5, LARGEST_PART]


def test_energies_are_in_a_second_line():
    (_, _, mesh), (_, _, yarns) = reports_of((3, 0.5), (20, 0.1, ENERGIES))
    assert mesh == "iteration 3, residual 0.5"
    assert yarns == "iteration 20, residual 0.1\nstretch 12, bend 3.4e+02 erg"


def test_the_remaining_time_follows_from_the_completed_part():
    assert seconds_left(30.0, 0.75) == pytest.approx(10.0)
    assert seconds_left(30.0, 0.01) is None and seconds_left(30.0, 1.0) is None


def test_the_completed_part_counts_the_work_after_the_stage():
    """With 10 s of a stage that is half complete and 5 s of a picture, 10 of 25 s are over and 15 s remain."""
    part = part_with_work_after(0.5, 10.0, 5.0)
    assert part == pytest.approx(10.0 / 25.0) and seconds_left(10.0, part) == pytest.approx(15.0)
    assert part_with_work_after(0.5, 10.0, 0.0) == 0.5 and part_with_work_after(0.0, 10.0, 5.0) == 0.0
    assert part_with_work_after(1.0, 10.0, 5.0) == pytest.approx(10.0 / 15.0)


class Terminal(io.StringIO):
    """A stream that is a terminal."""

    def isatty(self) -> bool:
        return True


def shell(name: str):
    """Return a function like ``get_ipython``, whose shell has the given name."""
    return type(name, (), {})


def test_a_line_is_shown_on_a_terminal_or_in_a_notebook_only(monkeypatch):
    terminal, notebook = Terminal(), io.StringIO()
    monkeypatch.setattr(sys, "stderr", terminal)
    monkeypatch.setattr(sys, "stdout", notebook)
    assert output_stream() is terminal
    monkeypatch.setattr(builtins, "get_ipython", shell("ZMQInteractiveShell"), raising=False)
    assert output_stream() is notebook
    monkeypatch.setattr(builtins, "get_ipython", shell("TerminalInteractiveShell"))
    assert output_stream() is terminal
    monkeypatch.setattr(sys, "stderr", io.StringIO())
    assert output_stream() is None
    monkeypatch.setattr(sys, "stderr", None)  # as in a program without a console
    assert output_stream() is None


def test_no_line_is_shown_in_another_thread(monkeypatch):
    monkeypatch.setattr(sys, "stderr", Terminal())
    found = []
    thread = threading.Thread(target=lambda: found.append(output_stream()))
    thread.start()
    thread.join()
    assert found == [None]


def test_the_function_of_the_caller_is_called_and_false_shows_nothing(monkeypatch):
    terminal = Terminal()
    monkeypatch.setattr(sys, "stderr", terminal)
    calls: list[tuple] = []
    with shown_progress(lambda *words: calls.append(words), lambda line: line) as report:
        report("label", 0.5, "note")
    with shown_progress(False, lambda line: line) as report:
        assert report is None
    assert calls == [("label", 0.5, "note")] and terminal.getvalue() == ""


def test_the_line_is_replaced_cut_at_the_width_and_removed(monkeypatch):
    terminal, now = Terminal(), [0.0]
    monkeypatch.setattr(sys, "stderr", terminal)
    monkeypatch.setattr(progress.time, "monotonic", lambda: now[0])
    monkeypatch.setenv("COLUMNS", "60")
    with shown_progress(None, lambda line: line) as report:
        report("yarnrelax", 0.0, "too early for a line")
        now[0] = 10.0
        report("yarnrelax", 0.5, "iteration 20, residual 0.1\nstretch 12 erg")
        now[0] = 10.1
        report("yarnrelax", 0.6, "too soon after the last one")
        now[0] = 20.0
        report("yarnrelax", 0.8, "i")
    first = "relaxing yarns: 50%, about 10 s left (iteration 20, residual 0.1)"[:59]
    second = "relaxing yarns: 80%, about 5 s left (i)"
    assert terminal.getvalue() == f"\r{first}\r{second.ljust(59)}\r{' ' * len(second)}\r"


def test_a_failure_removes_the_line(monkeypatch):
    terminal, now = Terminal(), [0.0]
    monkeypatch.setattr(sys, "stderr", terminal)
    monkeypatch.setattr(progress.time, "monotonic", lambda: now[0])
    with pytest.raises(KeyboardInterrupt), shown_progress(None, lambda line: line) as report:
        now[0] = 1.0
        report("meshrelax", 0.0, "iteration 1")
        raise KeyboardInterrupt
    assert terminal.getvalue().endswith(f"\r{' ' * len('relaxing the stitch mesh: 0% (iteration 1)')}\r")


def functions_with_progress() -> list[str]:
    functions = [name for name in stitchmesh.__all__ if inspect.isfunction(getattr(stitchmesh, name))]
    return [name for name in functions if "progress" in inspect.signature(getattr(stitchmesh, name)).parameters]


@pytest.mark.parametrize("name", functions_with_progress())
def test_every_public_function_shows_progress_by_default_and_nothing_with_false(name):
    given = inspect.signature(getattr(stitchmesh, name)).parameters["progress"]
    assert given.default is None and given.annotation.endswith("| Literal[False] | None")
