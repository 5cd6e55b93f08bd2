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
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from typing import Literal, TextIO, TypeVar

Progress = Callable[[str, float, str], None]
"""Function that reports progress: called with the stage, its completed part (0 to 1), and one or two lines of text."""
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
    "swatches": "relaxing swatches",
    "picture": "drawing the picture",
    "sweep": "running the sweep",
}
"""Text for each stage."""
SMALLEST_PART, LARGEST_PART = 0.05, 0.99
"""Completed parts between which the remaining time is estimated. A relaxation reports at most the second one, because
a residual below the tolerance does not end it (``yarnrelax.convergence``)."""
LINE_SECONDS = 0.2
"""Shortest time between two changes of the line [s]; a computation that ends within this time shows no line."""
NOTEBOOK_SHELL = "ZMQInteractiveShell"
"""Class of the shell in which a notebook runs Python."""


def no_progress(stage: str, done: float, note: str) -> None:
    """Report no progress (a ``Progress`` function)."""


def seconds_left(spent: float, done: float) -> float | None:
    """Estimate the remaining time of a stage [s].

    Args:
        spent: time so far [s].
        done: completed part, from 0 to 1.

    Returns:
        The remaining time at constant speed; None if the completed part is too small, or the stage is nearly complete.
    """
    return spent * (1.0 - done) / done if SMALLEST_PART < done < LARGEST_PART else None


def relaxing_progress(
    stage: str, tolerance: float, progress: Progress, *, max_iterations: float = math.inf, seconds_after: float = 0.0
) -> Callable[..., None]:
    """Return a function that converts the assessments of a solver into the completed part of a stage.

    The returned function is called with the iteration, the residual and, optionally, the energies by term. Residuals
    decrease approximately geometrically, so that the completed part is computed from the logarithm of the smallest
    residual so far, or from the number of iterations if that gives a larger part. With work after the stage, the
    completed part is the time so far over the estimated time until the end of that work.

    Args:
        stage: name of the stage.
        tolerance: residual at which the stage is complete.
        progress: called with the completed part and a line of text.
        max_iterations: iterations at which the stage is complete.
        seconds_after: estimated time of the work that follows the stage [s], for example of a picture.
    """
    start: list[tuple[int, float]] = []
    smallest = math.inf
    began = time.monotonic()

    def report_assessment(iteration: int, residual: float, energies: Mapping[str, float] | None = None) -> None:
        """Report one assessment."""
        nonlocal smallest
        if not start and residual > tolerance and math.isfinite(residual):
            start.append((iteration, residual))
        done = 0.0
        if start and residual > 0.0:
            first, highest = start[0]
            smallest = min(smallest, residual)
            decrease = math.log(highest / smallest) / math.log(highest / tolerance)
            done = max(decrease, (iteration - first) / max(max_iterations - first, 1.0))
        done = part_with_work_after(min(max(done, 0.0), LARGEST_PART), time.monotonic() - began, seconds_after)
        progress(stage, done, _note(iteration, residual, energies or {}))

    return report_assessment


def part_with_work_after(done: float, spent: float, seconds_after: float) -> float:
    """Return the completed part of a stage and of the work after it.

    Args:
        done: completed part of the stage, from 0 to 1.
        spent: time so far [s].
        seconds_after: estimated time of the work after the stage [s].
    """
    return done if done == 0.0 or seconds_after == 0.0 else spent / (spent / done + seconds_after)


def _note(iteration: int, residual: float, energies: Mapping[str, float]) -> str:
    """Iteration and residual of a relaxation, and its energies in a second line."""
    line = f"iteration {iteration}, residual {residual:.3g}"
    if not energies:
        return line
    return f"{line}\n{', '.join(f'{term} {energy:.2g}' for term, energy in energies.items())} erg"


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
    """Return the stream that shows progress: that of a notebook or of a terminal; None if there is neither."""
    if threading.current_thread() is not threading.main_thread():
        return None
    shell = getattr(builtins, "get_ipython", None)  # IPython adds this function to the built-in ones.
    if shell is not None and type(shell()).__name__ == NOTEBOOK_SHELL:
        return sys.stdout
    return sys.stderr if sys.stderr is not None and sys.stderr.isatty() else None


class _Line:
    """One line of a stream, which each report replaces (a ``Progress`` function)."""

    def __init__(self, stream: TextIO) -> None:
        self._stream, self._stage, self._width = stream, "", 0
        self._changed = self._began = time.monotonic()

    def __call__(self, stage: str, done: float, note: str) -> None:
        now = time.monotonic()
        if stage != self._stage:
            self._stage, self._began = stage, now
        if now - self._changed < LINE_SECONDS:
            return
        self._changed = now
        left = seconds_left(now - self._began, done)
        estimate = "" if left is None else f", about {left:.0f} s left"
        self._write(f"{STAGE_TEXTS.get(stage, stage)}: {done:.0%}{estimate} ({note.splitlines()[0]})")

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
