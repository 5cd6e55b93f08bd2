# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Frames of a run: the states at given times, in memory or as files ``frames/0000.smc``, which a resumed run keeps."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import TypedDict

import numpy as np

from stitchmesh.errors import FileError
from stitchmesh.io.checkpoint_file import CheckpointFile, checked_header, read_checkpoint, write_checkpoint
from stitchmesh.io.outputs import claim_folder
from stitchmesh.io.path_kind import is_file
from stitchmesh.mesh import FloatArray, IntArray

FOLDER, SUFFIX = "frames", ".smc"
"""Folder of the files in the output folder, and their suffix."""
STATE, PLACE = ("vertices", "nodes", "sliding"), ("triangle_kind", "vertex_alpha")
"""Names of the arrays of a frame: the moving positions, and the region."""


@dataclass(frozen=True, eq=False)
class DrapeFrame:
    """The state of the mixed system at a time."""

    time: float
    """Time [s]."""
    vertices: FloatArray
    """Positions of the vertices [cm], shape (V, 3)."""
    nodes: FloatArray
    """Positions of the simulated nodes [cm], shape (n, 3)."""
    sliding: FloatArray
    """Eulerian coordinates of the simulated nodes [cm], shape (n, 2)."""
    triangle_kind: IntArray
    """Kind of each triangle in the region of this time (``enrichment.region``), shape (T,)."""
    vertex_alpha: FloatArray
    """The blending field at the vertices, shape (V,)."""

    def between(self, later: DrapeFrame, time: float) -> DrapeFrame:
        """Return the state on the straight line to a later state of the same region, at a time between both."""
        if time == later.time:
            return later
        part = (time - self.time) / (later.time - self.time)
        mixed = [(1.0 - part) * getattr(self, name) + part * getattr(later, name) for name in STATE]
        vertices, nodes, sliding = mixed
        return DrapeFrame(time, vertices, nodes, sliding, later.triangle_kind, later.vertex_alpha)


class _Header(TypedDict):
    """The header of the file of a frame."""

    time: float


def read_frame(path: Path) -> DrapeFrame:
    """Read the file of a frame.

    Raises:
        FileError: the file is missing, damaged, or not the file of a frame.
    """
    content = read_checkpoint(path)
    time = checked_header(path, content, _Header)["time"]
    missing = [name for name in (*STATE, *PLACE) if name not in content.arrays]
    if missing:
        raise FileError(f"{path}: is no frame of a run: it holds no {missing[0]}; run stitchmesh drape again")
    return DrapeFrame(time, **{name: content.arrays[name] for name in (*STATE, *PLACE)})


class Frames:
    """The frames of one run, in the order of their times."""

    def __init__(self, folder: Path | None = None) -> None:
        """Keep frames in memory, or as files in a folder of the output folder."""
        self._folder = None if folder is None else folder / FOLDER
        self._kept: list[DrapeFrame] = []
        self.count = 0
        """Number of frames."""

    @classmethod
    def of_folder(cls, folder: Path) -> Frames:
        """Return the frames that an output folder holds now; a run may add more."""
        found = cls(folder)
        while is_file(found._path(found.count)):
            found.count += 1
        return found

    def __iter__(self) -> Iterator[DrapeFrame]:
        """Yield the frames one after the other."""
        for number in range(self.count):
            yield self[number]

    def __len__(self) -> int:
        """Return the number of frames."""
        return self.count

    def __getitem__(self, number: int) -> DrapeFrame:
        """Return a frame; negative numbers count from the last one."""
        number = number + self.count if number < 0 else number
        if self._folder is None:
            return self._kept[number]
        return read_frame(self._path(number))

    def add(self, frame: DrapeFrame) -> None:
        """Add a frame.

        Raises:
            FileError: the file cannot be written.
        """
        if self._folder is None:
            self._kept.append(frame)
        else:
            arrays = {name: np.asarray(getattr(frame, name)) for name in (*STATE, *PLACE)}
            write_checkpoint(self._path(self.count), CheckpointFile({"time": frame.time}, arrays))
        self.count += 1

    def begin(self, count: int = 0) -> None:
        """Keep the first frames, and remove files of later frames that an earlier run has left.

        Raises:
            FileError: the folder of the frames is a link, or holds files that StitchMesh did not write.
        """
        self.count = count
        if self._folder is None:
            return
        claim_folder(self._folder)
        for path in sorted(self._folder.glob(f"[0-9]*{SUFFIX}")):
            name = path.name.split(".")[0]
            if name.isdigit() and int(name) >= count:
                path.unlink()

    def _path(self, number: int) -> Path:
        assert self._folder is not None
        return self._folder / f"{number:04d}{SUFFIX}"
