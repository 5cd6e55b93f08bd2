# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Computations that ask for work on a device and go on with its results.

A swatch comes to rest by several relaxations, and each of them depends on the one before. A function that makes it is
written once, as a generator: it yields what it asks for (``Ask``, or ``Several`` computations that do not depend on
each other), and gets the result sent back. Who runs it decides how the work is done: ``answer_alone`` does one piece of
work after another, and others collect the work that many computations ask for, and do it in launches that all share.

Errors of the package are raised where the work was asked for, so that a computation can go on without it.
"""

from __future__ import annotations

import functools
from collections.abc import Callable, Generator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Generic, ParamSpec, TypeVar

from stitchmesh.errors import StitchMeshError

T = TypeVar("T")
P = ParamSpec("P")


@dataclass(frozen=True, eq=False)
class Ask:
    """Work that is asked for: a call of a function."""

    function: Callable[..., Any]
    """What to call."""
    positional: tuple[Any, ...]
    """Its positional arguments."""
    named: Mapping[str, Any]
    """Its other arguments."""

    def answer(self) -> Any:
        """Do the work alone."""
        return self.function(*self.positional, **self.named)


@dataclass(frozen=True, eq=False)
class Begun(Ask):
    """Work that was begun with that of others, and goes on with the next that is done together."""

    state: Any
    """How far it is, for the function that does it together."""


@dataclass(frozen=True, eq=False)
class Several:
    """Computations that do not depend on each other; the answer is a list of their results, or of errors."""

    computations: Sequence[Asking[Any]]
    """The computations, not yet begun."""


Asking = Generator[Ask | Several, Any, T]
"""A computation that asks for work and returns a result."""


def ask(function: Callable[..., Any], *positional: Any, **named: Any) -> Ask:
    """Return the work of a call."""
    return Ask(function, positional, named)


def answer_alone(computation: Asking[T], do: Callable[[Ask], Any] = Ask.answer) -> T:
    """Do the work that a computation asks for, one piece after another, and return its result.

    Args:
        computation: the computation, not yet begun.
        do: does one piece of work, for example with checkpoints.
    """
    try:
        asked = next(computation)
        while True:
            try:
                answer = _answer(asked, do)
            except StitchMeshError as error:
                asked = computation.throw(error)
            else:
                asked = computation.send(answer)
    except StopIteration as end:
        result: T = end.value
        return result


def _answer(asked: Ask | Several, do: Callable[[Ask], Any]) -> Any:
    if isinstance(asked, Ask):
        return do(asked)
    return [_result_or_error(computation, do) for computation in asked.computations]


def _result_or_error(computation: Asking[T], do: Callable[[Ask], Any]) -> T | StitchMeshError:
    try:
        return answer_alone(computation, do)
    except StitchMeshError as error:
        return error


class AnsweredAlone(Generic[P, T]):
    """A function that does its work alone; ``asking`` is the function that asks for it."""

    def __init__(self, asking: Callable[P, Asking[T]]) -> None:
        """Make the function; it has the name and the text of the one that asks."""
        self.asking = asking
        functools.update_wrapper(self, asking)

    def __call__(self, *args: P.args, **kwargs: P.kwargs) -> T:
        """Compute alone."""
        return answer_alone(self.asking(*args, **kwargs))


def answered_alone(asking: Callable[P, Asking[T]]) -> AnsweredAlone[P, T]:
    """Turn a function that asks for its work into one that does it alone (a decorator)."""
    return AnsweredAlone(asking)
