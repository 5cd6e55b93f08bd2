# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""One program at a time holds the lock of a folder, also where another one gives up its new lock meanwhile."""

from __future__ import annotations

import os

import pytest

from stitchmesh.errors import FileError
from stitchmesh.io import folder_lock
from stitchmesh.io.folder_lock import NAME, FolderLock, is_locked


def test_a_lock_that_is_given_up_leaves_what_was_there(tmp_path):
    FolderLock(tmp_path, "held").give_up()
    assert os.listdir(tmp_path) == []
    FolderLock(tmp_path, "held").release()
    FolderLock(tmp_path, "held").give_up()
    assert os.listdir(tmp_path) == [NAME] and not is_locked(tmp_path)


def test_a_lock_on_a_file_that_was_just_removed_is_taken_again(tmp_path, monkeypatch):
    taken = []

    def try_lock(file):
        if not taken:
            (tmp_path / NAME).unlink()  # Another program gives up between the opening of the file and its lock.
        taken.append(file)
        return lock(file)

    lock = folder_lock.try_lock
    monkeypatch.setattr(folder_lock, "try_lock", try_lock)
    held = FolderLock(tmp_path, "held")
    held.check()
    with pytest.raises(FileError, match="held"):
        FolderLock(tmp_path, "held")
    held.release()
