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
    CREEP,
    Outlook,
    ResidualCourse,
    StageClock,
    output_stream,
    part_with_work_after,
    relaxing_progress,
    shown_progress,
)
from stitchmesh.run import SHOWN


def reports_of(*entries: tuple, max_iterations: float = math.inf) -> list[tuple[str, float, str]]:
    """Return the reports of a stage for the given assessments of a solver, with a goal of 0.01."""
    reports: list[tuple[str, float, str]] = []
    report_progress = relaxing_progress(
        "yarnrelax", 0.01, lambda *report: reports.append(report), max_iterations=max_iterations
    )
    for entry in entries:
        report_progress(*entry)
    return reports


def test_the_completed_part_is_that_of_the_forecast():
    course = ResidualCourse()
    entries = [(20 * number, 1.0 / (1 + number)) for number in range(5)]
    for entry in entries:
        course.add(*entry)
    assert reports_of(*entries)[-1] == ("yarnrelax", course.completed_part(0.01), "iteration 80, residual 0.2")


def test_the_completed_part_follows_from_the_iterations_if_these_end_first():
    done = [part for _, part, _ in reports_of((50, 1.0), (100, 0.9), (150, 0.9), (200, 0.8), max_iterations=200)]
    assert done == [0.0, 0.0, 0.75, 1.0]


def test_the_remaining_time_of_even_work_is_known_better_and_better():
    """A first estimate may be wrong by a factor of two, equal estimates of the whole time by one of 1.25."""
    clock = StageClock()
    assert clock.outlook(1.0, 0.01) == Outlook(0.01, None)
    assert clock.outlook(10.0, 0.25) == Outlook(0.25, (15.0, 60.0))
    assert clock.outlook(20.0, 0.5) == Outlook(0.5, (16.0, 25.0))
    assert clock.outlook(40.0, 1.0) == Outlook(1.0, None)


def test_the_range_is_as_wide_as_the_estimates_of_the_second_half_differ():
    """Whole times of 40 and then of 60 s, after 20 and after 30 s; the one of 100 s after 5 s is too long ago."""
    clock = StageClock()
    for spent, whole in ((5.0, 100.0), (20.0, 40.0)):
        clock.outlook(spent, spent / whole)
    assert clock.outlook(30.0, 0.5).left == pytest.approx((30.0 / 1.5, 30.0 * 1.5))


def test_a_part_that_falls_is_shown_as_one_that_grows_more_slowly():
    """After 10 of 20 s it is found that 30 s are left: 3 s later, a tenth of them has passed, and 1 / 1.1 is left."""
    clock = StageClock()
    assert clock.outlook(10.0, 0.5).part == 0.5
    shown = clock.outlook(13.0, 13.0 / 43.0).part
    assert shown == pytest.approx(1.0 - 0.5 * (1.0 / 1.1) ** CREEP)
    assert (Outlook(0.999, None).percent, Outlook(1.0, None).percent) == ("99%", "100%")


@pytest.mark.parametrize(
    ("left", "words"),
    [
        (None, ""),
        ((0.2, 0.3), "1 s left"),
        ((21.0, 84.0), "20 to 85 s left"),
        ((52.0, 130.0), "50 s to 2 min left"),
        ((7000.0, 21_000.0), "117 min to 6 h left"),
    ],
)
def test_the_remaining_time_has_few_digits(left, words):
    assert Outlook(0.5, left).words == words


def test_the_completed_part_counts_the_work_after_the_stage():
    """With 10 s of a stage that is half complete and 5 s of a picture, 10 of 25 s are over and 15 s remain."""
    assert part_with_work_after(0.5, 10.0, 5.0) == pytest.approx(10.0 / 25.0)
    assert part_with_work_after(0.5, 10.0, 0.0) == 0.5 and part_with_work_after(0.0, 10.0, 5.0) == 0.0
    assert part_with_work_after(1.0, 10.0, 5.0) == pytest.approx(10.0 / 15.0)


class Terminal(io.StringIO):
    """A stream that is a terminal."""

    def isatty(self) -> bool:
        return True


def shell(name: str):
    """Return a function like ``get_ipython``, whose shell has the given name."""
    return type(name, (), {})


def test_a_line_is_shown_on_a_terminal_or_in_a_notebook_only_and_not_of_another_thread(monkeypatch):
    terminal, notebook = Terminal(), io.StringIO()
    monkeypatch.setattr(sys, "stderr", terminal)
    monkeypatch.setattr(sys, "stdout", notebook)
    assert output_stream() is terminal
    monkeypatch.setattr(builtins, "get_ipython", shell("ZMQInteractiveShell"), raising=False)
    assert output_stream() is notebook
    monkeypatch.setattr(builtins, "get_ipython", shell("TerminalInteractiveShell"))
    assert output_stream() is terminal
    found = []
    thread = threading.Thread(target=lambda: found.append(output_stream()))
    thread.start()
    thread.join()
    assert found == [None]
    monkeypatch.setattr(sys, "stderr", io.StringIO())
    assert output_stream() is None
    monkeypatch.setattr(sys, "stderr", None)  # as in a program without a console
    assert output_stream() is None


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
    first = "relaxing yarns: 50%, 5 to 20 s left (iteration 20, residual 0.1)"[:59]
    second = "relaxing yarns: 80%, 3 to 7 s left (i)"
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


def functions_with(argument: str) -> list[str]:
    functions = [name for name in stitchmesh.__all__ if inspect.isfunction(getattr(stitchmesh, name))]
    return [name for name in functions if argument in inspect.signature(getattr(stitchmesh, name)).parameters]


def test_every_public_function_shows_progress_by_default_and_nothing_with_false():
    for name in functions_with("run"):
        assert inspect.signature(getattr(stitchmesh, name)).parameters["run"].default is SHOWN, name
    for name in functions_with("progress"):
        given = inspect.signature(getattr(stitchmesh, name)).parameters["progress"]
        assert given.default is None and given.annotation.endswith("| Literal[False] | None"), name
