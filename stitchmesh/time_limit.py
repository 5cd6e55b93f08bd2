# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""A limit on the time of everything that runs inside a block.

A relaxation inside the block asks between its launches whether time is left (``check_time``). If none is left, it
returns its last accepted state. If the limit cuts an interval between two assessments short, this leaves no trace: the
result has the bits of a relaxation with the limit of iterations that the report names. Without a limit the question
costs less than a microsecond.

Blocks may be nested. An inner block can shorten the time. It can also protect work whose result is needed whole from
being cut short (``without_limit``).
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from dataclasses import dataclass

from stitchmesh.run_control import RunStopped

Clock = Callable[[], float]
"""Function that returns a time [s], which never decreases."""


class OutOfTime(RunStopped):
    """The time of the block has run out; a relaxation returns its last accepted state."""


@dataclass(eq=False)
class TimeLimit:
    """A number of seconds, counted from the moment at which the limit is made, or from an earlier moment."""

    seconds: float
    """Time for everything [s]."""
    clock: Clock = time.perf_counter
    """The clock; tests give their own."""
    reserved: float = 0.0
    """Part of the time that is kept for work after the relaxations [s]."""
    began: float = math.nan
    """Reading of the clock from which the time counts [s]; by default the reading when the limit is made."""

    def __post_init__(self) -> None:
        if math.isnan(self.began):
            self.began = self.clock()

    @property
    def spent(self) -> float:
        """Time since the start [s]."""
        return self.clock() - self.began

    @property
    def left(self) -> float:
        """Time that is left for relaxations, negative if the limit has passed [s]."""
        return self.seconds - self.reserved - self.spent


_limit: ContextVar[TimeLimit | None] = ContextVar("time limit", default=None)
_asked: ContextVar[Callable[[], bool] | None] = ContextVar("asked for something else", default=None)


class Interrupted(Exception):
    """The caller asked for something else first, and the work of the block is given up."""


@contextmanager
def given_up_when(asked: Callable[[], bool]) -> Iterator[None]:
    """Give up the work of a block as soon as ``asked`` returns True.

    Relaxations call it between their launches, also in a block without a limit.

    Raises:
        Interrupted: ``asked`` returned True.
    """
    token = _asked.set(asked)
    try:
        yield
    finally:
        _asked.reset(token)


@contextmanager
def limited_to(limit: TimeLimit | None) -> Iterator[None]:
    """Limit the time of the relaxations in a block; None changes nothing."""
    token = _limit.set(_limit.get() if limit is None else limit)
    try:
        yield
    finally:
        _limit.reset(token)


@contextmanager
def limited_to_share(share: float) -> Iterator[None]:
    """Limit the time of a block to a share of the remaining time, so that later work has the rest."""
    limit = _limit.get()
    part = None if limit is None else TimeLimit(max(share * limit.left, 0.0), limit.clock)
    with limited_to(part):
        yield


@contextmanager
def without_limit() -> Iterator[None]:
    """Do not cut the work of a block short, because later work needs its whole result."""
    token = _limit.set(None)
    try:
        yield
    finally:
        _limit.reset(token)


@contextmanager
def done_twice() -> Iterator[None]:
    """Reserve the time that a block takes once more, because the same work follows after the relaxation."""
    limit = _limit.get()
    began = 0.0 if limit is None else limit.clock()
    yield
    if limit is not None:
        limit.reserved += limit.clock() - began


def seconds_left() -> float:
    """Time that is left in this block [s]; infinite without a limit."""
    limit = _limit.get()
    return math.inf if limit is None else limit.left


def check_time() -> None:
    """Return if time is left in this block and no caller asks for something else (``given_up_when``).

    Raises:
        Interrupted: a caller asks for something else.
        OutOfTime: no time is left.
    """
    limit, asked = _limit.get(), _asked.get()
    if asked is not None and asked():
        raise Interrupted
    if limit is not None and limit.left <= 0.0:
        raise OutOfTime
