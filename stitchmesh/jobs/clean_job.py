# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Removal of the kept stages that the last run of a job has not used."""

from __future__ import annotations

from dataclasses import dataclass
from os import PathLike
from pathlib import Path

from stitchmesh.errors import FileError
from stitchmesh.io.folder_lock import FolderLock
from stitchmesh.jobs.job_status import read_status
from stitchmesh.jobs.kept_stages import KeptStages, stage_folder
from stitchmesh.jobs.run_job import BUSY


@dataclass(frozen=True)
class CleanedJob:
    """What was removed from the folder of a job."""

    removed: tuple[str, ...]
    """Names of the folders of the removed stages."""
    kept: int
    """Number of stages that are left."""
    freed: int
    """Size of the removed files [bytes]."""


def clean_job(folder: str | PathLike[str]) -> CleanedJob:
    """Remove stages and checkpoints from the folder of a job if they belong to other options than the last run.

    Raises:
        FileError: the folder has no job, its last run has not finished, a run is going on in it, or a file cannot be
            removed.
    """
    target = Path(folder)
    read_status(target)  # A folder without a job gets no lock.
    lock = FolderLock(target, BUSY)
    try:
        status = read_status(target)
        if status.state != "finished":
            found = f"the last run in it was {status.state}"
            raise FileError(f"{target}: {found}, so that its stages may still be needed; run the job to its end first")
        stages = KeptStages(target)
        stages.say_what_stays()
        removed, freed = stages.remove_others({stage_folder(stage.name, stage.key) for stage in status.stages})
        return CleanedJob(removed, len(stages.folders()), freed)
    finally:
        lock.release()
