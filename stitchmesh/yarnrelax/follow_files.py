# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The files of a run in which yarns follow a body or a cloth: two for each frame, an animation, and a report.

frames/0000.bcc   the yarns of a frame, for other programs, in the format of a choice
frames/0000.smc   their control points without loss, and the figures of the frame
animation.usdc    yarns and body or cloth with time samples
report.json       the figures of all frames

Frames are written and read one by one, so that the memory does not grow with their number.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from os import PathLike
from pathlib import Path
from typing import Any, TypedDict

import numpy as np

from stitchmesh import __version__
from stitchmesh.io import write_yarns
from stitchmesh.io.atomic import write_json
from stitchmesh.io.checkpoint_file import CheckpointFile, checked_header, read_checkpoint, write_checkpoint
from stitchmesh.io.yarn_formats.animated_usd import UsdFrame, write_animated_usd
from stitchmesh.mesh.vertex_motion import MovingMesh
from stitchmesh.simulation.bodies.mesh_features import feature_topology
from stitchmesh.yarn import YarnSet
from stitchmesh.yarnrelax.frame_run import YarnFrame

ANIMATION, REPORT = "animation.usdc", "report.json"
"""Names in the output folder."""


class _Header(TypedDict):
    """The header of the file of a frame."""

    report: dict[str, Any]


class FollowFiles:
    """Writes the files of a run, one frame after the other."""

    def __init__(
        self, folder: str | PathLike[str], yarns: YarnSet, moving: MovingMesh, *, frame_format: str = "bcc"
    ) -> None:
        """Write into a folder, which is made if it is missing.

        Args:
            folder: the folder.
            yarns: the yarns.
            moving: the body or the cloth.
            frame_format: suffix of the files of yarns, without a dot.
        """
        self.folder, self.yarns, self.moving, self.frame_format = Path(folder), yarns, moving, frame_format

    def add(self, frame: YarnFrame) -> None:
        """Write the yarns of a frame.

        Raises:
            FileError: a file cannot be written.
        """
        write_yarns(self._path(frame.number, self.frame_format), frame.yarns)
        content = CheckpointFile({"report": frame.report}, {"points": np.asarray(frame.yarns.points)})
        write_checkpoint(self._path(frame.number, "smc"), content)

    def finish(self) -> dict[str, Any]:
        """Write the animation and the report of all frames, and return the report.

        Raises:
            FileError: a file cannot be written, or the file of a frame is missing.
        """
        rate = self.moving.motion.frames_per_second
        write_animated_usd(self.folder / ANIMATION, self._animated(), frames_per_second=rate)
        report = {"stitchmesh": __version__, "frames": [frame.report for frame in self.frames()]}
        write_json(self.folder / REPORT, report)
        return report

    def frames(self) -> Iterator[YarnFrame]:
        """Yield all frames as they were written.

        Raises:
            FileError: the file of a frame is missing or damaged.
        """
        for number, time in enumerate(self.moving.motion.times.tolist()):
            path = self._path(number, "smc")
            content = read_checkpoint(path)
            header = checked_header(path, content, _Header)
            yield YarnFrame(number, time, replace(self.yarns, points=content.arrays["points"]), header["report"])

    def _animated(self) -> Iterator[UsdFrame]:
        triangles = feature_topology(self.moving.mesh).corner
        for frame, surface in zip(self.frames(), self.moving.motion.vertices, strict=True):
            yield UsdFrame(frame.time, frame.yarns, surface, triangles, {})

    def _path(self, number: int, suffix: str) -> Path:
        return self.folder / "frames" / f"{number:04d}.{suffix}"
