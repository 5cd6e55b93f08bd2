# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Shared functions: a worker may do the work of such a function for its caller.

The caller calls a shared function like any other. The function does its work at once, unless the call is made in a
block with a worker (``done_by``). In such a block the worker gets the call, and the worker's answer is the result. In
this way a job keeps checkpoints of all relaxations of a swatch, and many swatches share launches (``work_together``),
while the code of a swatch knows nothing about either.
"""

from __future__ import annotations

import inspect
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from contextvars import ContextVar
from dataclasses import dataclass
from functools import cache, wraps
from typing import Any, ParamSpec, TypeVar

from stitchmesh.errors import StitchMeshError

T = TypeVar("T")
P = ParamSpec("P")


@dataclass(frozen=True, eq=False)
class Call:
    """A call of a shared function."""

    function: Callable[..., Any]
    """The shared function."""
    arguments: Mapping[str, Any]
    """The arguments that were given, by name."""

    @classmethod
    def of(cls, function: Callable[P, Any], *args: P.args, **kwargs: P.kwargs) -> Call:
        """Return the call of a function with these arguments."""
        return cls(function, _signature(function).bind(*args, **kwargs).arguments)

    def do(self) -> Any:
        """Do the work at once."""
        with done_by(AT_ONCE):
            bound = inspect.BoundArguments(_signature(self.function), dict(self.arguments))
            return self.function(*bound.args, **bound.kwargs)


class Worker:
    """Does the shared work of a block; this class does it at once, one call after another."""

    def do(self, call: Call) -> Any:
        """Do the work of a call, and return its result."""
        return call.do()

    def compute_each(self, computations: Sequence[Callable[[], T]]) -> list[T | StitchMeshError]:
        """Return the result of each computation, or its error."""
        return [_result_or_error(computation) for computation in computations]


@cache
def _signature(function: Callable[..., Any]) -> inspect.Signature:
    """Return the signature of a shared function; to read it takes longer than to bind arguments."""
    return inspect.signature(function)


AT_ONCE = Worker()
"""The worker of all calls that are made in no block."""
_worker: ContextVar[Worker] = ContextVar("worker", default=AT_ONCE)


@contextmanager
def done_by(worker: Worker) -> Iterator[None]:
    """Let a worker do the shared work of a block."""
    token = _worker.set(worker)
    try:
        yield
    finally:
        _worker.reset(token)


def shared(function: Callable[P, T]) -> Callable[P, T]:
    """Let the worker of the block do the work of a function; this is a decorator."""

    @wraps(function)
    def call(*args: P.args, **kwargs: P.kwargs) -> T:
        worker = _worker.get()
        if worker is AT_ONCE:
            return function(*args, **kwargs)
        result: T = worker.do(Call.of(call, *args, **kwargs))
        return result

    return call


def compute_each(computations: Sequence[Callable[[], T]]) -> list[T | StitchMeshError]:
    """Return the results or errors of computations that do not depend on each other, in the order of the computations.

    The worker of the block decides whether a computation begins before the one before it has ended.
    """
    return _worker.get().compute_each(computations)


def _result_or_error(computation: Callable[[], T]) -> T | StitchMeshError:
    try:
        return computation()
    except StitchMeshError as error:
        return error
