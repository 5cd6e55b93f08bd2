# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The command ``animate``: its files, its summary, and what it refuses without writing anything."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from stitchmesh.cli.main import main
from stitchmesh.io import read_yarns, write_mesh, write_stitches
from stitchmesh.io.mesh_sequences import read_moving_mesh
from stitchmesh.patterns.swatch_mesh import plain_piece
from tests.cli.calls import refused_without_files
from tests.yarnrelax.test_animate_yarns import COLUMNS, ROWS, bent, sheet


@pytest.fixture
def scene(tmp_path: Path) -> tuple[Path, Path]:
    """Files of a swatch, and a folder of its plane that bends."""
    write_stitches(tmp_path / "swatch.h5", plain_piece(COLUMNS, ROWS, 1.0, 1.0))
    for number, angle in enumerate((0.0, 0.1)):
        mesh = sheet()
        write_mesh(tmp_path / "bend" / f"{number}.obj", replace(mesh, vertices=bent(angle)(mesh.vertices)))
    return tmp_path / "swatch.h5", tmp_path / "bend"


def words_of(scene: tuple[Path, Path], output: Path) -> list[str]:
    own = ["--iterations", "5", "--first-iterations", "20", "--quality", "draft", "--device", "cpu"]
    return ["animate", str(scene[0]), str(scene[1]), "-o", str(output), *own]


def test_animate_writes_the_frames_a_report_and_an_animation(scene: tuple[Path, Path], tmp_path: Path, capsys) -> None:
    out = tmp_path / "out"
    assert main(words_of(scene, out)) == 0
    said = capsys.readouterr().out
    assert "Made 2 frames" in said and "0 of them were missed" in said
    yarns = [read_yarns(out / "frames" / f"{number:04d}.bcc", radius=0.125) for number in range(2)]
    assert np.abs(yarns[1].points - yarns[0].points).max() > 0.1
    report = json.loads((out / "report.json").read_text())
    assert [frame["missed"] for frame in report["frames"]] == [None, None]
    surface = read_moving_mesh(out / "animation.usdc")
    assert surface.motion.vertices.shape[0] == 2


def test_animate_refuses_a_cloth_in_another_unit_and_writes_nothing(scene, tmp_path: Path, capsys) -> None:
    message = refused_without_files(capsys, tmp_path, *words_of(scene, tmp_path / "out"), "--cloth-unit", "mm")
    assert "from the cloth of frame 0; expected at most 2 cm, 2 stitches; give the unit" in message
    assert "iterations: got 0" in refused_without_files(
        capsys, tmp_path, *words_of(scene, tmp_path / "out")[:-4], "--iterations", "0"
    )
