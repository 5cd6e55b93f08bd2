# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Files of uploads and downloads: they are gone afterwards, and errors show only their names."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

import stitchmesh
from stitchmesh.errors import FileError, YarnError
from stitchmesh.io.atomic import temporary_file

MAKERS = re.compile(r"tempfile\.(TemporaryDirectory|mkdtemp|NamedTemporaryFile)|import .*TemporaryDirectory")
WITHOUT_NAMES = {
    "io/atomic.py", "io/guarded_child.py", "io/part_folder.py", "render/thumbnails/rest_sheet.py",
    "jobs/sweep/workers.py", "app/entrance.py",
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
