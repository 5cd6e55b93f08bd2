# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Long work reports, waits, goes on step by step, ends when asked, and hands over its result or its error."""

from __future__ import annotations

import threading

import pytest

from stitchmesh.app.event_queue import EventQueue
from stitchmesh.app.task import TaskRunner
from stitchmesh.errors import ParameterError, SolverError

SECONDS = 30.0
"""Longest wait for another thread; far more than any test needs."""


class Ends:
    """What came of a task."""

    def __init__(self) -> None:
        self.errors, self.results, self.failures = [], [], []
        self.queue = EventQueue()
        self.runner = TaskRunner(self.queue, self.errors.append)
        self.ended = threading.Event()

    def start(self, work):
        started = threading.Event()
        made = []

        def begin():
            made.append(self.runner.start("the work", work, self._done, self._failed))
            started.set()

        self.queue.post(begin)
        assert started.wait(SECONDS)
        return made[0]

    def _done(self, result):
        self.results.append(result)
        self.ended.set()

    def _failed(self, error):
        self.failures.append(error)
        self.ended.set()

    def wait(self):
        assert self.ended.wait(SECONDS)
        self.queue.settle()


@pytest.fixture
def ends():
    ends = Ends()
    yield ends
    ends.runner.cancel()
    ends.queue.stop()


def test_the_result_arrives_in_the_event_thread_and_frees_the_runner(ends):
    ends.start(lambda control: 42)
    ends.wait()
    assert ends.results == [42] and ends.failures == [] and not ends.runner.running


def test_an_error_is_reported_and_handed_over(ends):
    def work(control):
        raise SolverError("yarn 3: cannot go on")

    ends.start(work)
    ends.wait()
    assert [str(error) for error in ends.errors] == ["yarn 3: cannot go on"]
    assert ends.failures == ends.errors and ends.results == [] and not ends.runner.running


def test_cancelled_work_ends_at_its_next_report_and_is_no_error(ends):
    entered = threading.Event()

    def work(control):
        entered.set()
        while True:
            control("stage", 0.5, "")

    task = ends.start(work)
    assert entered.wait(SECONDS)
    task.cancel()
    ends.wait()
    assert ends.failures == [None] and ends.errors == []


def test_paused_work_makes_exactly_as_many_reports_as_steps(ends):
    reports = []
    task_made = threading.Event()

    def work(control):
        task_made.wait(SECONDS)
        for number in range(1000):
            control("stage", number / 1000, "")
            reports.append(number)

    task = ends.start(work)
    task.pause()
    task_made.set()
    for count in (1, 2, 3):
        task.step()
        for _ in range(3000):
            if len(reports) >= count:
                break
            threading.Event().wait(0.01)
        assert len(reports) == count
    task.resume()
    ends.wait()
    assert reports == list(range(1000))


def test_paused_work_can_be_cancelled(ends):
    entered = threading.Event()

    def work(control):
        entered.set()
        control.wait_while_paused()
        control.check()

    task = ends.start(work)
    task.pause()
    task.cancel()
    ends.wait()
    assert not ends.runner.running


def test_frames_and_reports_arrive_in_the_event_thread_the_newest_last(ends):
    frames, threads, notes, may_go = [], [], [], threading.Event()

    def work(control):
        may_go.wait(SECONDS)
        for number in range(50):
            control("stage", number / 50, f"note {number}")
            control.frame(number)

    task = ends.start(work)
    task.on_frame = lambda value: (frames.append(value), threads.append(ends.queue.is_own_thread()))
    task.on_progress = lambda: notes.append((task.stage, task.note))
    may_go.set()
    ends.wait()
    assert frames[-1] == 49 and frames == sorted(frames) and all(threads)
    assert notes[-1] == ("stage", "note 49")


def test_a_second_task_is_refused_while_one_runs(ends):
    gate = threading.Event()
    ends.start(lambda control: gate.wait(SECONDS))
    refused = []

    def start_second():
        try:
            ends.runner.start("the other work", lambda control: None, lambda _: None)
        except ParameterError as error:
            refused.append(str(error))

    ends.queue.post(start_second)
    ends.queue.settle()
    assert refused == ["the other work: the work is still running; stop it first, or wait"]
    gate.set()
    ends.wait()
