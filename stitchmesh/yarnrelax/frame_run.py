# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Frames that follow one after the other, each from the one before: progress, checkpoints and resuming."""

from __future__ import annotations

import logging
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from os import fspath
from typing import Any, TypedDict, TypeVar

from numpy.typing import NDArray

from stitchmesh.io.checkpoint_file import (
    CheckpointFile,
    checked_header,
    read_checkpoint,
    was_written,
    write_checkpoint,
)
from stitchmesh.progress import shown_stages
from stitchmesh.run import Run
from stitchmesh.yarn import YarnSet
from stitchmesh.yarnrelax.fingerprint import refuse_other_inputs

logger = logging.getLogger(__name__)


class FrameHeader(TypedDict):
    """The header of a checkpoint between two frames; the simulation may add numbers."""

    inputs: dict[str, str]
    frame: int


Header = TypeVar("Header", bound=FrameHeader)


@dataclass(frozen=True, eq=False)
class YarnFrame:
    """The yarns at one frame of a motion."""

    number: int
    """Number of the frame, from 0."""
    time: float
    """Time [s]."""
    yarns: YarnSet
    """The yarns."""
    report: dict[str, Any]
    """Figures of the frame as plain numbers and texts."""


@dataclass(frozen=True, eq=False)
class FrameRun:
    """How the frames of a simulation are made."""

    stage: str
    """Name of the work, for the progress."""
    last: int
    """Number of the last frame."""
    first_frame: Callable[[], YarnFrame] | None
    """Makes the first frame; None in a run that continues after its checkpoint."""
    next_frame: Callable[[], YarnFrame]
    """Makes the frame after the last one that was made."""
    checkpoint: Callable[[], CheckpointFile]
    """Returns everything that decides how the run continues."""
    run: Run[YarnSet]

    def frames(self, made: int) -> Iterator[YarnFrame]:
        """Yield the frames after ``made``; write a checkpoint after the caller has dealt with a frame."""
        kept = self.run.checkpoints
        with shown_stages(self.run.progress) as report:
            if self.first_frame is not None:
                yield self.first_frame()
            for number in range(made + 1, self.last + 1):
                frame = self.next_frame()
                report(self.stage, number / self.last, f"frame {number} of {self.last}")
                yield frame
                if kept is not None and number % kept.every == 0:
                    write_checkpoint(kept.path, self.checkpoint())


def checkpoint_of(
    run: Run[YarnSet], written: dict[str, str], kind: type[Header]
) -> tuple[Header, Mapping[str, NDArray[Any]]] | None:
    """Return the header and the arrays of the checkpoint that a run resumes; None if the run begins anew.

    Args:
        run: the run.
        written: the inputs of the run.
        kind: the fields of the header.

    Raises:
        ParameterError: the checkpoint belongs to a run with other inputs.
        FileError: the checkpoint cannot be read.
    """
    if run.resume is None:
        return None
    if not was_written(run.resume):
        logger.info("%s: is not there yet; the run begins at the first frame", run.resume)
        return None
    content = read_checkpoint(run.resume)
    header = checked_header(run.resume, content, kind)
    refuse_other_inputs(fspath(run.resume), header["inputs"], written)
    return header, content.arrays
