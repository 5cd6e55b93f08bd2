# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The progress of a job, as a file that another process can read at any moment, and the request to stop the job.

A process that gets a signal makes this request, for example.
"""

from __future__ import annotations

import os
import socket
import time
from collections.abc import Callable
from dataclasses import asdict, dataclass, replace
from datetime import UTC, datetime
from pathlib import Path
from typing import Literal

from stitchmesh.errors import FileError, StitchMeshError
from stitchmesh.io.atomic import write_json
from stitchmesh.io.checked import check_table, read_json
from stitchmesh.io.folder_lock import FolderLock, is_locked
from stitchmesh.io.path_kind import is_file
from stitchmesh.progress import Outlook, StageClock

STATUS = "status.json"
"""Name of the file in the folder of a job."""
State = Literal["running", "finished", "stopped", "failed", "killed"]
"""State of a job. The file of a killed job still says that it runs, but nobody holds its lock."""


@dataclass(frozen=True, kw_only=True)
class StageStatus:
    """A stage that has ended."""

    name: str
    """Name of the public function."""
    key: str
    """Key of the stage (``kept_stages``)."""
    kept: bool
    """Whether an earlier run had finished the stage."""
    seconds: float
    """Time that the stage took when it was computed [s]."""


@dataclass(frozen=True, kw_only=True)
class JobStatus:
    """One report of the progress of a job."""

    time: str
    """Moment of the report, in UTC."""
    state: State
    """State of the job."""
    stage: str
    """Name of the present stage, or of the last one."""
    done: float
    """Completed part of the stage, from 0 to 1."""
    seconds: float
    """Time since the start of the job, including the time of the runs that it continues [s]."""
    seconds_left: tuple[float, float] | None = None
    """Estimated least and most remaining time of the stage [s]; None if it is not known."""
    note: str = ""
    """Text that the stage reports, such as iteration and residual."""
    stages: tuple[StageStatus, ...] = ()
    """The stages that have ended."""
    process: int = 0
    """Number of the process."""
    host: str = ""
    """Name of its machine."""

    @property
    def line(self) -> str:
        """Return the report in one line."""
        left = f", {self.outlook.words}" if self.outlook.words else ""
        note = f" ({self.note})" if self.note else ""
        return f"{self.stage}: {self.outlook.percent}{left}{note}"

    @property
    def outlook(self) -> Outlook:
        """The completed part of the stage and its remaining time."""
        return Outlook(self.done, self.seconds_left)


Listener = Callable[[JobStatus], None]
"""Function that is called with each report of a job."""


class JobLog:
    """Reports of a running job: to the file, and to a listener."""

    def __init__(self, folder: Path, lock: FolderLock, listener: Listener) -> None:
        """Begin the reports to a listener and to a file in the folder of the job, whose lock the job holds."""
        self._path, self._lock, self._listener = folder / STATUS, lock, listener
        self._began, self._stage_began, self._written = time.monotonic(), 0.0, 0.0
        self._now = JobStatus(
            time="", state="running", stage="", done=0.0, seconds=0.0, process=os.getpid(), host=socket.gethostname()
        )

    @property
    def stages(self) -> tuple[StageStatus, ...]:
        """The stages that have ended."""
        return self._now.stages

    @property
    def seconds(self) -> float:
        """Time since the start of the job [s]."""
        return time.monotonic() - self._began

    def add(self, seconds: float) -> None:
        """Add the time of the runs that this run continues [s]."""
        self._began -= seconds

    def begin(self, stage: str) -> None:
        """Report the start of a stage."""
        self._stage_began, self._clock = time.monotonic(), StageClock()
        self._report(always=True, stage=stage, done=0.0, seconds_left=None, note="")

    def progress(self, stage: str, done: float, note: str) -> None:
        """Report the progress of the present stage (a ``Progress`` function, which keeps the name of the stage)."""
        outlook = self._clock.outlook(time.monotonic() - self._stage_began, done)
        left = None if outlook.left is None else (round(outlook.left[0], 1), round(outlook.left[1], 1))
        self._report(done=outlook.part, seconds_left=left, note=note.replace("\n", "; "))

    def end(self, stage: StageStatus) -> None:
        """Report the end of a stage."""
        stages = (*self._now.stages, stage)
        self._report(always=True, stage=stage.name, done=1.0, seconds_left=None, note="", stages=stages)

    def close(self, state: State, note: str = "") -> None:
        """Report the end of the job."""
        self._report(always=True, state=state, seconds_left=None, note=note)

    def _report(self, *, always: bool = False, **changes: object) -> None:
        now = time.monotonic()
        stamp = datetime.now(UTC).isoformat(timespec="seconds")
        self._now = replace(self._now, time=stamp, seconds=round(self.seconds, 2), **changes)  # type: ignore[arg-type]
        if always or now - self._written >= 1.0:  # At most one write a second while a stage runs.
            self._written = now
            self._lock.check()
            write_json(self._path, asdict(self._now))
        self._listener(self._now)


def read_status(folder: Path) -> JobStatus:
    """Read the last report of the job in a folder; if its process ended without a last report, the job was killed.

    Raises:
        FileError: the folder has no job, or its file is damaged.
    """
    path = folder / STATUS
    if not is_file(path):
        raise FileError(f"{folder}: holds no {STATUS}; expected the folder of a job that `stitchmesh run` has started")
    try:
        found = check_table(read_json(path), JobStatus)
    except StitchMeshError as error:
        raise FileError(f"{path}: is not the status of a job ({error}); run the job again") from error
    return replace(found, state="killed") if found.state == "running" and not is_locked(folder) else found


class JobStopped(Exception):
    """The user has stopped a job; its relaxation has written a checkpoint."""


class StopRequest:
    """A request to stop. A job checks it between stages and at each report of its progress."""

    def __init__(self) -> None:
        """Begin without a request."""
        self.asked = False
        """Whether the job shall stop."""

    def ask(self) -> None:
        """Ask the job to stop; returns at once, and may be called in a signal handler or in another thread."""
        self.asked = True

    def check(self) -> None:
        """Return if nobody has asked.

        Raises:
            JobStopped: somebody has asked.
        """
        if self.asked:
            raise JobStopped
