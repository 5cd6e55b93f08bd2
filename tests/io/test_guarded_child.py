# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""A library reads in a child process within limits of memory and time, and its end is an error of a line."""

from __future__ import annotations

import sys
from pathlib import Path

import pytest

from stitchmesh.errors import FileError
from stitchmesh.io import guarded_child
from stitchmesh.io.guarded_child import answer_of_child

LIBRARY = """
import os, sys, time
import numpy as np
from stitchmesh.errors import FileError
from stitchmesh.io import guarded_child
from stitchmesh.io.checkpoint_file import CheckpointFile
guarded_child.MEMORY, guarded_child.SECONDS = (2**27, 0), (1.0, 0.0)

def read(name, file):
    content = file.read_bytes()
    if content == b"memory":
        np.ones(2**25)
    while content == b"no end":
        pass
    while content == b"waits":
        time.sleep(1)
    if content == b"refused":
        raise FileError(f"{name}: is refused")
    if content == b"ends":
        os.abort()
    return CheckpointFile({"place": str(file)}, {"bytes": np.frombuffer(content, np.uint8)})

guarded_child.answer_parent(read)
"""
"""A reader with little memory and time."""


@pytest.fixture
def path(tmp_path, monkeypatch) -> Path:
    (tmp_path / "modules").mkdir()
    (tmp_path / "modules" / "broken_library.py").write_text(LIBRARY)
    monkeypatch.setattr(sys, "path", [*sys.path, str(tmp_path / "modules")])
    return tmp_path / "file"


@pytest.mark.parametrize(
    ("content", "words"),
    [
        (b"memory", "needs very much more memory than its size"),
        (b"no end", "takes too much memory or time"),
        (b"ends", "ended with status -6"),
        (b"refused", "is refused"),
    ],
)
def test_a_library_that_fails_costs_an_error_of_a_line(path, content, words):
    path.write_bytes(content)
    with pytest.raises(FileError, match=words) as caught:
        answer_of_child("broken_library", path)
    assert str(caught.value).startswith(f"{path}: ") and "\n" not in str(caught.value)


def test_a_library_that_waits_is_ended(path, monkeypatch):
    path.write_bytes(b"waits")
    monkeypatch.setattr(guarded_child, "WAITING", 0.1)
    with pytest.raises(FileError, match="its library waits"):
        answer_of_child("broken_library", path)


def test_the_library_gets_a_copy_or_the_file_in_its_place(path):
    path.write_bytes(b"whole")
    copied, in_place = answer_of_child("broken_library", path), answer_of_child("broken_library", path, in_place=True)
    assert in_place.header["place"] == str(path) != copied.header["place"]
    for answer in (copied, in_place):
        assert answer.arrays["bytes"].tobytes() == b"whole"
    assert not Path(copied.header["place"]).exists()
