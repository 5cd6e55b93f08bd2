# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Response of a live swatch: time from a change to the first frame and to convergence, and time per frame.

Each pattern relaxes in a free cell. Then several changes are made, each of them after the swatch has converged. The
kernels are compiled and loaded by a run of all changes before the measured run. Then the swatch is drawn again, and
single steps with different numbers of iterations per frame are timed.
"""

from __future__ import annotations

import platform
import time
from dataclasses import replace
from typing import Any

import stitchmesh as sm
from benchmarks.table import Rows
from stitchmesh.compute.device import device_named
from stitchmesh.quality import PRESETS

PATTERNS = ("stockinette", "rib2x2", "honeycomb")
FRAME_ITERATIONS = (1, 5, 20, 100)
"""Numbers of iterations per frame that are timed."""
TIMED_ITERATIONS = 300
"""Iterations over which the time of a frame is measured."""
NEVER = 1e-12
"""Tolerance at which no swatch comes to rest while it is timed."""
LONGEST = 300.0
"""Time limit of a change [s]."""


def changes_of(pattern: str, width: float) -> dict[str, dict[str, Any]]:
    """Return the changes by name; each change starts from the state after the previous one."""
    take_up = sm.RestLengths(held=0.6) if pattern == "honeycomb" else sm.RestLengths(factor=0.6)
    return {
        "drawn anew": {},
        "gamma 1 to 1.3": {"gamma": 1.3},
        "gamma 1.3 to 1": {"gamma": 1.0},
        "width -10 %": {"period": (0.9 * width, None)},
        "width free again": {"period": (None, None)},
        "slips taken up to 0.6" if pattern == "honeycomb" else "all yarn taken up to 0.6": {"rest_lengths": take_up},
        "chart to garter": {"rest_lengths": sm.RestLengths(), "pattern": "garter"},
        f"chart to {pattern}": {"pattern": pattern},
    }


def watched(session: sm.SwatchSession, number: int) -> tuple[object, ...]:
    """Return cells of the table: the frames after the frame ``number`` until the swatch has converged."""
    first = session.wait_for_frame(LONGEST, after=number)
    assert first is not None
    last = first
    while last.report["running"]:
        frame = session.wait_for_frame(LONGEST, after=last.number)
        assert frame is not None
        last = frame
    if last.error is not None:
        return (last.error,)
    seconds = last.report["seconds"]
    rate = (last.number - number) / seconds
    at_rest = "" if last.report["at_rest"] else ", not at rest"
    speed = f"{1e3 * first.report['seconds']:.1f}", f"{rate:.0f}", last.report["iteration"], f"{seconds:.2f}"
    return *speed, f"{last.size[0]:.3f}", f"{last.report['energy']:.1f}{at_rest}"


def measure(pattern: str, device: str | None, show: bool) -> Rows:
    """Make the changes of a pattern, and print their times."""
    with sm.SwatchSession(pattern, quality="draft", device=device, relax_cell=True) as session:
        session.wait_until_rest(LONGEST)
        points, width = len(session.frame.yarns.points), session.frame.size[0]
        for name, change in changes_of(pattern, width).items():
            number = session.frame.number
            session.set(**change) if change else session.restart()
            cells = watched(session, number)
            if show:
                yield pattern, points, name, *cells


def frame_times(pattern: str, device: str | None) -> tuple[object, ...]:
    """Return a line of the table: milliseconds per frame for each number of iterations per frame."""
    times, endless = [], replace(PRESETS["draft"], tolerance=NEVER)
    with sm.SwatchSession(
        pattern, quality=endless, device=device, relax_cell=True, relaxation="frictionless", stopped=True
    ) as session:
        points = len(session.frame.yarns.points)
        for count in FRAME_ITERATIONS:
            session.iterations_per_frame = count
            session.reset()
            session.step(timeout=LONGEST)  # the first step starts the relaxation
            before, began = session.frame, time.perf_counter()
            last = session.step(TIMED_ITERATIONS // count, timeout=LONGEST)
            times.append(1e3 * (time.perf_counter() - began) / (last.number - before.number))
    return pattern, points, *(f"{each:.2f}" for each in times)


def swatch_session(*, device: str | None = None) -> Rows:
    """Time the changes of each pattern."""
    yield f"{device_named(device).name or platform.machine()}; draft; Python {platform.python_version()}"
    yield "pattern", "points", "change", "first ms", "frames/s", "iterations", "rest s", "width cm", "energy erg"
    for pattern in PATTERNS:
        yield from measure(pattern, device, show=False)
        yield from measure(pattern, device, show=True)
    yield ""
    yield "ms per frame of", "points", *(f"{count} it." for count in FRAME_ITERATIONS)
    for pattern in PATTERNS:
        yield frame_times(pattern, device)
