# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Threads that share work: all take part, none is left in the work, and no error is lost."""

from __future__ import annotations

import os
import threading

import pytest

from stitchmesh.compute.thread_team import ThreadTeam

SAFETY = 60.0  # Time after which a test that blocks fails [s]; a test that passes waits for a much shorter time.


def test_all_threads_take_part_and_leave() -> None:
    team, barrier, within = ThreadTeam(3), threading.Barrier(3), []

    def work() -> None:
        within.append(threading.get_ident())
        barrier.wait(SAFETY)  # all three are in the work at the same time
        within.remove(threading.get_ident())

    for _ in range(20):
        team.share(work)
        assert not within


def test_the_caller_does_not_wait_for_threads_that_sleep() -> None:
    team, done = ThreadTeam(2), []
    for number in range(1000):
        team.share(lambda number=number: done.append(number))  # type: ignore[misc]
    assert set(done) == set(range(1000))


def test_an_error_in_another_thread_is_raised_in_the_calling_one() -> None:
    team, begun = ThreadTeam(2), threading.Event()
    own = threading.get_ident()

    def work() -> None:
        if threading.get_ident() == own:
            assert begun.wait(SAFETY)
            return
        begun.set()
        raise ValueError("in another thread")

    with pytest.raises(ValueError, match="in another thread"):
        team.share(work)
    begun.set()
    team.share(begun.set)  # the team still works, and the error is not raised again


def test_an_error_in_the_calling_thread_waits_for_the_others() -> None:
    team, begun, finish = ThreadTeam(2), threading.Event(), threading.Event()
    own, left = threading.get_ident(), []

    def work() -> None:
        if threading.get_ident() == own:
            assert begun.wait(SAFETY)
            finish.set()
            raise ValueError("here")
        begun.set()
        assert finish.wait(SAFETY)
        left.append(True)

    with pytest.raises(ValueError, match="here"):
        team.share(work)
    assert left == [True]


def test_work_within_work_is_done_by_the_thread_that_has_it() -> None:
    team, begun = ThreadTeam(2), threading.Barrier(2)
    inner: list[tuple[int, int]] = []

    def work() -> None:
        begun.wait(SAFETY)
        own = threading.get_ident()
        team.share(lambda: inner.append((own, threading.get_ident())))

    team.share(work)
    assert len(inner) == 2 and all(asked == did for asked, did in inner)


def test_a_team_of_one_works_alone() -> None:
    did: list[int] = []
    ThreadTeam(1).share(lambda: did.append(threading.get_ident()))
    assert did == [threading.get_ident()]


@pytest.mark.parametrize("forked", [hasattr(os, "fork")])
def test_a_child_process_has_a_team_of_its_own(forked: bool) -> None:
    """The threads of the parent do not exist in a child; without a team of its own the child would wait for them."""
    from stitchmesh.compute import thread_team
    from tests.compute.thread_counts import thread_count

    def together() -> None:
        barrier = threading.Barrier(3)
        thread_team.share(lambda: barrier.wait(SAFETY) and None)

    with thread_count(3):
        together()
        if not forked:
            return
        child = os.fork()
        if child == 0:
            try:
                together()
                os._exit(0)
            finally:
                os._exit(1)
        assert os.waitpid(child, 0)[1] == 0
