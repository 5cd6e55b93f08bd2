# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Progress of long computations, and the line that shows it if the caller asks for nothing else.

A function with an argument ``progress`` calls the function that it is given. With ``False`` it shows nothing. With
``None``, the default, it shows one line on a terminal (standard error) or in a notebook, and removes the line at the
end. Nothing is shown in a file, a pipe, a test or a thread other than the main one, so that a library that uses this
one stays silent.
"""

from __future__ import annotations

import builtins
import math
import shutil
import sys
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Literal, TextIO, TypeVar

import numpy as np

Progress = Callable[[str, float, str], None]
"""Function that reports progress. Its arguments are the stage, the estimate of its completed part (0 to 1), and one or
two lines of text."""
T = TypeVar("T", bound=Callable[..., None])
STAGE_TEXTS = {
    "label": "labeling rows",
    "tessellate": "tessellating",
    "shape": "finding rows",
    "edit": "editing stitches",
    "pattern": "applying the pattern",
    "meshrelax": "relaxing the stitch mesh",
    "outline": "relaxing the outline",
    "yarngen": "generating yarns",
    "yarnrelax": "relaxing yarns",
    "match": "matching the cloth to its yarns",
    "triangles": "draping triangles alone",
    "drape": "draping",
    "follow": "following the body",
    "animate": "carrying the yarns with the cloth",
    "swatches": "relaxing swatches",
    "book": "writing the swatch book",
    "grade": "making the sizes",
    "fit": "fitting the yarn",
    "picture": "drawing the picture",
    "pictures": "drawing the frames",
    "sweep": "running the sweep",
    "warm-up": "compiling kernels",
}
"""Text for each stage."""
SMALLEST_PART = 0.05
"""The remaining time is estimated from this completed part on."""
SPREADS = (1.25, 2.0)
"""Least and largest factor between the estimate of the remaining time and an end of its range. The least is above 1,
because estimates that agree can be wrong together. A first estimate has the largest factor."""
CREEP = 0.2
"""The power with which the rest shrinks while the reported part does not grow."""
TIME_STEPS = (
    (10.0, 1.0, "s", 1.0), (120.0, 5.0, "s", 1.0), (7200.0, 60.0, "min", 60.0), (math.inf, 1800.0, "h", 3600.0),
)  # fmt: skip
"""Each row: a remaining time below the first number [s] is rounded to the step [s], and shown in the unit, which has
the last number of seconds."""
LINE_SECONDS = 0.2
"""Shortest time between two changes of the line [s]; a computation that ends within this time shows no line."""
POWER = 0.8
"""The residual falls with this power of the number of iterations."""
LEFT = (0.7, 2.7)
"""Least and most remaining iterations, over the iterations so far. A residual below its goal does not end a relaxation
(``yarnrelax.convergence``), and one far above its goal says little beyond a few times the iterations so far."""
FEWEST = 3
"""Number of assessments that a line needs."""


def no_progress(stage: str, done: float, note: str) -> None:
    """Report no progress (a ``Progress`` function)."""


@dataclass(frozen=True)
class Outlook:
    """What a reader is told about a stage."""

    part: float
    """Completed part, from 0 to 1. It never falls, and it grows as long as the stage goes on."""
    left: tuple[float, float] | None
    """Least and most remaining time [s]; None while it cannot be estimated."""

    @property
    def percent(self) -> str:
        """The completed part in percent, which is 100 at the end only."""
        return f"{math.floor(100.0 * self.part)}%"

    @property
    def words(self) -> str:
        """The remaining time in words: ``20 to 80 s left``; an empty text while it cannot be estimated."""
        if self.left is None:
            return ""
        least, most = (_rounded(seconds) for seconds in self.left)
        if least == most:
            return f"{' '.join(most)} left"
        return f"{least[0] if least[1] == most[1] else ' '.join(least)} to {' '.join(most)} left"


class StageClock:
    """Makes the outlook of one stage from the parts that it reports as completed, and from the times of these reports.

    A reported part is an estimate too: the part of a relaxation may fall when its forecast changes. The estimate of the
    whole time is the time so far over the part. The estimates of the second half of the time so far differ, and their
    spread gives the width of the range of the remaining time. While the reported part does not grow, the shown part
    creeps. With the time t that has passed since the last report,

        1 - part  ->  (1 - part) (left / (left + t))^CREEP

    A power of 1 would suit a correct forecast, but a wrong one would show 99 % long before the end.
    """

    def __init__(self) -> None:
        """Begin the stage."""
        self._part, self._spent = 0.0, 0.0
        self._totals: list[tuple[float, float]] = []
        """The reports in the second half of the time so far: the time, and the estimate of the whole time [s]."""

    def outlook(self, spent: float, done: float) -> Outlook:
        """Return the outlook after a report.

        Args:
            spent: time so far [s].
            done: completed part that the stage reports, from 0 to 1.
        """
        if not (SMALLEST_PART < done < 1.0 and spent > 0.0):
            self._part = max(self._part, done)
            return Outlook(self._part, None)
        left = spent / done - spent
        self._totals = [(at, total) for at, total in self._totals if at >= spent / 2.0]
        if not self._totals or spent >= 1.01 * self._totals[-1][0]:  # others say the same
            self._totals.append((spent, left + spent))
        totals = [total for _at, total in self._totals]
        known = self._totals[0][0] < spent
        spread = min(max(max(totals) / min(totals), SPREADS[0]), SPREADS[1]) if known else SPREADS[1]
        if done <= self._part:
            done = 1.0 - (1.0 - self._part) * (left / (left + spent - self._spent)) ** CREEP
        self._part, self._spent = done, spent
        return Outlook(self._part, (left / spread, left * spread))


def _rounded(seconds: float) -> tuple[str, str]:
    """Return the number and the unit of a remaining time, rounded as ``TIME_STEPS`` says."""
    step, unit, size = next((step, unit, size) for most, step, unit, size in TIME_STEPS if seconds < most)
    return f"{max(round(seconds / step), 1) * step / size:g}", unit


class ResidualCourse:
    """The residuals of a stage, which may be several relaxations one after another, and what they forecast.

    The soft motions of a fabric come to rest after the stiff ones, so that the residual r falls about by a power of the
    number of iterations n. A line is laid through the last assessments:

        ln r = ln R - POWER ln(n / N),        left = N ((R / goal)^(1 / POWER) - 1)

    Here N is the number of iterations so far. R is the level of the line at N, chosen so that as many assessments lie
    above the line as below it; single bad assessments therefore do not change it. The slope is a constant, because a
    slope that is fitted to the last assessments follows their noise and forecasts worse. ``POWER`` and the bounds of
    the remaining iterations were chosen for the courses of ``tests/courses``, where the tests say how well the forecast
    meets them.
    """

    def __init__(self) -> None:
        """Begin without assessments."""
        self._before = 0
        """Iterations of the relaxations that have ended."""
        self._assessments: list[tuple[int, float]] = []

    def add(self, iteration: int, residual: float) -> None:
        """Add an assessment; if its iteration is not after the last one, another relaxation has begun."""
        if self._assessments and iteration <= self._assessments[-1][0]:
            self._before += self._assessments[-1][0]
            self._assessments = []
        self._assessments.append((iteration, residual))

    def completed_part(self, goal: float, most: float = math.inf) -> float:
        """Return the forecast part of the iterations that is done; 0 while there is no forecast.

        Args:
            goal: residual near which the relaxation ends.
            most: number of iterations after which the relaxation ends in any case.
        """
        n, r = np.array(self._assessments, dtype=np.float64).T
        known = (n > 0.0) & (r > 0.0) & np.isfinite(r)
        n, r = n[known], r[known]
        if len(n) < FEWEST:
            return 0.0
        late = n >= min(n[-1] / 4.0, n[-FEWEST])  # the line begins at a quarter of the iterations so far
        level = float(np.median(np.log(r[late]) + POWER * np.log(n[late] / n[-1])))
        growth = math.expm1(min((level - math.log(goal)) / POWER, math.log(1.0 + LEFT[1])))
        left = min(n[-1] * max(growth, LEFT[0]), max(most - n[-1], 0.0))
        done = self._before + float(n[-1])
        return done / (done + left)


def relaxing_progress(
    stage: str, goal: float, progress: Progress, *, max_iterations: float = math.inf
) -> Callable[..., None]:
    """Return a function that turns the assessments of a solver into the completed part of a stage.

    The returned function takes the iteration and the residual. The completed part is the part of the iterations that is
    done, by the forecast of ``ResidualCourse``.

    Args:
        stage: name of the stage.
        goal: residual near which the stage is complete (``Quality.resting_residual`` for yarns).
        progress: called with the completed part and a line of text.
        max_iterations: iterations at which the stage is complete.
    """
    course = ResidualCourse()

    def report_assessment(iteration: int, residual: float) -> None:
        course.add(iteration, residual)
        done = course.completed_part(goal, max_iterations)
        progress(stage, done, f"iteration {iteration}, residual {residual:.3g}")

    return report_assessment


def with_work_after(progress: Progress, seconds: float) -> Progress:
    """Return a progress function that counts later work, for example a picture, as a part of the stage.

    Args:
        progress: called with the time so far over the estimated time until that work ends.
        seconds: estimated time of the work [s].
    """
    began = time.monotonic()

    def report(stage: str, done: float, note: str) -> None:
        """Report the completed part of the stage and of the work after it."""
        progress(stage, part_with_work_after(done, time.monotonic() - began, seconds), note)

    return report


def part_with_work_after(done: float, spent: float, seconds_after: float) -> float:
    """Return the completed part of a stage and of the work after it.

    Args:
        done: completed part of the stage, from 0 to 1.
        spent: time so far [s].
        seconds_after: estimated time of the work after the stage [s].
    """
    return done if done == 0.0 or seconds_after == 0.0 else spent / (spent / done + seconds_after)


@contextmanager
def shown_progress(given: T | Literal[False] | None, convert: Callable[[Progress], T]) -> Iterator[T | None]:
    """Provide the progress function of a computation; the module docstring says which function that is.

    Args:
        given: function of the caller, False or None.
        convert: converts a ``Progress`` function into a function of the kind that the computation calls.

    Returns:
        A context manager of the function, or of None if nothing is shown. The line is removed when the block ends.
    """
    stream = output_stream() if given is None else None
    if stream is None:
        yield given or None
        return
    line = _Line(stream)
    try:
        yield convert(line)
    finally:
        line.remove()


@contextmanager
def shown_stages(given: Progress | Literal[False] | None) -> Iterator[Progress]:
    """Provide the progress function of a computation with several stages.

    Args:
        given: function of the caller, False or None (module docstring).

    Returns:
        A context manager of the function, which does nothing if nothing is shown.
    """
    with shown_progress(given, lambda line: line) as report:
        yield report or no_progress


def output_stream() -> TextIO | None:
    """Return the stream of a notebook or of a terminal, which shows progress; None if there is neither."""
    if threading.current_thread() is not threading.main_thread():
        return None
    shell = getattr(builtins, "get_ipython", None)  # IPython adds this function to the built-in ones.
    if shell is not None and type(shell()).__name__ == "ZMQInteractiveShell":  # the shell of a notebook
        return sys.stdout
    return sys.stderr if sys.stderr is not None and sys.stderr.isatty() else None


class _Line:
    """One line of a stream, which each report replaces (a ``Progress`` function)."""

    def __init__(self, stream: TextIO) -> None:
        self._stream, self._stage, self._width = stream, "", 0
        self._clock = StageClock()
        self._changed = self._began = time.monotonic()

    def __call__(self, stage: str, done: float, note: str) -> None:
        now = time.monotonic()
        if stage != self._stage:
            self._stage, self._began, self._clock = stage, now, StageClock()
        outlook = self._clock.outlook(now - self._began, done)
        if now - self._changed < LINE_SECONDS:
            return
        self._changed = now
        words = f", {outlook.words}" if outlook.words else ""
        self._write(f"{STAGE_TEXTS.get(stage, stage)}: {outlook.percent}{words} ({note.splitlines()[0]})")

    def remove(self) -> None:
        """Remove the line, if there is one."""
        if self._width:
            self._write("")
            self._stream.write("\r")
            self._stream.flush()

    def _write(self, text: str) -> None:
        """Replace the line by a text, which is cut at the width of the terminal."""
        text = text[: shutil.get_terminal_size().columns - 1]
        self._stream.write(f"\r{text.ljust(self._width)}")
        self._stream.flush()
        self._width = len(text)
