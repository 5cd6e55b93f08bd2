# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The event queue keeps the order, takes the newest of a stream, and lives on after errors."""

from __future__ import annotations

import threading

import pytest

from stitchmesh.app.event_queue import EventQueue


@pytest.fixture
def queue():
    queue = EventQueue()
    yield queue
    queue.stop()


def test_calls_of_one_thread_run_in_order_in_the_thread_of_the_queue(queue):
    seen = []
    for number in range(200):
        queue.post(lambda n: seen.append((n, queue.is_own_thread())), number)
    queue.settle()
    assert seen == [(number, True) for number in range(200)]
    assert not queue.is_own_thread()


def test_of_a_stream_with_one_key_only_the_newest_value_is_called(queue):
    gate, seen = threading.Event(), []
    queue.post(gate.wait)
    for number in range(100):
        queue.post_newest("slider", seen.append, number)
    queue.post_newest("other", seen.append, "other")
    gate.set()
    queue.settle()
    assert seen == [99, "other"]
    queue.post_newest("slider", seen.append, 100)
    queue.settle()
    assert seen[-1] == 100


def test_the_queue_lives_on_after_an_error_even_if_its_report_fails(queue):
    errors, seen = [], []

    def report(error):
        errors.append(str(error))
        raise RuntimeError("the report fails too")

    queue.on_error = report
    queue.post(lambda: 1 / 0)
    queue.post(seen.append, "after")
    queue.settle()
    assert errors == ["division by zero"] and seen == ["after"]
