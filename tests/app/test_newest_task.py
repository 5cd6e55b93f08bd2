# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Of works that are asked for one after another the newest is done, and no result of an earlier one arrives."""

from __future__ import annotations

import threading

import pytest

from stitchmesh.app.event_queue import EventQueue
from stitchmesh.app.newest_task import NewestTask, Refused, Work
from stitchmesh.app.task import TaskRunner
from stitchmesh.errors import ParameterError

SAFETY = 60.0  # Time after which a test that blocks fails [s].


@pytest.fixture
def queue():
    opened = EventQueue()
    yield opened
    opened.stop()


def wait(queue: EventQueue, tasks: TaskRunner) -> None:
    while tasks.running:
        threading.Event().wait(0.005)
        queue.settle(SAFETY)
    queue.settle(SAFETY)


def test_the_newest_work_is_done_and_earlier_ones_are_not(queue):
    errors, results, begun, may_go = [], [], threading.Event(), threading.Event()
    tasks = TaskRunner(queue, errors.append)
    newest = NewestTask(tasks)

    def first(control):
        begun.set()
        may_go.wait(SAFETY)
        control.frame("frame of the first")
        return "first"

    queue.post(newest.ask, Work("first", first, results.append, results.append))
    begun.wait(SAFETY)
    for name in ("second", "third"):
        queue.post(newest.ask, Work(name, lambda control, name=name: name, results.append))
    queue.settle(SAFETY)
    assert newest.work is not None and newest.work.name == "third"
    may_go.set()
    wait(queue, tasks)
    assert results == ["third"] and errors == [] and newest.work is None


def test_a_refusal_is_a_result_and_no_notice(queue):
    errors, results = [], []
    tasks = TaskRunner(queue, errors.append)

    def refuse(control):
        raise ParameterError("marks: too many")

    queue.post(NewestTask(tasks).ask, Work("try", refuse, results.append))
    queue.settle(SAFETY)
    wait(queue, tasks)
    assert results == [Refused("marks: too many")] and errors == []


def test_work_that_is_stopped_gives_nothing_and_another_task_blocks(queue):
    results, begun, may_go = [], threading.Event(), threading.Event()
    tasks = TaskRunner(queue, results.append)
    one, other = NewestTask(tasks), NewestTask(tasks)

    def wait_long(control):
        begun.set()
        may_go.wait(SAFETY)
        control.progress("wait", 1.0, "")

    queue.post(one.ask, Work("waiting", wait_long, results.append))
    begun.wait(SAFETY)
    queue.settle(SAFETY)  # the work may begin before the event thread has stored its task
    assert other.blocked_by == "waiting" and one.blocked_by is None
    queue.post(one.stop)
    queue.settle(SAFETY)
    may_go.set()
    wait(queue, tasks)
    assert results == [None]
