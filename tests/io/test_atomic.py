# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Atomic writes: the target is always the complete old file or the complete new file; no temporary file remains.

Files of uploads and downloads are gone afterwards, and errors show only their names.
"""

from __future__ import annotations

import errno
import os
import re
import resource
import shutil
import stat
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import numpy as np
import pytest

import stitchmesh
from stitchmesh.errors import FileError, YarnError
from stitchmesh.io import write_mesh, write_stitches, write_yarns
from stitchmesh.io.atomic import atomic_path, temporary_file, write_text
from stitchmesh.io.checkpoint_file import CheckpointFile, write_checkpoint
from stitchmesh.mesh import Mesh, StitchMesh
from stitchmesh.patterns.charts.chart_image import write_numbers
from stitchmesh.yarn import YarnSet

SQUARE = Mesh.from_polygons([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], [[0, 1, 2, 3]])
STITCHES = StitchMesh(
    SQUARE.vertices, SQUARE.face_start, SQUARE.face_vertex, SQUARE.twin, n_bottom=[1], n_top=[1], stitch=[1], row=[0]
)
YARNS = YarnSet.from_curves([np.eye(3), np.eye(3) + 0.1], closed=[True, True], radius=0.05)


def names(folder: Path) -> list[str]:
    return sorted(path.name for path in folder.iterdir())


def test_a_failing_writer_keeps_the_old_file_and_leaves_no_temporary_file(tmp_path):
    write_text(tmp_path / "a.txt", "old")

    def write_half() -> None:
        with atomic_path(tmp_path / "a.txt") as temporary:
            temporary.write_text("half of the n")
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
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


def test_names_that_no_file_can_have_and_texts_that_are_none_are_one_line(tmp_path):
    with pytest.raises(FileError, match="cannot be looked at"):
        write_text(tmp_path / "a\0.txt", "")
    with pytest.raises(FileError, match=r"a\.txt: cannot be written: a name in it is not UTF-8"):
        write_text(tmp_path / "a.txt", os.fsdecode(b"mesh = '\xff.obj'"))
    assert names(tmp_path) == []


def test_a_pipe_and_a_device_are_not_replaced(tmp_path):
    os.mkfifo(tmp_path / "pipe.txt")
    (tmp_path / "null.txt").symlink_to("/dev/null")
    for name in ("pipe.txt", "null.txt"):
        with pytest.raises(FileError, match="is a device or a pipe, whose place no file can take"):
            write_text(tmp_path / name, "")
    assert stat.S_ISFIFO((tmp_path / "pipe.txt").stat().st_mode) and (tmp_path / "null.txt").is_symlink()


WRITERS = [
    *((f"m.{suffix}", lambda path: write_mesh(path, SQUARE)) for suffix in ("obj", "ply", "off", "stl", "vtk", "glb")),
    *((f"s.{suffix}", lambda path: write_stitches(path, STITCHES)) for suffix in ("h5", "smobj")),
    *((f"y.{suffix}", lambda path: write_yarns(path, YARNS)) for suffix in ("h5", "bcc", "obj", "vtp", "usda", "usdc")),
    ("c.smc", lambda path: write_checkpoint(path, CheckpointFile({}, {"points": np.zeros(9)}))),
    ("c.png", lambda path: write_numbers(path, np.eye(9, dtype=np.int64), np.eye(3, dtype=np.uint8))),
]


@contextmanager
def largest_file(size: int) -> Iterator[None]:
    """Limit the size of files [bytes]: the operating system refuses more, in the libraries too, as on a full disk."""
    before = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (size, before[1]))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, before)


@pytest.mark.parametrize(("name", "write"), WRITERS)
def test_a_file_that_the_system_cuts_short_keeps_the_old_file_of_every_format(tmp_path, name, write):
    write(tmp_path / name)
    before = (tmp_path / name).read_bytes()
    for size in (len(before) // 3, len(before) - 32):  # Libraries write their parts in another order, or at the end.
        with largest_file(size), pytest.raises(FileError, match=r"cannot be written \(.*\); \w+"):
            write(tmp_path / name)
        assert (tmp_path / name).read_bytes() == before
        assert names(tmp_path) == [name]


@pytest.mark.parametrize(
    ("number", "remedy"),
    [
        (errno.ENOSPC, r"\(No space left on device\); free space on this disk, or choose a folder on another one"),
        (errno.EFBIG, r"\(File too large\); the largest size of a file is limited here"),
        (errno.EROFS, r"\(Read-only file system\); choose a folder that you may write"),
    ],
)
def test_a_disk_that_refuses_a_file_is_one_line_with_the_remedy(tmp_path, monkeypatch, number, remedy):
    def refuse(handle: int) -> None:
        raise OSError(number, os.strerror(number))

    write_text(tmp_path / "a.txt", "old")
    monkeypatch.setattr("os.fsync", refuse)
    with pytest.raises(FileError, match=f"a.txt: cannot be written {remedy}"):
        write_text(tmp_path / "a.txt", "new")
    assert (tmp_path / "a.txt").read_text() == "old"
    assert names(tmp_path) == ["a.txt"]


def test_a_folder_that_vanishes_during_a_write_is_one_line(tmp_path):
    with (
        pytest.raises(FileError, match=r"\(No such file or directory\); its folder was removed meanwhile; begin again"),
        atomic_path(tmp_path / "out" / "a.txt") as temporary,
    ):
        temporary.write_text("new")
        shutil.rmtree(tmp_path / "out")
    assert names(tmp_path) == []


@pytest.mark.parametrize(("name", "write"), WRITERS)
def test_two_writes_of_every_format_give_the_same_bytes(tmp_path, name, write):
    write(tmp_path / name)
    first = (tmp_path / name).read_bytes()
    write(tmp_path / name)
    assert (tmp_path / name).read_bytes() == first


MAKERS = re.compile(r"tempfile\.(TemporaryDirectory|mkdtemp|NamedTemporaryFile)|import .*TemporaryDirectory")
WITHOUT_NAMES = {
    "io/atomic.py", "io/guarded_child.py", "io/part_folder.py", "render/animation_pictures.py",
    "render/swatch_picture.py", "jobs/sweep/workers.py", "app/guard.py",
}  # fmt: skip
"""Modules that make temporary folders; the files in them have no name of the user's, and no error shows them."""


def test_the_file_is_there_in_the_block_only():
    with temporary_file("C:\\shirts\\mine.obj", b"v") as path:
        assert path.name == "mine.obj" and path.read_bytes() == b"v"
    assert not path.parent.exists()


def test_an_error_names_the_file_alone_and_keeps_what_it_holds():
    with pytest.raises(YarnError, match=r"^a\.h5: no yarns, see a\.h5$") as caught, temporary_file("a.h5") as path:
        raise YarnError(f"{path}: no yarns, see {path}", face=7)
    assert caught.value.face == 7


@pytest.mark.parametrize("name", ["", "a" * 300, "a\0b"])
def test_a_name_that_no_file_can_have_is_one_line(name):
    with pytest.raises(FileError, match="cannot be opened"), temporary_file(name, b""):
        pass


def test_every_temporary_file_with_a_name_is_one_of_these():
    root = Path(stitchmesh.__file__).parent
    makers = {path.relative_to(root).as_posix() for path in root.rglob("*.py") if MAKERS.search(path.read_text())}
    assert makers == WITHOUT_NAMES
