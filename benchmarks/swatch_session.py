# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Response of a live swatch: time from a change to the first frame and to convergence, and time per frame.

    python benchmarks/swatch_session.py
    python benchmarks/swatch_session.py --device cuda:0 --quality standard

Each pattern relaxes in a free cell. Then several changes are made, each of them after the swatch has converged. The
kernels are compiled and loaded by a run of all changes before the measured run. Then the swatch is drawn again, and
single steps with different numbers of iterations per frame are timed.
"""

from __future__ import annotations

import argparse
import platform
import time
from dataclasses import replace
from typing import Any

import stitchmesh as sm
from stitchmesh.compute.device import device_named
from stitchmesh.quality import quality_named

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


def watched(session: sm.SwatchSession, number: int) -> str:
    """Return a line of the table: the frames after the frame ``number`` until the swatch has converged."""
    first = session.wait_for_frame(LONGEST, after=number)
    assert first is not None
    last = first
    while last.report["running"]:
        frame = session.wait_for_frame(LONGEST, after=last.number)
        assert frame is not None
        last = frame
    if last.error is not None:
        return f"{last.error}"
    seconds = last.report["seconds"]
    rate = (last.number - number) / seconds
    at_rest = "" if last.report["at_rest"] else "  not at rest"
    speed = f"{1e3 * first.report['seconds']:>9.1f}{rate:>9.0f}{last.report['iteration']:>12}{seconds:>9.2f}"
    return f"{speed}{last.size[0]:>10.3f}{last.report['energy']:>12.1f}{at_rest}"


def measure(pattern: str, quality: str, device: str | None, show: bool) -> None:
    """Make the changes of a pattern, and print their times."""
    with sm.SwatchSession(pattern, quality=quality, device=device, relax_cell=True) as session:
        session.wait_until_rest(LONGEST)
        points, width = len(session.frame.yarns.points), session.frame.size[0]
        for name, change in changes_of(pattern, width).items():
            number = session.frame.number
            session.set(**change) if change else session.restart()
            line = watched(session, number)
            if show:
                print(f"{pattern:<13}{points:>7}  {name:<27}{line}", flush=True)


def frame_times(pattern: str, quality: str, device: str | None) -> str:
    """Return a line of the table: milliseconds per frame for each number of iterations per frame."""
    times, endless = [], replace(quality_named(quality), tolerance=NEVER)
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
    return f"{pattern:<13}{points:>7}" + "".join(f"{each:>10.2f}" for each in times)


def main() -> None:
    """Time the changes of each pattern."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--quality", default="draft")
    parser.add_argument("--device")
    parser.add_argument("--patterns", nargs="+", default=PATTERNS)
    given = parser.parse_args()
    device = device_named(given.device)
    print(f"{device.name or platform.machine()}; {given.quality}; Python {platform.python_version()}")
    print(f"{'pattern':<13}{'points':>7}  {'change':<27}{'first ms':>9}{'frames/s':>9}{'iterations':>12}{'rest s':>9}"
          f"{'width cm':>10}{'energy erg':>12}")
    for pattern in given.patterns:
        measure(pattern, given.quality, given.device, show=False)
        measure(pattern, given.quality, given.device, show=True)
    print(f"\n{'ms per frame of':<15}{'points':>5}" + "".join(f"{count:>7} it." for count in FRAME_ITERATIONS))
    for pattern in given.patterns:
        print(frame_times(pattern, given.quality, given.device), flush=True)


if __name__ == "__main__":
    main()
