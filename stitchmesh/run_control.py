# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Control of a running relaxation from other threads: watch it, pause it, make single steps, stop it.

A relaxation runs in one thread. It calls ``RunControl.after_step`` after every step. A step of a mesh relaxation is an
iteration; a step of a relaxation of yarns is a Newton step, or the iterations up to the next assessment. All other
methods may be called from any thread, before or during the relaxation. A relaxation that is paused and continued ends
with the same bits as one that was never paused.
"""

from __future__ import annotations

import threading
import time
from collections.abc import Callable, Mapping
from contextlib import AbstractContextManager, nullcontext
from dataclasses import dataclass, field
from typing import Generic, TypeVar

from stitchmesh.errors import ParameterError

S = TypeVar("S")
WATCH_SECONDS = 0.1
"""Shortest time between two calls of ``watch`` [s]."""
LARGEST_SHARE = 0.05
"""Largest part of the time of a relaxation that ``watch`` may take; long calls are therefore made less often."""


class RunStopped(Exception):
    """The user has stopped a relaxation, which then returns its last good state."""


@dataclass(frozen=True, eq=False)
class Snapshot(Generic[S]):
    """The state of a running relaxation after one of its steps."""

    state: S
    """The last good state: a ``StitchMesh`` with the stretch of its edges, or a ``YarnSet``."""
    iteration: int
    """Number of iterations."""
    residual: float
    """Residual of the state."""
    tolerance: float
    """Residual at which the relaxation ends."""
    seconds: float
    """Time since the start, without pauses [s]."""
    energies: Mapping[str, float] = field(default_factory=dict)
    """Energy of each term [erg]; empty in a mesh relaxation."""


class RunControl(Generic[S]):
    """Watches, pauses, steps and stops one relaxation."""

    def __init__(
        self,
        watch: Callable[[Snapshot[S]], None] | None = None,
        *,
        seconds: float = WATCH_SECONDS,
        paused: bool = False,
    ) -> None:
        """Make the control of a relaxation that has not begun.

        Args:
            watch: called with a ``Snapshot`` in the thread of the relaxation, which waits for the call to end.
            seconds: shortest time between two calls of ``watch`` [s]; it grows if the calls take long
                (``LARGEST_SHARE``). A relaxation that pauses calls ``watch`` in any case.
            paused: whether the relaxation waits before its first step.

        Raises:
            ParameterError: the time is negative or not a number.
        """
        if not seconds >= 0.0:
            raise ParameterError(f"seconds between two snapshots: got {seconds}; expected 0 or more")
        self._watch = watch
        self.seconds = seconds
        """Shortest time between two calls of ``watch`` [s]; it may change while the relaxation runs."""
        self._condition = threading.Condition()
        self._paused, self._stopped, self._steps = paused, False, 0
        self._due = -float("inf")
        self.seconds_waited = 0.0
        """Time for which the relaxation has waited between its steps [s]."""

    @property
    def paused(self) -> bool:
        """Whether the relaxation waits for ``resume`` or ``step``, or will wait after its present step."""
        return self._paused

    @property
    def stopped(self) -> bool:
        """Whether ``stop`` was called."""
        return self._stopped

    def pause(self) -> None:
        """Let the relaxation wait after its present step; returns at once."""
        self._change(paused=True)

    def resume(self) -> None:
        """Let a paused relaxation continue; returns at once."""
        self._change(paused=False)

    def step(self, count: int = 1) -> None:
        """Pause the relaxation after ``count`` more steps; returns at once.

        If a paused relaxation has not made all steps of the last call, the new steps are added to them.

        Raises:
            ParameterError: the count is less than 1.
        """
        if count < 1:
            raise ParameterError(f"steps: got {count}; expected at least 1")
        with self._condition:
            self._steps = count + (self._steps if self._paused else 0)
            self._paused = True
            self._condition.notify_all()

    def stop(self) -> None:
        """Let the relaxation end after its present step with the last good state; returns at once."""
        with self._condition:
            self._stopped = True
            self._condition.notify_all()

    def after_step(
        self,
        snapshot: Callable[[], Snapshot[S]],
        *,
        before_wait: Callable[[], None] = lambda: None,
        aside: Callable[[], AbstractContextManager[None]] = nullcontext,
    ) -> None:
        """Show the state if it is due, and wait while the relaxation is paused; the relaxation calls this function.

        Args:
            snapshot: function that makes the snapshot; it is called only if there is a ``watch`` and a snapshot is due.
            before_wait: called before the relaxation waits, for example to write a checkpoint.
            aside: context manager that is entered between two steps and while the relaxation is paused, for example one
                that lets other threads launch kernels.

        Raises:
            RunStopped: the user has stopped the relaxation.
        """
        pauses = self._must_wait()
        if self._watch is not None and (pauses or time.monotonic() >= self._due):
            self._show(self._watch, snapshot)
        if pauses:
            before_wait()
        self._wait(aside)
        if self._stopped:
            raise RunStopped

    def _change(self, *, paused: bool) -> None:
        with self._condition:
            self._paused, self._steps = paused, 0
            self._condition.notify_all()

    def _show(self, watch: Callable[[Snapshot[S]], None], snapshot: Callable[[], Snapshot[S]]) -> None:
        """Show the state, and set the time at which the next one is due."""
        began = time.monotonic()
        watch(snapshot())
        now = time.monotonic()
        self._due = now + max(self.seconds, (now - began) / LARGEST_SHARE)

    def _must_wait(self) -> bool:
        """Return whether the relaxation waits now."""
        with self._condition:
            return self._paused and self._steps == 0 and not self._stopped

    def _wait(self, aside: Callable[[], AbstractContextManager[None]]) -> None:
        """Wait while the relaxation is paused, and count the step that follows."""
        began = time.monotonic()
        with aside(), self._condition:
            self._condition.wait_for(lambda: not self._paused or self._steps > 0 or self._stopped)
            self._steps = max(self._steps - 1, 0)
        self.seconds_waited += time.monotonic() - began
