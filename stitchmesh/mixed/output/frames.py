# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Frames of a run: the states at given times, in memory or as files ``frames/0000.smc``, which a resumed run keeps."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from stitchmesh.io.checkpoint_file import CheckpointFile, read_checkpoint, write_checkpoint
from stitchmesh.mesh import FloatArray

FOLDER, SUFFIX = "frames", ".smc"
"""Folder of the files in the output folder, and their suffix."""


@dataclass(frozen=True, eq=False)
class Frame:
    """The state of the mixed system at a time."""

    time: float
    """Time [s]."""
    vertices: FloatArray
    """Positions of the vertices [cm], shape (V, 3)."""
    nodes: FloatArray
    """Positions of the simulated nodes [cm], shape (n, 3)."""
    sliding: FloatArray
    """Eulerian coordinates of the simulated nodes [cm], shape (n, 2)."""

    def between(self, later: Frame, time: float) -> Frame:
        """Return the state at a time between this one and a later one, on the straight line between both."""
        if time == later.time:
            return later
        part = (time - self.time) / (later.time - self.time)
        names = ("vertices", "nodes", "sliding")
        mixed = [(1.0 - part) * getattr(self, name) + part * getattr(later, name) for name in names]
        return Frame(time, *mixed)


class Frames:
    """The frames of one run, in the order of their times."""

    def __init__(self, folder: Path | None = None) -> None:
        """Keep frames in memory, or as files in a folder of the output folder."""
        self._folder = None if folder is None else folder / FOLDER
        self._kept: list[Frame] = []
        self.count = 0
        """Number of frames."""

    def __iter__(self) -> Iterator[Frame]:
        """Yield the frames one after the other."""
        for number in range(self.count):
            yield self[number]

    def __len__(self) -> int:
        """Return the number of frames."""
        return self.count

    def __getitem__(self, number: int) -> Frame:
        """Return a frame; negative numbers count from the last one."""
        number = number + self.count if number < 0 else number
        if self._folder is None:
            return self._kept[number]
        content = read_checkpoint(self._path(number))
        return Frame(
            float(content.header["time"]), *(content.arrays[name] for name in ("vertices", "nodes", "sliding"))
        )

    def add(self, frame: Frame) -> None:
        """Add a frame.

        Raises:
            FileError: the file cannot be written.
        """
        if self._folder is None:
            self._kept.append(frame)
        else:
            arrays = {name: np.asarray(getattr(frame, name)) for name in ("vertices", "nodes", "sliding")}
            write_checkpoint(self._path(self.count), CheckpointFile({"time": frame.time}, arrays))
        self.count += 1

    def begin(self, count: int = 0) -> None:
        """Keep the first frames, and remove files of later ones, which an earlier run has left."""
        self.count = count
        for path in [] if self._folder is None else sorted(self._folder.glob(f"[0-9]*{SUFFIX}")):
            name = path.name.split(".")[0]
            if name.isdigit() and int(name) >= count:
                path.unlink()

    def _path(self, number: int) -> Path:
        assert self._folder is not None
        return self._folder / f"{number:04d}{SUFFIX}"
