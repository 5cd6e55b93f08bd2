# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Runs many computations at once, and does their shared work (``shared_work``) of the same kind together.

Each computation has a thread of its own, but only one thread runs at a time, so that the order of all steps depends on
the computations alone. A computation runs until it calls a shared function, and then waits. When all of them wait, the
scheduler picks one kind of work, the shortest first, and does it at once for all computations that wait for it. With
short work first, the computations catch up with each other before the long work is done for all of them.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from contextvars import copy_context
from dataclasses import dataclass
from threading import Semaphore, Thread
from typing import Any, TypeVar

from stitchmesh.compute.shared_work import Call, Worker, done_by
from stitchmesh.errors import StitchMeshError

T = TypeVar("T")


@dataclass(frozen=True, eq=False)
class Begun(Call):
    """A call whose work was begun together with other calls; the next work of the same kind continues it."""

    state: Any
    """The state of the unfinished work, for the function that does it."""


Together = Callable[[Sequence[Call]], Sequence[Any]]
"""Does the work of several calls of one function. It returns for each call the result, the error, or ``Begun`` if the
work is to continue with the next calls. It completes the work of at least one call."""


def done_together(
    computations: Sequence[Callable[[], T]], ways: Mapping[Callable[..., Any], Together],
    on_done: Callable[[int], None] = lambda _done: None,
) -> list[T | StitchMeshError]:  # fmt: skip
    """Run computations at once; an error of the package ends only the computation that raises it.

    Any other exception, such as an interrupt by the user, ends all computations, and is raised here.

    Args:
        computations: the computations.
        ways: for each shared function, the function that does its calls together; the shortest work comes first. Shared
            functions that are not listed do their work where they are called.
        on_done: called with the number of ended computations, each time that one has ended.

    Returns:
        The result of each computation, or its error.
    """
    scheduler = _Scheduler(ways, on_done)
    try:
        for computation in computations:
            scheduler.begin(computation)
        while scheduler.waiting:
            scheduler.do_some()
    except BaseException:
        scheduler.give_up()
        raise
    return [one.result for one in scheduler.given]


class _GivenUp(BaseException):
    """Raised in all computations that have not ended when the whole work is given up."""


class _Scheduler:
    """Holds the computations that have begun, and the computations that wait for work."""

    def __init__(self, ways: Mapping[Callable[..., Any], Together], on_done: Callable[[int], None]) -> None:
        self.ways = ways
        self.on_done = on_done
        self.given: list[_Running] = []
        """The given computations that have begun."""
        self.ended = 0
        """How many of the given computations have ended."""
        self.reported = 0
        """The last number that ``on_done`` was called with."""
        self.running: set[_Running] = set()
        """The computations, and parts of computations, that have begun and not ended."""
        self.waiting: list[tuple[_Running, Call]] = []
        """The computations that wait for the work of a call, in the order in which they called."""
        self.is_given_up = False
        self.fault: BaseException | None = None
        """The exception of a computation that ends the whole work."""

    def begin(self, computation: Callable[[], Any]) -> None:
        """Run a given computation until it waits or has ended."""
        self.given.append(_Running(computation, self))
        self._go_on(self.given[-1])

    def do_some(self) -> None:
        """Do the waiting work that stands first in ``ways``, and continue all computations that waited for it."""
        kinds = {call.function for _running, call in self.waiting}
        kind = next(way for way in self.ways if way in kinds)
        some = [each for each in self.waiting if each[1].function is kind]
        self.waiting = [each for each in self.waiting if each[1].function is not kind]
        answers = self.ways[kind]([call for _running, call in some])
        for (running, _call), answer in zip(some, answers, strict=True):
            if isinstance(answer, Begun):
                self.waiting.append((running, answer))
            else:
                running.answer = answer
                self._go_on(running)

    def _go_on(self, running: _Running) -> None:
        running.go_on()
        if self.fault is not None:
            raise self.fault
        while self.reported < self.ended:
            self.reported += 1
            self.on_done(self.reported)

    def give_up(self) -> None:
        """End all computations, and wait until they have ended."""
        self.is_given_up = True
        left = list(self.running)
        for running in left:
            running.turn.release()
        for running in left:
            running.thread.join()


class _Running(Worker):
    """A computation in a thread of its own; it is the worker of this thread."""

    def __init__(
        self, computation: Callable[[], Any], scheduler: _Scheduler, whole: _Running | None = None
    ) -> None:  # fmt: skip
        self.computation = computation
        self.scheduler = scheduler
        self.whole = whole
        """The computation of which this one is a part."""
        self.parts: list[_Running] = []
        """The parts that this computation waits for."""
        self.answer: Any = None
        """The result, or the error, of the work that the computation waited for."""
        self.result: Any = None
        """The result, or the error, of the computation itself."""
        self.has_ended = False
        self.turn = Semaphore(0)
        self.pause = Semaphore(0)
        self.thread = Thread(target=copy_context().run, args=(self._run,), daemon=True)

    def go_on(self) -> None:
        """Let the thread run until it waits or has ended; the calling thread waits in the meantime."""
        if self.thread.ident is None:
            self.thread.start()
            self.scheduler.running.add(self)
        self.turn.release()
        self.pause.acquire()
        if self.has_ended:
            self.thread.join()

    def do(self, call: Call) -> Any:
        """Wait for the work of a call, and return its result."""
        if call.function not in self.scheduler.ways:
            return call.do()
        self.scheduler.waiting.append((self, call))
        self._wait()
        if isinstance(self.answer, StitchMeshError):
            raise self.answer
        return self.answer

    def compute_each(self, computations: Sequence[Callable[[], T]]) -> list[T | StitchMeshError]:
        """Run parts in threads of their own, and wait until the last one has ended."""
        running = [_Running(computation, self.scheduler, self) for computation in computations]
        for one in running:
            self._refuse_given_up()
            one.go_on()
        self.parts = [one for one in running if not one.has_ended]
        if self.parts:
            self._wait()
        return [one.result for one in running]

    def _wait(self) -> None:
        """Let the thread continue that gave this one its turn, and wait until this one has its turn again."""
        self._refuse_given_up()
        self.pause.release()
        self.turn.acquire()
        self._refuse_given_up()

    def _refuse_given_up(self) -> None:
        if self.scheduler.is_given_up:
            raise _GivenUp

    def _run(self) -> None:
        """Run the computation in its thread; after the last part of a computation, continue that computation."""
        self.turn.acquire()
        try:
            self._refuse_given_up()
            with done_by(self):
                self.result = self.computation()
        except StitchMeshError as error:
            self.result = error
        except _GivenUp:
            pass
        except BaseException as error:
            self.scheduler.fault = error
            self.scheduler.is_given_up = True
        self.has_ended = True
        self.scheduler.running.discard(self)
        if self.whole is None:
            self.scheduler.ended += 1
        elif not self.scheduler.is_given_up:
            self.whole.part_ended(self)
        self.pause.release()

    def part_ended(self, part: _Running) -> None:
        """Continue this computation if no other part is left."""
        if part in self.parts:
            self.parts.remove(part)
            if not self.parts:
                self.go_on()
