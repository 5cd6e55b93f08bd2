# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Limits on time: their arithmetic, with a clock of the test; and work that is given up."""

from __future__ import annotations

import math

import pytest

from stitchmesh.time_limit import (
    Interrupted,
    OutOfTime,
    TimeLimit,
    check_time,
    done_twice,
    given_up_when,
    limited_to,
    limited_to_share,
    seconds_left,
    without_limit,
)


class Clock:
    """A clock that the test sets."""

    def __init__(self) -> None:
        self.now = 100.0

    def __call__(self) -> float:
        return self.now


def test_without_a_limit_time_never_ends():
    check_time()
    assert seconds_left() == math.inf
    with limited_to(None):
        assert seconds_left() == math.inf


def test_time_ends_when_the_clock_has_passed_the_limit():
    clock = Clock()
    with limited_to(TimeLimit(10.0, clock)):
        clock.now += 9.5
        check_time()
        assert seconds_left() == 0.5
        clock.now += 0.5
        with pytest.raises(OutOfTime):
            check_time()
        with without_limit():
            check_time()
    check_time()


def test_a_share_leaves_the_rest_for_what_follows():
    clock = Clock()
    with limited_to(TimeLimit(10.0, clock)):
        clock.now += 2.0
        with limited_to_share(0.25):
            assert seconds_left() == 2.0
            clock.now += 2.0
            with pytest.raises(OutOfTime):
                check_time()
        assert seconds_left() == 6.0
        clock.now += 9.0
        with limited_to_share(0.5):
            assert seconds_left() == 0.0
    with limited_to_share(0.25):
        assert seconds_left() == math.inf


def test_work_that_is_done_twice_is_paid_for_twice():
    clock = Clock()
    with limited_to(TimeLimit(10.0, clock)):
        with done_twice():
            clock.now += 3.0
        assert seconds_left() == 4.0


def test_work_is_given_up_as_soon_as_something_else_is_asked_for() -> None:
    """Also work that no limit on the time cuts short, and only within the block."""
    asked = list[bool]()
    with given_up_when(lambda: bool(asked)), without_limit():
        check_time()
        asked.append(True)
        with pytest.raises(Interrupted):
            check_time()
    check_time()
