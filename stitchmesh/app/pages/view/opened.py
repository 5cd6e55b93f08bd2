# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""What the page shows: meshes, stitches, yarns or runs with their companions, pictures, texts, and folders of jobs.

A folder is read again after its job has written into it.
"""

from __future__ import annotations

import threading
from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TypeAlias

from stitchmesh.app.project.project import Project
from stitchmesh.errors import FileError, ParameterError, StitchMeshError
from stitchmesh.faces.face_mesh import FaceMesh
from stitchmesh.io.any_file import read_any
from stitchmesh.io.atomic import temporary_file
from stitchmesh.io.checkpoint_file import previous_path
from stitchmesh.io.contents import read_bytes, read_lines
from stitchmesh.io.hdf5 import stored_format
from stitchmesh.io.history import HistoryEntry, read_history
from stitchmesh.io.path_kind import is_file, is_folder, is_there
from stitchmesh.io.stitches import read_stitches
from stitchmesh.io.yarns import read_yarns
from stitchmesh.jobs.job_status import JobStatus, read_status
from stitchmesh.jobs.kept_stages import STAGES
from stitchmesh.labeling.labeling_file import FORMAT as LABELING
from stitchmesh.labeling.labeling_file import read_labeling
from stitchmesh.mesh import Mesh, StitchMesh
from stitchmesh.mixed.drape import SCENE_FILE, Draped
from stitchmesh.mixed.draped_folder import read_again, read_draped
from stitchmesh.mixed.output.frames import FOLDER as FRAMES
from stitchmesh.mixed.output.frames import Frames
from stitchmesh.mixed.scene.scene import read_scene
from stitchmesh.run import CHECKPOINT
from stitchmesh.yarn import YarnSet
from stitchmesh.yarngen.face_yarns.generate import face_yarns
from stitchmesh.yarnrelax.checkpoint_yarns import checkpoint_yarns

MOST_CHARACTERS = 20_000
"""Number of characters of a text that are shown; the rest is left out."""
TEXTS = (".json", ".toml", ".txt", ".md", ".k")
"""Suffixes of files whose text is shown."""
SUFFIXES = (
    ".h5", ".bcc", ".yarns", ".usda", ".usdc", ".usd", ".vtp", ".obj", ".pyp", ".smobj", ".st", ".ply", ".off",
    ".stl", ".glb", ".gltf", ".vtk", ".vtu", ".msh", ".mesh", ".csv", ".png", *TEXTS,
)  # fmt: skip
"""Suffixes of files that can be uploaded."""


Thing: TypeAlias = Mesh | YarnSet | Draped
"""The things that can stand in the scene; a run is a run of mixed yarns and triangles."""


@dataclass(frozen=True, eq=False)
class Viewed:
    """Something to look at, with the facts about it."""

    name: str
    """Name of the thing, in the words of the user."""
    thing: Thing | None = None
    """The mesh, the stitches, the yarns or the run; None for a picture, a plot or a text alone."""
    fabric: StitchMesh | None = None
    """The stitches from which the yarns were made, for colours by stitch."""
    history: Sequence[HistoryEntry] = ()
    """Assessments of the relaxation."""
    picture: bytes = b""
    """A PNG file."""
    text: str = ""
    """Text of a file, or a line about a running job."""
    job: JobStatus | None = None
    """Progress of the job that makes it; None for anything else."""


def project_results(project: Project) -> dict[str, Viewed]:
    """Return the results of a project, the newest first, by their names in the list of the page."""
    stitches = project.evened if project.evened is not None else project.fabric
    history = project.history or ()
    found = {
        "Relaxed yarns": Viewed("Relaxed yarns", project.relaxed, stitches, history),
        "Generated yarns": Viewed("Generated yarns", project.yarns, stitches),
        "Evened stitches": Viewed("Evened stitches", project.evened),
        "Stitches": Viewed("Stitches", project.fabric),
        "Labeled mesh": Viewed("Labeled mesh", project.labeled),
        "Mesh": Viewed("Mesh", project.mesh),
    }
    return {name: viewed for name, viewed in found.items() if viewed.thing is not None}


def read_viewed(path: Path) -> Viewed:
    """Read a file; yarns get the stitches of ``stitches.h5`` in the same folder if these fit.

    Raises:
        StitchMeshError: the file cannot be read.
    """
    reader = READERS.get(path.suffix.lower(), _read_thing)
    return replace(reader(path), name=path.name)


def _read_thing(path: Path) -> Viewed:
    if path.suffix.lower() == ".h5" and is_file(path) and stored_format(path) == LABELING:
        return Viewed("", read_labeling(path).mesh)
    thing = read_any(path)
    if isinstance(thing, FaceMesh):
        return Viewed("", face_yarns(thing).yarns)
    return Viewed("", thing, stitches_beside(path, thing) if isinstance(thing, YarnSet) else None)


def stitches_beside(path: Path, yarns: YarnSet) -> StitchMesh | None:
    """Return the stitches in the folder of a file of yarns if the yarns can come from them."""
    beside = path.with_name("stitches.h5")
    if not is_file(beside) or yarns.face.max(initial=-1) < 0:
        return None
    try:
        fabric = read_stitches(beside)
    except FileError:
        return None
    return fabric if yarns.face.max() < fabric.face_count else None


def read_checkpoint_file(path: Path) -> Viewed:
    """Read a checkpoint; its yarns are in the same folder, or beside the folder of checkpoints."""
    stem = path.parent.name.removesuffix(".checkpoints")
    places = [path.with_name("yarns.h5"), path.parent.with_name(f"{stem}.h5")]
    beside = next((place for place in places if is_file(place)), None)
    if beside is None:
        raise FileError(f"{path}: a checkpoint holds positions only; put yarns.h5 of the same job beside it")
    yarns = checkpoint_yarns(path, read_yarns(beside))
    return Viewed("", yarns, stitches_beside(beside, yarns))


def _read_table(path: Path) -> Viewed:
    """Read the convergence of a relaxation, or read any other table as a text."""
    try:
        return Viewed("", history=read_history(path))
    except FileError:
        return _read_text(path)


def _read_picture(path: Path) -> Viewed:
    content = read_bytes(path)
    if not content.startswith(b"\x89PNG\r\n\x1a\n"):
        raise FileError(f"{path}: is no PNG picture; expected one that StitchMesh wrote")
    return Viewed("", picture=content)


def _read_text(path: Path) -> Viewed:
    text = "\n".join(read_lines(path))
    more = f"\n... and {len(text) - MOST_CHARACTERS} more characters" if len(text) > MOST_CHARACTERS else ""
    return Viewed("", text=text[:MOST_CHARACTERS] + more)


READERS: dict[str, Callable[[Path], Viewed]] = {
    ".smc": read_checkpoint_file, ".csv": _read_table, ".png": _read_picture, **dict.fromkeys(TEXTS, _read_text),
}  # fmt: skip
"""Functions that read files other than meshes, stitches and yarns, by suffix."""


@dataclass(frozen=True)
class JobFiles:
    """The files of a job, with the times of their last changes."""

    folder: Path
    times: tuple[tuple[str, int, int], ...]
    """Name, time of the last change [ns] and size of each existing file."""
    status: JobStatus | None = None
    """Progress of the job, if `stitchmesh run` has started it."""

    def time_of(self, name: str) -> int:
        """Return the time of the last change of a file [ns]; 0 if there is no such file."""
        return next((time for found, time, _ in self.times if found == name), 0)


STATES = ("stitches.h5", "yarns.h5", "convergence.csv", "report.json", SCENE_FILE, FRAMES)
"""Files of a job that are watched; the folder of the frames changes with each frame."""
EVERY_SECONDS = 1.0
"""Time between two checks of the folder."""
WAITING = "Waiting for the first result: the folder holds no stitches.h5, no yarns.h5 and no frames yet."


def job_files(folder: Path) -> JobFiles:
    """Return the present files of a job.

    Raises:
        ParameterError: the folder does not exist.
    """
    if not is_folder(folder):
        raise ParameterError(f"folder: {folder} is no folder; expected the output folder of a job")
    times = []
    for name, path in {**{name: folder / name for name in STATES}, CHECKPOINT: _checkpoint_path(folder)}.items():
        try:
            found = path.stat()
        except OSError:
            continue  # The job has not written the file yet, or is replacing it.
        times.append((name, found.st_mtime_ns, found.st_size))
    return JobFiles(folder, tuple(times), _status(folder))


def read_job(files: JobFiles, earlier: tuple[JobFiles, Viewed] | None = None) -> Viewed:
    """Read the newest state of a job: its yarns, its stitches if it has no yarns yet, or its frames.

    Args:
        files: the files of the job.
        earlier: an earlier state of the same folder. It is kept if only the status of the job is newer, and a run of
            the same scene keeps its preparation.

    Raises:
        StitchMeshError: a file cannot be read, or there is none.
    """
    folder, here = files.folder, {name for name, _, _ in files.times}
    if files.status is not None and earlier is not None and files.times == earlier[0].times:
        return replace(earlier[1], job=files.status)
    if {SCENE_FILE, FRAMES} <= here:
        return _read_run(files, earlier)
    # A job writes its convergence last; the file of an earlier job may still be in the folder.
    finished = files.time_of("convergence.csv") >= files.time_of("yarns.h5") > 0
    state = "finished" if finished else "running, or was stopped"
    line = f"The job in {folder.name} is {state}." if files.status is None else ""
    history = read_history(folder / "convergence.csv") if finished else []
    if "yarns.h5" in here:
        newer = files.time_of(CHECKPOINT) > files.time_of("yarns.h5")
        viewed = _newest_checkpoint(folder) if newer else read_viewed(folder / "yarns.h5")
        return replace(viewed, name=folder.name, history=history, text=line, job=files.status)
    if "stitches.h5" in here:
        return Viewed(folder.name, read_stitches(folder / "stitches.h5"), history=history, text=line, job=files.status)
    if files.status is not None:
        return Viewed(folder.name, text=WAITING, job=files.status)
    raise FileError(f"{folder}: holds no stitches.h5 and no yarns.h5 yet; wait until the job has written them")


class FolderWatch:
    """A thread that watches a folder until it is stopped."""

    def __init__(self, folder: Path, changed: Callable[[JobFiles], object]) -> None:
        """Start; the thread of the watch calls ``changed`` with the files after each change."""
        self.folder, self._changed = folder, changed
        self._stopped = threading.Event()
        self._seen = job_files(folder)
        threading.Thread(target=self._run, name=f"watching {folder}", daemon=True).start()

    def stop(self) -> None:
        """End the thread."""
        self._stopped.set()

    def _run(self) -> None:
        while not self._stopped.wait(EVERY_SECONDS):
            try:
                files = job_files(self.folder)
            except StitchMeshError:
                continue  # The folder may return, for example on a disk of another computer.
            if files != self._seen and not self._stopped.is_set():
                self._seen = files
                self._changed(files)


def _status(folder: Path) -> JobStatus | None:
    """Return the progress of a job that `stitchmesh run` has started; None without one, or if its file is damaged."""
    try:
        return read_status(folder)
    except FileError:
        return None


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


def _checkpoint_path(folder: Path) -> Path:
    """Return the newest checkpoint of a garment's relaxation: beside the yarns, or among the kept stages."""
    found = [folder / CHECKPOINT, *folder.glob(f"{STAGES}/relax_yarns-*/{CHECKPOINT}")]
    return max(found, key=_time)


def _time(path: Path) -> int:
    """Return the time of the last change of a file [ns]; 0 if there is no such file."""
    try:
        return path.stat().st_mtime_ns
    except OSError:
        return 0


def _newest_checkpoint(folder: Path) -> Viewed:
    """Read the newest intact checkpoint that fits the yarns in the folder; without one, read these yarns."""
    path, beside = _checkpoint_path(folder), folder / "yarns.h5"
    before = read_viewed(beside)
    assert isinstance(before.thing, YarnSet)
    for one in (path, previous_path(path)):
        with suppress(FileError):
            return replace(before, thing=checkpoint_yarns(one, before.thing))
    return before


class Opened:
    """The opened thing, and the watch of its folder if it is a job. All methods belong to the event thread."""

    def __init__(self, post: Callable[..., None], changed: Callable[[], object]) -> None:
        """Start with nothing.

        Args:
            post: calls a function in the event thread; any thread may call it.
            changed: called in the event thread when a job has a newer state.
        """
        self.viewed: Viewed | None = None
        self.watch: FolderWatch | None = None
        self._post, self._changed = post, changed
        self._files: JobFiles | None = None

    def open_path(self, path: Path) -> None:
        """Open a file, or the output folder of a job, and follow the job from now on.

        Raises:
            StitchMeshError: the file or the folder cannot be read.
        """
        if not is_there(path):
            raise FileError(f"{path}: does not exist; expected a file, or the output folder of a job")
        self.stop()
        if not is_folder(path):
            self.viewed = read_viewed(path)
            return
        files = job_files(path)
        self.viewed = self._read(files) if files.times or files.status else Viewed(path.name, text=WAITING)
        self.watch = FolderWatch(path, lambda now: self._post(self.take_state, now))

    def receive(self, name: str, content: bytes) -> None:
        """Open an uploaded file.

        Raises:
            StitchMeshError: the file cannot be read.
        """
        self.viewed = read_upload(name, content)
        self.stop()

    def take_state(self, files: JobFiles) -> None:
        """Read the newest state of the job, unless the user has opened something else.

        Raises:
            StitchMeshError: a file cannot be read.
        """
        if self.watch is not None and files.folder == self.watch.folder:
            self.viewed = self._read(files)
            self._changed()

    def _read(self, files: JobFiles) -> Viewed:
        """Read a state of a job; an earlier state of the same folder saves work."""
        before, self._files = self._files, files
        if before is None or self.viewed is None or before.folder != files.folder:
            return read_job(files)
        return read_job(files, (before, self.viewed))

    def follow_again(self) -> None:
        """Watch the folder again after a pause, and read its changes."""
        if self.watch is not None:
            self.open_path(self.watch.folder)

    def stop(self) -> None:
        """Stop watching the folder."""
        if self.watch is not None:
            self.watch.stop()
            self.watch = None

    def pause(self) -> None:
        """End the watch, but keep the folder for ``follow_again``."""
        if self.watch is not None:
            self.watch.stop()


def read_upload(name: str, content: bytes) -> Viewed:
    """Read an uploaded file.

    Raises:
        StitchMeshError: the file cannot be read.
    """
    with temporary_file(name, content) as path:
        return read_viewed(path)
