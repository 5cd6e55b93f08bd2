# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The output folder of a command: what is left by killed runs, what is refused, and output that nobody can take."""

from __future__ import annotations

import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from stitchmesh.cli.output_folder import output_folder
from stitchmesh.errors import FileError
from tests.gallery import ROOT
from tests.killing import leave_part


def test_parts_of_killed_runs_go_at_the_next_one(tmp_path):
    leave_part(tmp_path, "preview.png")
    leave_part(tmp_path / "textures", "height.png")
    with output_folder(str(tmp_path)):
        assert [path.name for path in tmp_path.rglob("*")] == ["textures"]


def test_a_folder_that_is_removed_while_a_command_runs_is_an_error(tmp_path):
    folder = tmp_path / "out"
    with (
        pytest.raises(FileError, match="out: was removed while the command ran, with files of it"),
        output_folder(str(folder)),
    ):
        shutil.rmtree(folder)
    with pytest.raises(FileError, match="was removed while the command ran"), output_folder(str(folder)):
        folder.rename(tmp_path / "before")
        folder.mkdir()  # A file that is written later makes the folder again.
    assert not folder.exists(), "it was new and is empty"


def test_a_new_folder_goes_again_if_nothing_was_written(tmp_path):
    with output_folder(str(tmp_path / "empty")):
        pass
    with output_folder(str(tmp_path / "full")) as folder:
        (folder / "a.txt").write_text("")
    assert [path.name for path in tmp_path.iterdir()] == ["full"]


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="this system has no /dev/full")
def test_a_full_disk_for_the_printed_text_is_one_line():
    command = [sys.executable, "-m", "stitchmesh", "check", "assets/meshes/hat.obj"]
    with open("/dev/full", "w") as full:
        done = subprocess.run(command, stdout=full, stderr=subprocess.PIPE, text=True, cwd=ROOT, check=False)
    remedy = "free space on this disk, or choose a folder on another one"
    assert done.stderr == f"standard output: cannot be written (No space left on device); {remedy}\n"
    assert done.returncode == 2
