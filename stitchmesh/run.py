# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""How a relaxation begins, shows its progress, hands out and keeps its states, and is paused, stopped and continued.

One value holds all of this. A function takes it as its argument ``run`` and passes it on unchanged.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, fields
from pathlib import Path
from typing import Any, Generic, Literal, TypeVar

from stitchmesh.errors import ParameterError
from stitchmesh.io.contents import FilePath
from stitchmesh.progress import Progress, relaxing_progress, shown_progress
from stitchmesh.run_control import RunControl

S = TypeVar("S")
CHECKPOINT = "checkpoint.smc"
"""Name of the newest checkpoint in its folder."""


@dataclass(frozen=True)
class Checkpoints:
    """Where and how often checkpoints of a relaxation are written.

    Raises:
        ParameterError: ``every`` is below 1.
    """

    folder: FilePath
    """Folder of ``checkpoint.smc`` and of the previous one, ``checkpoint.previous.smc``; created if it is missing."""
    every: int
    """Least number of iterations between two checkpoints; a checkpoint is written after the next assessment."""

    def __post_init__(self) -> None:
        if self.every < 1:
            raise ParameterError(f"checkpoint: got one every {self.every} iterations; expected at least 1")

    @property
    def path(self) -> Path:
        """The newest checkpoint."""
        return Path(self.folder) / CHECKPOINT


@dataclass(frozen=True, eq=False)
class Run(Generic[S]):
    """What happens around a relaxation whose states are of one kind: yarns, or a stitch mesh."""

    progress: Progress | Literal[False] | None = None
    """Called with the stage, its completed part and a line of text, for yarns about every half second. By default they
    are shown in a line on a terminal or in a notebook; False shows nothing."""
    on_state: Callable[[S], None] | None = None
    """Called every few seconds, and when a relaxation of yarns ends early, with the last accepted state."""
    checkpoints: Checkpoints | None = None
    """Where and how often to write checkpoints; the relaxation also writes one at its start and at its end."""
    resume: FilePath | None = None
    """A checkpoint to continue from; all other inputs must be the same as when it was written."""
    start: S | None = None
    """The same piece at other positions to start from, for example as it was relaxed before an edit."""
    load_steps: bool = True
    """Whether a load is applied in steps (``yarnrelax.loading``) if it would press yarns through one another at once.
    The report then says so. Without load steps such a load is an error. Terms begin anew in each step."""
    control: RunControl[S] | None = None
    """Watches, pauses, steps and stops the relaxation from another thread. A pause writes a checkpoint, and a stopped
    relaxation returns its last accepted state."""

    @property
    def only_shows(self) -> bool:
        """Whether the run asks for nothing but the progress."""
        return not self._asks_for()

    def refuse_all_but(self, place: str, *obeyed: str) -> None:
        """Refuse the fields that a computation does not obey; all computations obey ``progress``.

        Args:
            place: name of the function, for the message.
            obeyed: names of the fields that it obeys beside ``progress``.

        Raises:
            ParameterError: another field is given.
        """
        for name in self._asks_for():
            if name not in obeyed:
                raise ParameterError(f"{place}, run: got {name}, which it does not obey; leave it out")

    def _asks_for(self) -> list[str]:
        """Return the names of the given fields, without ``progress``."""
        return [
            own.name for own in fields(self)
            if own.name != "progress" and getattr(self, own.name) is not own.default
        ]  # fmt: skip

    @contextmanager
    def assessments_shown(
        self, stage: str, goal: float, max_iterations: float = math.inf
    ) -> Iterator[Callable[..., None] | None]:
        """Provide the function to which a solver reports its iteration and its residual; None if nothing is shown.

        Args:
            stage: name of the stage.
            goal: residual near which the stage is complete.
            max_iterations: iterations at which the stage is complete.
        """
        with shown_progress(self.progress, lambda line: line) as report:
            yield None if report is None else relaxing_progress(stage, goal, report, max_iterations=max_iterations)


SHOWN: Run[Any] = Run()
"""A run that shows a line of progress."""
QUIET: Run[Any] = Run(progress=False)
"""A run that shows nothing, for relaxations that are a part of other work."""
