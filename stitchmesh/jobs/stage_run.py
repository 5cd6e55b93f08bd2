# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The state that the stages of a running job share, and the function that runs each stage."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, TypeVar

from stitchmesh.budget.budget import Budget
from stitchmesh.budget.plan import limit_of
from stitchmesh.errors import ParameterError
from stitchmesh.jobs.job import Job
from stitchmesh.jobs.job_status import JobLog, StageStatus, StopRequest
from stitchmesh.jobs.kept_stages import KeptStage, KeptStages, StageRecord
from stitchmesh.pipeline.garment import Made
from stitchmesh.time_limit import limited_to

T = TypeVar("T")


@dataclass(frozen=True, eq=False)
class JobRun:
    """A running job."""

    job: Job
    """What is made."""
    folder: Path
    """Folder of the job."""
    resume: bool
    """Whether a stage continues from its checkpoint."""
    stop: StopRequest
    """The request to stop."""
    log: JobLog
    """Where progress is reported."""
    kept: KeptStages
    """The finished stages."""
    budget: Budget | None = None
    """The limits on the time and on the error; None without limits."""

    def progress(self, stage: str, done: float, note: str) -> None:
        """Report the progress of the present stage (a ``Progress`` function).

        Raises:
            JobStopped: the user wants the job to stop.
        """
        self.log.progress(stage, done, note)
        self.stop.check()

    def finished(self, stage: KeptStage[T]) -> StageRecord | None:
        """Return the record of a stage that an earlier run has finished; None if it has to be computed."""
        record = self.kept.record(stage)
        return record if record is None or record.within in (None, self.job.within) else None

    def check_resume(self, stage: KeptStage[Any], *, stopped: bool) -> None:
        """Refuse to lose the work of a run that was stopped in a stage.

        Args:
            stage: the stage.
            stopped: whether the stage has a checkpoint.

        Raises:
            ParameterError: the stage has a checkpoint, and the job shall not continue from it.
        """
        if stopped and not self.resume and self.finished(stage) is None:
            raise ParameterError(
                f"{self.folder}: a run was stopped in {stage.name}; give --resume to continue from its checkpoint, or "
                f"remove {self.kept.folder_of(stage)} to begin that stage again"
            )

    def keep(self, stage: KeptStage[T], make: Callable[[], Made[T]]) -> Made[T]:
        """Return the result of a stage: the result that an earlier run has kept, or a new one, which is kept.

        Args:
            stage: the stage.
            make: makes the value.

        Raises:
            StitchMeshError: the stage cannot be carried out, or its files cannot be written.
            JobStopped: the user wants the job to stop.
        """
        self.stop.check()
        record = self.finished(stage)
        found = None if record is None else self.kept.load(stage, record)
        if record is not None and found is not None:
            self._end(stage, record, kept=True)
            return found
        self.log.begin(stage.name)
        self.kept.begin(stage)
        began = time.perf_counter()
        made = make()
        report = dict(made.report)
        late = any(cut_short(entry) for entry in report.values() if isinstance(entry, dict))
        within = self.job.within if late else None
        record = StageRecord(seconds=round(time.perf_counter() - began, 4), report=report, within=within)
        self.kept.keep(stage, made.value, record)
        self._end(stage, record, kept=False)
        return made

    @contextmanager
    def continued(self, seconds: float) -> Iterator[None]:
        """In the block, count the time of earlier stages, and of the part of a stage that an earlier run has done [s].

        Raises:
            ParameterError: no time is left.
        """
        spent = seconds + sum(stage.seconds for stage in self.log.stages if stage.kept)
        self.log.add(spent)
        limited = None if self.budget is None else replace(self.budget, began=self.budget.began - spent)
        with limited_to(limit_of(limited)):
            yield

    def _end(self, stage: KeptStage[T], record: StageRecord, *, kept: bool) -> None:
        self.log.end(StageStatus(name=stage.name, key=stage.key, kept=kept, seconds=record.seconds))


def cut_short(entry: Mapping[str, Any]) -> bool:
    """Return whether the time limit has ended a relaxation, given its report."""
    return any(entry.get(name) for name in ("out_of_time", "stopped", "search_out_of_time"))
