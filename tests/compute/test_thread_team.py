# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Threads that share work: they take part if they are wanted, none is waited for, and no error is lost."""

from __future__ import annotations

import os
import threading

import pytest

from stitchmesh.compute import thread_team
from stitchmesh.compute.thread_team import ThreadTeam
from tests.compute.thread_counts import thread_count

SAFETY = 60.0  # Time after which a test that blocks fails [s]; a test that passes waits for a much shorter time.


def meet(team: ThreadTeam, threads: int, wanted: int) -> set[int]:
    """Let ``threads`` threads of a team meet, of which ``wanted`` are asked for; return which they were."""
    barrier, met = threading.Barrier(threads), set()

    def work() -> None:
        met.add(threading.get_ident())
        barrier.wait(SAFETY)

    team.share(work, work, wanted)
    return met


def test_all_threads_take_part() -> None:
    team = ThreadTeam(3)
    groups = [meet(team, 3, 3) for _ in range(20)]
    assert threading.get_ident() in groups[0] and len(groups[0]) == 3
    assert all(group == groups[0] for group in groups)  # the same threads, which are started once


@pytest.mark.parametrize(("size", "wanted", "threads"), [(4, 2, 2), (2, 9, 2), (1, 9, 1), (3, 1, 1)])
def test_no_more_threads_take_part_than_are_wanted_and_exist(size: int, wanted: int, threads: int) -> None:
    assert len(meet(ThreadTeam(size), threads, wanted)) == threads


def test_the_calling_thread_waits_for_no_other() -> None:
    team, release, late = ThreadTeam(2), threading.Event(), threading.Event()

    def other() -> None:
        assert release.wait(SAFETY)
        late.set()

    own: list[int] = []
    for number in range(100):
        team.share(lambda number=number: own.append(number), other, 2)  # type: ignore[misc]
    assert own == list(range(100))
    release.set()
    assert late.wait(SAFETY)


def test_an_error_in_another_thread_is_raised_in_the_calling_one() -> None:
    team, failed = ThreadTeam(2), threading.Event()

    def other() -> None:
        failed.set()
        raise ValueError("in another thread")

    with pytest.raises(ValueError, match="in another thread"):
        team.share(lambda: failed.wait(SAFETY), other, 2)
        while team._errors.empty():  # the error comes after the end of the work, and is raised by the next one
            pass
        team.share(lambda: None, lambda: None, 1)
    assert len(meet(team, 2, 2)) == 2  # the thread still works


def test_an_error_in_the_calling_thread_is_raised() -> None:
    def own() -> None:
        raise ValueError("here")

    with pytest.raises(ValueError, match="here"):
        ThreadTeam(2).share(own, lambda: None, 2)


def test_work_within_work_does_not_wait() -> None:
    team, inner = ThreadTeam(2), []

    def work() -> None:
        team.share(lambda: inner.append(threading.get_ident()), lambda: None, 2)

    team.share(work, lambda: None, 2)
    assert inner == [threading.get_ident()]


def test_a_child_process_has_threads_of_its_own() -> None:
    """The threads of the parent do not exist in a child."""
    if not hasattr(os, "fork"):
        return

    def together() -> None:
        barrier = threading.Barrier(3)
        thread_team.share(lambda: barrier.wait(SAFETY), lambda: barrier.wait(SAFETY), 3)

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
