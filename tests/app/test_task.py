# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Long work reports, ends when asked, and hands over its result or its error.

Of works that are asked for one after another the newest is done, and no result of an earlier one arrives.
"""

from __future__ import annotations

import threading

import pytest

from stitchmesh.app.event_queue import EventQueue
from stitchmesh.app.task import NewestTask, Refused, TaskRunner, Work
from stitchmesh.errors import ParameterError, SolverError

SECONDS = 30.0
"""Longest wait for another thread; far more than any test needs."""


class Ends:
    """What came of tasks."""

    def __init__(self) -> None:
        self.errors, self.results, self.failures = [], [], []
        self.queue = EventQueue()
        self.runner = TaskRunner(self.queue, self.errors.append)

    def call(self, function, *arguments):
        """Call a function in the event thread, and return its value."""
        made = []
        self.queue.post(lambda: made.append(function(*arguments)))
        self.queue.settle(SECONDS)
        return made[0]

    def start(self, work):
        return self.call(self.runner.start, "the work", work, self.results.append, self.failures.append)

    def wait(self):
        """Wait until no task runs; the event thread says so, which has then handled the end of the last one."""
        while self.call(lambda: self.runner.running):
            threading.Event().wait(0.005)


@pytest.fixture
def ends():
    ends = Ends()
    yield ends
    ends.runner.cancel()
    ends.queue.stop()


def test_a_result_or_an_error_arrives_and_frees_the_runner(ends):
    def fail(control):
        raise SolverError("yarn 3: cannot go on")

    ends.start(lambda control: 42)
    ends.wait()
    assert ends.results == [42] and ends.failures == []
    ends.start(fail)
    ends.wait()
    assert [str(error) for error in ends.errors] == ["yarn 3: cannot go on"]
    assert ends.failures == ends.errors and ends.results == [42]


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


def test_frames_arrive_in_the_event_thread_the_newest_last_and_the_last_report_is_kept(ends):
    frames, threads, may_go = [], [], threading.Event()

    def work(control):
        may_go.wait(SECONDS)
        for number in range(50):
            control("stage", number / 50, f"note {number}")
            control.frame(number)

    task = ends.start(work)
    task.on_frame = lambda value: (frames.append(value), threads.append(ends.queue.is_own_thread()))
    may_go.set()
    ends.wait()
    assert frames[-1] == 49 and frames == sorted(frames) and all(threads)
    assert (task.stage, task.done) == ("stage", 49 / 50)


def test_a_second_task_is_refused_while_one_runs(ends):
    gate = threading.Event()
    ends.start(lambda control: gate.wait(SECONDS))
    ends.queue.post(ends.runner.start, "the other work", lambda control: None, lambda _: None)
    ends.queue.on_error = ends.errors.append
    ends.queue.settle(SECONDS)
    gate.set()
    ends.wait()
    assert [str(error) for error in ends.errors] == [
        "the other work: the work is still running; stop it first, or wait"
    ]


def test_the_newest_work_is_done_and_earlier_ones_are_not(ends):
    newest, begun, may_go = NewestTask(ends.runner), threading.Event(), threading.Event()

    def first(control):
        begun.set()
        may_go.wait(SECONDS)
        control.frame("frame of the first")
        return "first"

    ends.call(newest.ask, Work("first", first, ends.results.append, ends.results.append))
    assert begun.wait(SECONDS)
    for name in ("second", "third"):
        ends.call(newest.ask, Work(name, lambda control, name=name: name, ends.results.append))
    assert newest.work is not None and newest.work.name == "third"
    may_go.set()
    ends.wait()
    assert ends.results == ["third"] and ends.errors == [] and newest.work is None


def test_a_refusal_is_a_result_and_no_notice(ends):
    def refuse(control):
        raise ParameterError("marks: too many")

    ends.call(NewestTask(ends.runner).ask, Work("try", refuse, ends.results.append))
    ends.wait()
    assert ends.results == [Refused("marks: too many")] and ends.errors == []


def test_work_that_is_stopped_gives_nothing_and_another_task_blocks(ends):
    begun, may_go = threading.Event(), threading.Event()
    one, other = NewestTask(ends.runner), NewestTask(ends.runner)

    def wait_long(control):
        begun.set()
        may_go.wait(SECONDS)
        control.progress("wait", 1.0, "")

    ends.call(one.ask, Work("waiting", wait_long, ends.results.append))
    assert begun.wait(SECONDS)
    assert other.blocked_by == "waiting" and one.blocked_by is None
    ends.call(one.stop)
    may_go.set()
    ends.wait()
    assert ends.results == [None]
