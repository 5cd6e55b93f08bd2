# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Many computations that ask for work on a device (``asking``), of which the work of the same kind is done together.

Every computation runs until it asks for work. Work of kinds that cannot be done together is done alone at once. Of the
other kinds, the first in a given order that any computation asks for is done, for all that ask for it; short work comes
first in that order, so that the computations catch up with each other before the long work is done for all of them.
What is done together depends on the computations alone and not on time, so that a run is repeatable.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from typing import Any, TypeVar

from stitchmesh.compute.asking import Ask, Asking, Begun
from stitchmesh.errors import StitchMeshError

T = TypeVar("T")
Together = Callable[[Sequence[Ask]], Sequence[Any]]
"""A function that does several pieces of work at once, and returns the answer to each, or its error, or ``Begun`` for a
piece that goes on when this kind of work is done again; at least one piece is done."""


@dataclass(eq=False)
class _Running:
    """A computation that has begun."""

    computation: Asking[Any]
    done: Callable[[Any], None]
    """Called with the result, or with the error."""
    asked: Ask | None = None
    """What it asks for, if it waits for an answer."""
    parts: list[Any] = field(default_factory=list)
    """Results of the computations that it waits for."""
    left: int = 0
    """Number of computations that have no result yet."""


def answer_together(
    computations: Sequence[Asking[T]], ways: Mapping[Callable[..., Any], Together],
    on_done: Callable[[int], None] = lambda _done: None,
) -> list[T | StitchMeshError]:  # fmt: skip
    """Run computations together; an error of one does not end the others.

    Args:
        computations: the computations, not yet begun.
        ways: for each function that computations ask for, how many calls are answered together, the shortest work
            first. Other functions are called alone.
        on_done: called with the number of computations that are done, as often as one is.

    Returns:
        The result of each computation, or its error.
    """
    together = _Computations(ways)
    results: dict[int, T | StitchMeshError] = {}

    def keep(number: int, result: T | StitchMeshError) -> None:
        results[number] = result
        on_done(len(results))

    for number, computation in enumerate(computations):
        together.begin(computation, partial(keep, number))
    while together.waiting:
        together.answer_some()
    return [results[number] for number in range(len(computations))]


class _Computations:
    """The computations that wait for an answer."""

    def __init__(self, ways: Mapping[Callable[..., Any], Together]) -> None:
        self.ways = ways
        self.waiting: list[_Running] = []

    def begin(self, computation: Asking[Any], done: Callable[[Any], None]) -> None:
        """Run a computation until it asks for work that is done together with that of others."""
        self._resume(_Running(computation, done), None)

    def answer_some(self) -> None:
        """Do the first kind of work that any computation asks for."""
        kinds = {running.asked.function for running in self.waiting if running.asked is not None}
        kind = next(way for way in self.ways if way in kinds)
        some, others = list[_Running](), list[_Running]()
        for running in self.waiting:
            (some if running.asked is not None and running.asked.function is kind else others).append(running)
        self.waiting = others
        asks = [running.asked for running in some if running.asked is not None]
        for running, answer in zip(some, self.ways[kind](asks), strict=True):
            if isinstance(answer, Begun):
                self.waiting.append(replace(running, asked=answer))
            else:
                self._resume(running, answer)

    def _resume(self, running: _Running, answer: Any) -> None:
        """Give a computation an answer, and answer at once what is done alone."""
        while True:
            try:
                if isinstance(answer, StitchMeshError):
                    asked = running.computation.throw(answer)
                else:
                    asked = running.computation.send(answer)
            except StopIteration as end:
                running.done(end.value)
                return
            except StitchMeshError as error:
                running.done(error)
                return
            if not isinstance(asked, Ask):
                self._begin_parts(running, asked.computations)
                return
            if asked.function in self.ways:
                running.asked = asked
                self.waiting.append(running)
                return
            answer = _answer_or_error(asked)

    def _begin_parts(self, running: _Running, computations: Sequence[Asking[Any]]) -> None:
        """Begin computations for whose results another one waits."""
        running.parts, running.left = [None] * len(computations), len(computations)
        if not computations:
            self._resume(running, [])

        def keep(number: int, result: Any) -> None:
            running.parts[number] = result
            running.left -= 1
            if running.left == 0:
                self._resume(running, running.parts)

        for number, computation in enumerate(computations):
            self.begin(computation, partial(keep, number))


def _answer_or_error(asked: Ask) -> Any:
    try:
        return asked.answer()
    except StitchMeshError as error:
        return error
