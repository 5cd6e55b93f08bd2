# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""A relaxation in the worker thread: snapshots, estimates, and what ends it."""

from __future__ import annotations

import threading
from collections.abc import Iterator
from typing import Any

import pytest

from stitchmesh.app.event_queue import EventQueue
from stitchmesh.app.pages.page_run import BYTES_PER_SECOND, LiveRun, WatchedWork, status_of
from stitchmesh.app.task import TaskRunner
from stitchmesh.progress import Progress, ResidualCourse
from stitchmesh.run_control import RunControl, RunStopped, Snapshot

SAFETY = 60.0  # Time after which a test that blocks fails [s]; a test that passes waits for a much shorter time.


class Runs:
    """A runner of tasks, and what its runs have ended with."""

    def __init__(self) -> None:
        self.errors: list[Exception] = []
        self.queue = EventQueue()
        self.tasks = TaskRunner(self.queue, self.errors.append)
        self.ends: list[Any] = []

    def start(self, steps: int, **options: Any) -> LiveRun[int, str]:
        made: list[LiveRun[int, str]] = []
        paused = threading.Event()

        def relax(control: RunControl[int], progress: Progress) -> str:
            paused.wait(SAFETY)
            for step in range(steps + 1):
                snapshot = Snapshot(step, step, 10.0**-step, 1e-4, 0.5 * step, {"bend": 1.0})
                try:
                    control.after_step(lambda shown=snapshot: shown)
                    progress("counting", (step + 1) / (steps + 1), "")
                except RunStopped:
                    return f"stopped at {step}"
            return "finished"

        def begin() -> None:
            watched = WatchedWork(name="counting", relax=relax, **{"stage": "yarnrelax", **options})
            run = LiveRun(self.tasks, watched, self.ends.append, self.ends.append)
            made.append(run)
            run.control.pause()
            paused.set()

        self.queue.post(begin)
        self.queue.settle(SAFETY)
        return made[0]

    def wait_for(self, condition: Any) -> None:
        while not condition():
            self.queue.settle(SAFETY)
        self.queue.settle(SAFETY)  # The condition may hold in the middle of an event.


@pytest.fixture
def runs() -> Iterator[Runs]:
    made = Runs()
    yield made
    made.tasks.cancel()
    made.queue.stop()


def test_snapshots_arrive_with_their_figures_and_the_completed_part(runs: Runs):
    run = runs.start(8)
    shown: list[int] = []
    run.on_snapshot = lambda snapshot: shown.append(snapshot.state)
    runs.wait_for(lambda: run.newest is not None)
    run.control.step(2)
    runs.wait_for(lambda: run.newest is not None and run.newest.state >= 2)
    assert shown[-1] == 2 and run.history[-1].iteration == 2 and run.history[-1].state is None
    assert run.outlook.left is None, "two assessments are no course"
    for state in (3, 4):
        run.control.step()
        runs.wait_for(lambda: run.newest is not None and run.newest.state >= state)  # noqa: B023 - called in this round
    course = ResidualCourse()
    for one in run.history:
        course.add(one.iteration, one.residual)
    assert run.outlook.part == course.completed_part(1e-4) > 0.0
    assert "iteration 4," in status_of(run) and status_of(run).startswith("Paused")
    run.control.resume()
    runs.wait_for(lambda: runs.ends)
    assert runs.ends == ["finished"]
    run.newest = None  # as before the first snapshot
    assert status_of(run) == "Preparing."


def test_a_stopped_run_gives_its_result(runs: Runs):
    run = runs.start(1000)
    run.control.stop()
    runs.wait_for(lambda: runs.ends)
    assert runs.ends == ["stopped at 0"]


def test_a_cancelled_run_ends_also_while_it_is_paused_and_gives_no_result(runs: Runs):
    runs.start(1000)
    runs.tasks.cancel()
    runs.wait_for(lambda: runs.ends)
    assert runs.ends == [None] and not runs.tasks.running and not runs.errors


def test_large_snapshots_come_less_often(runs: Runs):
    run = runs.start(0, frame_bytes=int(3 * BYTES_PER_SECOND))
    assert run.control.seconds == 3.0


def test_the_progress_is_that_of_the_work_if_no_stage_is_given(runs: Runs):
    run = runs.start(3, stage=None)
    for steps in (1, 2):
        run.control.step()
        runs.wait_for(lambda: run.outlook.part == steps / 4)  # noqa: B023 - called in this round
    run.control.resume()
    runs.wait_for(lambda: runs.ends)
    assert run.outlook.part == 1.0
