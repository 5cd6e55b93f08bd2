# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Meshes that move, in folders of mesh files and in USD files with time samples."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from stitchmesh.errors import FileError, ParameterError
from stitchmesh.io import write_mesh
from stitchmesh.io.mesh_sequences import read_moving_mesh, write_moving_mesh
from stitchmesh.mesh import Mesh
from stitchmesh.mesh.vertex_motion import MovingMesh

CORNERS = np.array([[0.0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [2, 0.5, 0]])
FACES = [[0, 1, 2, 3], [1, 4, 2]]
TIMES = [0.0, 0.5, 1.25]


def frames() -> list[Mesh]:
    return [Mesh.from_polygons(CORNERS + np.array([0.0, 0.0, time]), FACES) for time in TIMES]


def folder_of(tmp_path: Path, numbers: list[int], *, other: int | None = None) -> Path:
    for number, mesh in zip(numbers, frames(), strict=True):
        changed = Mesh.from_polygons(CORNERS, [FACES[1], FACES[0]]) if number == other else mesh
        write_mesh(tmp_path / f"walk.{number:04d}.obj", changed, unit="dm")
    return tmp_path


def test_usd_keeps_times_faces_and_positions(tmp_path: Path) -> None:
    moving = MovingMesh.of_frames(frames(), TIMES)
    write_moving_mesh(tmp_path / "walk.usda", moving, frames_per_second=24.0)
    found = read_moving_mesh(tmp_path / "walk.usda")
    np.testing.assert_allclose(found.motion.times, TIMES, rtol=1e-15)  # 24 times and divided by 24 again
    np.testing.assert_array_equal(found.motion.vertices, moving.motion.vertices)  # exact in float32
    np.testing.assert_array_equal(found.mesh.face_vertex, moving.mesh.face_vertex)
    np.testing.assert_array_equal(found.mesh.face_start, moving.mesh.face_start)


def test_a_folder_has_its_frames_in_the_order_of_their_numbers(tmp_path: Path) -> None:
    found = read_moving_mesh(folder_of(tmp_path, [8, 9, 10]), unit="dm", frames_per_second=10.0)
    np.testing.assert_allclose(found.motion.vertices[:, 0, 2], TIMES, rtol=1e-15)  # divided by 10 and times 10
    np.testing.assert_array_equal(found.motion.times, [0.0, 0.1, 0.2])


@pytest.mark.parametrize(
    ("numbers", "other", "message"),
    [
        ([1, 2, 4], None, r"frame 3 is missing: got 3 files from 1 to 4; expected every number"),
        ([1, 2, 3], 2, r"frame 1: face 0: got vertices \[1, 4, 2\]; expected \[0, 1, 2, 3\]"),
    ],
)
def test_a_wrong_frame_is_refused(tmp_path: Path, numbers: list[int], other: int | None, message: str) -> None:
    with pytest.raises(FileError, match=message):
        read_moving_mesh(folder_of(tmp_path, numbers, other=other))


def test_times_that_do_not_increase_are_refused() -> None:
    with pytest.raises(ParameterError, match="keyframe 1: got 0 s after 0 s; expected times that increase"):
        MovingMesh.of_frames(frames()[:2], [0.0, 0.0])


def test_what_is_no_moving_mesh_is_refused(tmp_path: Path) -> None:
    with pytest.raises(FileError, match="has no mesh whose name ends in a number"):
        read_moving_mesh(tmp_path)
    with pytest.raises(FileError, match="is no mesh that moves; expected a folder with a mesh for each frame"):
        read_moving_mesh(tmp_path / "walk.obj")


def test_usd_with_faces_that_change_is_refused(tmp_path: Path) -> None:
    from pxr import Usd, UsdGeom

    path = tmp_path / "walk.usda"
    write_moving_mesh(path, MovingMesh.of_frames(frames(), TIMES), frames_per_second=24.0)
    stage = Usd.Stage.Open(str(path))
    corners = UsdGeom.Mesh(stage.GetPrimAtPath("/body")).GetFaceVertexIndicesAttr()
    corners.Set(corners.Get(), 0.0)
    corners.Set([0, 1, 2, 3, 4, 2, 1], 12.0)
    stage.Export(str(tmp_path / "other.usda"))
    with pytest.raises(FileError, match="frame 1: got faces that differ from those of the first frame"):
        read_moving_mesh(tmp_path / "other.usda")
