# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Finished stages, which are kept so that the next run of a job computes only what has changed.

Each stage has a folder ``stages/NAME-KEY`` in the folder of the job. The key is the checksum of the version of
StitchMesh, the name of the stage, its inputs with all their bits, and its options. ``stage.json`` is written last, so
that a folder with it is complete.
"""

from __future__ import annotations

import json
import shutil
from collections.abc import Callable, Iterator
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any, Generic, TypeVar

from stitchmesh import __version__
from stitchmesh.errors import FileError, StitchMeshError
from stitchmesh.io.atomic import write_json
from stitchmesh.io.checked import check_table
from stitchmesh.io.contents import read_bytes
from stitchmesh.yarnrelax.fingerprint import checksum

STAGES = "stages"
"""Folder of the stages in the folder of a job."""
RECORD = "stage.json"
"""File that ends a stage: its report."""
T = TypeVar("T")


@dataclass(frozen=True)
class Stage(Generic[T]):
    """A stage of a job whose result can be kept."""

    name: str
    """Name of the public function."""
    key: str
    """Checksum of everything that decides the result."""
    write: Callable[[Path, T], None]
    """Writes the result into a folder."""
    read: Callable[[Path, dict[str, Any]], T]
    """Reads the result with all its bits from a folder, given the report of the stage."""

    @property
    def folder(self) -> str:
        """Name of the folder of the stage."""
        return f"{self.name}-{self.key}"


def stage_key(name: str, *inputs: Any) -> str:
    """Return the key of a stage.

    Args:
        name: name of the stage.
        inputs: the values of the stages before it, and the options: everything that decides the result.
    """
    return checksum(name, (__version__, name, inputs))


@dataclass(frozen=True, kw_only=True)
class StageRecord:
    """What is known of a finished stage besides its result."""

    seconds: float
    """Time of the stage [s]."""
    report: dict[str, Any]
    """Its entries in ``report.json``."""
    within: str | None = None
    """Time of the whole job, if it cut the stage short; the stage is finished for jobs with the same time only."""


class KeptStages:
    """The finished stages in the folder of a job."""

    def __init__(self, folder: Path) -> None:
        """Look at the stages of the folder of a job."""
        self.folder = folder / STAGES

    def folder_of(self, stage: Stage[Any]) -> Path:
        """Return the folder of a stage."""
        return self.folder / stage.folder

    def record(self, stage: Stage[Any]) -> StageRecord | None:
        """Return the record of a stage; None if the stage is not finished, or its record is damaged."""
        path = self.folder_of(stage) / RECORD
        try:
            return check_table(json.loads(read_bytes(path)), StageRecord) if path.is_file() else None
        except (StitchMeshError, ValueError):
            return None

    def load(self, stage: Stage[T], record: StageRecord) -> T | None:
        """Return the result of a finished stage; None if a file is missing or damaged."""
        try:
            return stage.read(self.folder_of(stage), record.report)
        except FileError:
            return None

    def keep(self, stage: Stage[T], result: T, record: StageRecord) -> None:
        """Write the result of a stage, and then its record.

        Raises:
            FileError: a file cannot be written.
        """
        folder = self.folder_of(stage)
        stage.write(folder, result)
        write_json(folder / RECORD, asdict(record))

    def unfinished(self) -> Iterator[Path]:
        """Yield the folders of stages that are not finished."""
        if self.folder.is_dir():
            yield from (path for path in sorted(self.folder.iterdir()) if not (path / RECORD).is_file())

    def tidy(self, checkpoint: str) -> None:
        """Remove what killed runs have left: hidden parts of files, and unfinished stages without a checkpoint."""
        for path in list(self.unfinished()):
            if not (path / checkpoint).is_file():
                shutil.rmtree(path, ignore_errors=True)
        for part in self.folder.glob("*/.*"):
            part.unlink(missing_ok=True)
