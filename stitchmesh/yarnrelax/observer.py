# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Output of a running relaxation to its caller: history, progress, states and checkpoints."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from functools import partial
from typing import Protocol

import numpy as np

from stitchmesh.compute.device import others_may_launch
from stitchmesh.errors import FileError
from stitchmesh.io.history import HistoryEntry
from stitchmesh.run import Run
from stitchmesh.run_control import Snapshot
from stitchmesh.yarn import YarnSet
from stitchmesh.yarnrelax.checkpoint import CheckpointState, EndedStep, write_state
from stitchmesh.yarnrelax.load_position import LoadPosition
from stitchmesh.yarnrelax.relaxation_loop import RelaxationLoop

PROGRESS_SECONDS = 0.5
"""Time between two calls of ``report`` [s]."""


class Loaded(Protocol):
    """A relaxation under a load that is applied at once or in steps."""

    @property
    def loop(self) -> RelaxationLoop:
        """The loop of the present step of the load."""

    @property
    def position(self) -> LoadPosition:
        """The place on the path of loads (``loading``)."""

    def good_yarns(self) -> YarnSet:
        """Return the last accepted state of the yarns, with the inputs that the caller asked for."""


@dataclass(eq=False)
class Observer:
    """Keeps the history of a relaxation, reports its progress, hands out states and writes checkpoints."""

    loading: Loaded
    run: Run[YarnSet]
    report: Callable[..., None] | None
    """Called with the iteration and the residual; None if nothing is shown."""
    inputs: Mapping[str, str]
    began: float
    ended: Sequence[EndedStep] = ()
    """The load steps before the present one."""
    history: list[HistoryEntry] = field(default_factory=list)
    unwritten: CheckpointState | None = None
    """The state at the last assessment, until it is written."""
    written: float = -np.inf
    """Iteration of the last checkpoint that was written because it was due."""
    reported: float = 0.0
    saved: float = 0.0

    @property
    def loop(self) -> RelaxationLoop:
        """The loop of the present step of the load."""
        return self.loading.loop

    def note(self) -> None:
        """Add the last assessment to the history; report it, hand out the state and write a checkpoint when due.

        Raises:
            RunStopped: the user has stopped the relaxation.
        """
        loop, now = self.loop, time.perf_counter()
        last = loop.last[0]
        entry = HistoryEntry(
            iteration=loop.iteration, seconds=self.seconds(), residual=last.residual, energies=last.energies
        )
        self.history.append(entry)
        # To keep the bits, a relaxation that continues with a larger limit repeats the interval that was cut short.
        if self.run.checkpoints is not None and not loop.cut_short:
            self.unwritten = CheckpointState(
                loop.state(), self.seconds(), tuple(self.history), self.loading.position, tuple(self.ended)
            )
            if loop.iteration >= self.written + self.run.checkpoints.every:
                self.written = loop.iteration
                self.write_checkpoint()
        # A caller that ends the relaxation by an exception finds the last assessment in the checkpoint.
        if self.report is not None and now - self.reported > PROGRESS_SECONDS:
            self.reported = now
            self.report(loop.iteration, last.residual)
        if self.run.on_state is not None and now - self.saved > 5.0:  # seconds
            self.saved = now
            self.run.on_state(self.loading.good_yarns())
        if self.run.control is not None:
            make = partial(self._snapshot, entry)
            self.run.control.after_step(make, before_wait=self.write_checkpoint, aside=others_may_launch)

    def seconds(self) -> float:
        """Return the time since the start, without the time for which the relaxation has waited [s]."""
        waited = 0.0 if self.run.control is None else self.run.control.seconds_waited
        return time.perf_counter() - self.began - waited

    @contextmanager
    def last_state_kept(self) -> Iterator[None]:
        """Write a checkpoint of the last assessment whenever the block ends; hand out the state if it ends early."""
        try:
            yield
        except FileError:  # Checkpoints cannot be written.
            raise
        except BaseException:
            if self.run.on_state is not None:
                self.run.on_state(self.loading.good_yarns())
            self.write_checkpoint()
            raise
        self.write_checkpoint()

    def write_checkpoint(self) -> None:
        """Write a checkpoint of the last assessment, unless it was written already."""
        if self.run.checkpoints is not None and self.unwritten is not None:
            write_state(self.run.checkpoints.path, self.inputs, self.unwritten)
            self.unwritten = None

    def resume(self, saved: CheckpointState) -> None:
        """Continue from a checkpoint of the same relaxation."""
        self.loop.resume(saved.loop)
        self.written = saved.loop.iteration
        self.history = list(saved.history)
        self.began -= saved.seconds

    def _snapshot(self, entry: HistoryEntry) -> Snapshot[YarnSet]:
        """Return the last accepted state with its assessment."""
        yarns, tolerance = self.loading.good_yarns(), self.loop.tolerance
        figures = entry["residual"], tolerance, entry["seconds"], entry["energies"]
        return Snapshot(yarns, entry["iteration"], *figures)
