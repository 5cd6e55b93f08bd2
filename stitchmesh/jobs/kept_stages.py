# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Finished stages, which are kept so that the next run of a job computes only what has changed.

Each stage has a folder ``stages/NAME-KEY`` in the folder of the job. The key is the checksum of the version of
StitchMesh, the name of the stage, its inputs with all their bits, and its options. ``stage.json`` is written last, so
that a folder with it is complete; it holds a checksum of its content, so that a stage with a damaged report is computed
again.

Only folders with such a name and the program's mark (``stitchmesh.io.own_files``) are ever removed. Everything else in
``stages`` belongs to the user, and stays.
"""

from __future__ import annotations

import hashlib
import json
import logging
import os
import re
import shutil
from collections.abc import Collection
from contextlib import suppress
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any, Generic, TypeVar

from stitchmesh import __version__
from stitchmesh.errors import FileError, StitchMeshError, first_few
from stitchmesh.io.atomic import write_json
from stitchmesh.io.checked import check_table, read_json
from stitchmesh.io.outputs import claim_folder
from stitchmesh.io.own_files import RECORD as MARK
from stitchmesh.io.own_files import is_marked, opened_folder
from stitchmesh.io.part_folder import PARTS, remove_stale_parts
from stitchmesh.io.path_kind import entries_of, is_folder
from stitchmesh.jobs.stage_files import read_value, write_value
from stitchmesh.pipeline.garment import Made
from stitchmesh.yarnrelax.fingerprint import DIGITS, checksum

STAGES = "stages"
"""Folder of the stages in the folder of a job."""
RECORD = "stage.json"
"""File that ends a stage: its report."""
STAGE_NAME = re.compile(rf"[a-z_]+-[0-9a-f]{{{DIGITS}}}")
"""Form of the name of the folder of a stage."""
T = TypeVar("T")
logger = logging.getLogger(__name__)


@dataclass(frozen=True)
class KeptStage(Generic[T]):
    """A stage of a job whose value can be kept."""

    name: str
    """Name of the public function."""
    key: str
    """Checksum of everything that decides the value."""
    kind: type[T]
    """Class of the value; ``stage_files`` knows its files."""

    @property
    def folder(self) -> str:
        """Name of the folder of the stage."""
        return stage_folder(self.name, self.key)


def stage_folder(name: str, key: str) -> str:
    """Return the name of the folder of a stage."""
    return f"{name}-{key}"


def stage_key(name: str, *inputs: Any) -> str:
    """Return the key of a stage.

    Args:
        name: name of the stage.
        inputs: the values of the stages before it, and the options: everything that decides the result.
    """
    return checksum(name, (__version__, name, inputs))


@dataclass(frozen=True, kw_only=True)
class StageRecord:
    """The time and the report of a finished stage."""

    seconds: float
    """Time of the stage [s]."""
    report: dict[str, Any]
    """Its entries in ``report.json``."""
    within: str | None = None
    """Time limit of the whole job, if it cut the stage short; the stage then counts as finished only for jobs with this
    limit."""


@dataclass(frozen=True)
class _RecordFile:
    """The content of ``stage.json``."""

    checksum: str
    record: StageRecord


def _checksum(record: StageRecord) -> str:
    """Return the SHA-256 checksum of a record, which does not change if JSON turns tuples into lists."""
    return hashlib.sha256(json.dumps(asdict(record)).encode()).hexdigest()


class KeptStages:
    """The finished stages in the folder of a job."""

    def __init__(self, folder: Path) -> None:
        """Open the stages in the folder of a job.

        Raises:
            FileError: the folder of the stages is a link.
        """
        self.folder = folder / STAGES
        if os.path.islink(self.folder):
            found = "is a symbolic link; expected a folder, in which stages are kept and removed"
            raise FileError(f"{self.folder}: {found}; remove the link, or choose another folder for the job")

    def folder_of(self, stage: KeptStage[Any]) -> Path:
        """Return the folder of a stage."""
        return self.folder / stage.folder

    def record(self, stage: KeptStage[Any]) -> StageRecord | None:
        """Return the record of a stage; None if the stage is not finished, or its record is damaged."""
        path = self.folder_of(stage) / RECORD
        try:
            read = check_table(read_json(path), _RecordFile) if path.is_file() else None
        except StitchMeshError:
            return None
        return read.record if read is not None and read.checksum == _checksum(read.record) else None

    def load(self, stage: KeptStage[T], record: StageRecord) -> Made[T] | None:
        """Return the result of a finished stage; None if a file is missing or damaged, or if the record was altered."""
        try:
            return Made(read_value(self.folder_of(stage), stage.kind, record.report), record.report)
        except StitchMeshError:
            return None

    def begin(self, stage: KeptStage[Any]) -> None:
        """Make the folder of a stage, with the program's mark.

        Raises:
            FileError: the folder cannot be made, or holds something that the program did not make.
        """
        claim_folder(self.folder_of(stage))

    def keep(self, stage: KeptStage[T], value: T, record: StageRecord) -> None:
        """Write the value of a stage, and then its record.

        Raises:
            FileError: a file cannot be written.
        """
        folder = self.folder_of(stage)
        write_value(folder, stage.kind, value)
        write_json(folder / RECORD, asdict(_RecordFile(_checksum(record), record)))

    def folders(self) -> list[Path]:
        """Return the folders of all stages, finished or not, in the order of their names."""
        return [path for path in self._inside() if self._is_stage(path)]

    def say_what_stays(self) -> None:
        """Print the names of other files in the folder of the stages, which the program did not make."""
        others = [path.name for path in self._inside() if not self._is_stage(path) and path.name not in (MARK, PARTS)]
        if others:
            logger.warning(f"{self.folder}: left alone what StitchMesh did not make: {first_few(others)}")

    def remove_others(self, names: Collection[str]) -> tuple[tuple[str, ...], int]:
        """Remove the folders of all stages whose names are not given; return the removed names and their size [bytes].

        Raises:
            FileError: a file cannot be removed.
        """
        others, freed = [path for path in self.folders() if path.name not in names], 0
        for path in others:
            size = sum(file.lstat().st_size for file in path.rglob("*") if file.is_file())
            self._remove(path)
            freed += size
        return tuple(path.name for path in others), freed

    def tidy(self, checkpoint: str) -> None:
        """Remove the remains of killed runs: parts of files, and unfinished stages without a checkpoint.

        Raises:
            FileError: a file cannot be removed.
        """
        for path in self.folders():
            for parts in list(path.rglob(PARTS)):
                remove_stale_parts(parts.parent)
            if not (path / RECORD).is_file() and not any(path.rglob(checkpoint)):
                self._remove(path)

    def _inside(self) -> list[Path]:
        return entries_of(self.folder) if is_folder(self.folder) else []

    def _is_stage(self, path: Path) -> bool:
        return STAGE_NAME.fullmatch(path.name) is not None and is_marked(path)

    def _remove(self, path: Path) -> None:
        """Remove the folder of a stage, but never follow a link, which may take its place meanwhile.

        The record of the stage is removed first, so that a partly removed stage is unfinished.
        """
        with opened_folder(path.parent) as stages, opened_folder(path.name, stages) as stage:
            try:
                if stage is not None:
                    with suppress(FileNotFoundError):
                        os.unlink(RECORD, dir_fd=stage)
                shutil.rmtree(path if stage is None else path.name, dir_fd=None if stage is None else stages)
            except OSError as error:
                raise FileError(f"{path}: cannot be removed ({error.strerror or error}); remove it by hand") from error
