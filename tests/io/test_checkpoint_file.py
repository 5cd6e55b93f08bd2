# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Checkpoint files: reading returns the same bits, damage is an error, and a killed writer leaves an undamaged file."""

from __future__ import annotations

import functools
import hashlib
import json
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np
import pytest

from stitchmesh.errors import FileError
from stitchmesh.io.checkpoint_file import (
    CHECKSUM_BYTES,
    LENGTHS,
    MAGIC,
    VERSION,
    CheckpointFile,
    is_undamaged,
    previous_path,
    read_checkpoint,
    write_checkpoint,
)
from tests.gallery import ROOT
from tests.io.refusals import refused
from tests.killing import killed


def content(number: int) -> CheckpointFile:
    rng = np.random.default_rng(number)
    arrays = {
        "single": rng.normal(size=(3, 5, 3)).astype(np.float32),
        "double": rng.normal(size=7),
        "whole": rng.integers(-9, 9, (4, 2)).astype(np.int32),
        "nothing": np.zeros((0, 3)),
        "turned": np.asfortranarray(rng.normal(size=(3, 2))),
    }
    return CheckpointFile({"number": number, "third": 1.0 / 3.0, "words": ["a", "ä"]}, arrays)


def written(folder: Path, count: int) -> Path:
    path = folder / "checkpoint.smc"
    for number in range(count):
        write_checkpoint(path, content(number))
    return path


def test_reading_returns_the_same_bits(tmp_path):
    stored, read = content(4), CheckpointFile({}, {})
    stored.arrays["double"][:2] = [np.nan, -0.0]
    write_checkpoint(tmp_path / "a.smc", stored)
    read = read_checkpoint(tmp_path / "a.smc")
    assert read.header == stored.header
    assert list(read.arrays) == list(stored.arrays)
    for name, values in stored.arrays.items():
        assert read.arrays[name].dtype == values.dtype
        assert read.arrays[name].shape == values.shape
        assert read.arrays[name].tobytes() == values.tobytes()


def test_the_previous_checkpoint_is_kept_and_no_other_file(tmp_path):
    path = written(tmp_path, 3)
    assert read_checkpoint(path).header["number"] == 2
    assert read_checkpoint(previous_path(path)).header["number"] == 1
    assert sorted(tmp_path.iterdir()) == [previous_path(path), path]


def test_each_changed_byte_is_detected(tmp_path):
    path = written(tmp_path, 1)
    sound = path.read_bytes()
    for place in [*range(64), *range(64, len(sound), 7)]:
        damaged = bytearray(sound)
        damaged[place] ^= 1 << place % 8
        path.write_bytes(damaged)
        assert not is_undamaged(path), place


@pytest.mark.parametrize("left", [0, len(MAGIC), len(MAGIC) + CHECKSUM_BYTES, -1])
def test_a_file_that_was_cut_short_gives_a_message_of_one_line(tmp_path, left):
    path = written(tmp_path, 1)
    path.write_bytes(path.read_bytes()[:left])
    with pytest.raises(FileError, match=r"checkpoint\.smc: ") as caught:
        read_checkpoint(path)
    assert "\n" not in str(caught.value)
    assert "previous" not in str(caught.value)


def test_the_error_names_the_previous_checkpoint_if_it_is_undamaged(tmp_path):
    path = written(tmp_path, 2)
    path.write_bytes(path.read_bytes()[:-1])
    with pytest.raises(FileError, match=r"checksum is wrong; the previous checkpoint is undamaged, .*previous\.smc$"):
        read_checkpoint(path)
    path.unlink()
    with pytest.raises(FileError, match=r"there is no such file; .* use .*previous\.smc$"):
        read_checkpoint(path)
    previous_path(path).write_bytes(b"damaged")
    with pytest.raises(FileError, match=r"there is no such file; check the path$"):
        read_checkpoint(path)


def test_another_version_and_another_format_are_errors(tmp_path, monkeypatch):
    monkeypatch.setattr("stitchmesh.io.checkpoint_file.VERSION", 2)
    path = written(tmp_path, 1)
    monkeypatch.undo()
    with pytest.raises(FileError, match="a checkpoint of version 2; expected version 1"):
        read_checkpoint(path)
    path.write_bytes(b"BCC" + bytes(200))
    with pytest.raises(FileError, match="is not a checkpoint"):
        read_checkpoint(path)


def test_a_damaged_file_does_not_replace_an_undamaged_previous_one(tmp_path):
    path = written(tmp_path, 2)
    path.write_bytes(b"damaged")
    write_checkpoint(path, content(7))
    assert read_checkpoint(path).header["number"] == 7
    assert read_checkpoint(previous_path(path)).header["number"] == 0


def test_without_hard_links_a_checkpoint_is_renamed(tmp_path, monkeypatch):
    def refuse(*names: object) -> None:
        raise OSError("not on this file system")

    monkeypatch.setattr("os.link", refuse)
    path = written(tmp_path, 3)
    assert read_checkpoint(previous_path(path)).header["number"] == 1
    assert sorted(tmp_path.iterdir()) == [previous_path(path), path]


def kill_at_every_call() -> list[list[int]]:
    """Kill a third write before each of its file operations; return the numbers in both files then, newest first."""
    with tempfile.TemporaryDirectory() as scratch:
        start = written(Path(scratch) / "start", 2)
        found: list[list[int]] = []
        while True:
            path = Path(shutil.copytree(start.parent, Path(scratch) / str(len(found)))) / start.name
            third = functools.partial(write_checkpoint, path, content(2))
            if not killed("write_checkpoint", len(found), third, of_files=True):
                return found
            found.append([read_checkpoint(file).header["number"] for file in (path, previous_path(path))])
            write_checkpoint(path, content(2))
            assert sorted(path.parent.iterdir()) == [previous_path(path), path], "what the killed write has left"


def test_a_kill_at_any_call_of_a_write_leaves_two_undamaged_files():
    code = "import json; from tests.io.test_checkpoint_file import kill_at_every_call as k; print(json.dumps(k()))"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True, cwd=ROOT)
    found = json.loads(done.stdout)
    # The states in order: as before the write, the old file under both names, and complete. No other state occurs.
    assert found == sorted(found)
    assert {tuple(pair) for pair in found} == {(1, 0), (1, 1), (2, 1)}



def forged(path: Path, header: bytes, numbers: bytes = b"") -> None:
    """Write a file whose checksum is right."""
    body = MAGIC + LENGTHS.pack(VERSION, len(header)) + header + numbers
    path.write_bytes(body + hashlib.sha256(body).digest())


@pytest.mark.parametrize(
    ("header", "message"),
    [
        (b"no JSON", "is no JSON"),
        (b"\xff", "the header of the checkpoint is damaged"),
        (b"[" * 5000, "nested too deeply"),
        (b"{}", "needs"),
        (b'{"content": 3, "arrays": []}', "content is 3"),
        (b'{"content": {}, "arrays": [["a", "O", [1]]]}', "array 'a' is of type 'O'"),
        (b'{"content": {}, "arrays": [["a", "(9999999,)<f8", [1]]]}', "is of type"),
        (b'{"content": {}, "arrays": [["a", "<f8", [-1]]]}', "shape [-1]"),
        (b'{"content": {}, "arrays": [["a", "<f8", [4611686018427387904, 4]]]}', "is longer than the file"),
        (b'{"content": {}, "arrays": [["a", "|u1", [3]]]}', "5 bytes are left after the last array"),
    ],
)
def test_each_forged_header_gets_its_message(tmp_path, header, message):
    forged(tmp_path / "c.smc", header, bytes(8))
    with refused(tmp_path / "c.smc", message):
        read_checkpoint(tmp_path / "c.smc")
