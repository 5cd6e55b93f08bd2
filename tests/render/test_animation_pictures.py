# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Pictures of frames: which of them a sheet shows, what the camera does, and a video."""

from __future__ import annotations

import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from stitchmesh.errors import DisplayError, ParameterError
from stitchmesh.mesh import Mesh
from stitchmesh.mesh.vertex_motion import MovingMesh, VertexMotion
from stitchmesh.render.animation_options import AnimationPictures
from stitchmesh.render.animation_pictures import draw_animation
from stitchmesh.yarn import YarnSet
from stitchmesh.yarnrelax.frame_run import YarnFrame
from tests.yarnrelax.energies.test_body import ring

SIZE = 96, 60
FRAMES = 5


def scene() -> tuple[list[YarnFrame], MovingMesh]:
    """A ring that goes along with a square, 10 cm in each frame, and is wider in the last frame."""
    square = np.array([[-2.0, -2.0, 0.0], [2.0, -2.0, 0.0], [2.0, 2.0, 0.0], [-2.0, 2.0, 0.0]])
    places = np.array([square + np.array([10.0 * number, 0.0, 0.0]) for number in range(FRAMES)])
    moving = MovingMesh(Mesh.from_polygons(square, [[0, 1, 2, 3]]), VertexMotion(np.arange(FRAMES) / 10.0, places))
    yarns: YarnSet = ring(1.0, 0.0, 16, 0.2)
    turned = yarns.points[:, [0, 2, 1]]
    frames = []
    for number in range(FRAMES):
        size = 1.5 if number == FRAMES - 1 else 1.0
        moved = replace(yarns, points=size * turned + [10.0 * number, 0.0, 0.0])
        frames.append(YarnFrame(number, number / 10.0, moved, {}))
    return frames, moving


def test_the_camera_goes_along_and_shows_as_much_in_each_frame(tmp_path: Path) -> None:
    frames, moving = scene()
    chosen = AnimationPictures(sheet=True, sheet_frames=3, sheet_columns=2, picture_size=SIZE)
    draw_animation(iter(frames), moving, tmp_path, chosen)
    sheet = np.asarray(Image.open(tmp_path / "sheet.png")).astype(int)
    assert sheet.shape == (2 * SIZE[1] // 3, 2 * SIZE[0] // 3, 3)  # Three frames, two in a row, a third of their size.
    height, width = SIZE[1] // 3, SIZE[0] // 3
    first, middle, last = sheet[:height, :width], sheet[:height, width:], sheet[height:, :width]
    assert np.abs(first - middle).max() < 40  # The antialiasing of edges differs by a rounding of the place.
    assert np.abs(first - last).max() > 40
    assert [path.name for path in tmp_path.iterdir()] == ["sheet.png"]


def test_a_video_has_all_frames_in_its_size(tmp_path: Path) -> None:
    ffmpeg = pytest.importorskip("imageio_ffmpeg")
    frames, moving = scene()
    draw_animation(frames, moving, tmp_path, AnimationPictures(video=True, picture_size=SIZE), body=True)
    count, seconds = ffmpeg.count_frames_and_secs(str(tmp_path / "video.mp4"))
    assert count == FRAMES and seconds == pytest.approx(FRAMES / 10.0, abs=0.01)  # The file rounds to its ticks.
    assert next(ffmpeg.read_frames(str(tmp_path / "video.mp4")))["size"] == SIZE


def test_what_cannot_be_drawn_is_refused_before_the_work(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    module = sys.modules["stitchmesh.render.animation_pictures"]  # Its package has a function of the name ``render``.
    monkeypatch.setattr(module, "find_spec", lambda name: None)
    with pytest.raises(DisplayError, match=r"ffmpeg is not installed; install it by `pip install stitchmesh\[video\]`"):
        draw_animation([], scene()[1], tmp_path, AnimationPictures(video=True))
    with pytest.raises(ParameterError, match="got 95 x 60; a video has even numbers of pixels"):
        AnimationPictures(video=True, picture_size=(95, 60))
    with pytest.raises(ParameterError, match="frame format: got 'png'; expected one of bcc, vtp"):
        AnimationPictures(frame_format="png")
