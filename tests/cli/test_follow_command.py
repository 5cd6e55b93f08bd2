# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The command ``follow``: its files, and what it refuses without writing anything."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from stitchmesh.cli.main import main
from stitchmesh.io import read_yarns, write_mesh, write_yarns
from stitchmesh.io.mesh_sequences import read_moving_mesh
from tests.cli.calls import refused_without_files
from tests.yarnrelax.energies.test_body import ring, sphere


@pytest.fixture
def scene(tmp_path: Path) -> tuple[Path, Path]:
    """Files of a ring on a ball, and a folder of the ball in motion."""
    write_yarns(tmp_path / "ring.h5", ring(1.085, 0.3, 24, 0.125))
    for number in range(2):
        ball = sphere(1.0)
        moved = replace(ball, vertices=ball.vertices + np.array([0.05 * number, 0.0, 0.0]))
        write_mesh(tmp_path / "walk" / f"{number}.obj", moved)
    return tmp_path / "ring.h5", tmp_path / "walk"


def words_of(scene: tuple[Path, Path], output: Path) -> list[str]:
    own = ["--frames-per-second", "200", "--quality", "draft", "--device", "cpu"]
    return ["follow", str(scene[0]), str(scene[1]), "-o", str(output), *own]


def test_follow_writes_a_bcc_for_each_frame_and_time_samples(scene: tuple[Path, Path], tmp_path: Path, capsys) -> None:
    from pxr import Usd, UsdGeom

    out = tmp_path / "out"
    assert main(words_of(scene, out)) == 0
    assert "Simulated 2 frames" in capsys.readouterr().out
    frames = [read_yarns(out / "frames" / f"{number:04d}.bcc", radius=0.125) for number in range(2)]
    stage = Usd.Stage.Open(str(out / "animation.usdc"))
    curves = UsdGeom.BasisCurves(stage.GetPrimAtPath("/yarns/closed")).GetPointsAttr()
    assert curves.GetTimeSamples() == [0.0, 1.0]
    for number, frame in enumerate(frames):
        # the middle of a closed curve is that of its control points, in BCC and in USD, in single precision
        np.testing.assert_allclose(np.mean(curves.Get(number), axis=0), frame.points.mean(axis=0), atol=1e-6)
    surface = read_moving_mesh(out / "animation.usdc")
    assert surface.motion.vertices[1, :, 0].mean() - surface.motion.vertices[0, :, 0].mean() == pytest.approx(0.05)


def test_follow_writes_frames_of_another_format_and_a_sheet(scene: tuple[Path, Path], tmp_path: Path) -> None:
    from PIL import Image

    out = tmp_path / "out"
    assert main([*words_of(scene, out), "--frame-format", "vtp", "--sheet", "--picture-size", "96", "60"]) == 0
    assert sorted(path.name for path in (out / "frames").glob("[!.]*.[!s]*")) == ["0000.vtp", "0001.vtp"]
    assert read_yarns(out / "frames" / "0001.vtp").closed.all()
    assert Image.open(out / "sheet.png").size == (2 * 96 // 3, 60 // 3)


def test_follow_refuses_what_it_cannot_do_and_writes_nothing(scene: tuple[Path, Path], tmp_path: Path, capsys) -> None:
    words = words_of(scene, tmp_path / "out")
    message = refused_without_files(capsys, tmp_path, *words, "--carry", "hem 2")
    assert "got --carry without --fabric" in message
    assert "frame format: got 'png'" in refused_without_files(capsys, tmp_path, *words, "--frame-format", "png")
    (scene[1] / "1.obj").rename(scene[1] / "2.obj")
    assert "frame 1 is missing" in refused_without_files(capsys, tmp_path, *words)
