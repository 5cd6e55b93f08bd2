# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The output folder of a job that runs, was stopped or has finished."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path

from stitchmesh.app.pages.view.viewed import Viewed, read_checkpoint_file, read_viewed
from stitchmesh.errors import FileError, ParameterError
from stitchmesh.io.checkpoint_file import previous_path
from stitchmesh.io.history import read_history
from stitchmesh.io.stitches import read_stitches
from stitchmesh.mixed.drape import SCENE_FILE, Draped
from stitchmesh.mixed.draped_folder import read_again, read_draped
from stitchmesh.mixed.output.frames import FOLDER as FRAMES
from stitchmesh.mixed.output.frames import Frames
from stitchmesh.mixed.scene.scene_file import read_scene


@dataclass(frozen=True)
class JobFiles:
    """The files of a job, with the times at which they were changed."""

    folder: Path
    times: tuple[tuple[str, int, int], ...]
    """Name, time of the last change [ns] and size of each file that is there."""

    def time_of(self, name: str) -> int:
        """Return the time at which a file was changed [ns]; 0 if it is not there."""
        return next((time for found, time, _ in self.times if found == name), 0)


JOB_FILES = ("stitches.h5", "yarns.h5", "checkpoint.smc", "convergence.csv", "report.json", SCENE_FILE, FRAMES)
"""Files of a job that are looked at; the folder of the frames changes with each frame."""


def job_files(folder: Path) -> JobFiles:
    """Return the files of a job that are there now.

    Raises:
        ParameterError: there is no such folder.
    """
    if not folder.is_dir():
        raise ParameterError(f"folder: {folder} is no folder; expected the output folder of a job")
    times = []
    for name in JOB_FILES:
        try:
            found = (folder / name).stat()
        except OSError:
            continue  # The job has not written it yet, or replaces it at this moment.
        times.append((name, found.st_mtime_ns, found.st_size))
    return JobFiles(folder, tuple(times))


def read_job(files: JobFiles, earlier: tuple[JobFiles, Viewed] | None = None) -> Viewed:
    """Read the newest state of a job: its yarns, or its stitches while it has no yarns, or its frames.

    Args:
        files: the files of the job.
        earlier: an earlier state of the same folder, of which a run with the same scene keeps what it has prepared.

    Raises:
        StitchMeshError: a file cannot be read, or there is none.
    """
    folder, here = files.folder, {name for name, _, _ in files.times}
    if {SCENE_FILE, FRAMES} <= here:
        return _read_run(files, earlier)
    # A job writes its convergence last; an earlier job may have left its own in the folder.
    finished = files.time_of("convergence.csv") >= files.time_of("yarns.h5") > 0
    line = f"The job in {folder.name} is {'finished' if finished else 'running, or was stopped'}."
    history = read_history(folder / "convergence.csv") if finished else []
    if "yarns.h5" in here:
        newer = files.time_of("checkpoint.smc") > files.time_of("yarns.h5")
        viewed = _newest_checkpoint(folder) if newer else read_viewed(folder / "yarns.h5")
        return replace(viewed, name=folder.name, history=history, text=line)
    if "stitches.h5" in here:
        return Viewed(folder.name, read_stitches(folder / "stitches.h5"), history=history, text=line)
    raise FileError(f"{folder}: holds no stitches.h5 and no yarns.h5 yet; wait until the job has written them")


def _read_run(files: JobFiles, earlier: tuple[JobFiles, Viewed] | None) -> Viewed:
    """Read a run of mixed yarns and triangles."""
    folder = files.folder
    if not len(Frames.of_folder(folder)):
        return Viewed(folder.name, text=f"The run in the folder {folder.name} has no frame yet.")
    known = None if earlier is None else earlier[1].thing
    same = isinstance(known, Draped) and known.prepared.scene == read_scene(folder / SCENE_FILE)
    draped = read_again(known, folder) if same and isinstance(known, Draped) else read_draped(folder)
    state = "finished" if draped.report else "running, or was stopped"
    return Viewed(folder.name, draped, text=f"The run in the folder {folder.name} is {state}.")


def _newest_checkpoint(folder: Path) -> Viewed:
    """Read the newest checkpoint that is whole."""
    path = folder / "checkpoint.smc"
    try:
        return read_checkpoint_file(path)
    except FileError:
        return read_checkpoint_file(previous_path(path))
