# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Atomic writes: the target is always the complete old file or the complete new file; no temporary file remains."""

from __future__ import annotations

import json
import stat
from pathlib import Path

import numpy as np
import pytest

from stitchmesh.errors import FileError
from stitchmesh.io import write_mesh, write_stitches, write_yarns
from stitchmesh.io.atomic import atomic_path, write_json, write_text
from stitchmesh.mesh import Mesh, StitchMesh
from stitchmesh.yarn import YarnSet

SQUARE = Mesh.from_polygons([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], [[0, 1, 2, 3]])
STITCHES = StitchMesh(
    SQUARE.vertices, SQUARE.face_start, SQUARE.face_vertex, SQUARE.twin, n_bottom=[1], n_top=[1], stitch=[1], row=[0]
)
YARNS = YarnSet.from_curves([np.eye(3), np.eye(3) + 0.1], closed=[True, True], radius=0.05)


def names(folder: Path) -> list[str]:
    return sorted(path.name for path in folder.iterdir())


@pytest.mark.parametrize("failure", [RuntimeError, KeyboardInterrupt, SystemExit])
def test_a_failing_writer_keeps_the_old_file_and_leaves_no_temporary_file(tmp_path, failure):
    write_text(tmp_path / "a.txt", "old")

    def write_half() -> None:
        with atomic_path(tmp_path / "a.txt") as temporary:
            temporary.write_text("half of the n")
            raise failure

    with pytest.raises(failure):
        write_half()
    assert (tmp_path / "a.txt").read_text() == "old"
    assert names(tmp_path) == ["a.txt"]


def test_the_target_appears_only_when_the_block_ends(tmp_path):
    with atomic_path(tmp_path / "a.txt") as temporary:
        temporary.write_text("new")
        assert temporary.name == "a.txt"  # Some writers choose the format by the suffix, others store the name.
        assert not (tmp_path / "a.txt").exists()
    assert (tmp_path / "a.txt").read_text() == "new"
    assert names(tmp_path) == ["a.txt"]


def test_missing_folders_are_made(tmp_path):
    write_json(tmp_path / "out" / "deep" / "report.json", {"b": 1, "a": [0.1, None]})
    text = (tmp_path / "out" / "deep" / "report.json").read_text()
    assert json.loads(text) == {"b": 1, "a": [0.1, None]}
    assert text.index('"b"') < text.index('"a"')


def test_other_users_may_read_a_written_file(tmp_path):
    (tmp_path / "plain").write_text("")
    write_text(tmp_path / "atomic", "")
    modes = [stat.S_IMODE((tmp_path / name).stat().st_mode) for name in ("plain", "atomic")]
    assert modes[0] == modes[1]


def test_a_folder_that_cannot_be_made_gives_a_message_of_one_line(tmp_path):
    (tmp_path / "file").write_text("")
    with pytest.raises(FileError, match="the name of its folder is the name of a file"):
        write_text(tmp_path / "file" / "a.txt", "")
    with pytest.raises(FileError, match="its folder cannot be written"):
        write_text("/proc/nowhere/a.txt", "")


def test_a_folder_is_not_overwritten(tmp_path):
    (tmp_path / "a.txt").mkdir()
    with pytest.raises(FileError, match="is a folder; expected the name of a file"):
        write_text(tmp_path / "a.txt", "")


WRITERS = [
    ("m.obj", lambda path: write_mesh(path, SQUARE)),
    ("s.h5", lambda path: write_stitches(path, STITCHES)),
    ("y.h5", lambda path: write_yarns(path, YARNS)),
    ("y.bcc", lambda path: write_yarns(path, YARNS)),
    ("y.obj", lambda path: write_yarns(path, YARNS)),
]


@pytest.mark.parametrize(("name", "write"), WRITERS)
def test_a_full_disk_keeps_the_old_file_of_every_format(tmp_path, monkeypatch, name, write):
    write(tmp_path / name)
    before = (tmp_path / name).read_bytes()

    def no_space(handle: int) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr("os.fsync", no_space)
    with pytest.raises(FileError, match=r"cannot be written \(No space left on device\)"):
        write(tmp_path / name)
    assert (tmp_path / name).read_bytes() == before
    assert names(tmp_path) == [name]


@pytest.mark.parametrize(("name", "write"), WRITERS)
def test_two_writes_of_every_format_give_the_same_bytes(tmp_path, name, write):
    write(tmp_path / name)
    first = (tmp_path / name).read_bytes()
    write(tmp_path / name)
    assert (tmp_path / name).read_bytes() == first
