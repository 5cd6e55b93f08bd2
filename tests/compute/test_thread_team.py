# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Threads that share work: they take part if they are wanted, none is waited for, and no error is lost."""

from __future__ import annotations

import os
import threading

import pytest

from stitchmesh.compute.threads import ThreadTeam, share
from tests.compute.thread_counts import thread_count

SAFETY = 60.0  # Time after which a test that blocks fails [s]; a test that passes waits for a much shorter time.


def meet(team: ThreadTeam, threads: int, wanted: int) -> dict[int, int]:
    """Let ``threads`` threads of a team meet, of which ``wanted`` are asked for; return them by their numbers."""
    barrier, met = threading.Barrier(threads), {}

    def work(thread: int) -> None:
        met[thread] = threading.get_ident()
        barrier.wait(SAFETY)

    team.share(work, wanted)
    return met


def test_all_threads_take_part_each_with_its_number() -> None:
    team = ThreadTeam(3)
    groups = [meet(team, 3, 3) for _ in range(20)]
    assert sorted(groups[0]) == [0, 1, 2] and groups[0][0] == threading.get_ident()
    assert len(set(groups[0].values())) == 3
    assert all(group == groups[0] for group in groups)  # the same threads, which are started once


@pytest.mark.parametrize(("size", "wanted", "threads"), [(4, 2, 2), (2, 9, 2), (1, 9, 1), (3, 1, 1)])
def test_no_more_threads_take_part_than_are_wanted_and_exist(size: int, wanted: int, threads: int) -> None:
    assert len(meet(ThreadTeam(size), threads, wanted)) == threads


def test_the_calling_thread_waits_for_no_other() -> None:
    team, release, late = ThreadTeam(2), threading.Event(), threading.Event()
    own: list[int] = []

    def work(thread: int) -> None:
        if thread == 0:
            own.append(thread)
        else:
            assert release.wait(SAFETY)
            late.set()

    for _ in range(100):
        team.share(work, 2)
    assert len(own) == 100
    release.set()
    assert late.wait(SAFETY)


def test_a_thread_that_comes_late_does_the_work_that_was_offered_last() -> None:
    team, release, done = ThreadTeam(2), threading.Event(), threading.Event()
    works: list[str] = []

    def first(thread: int) -> None:
        if thread == 1:
            assert release.wait(SAFETY)

    def note(name: str, thread: int) -> None:
        if thread == 1:
            works.append(name)
            done.set()

    team.share(first, 2)
    while not team._calls[0].empty():  # the other thread is in the first work
        pass
    for name in ("second", "third", "last"):
        team.share(lambda thread, name=name: note(name, thread), 2)  # type: ignore[misc]
    release.set()
    assert done.wait(SAFETY)
    assert works == ["last"]


def test_a_thread_that_comes_late_leaves_work_for_fewer_threads_alone() -> None:
    team, release, left = ThreadTeam(3), threading.Event(), threading.Event()
    numbers: list[int] = []

    def first(thread: int) -> None:
        if thread > 0:
            assert release.wait(SAFETY)

    team.share(first, 3)
    while not all(calls.empty() for calls in team._calls):  # both others are in the first work
        pass
    team.share(lambda thread: None, 3)
    team.share(lambda thread: (numbers.append(thread), left.set() if thread else None), 2)
    release.set()
    assert left.wait(SAFETY)
    assert len(meet(team, 3, 3)) == 3  # all three are back
    assert sorted(numbers) == [0, 1]


def test_an_error_in_another_thread_is_raised_in_the_calling_one() -> None:
    team, failed = ThreadTeam(2), threading.Event()

    def work(thread: int) -> None:
        if thread == 0:
            assert failed.wait(SAFETY)
            return
        failed.set()
        raise ValueError("in another thread")

    with pytest.raises(ValueError, match="in another thread"):
        team.share(work, 2)
        while team._errors.empty():  # the error comes after the end of the work, and is raised by the next one
            pass
        team.share(lambda _thread: None, 1)
    assert len(meet(team, 2, 2)) == 2  # the thread still works


def test_work_within_work_does_not_wait() -> None:
    team, inner = ThreadTeam(2), []

    def work(thread: int) -> None:
        if thread == 0:
            team.share(inner.append, 1)

    team.share(work, 2)
    assert inner == [0]


def test_a_child_process_has_threads_of_its_own() -> None:
    """The threads of the parent do not exist in a child."""
    if not hasattr(os, "fork"):
        return

    def together() -> None:
        barrier = threading.Barrier(3)
        share(lambda _thread: barrier.wait(SAFETY), 3)

    with thread_count(3):
        together()
        child = os.fork()
        if child == 0:
            try:
                together()
                os._exit(0)
            finally:
                os._exit(1)
        assert os.waitpid(child, 0)[1] == 0
