# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Parts of files go at the next write if their process has ended, and stay if it lives; one program holds a lock."""

from __future__ import annotations

import functools
import json
import os
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

import pytest

from stitchmesh.errors import FileError
from stitchmesh.io import folder_lock
from stitchmesh.io.atomic import atomic_path, write_text
from stitchmesh.io.folder_lock import NAME, FolderLock, is_locked
from stitchmesh.io.part_folder import PARTS, remove_stale_parts
from tests.gallery import ROOT
from tests.killing import killed, leave_part


def names(folder: Path) -> list[str]:
    return sorted(path.name for path in folder.rglob("*"))


def kill_at_every_call() -> list[tuple[str, list[str]]]:
    """Kill a write before each of its file operations; return the text in the file then, and all names after a write.

    The file that is written next is another one, as the next run may write less than the one that was killed.
    """
    found: list[tuple[str, list[str]]] = []
    while True:
        with tempfile.TemporaryDirectory() as scratch:
            folder = Path(scratch)
            write_text(folder / "a.txt", "old")
            write = functools.partial(write_text, folder / "a.txt", "new")
            if not killed("write_text", len(found), write, of_files=True):
                return found
            text = (folder / "a.txt").read_text()
            write_text(folder / "b.txt", "")
            found.append((text, names(folder)))


def test_after_a_kill_at_any_call_the_file_is_old_or_new_and_the_next_write_leaves_no_part():
    code = "import json; from tests.io.test_part_folder import kill_at_every_call as k; print(json.dumps(k()))"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True, cwd=ROOT)
    found = json.loads(done.stdout)
    texts = [text for text, _ in found]
    assert texts == sorted(texts, reverse=True) and set(texts) == {"old", "new"}  # once new, it stays new
    assert all(left == ["a.txt", "b.txt"] for _, left in found)


def test_the_part_of_a_process_that_writes_stays(tmp_path):
    with atomic_path(tmp_path / "a.txt") as temporary:
        temporary.write_text("new")
        write_text(tmp_path / "b.txt", "")
        remove_stale_parts(tmp_path)
    assert (tmp_path / "a.txt").read_text() == "new"
    assert names(tmp_path) == ["a.txt", "b.txt"]


def test_a_run_removes_the_parts_of_ended_ones_also_in_the_folders_of_its_folder(tmp_path):
    leave_part(tmp_path, "yarns.h5")
    leave_part(tmp_path / "textures", "height.png")
    (tmp_path / PARTS / "part-no_lock_").mkdir()
    (tmp_path / ".mine").write_text("")
    remove_stale_parts(tmp_path)
    assert names(tmp_path) == [".mine", "textures"]


@pytest.mark.parametrize("place", ["", "textures"])
def test_nothing_behind_a_link_is_removed_or_made(tmp_path, place):
    victim, out = tmp_path / "victim", tmp_path / "out"
    leave_part(victim, "yarns.h5")
    shutil.move(victim / PARTS, victim / "parts")
    (out / place).mkdir(parents=True)
    (out / place / PARTS).symlink_to(victim / "parts")
    (out / "linked").symlink_to(victim)
    before = names(victim)
    remove_stale_parts(out)
    with pytest.raises(FileError, match=f"{PARTS}: is a symbolic link; .* remove it"):
        write_text(out / place / "a.txt", "")
    assert names(victim) == before


def test_only_folders_of_parts_are_removed(tmp_path):
    leave_part(tmp_path, "yarns.h5")
    parts = tmp_path / PARTS
    for name in ("mine", "part-mine", "part-abcdefgh"):
        (parts / name).mkdir()
        (parts / name / "a.txt").write_text("")
    (parts / "part-linked__").symlink_to(tmp_path / PARTS / "mine")
    remove_stale_parts(tmp_path)
    assert not list(parts.rglob("*.h5"))
    assert len(list(parts.glob("*/a.txt"))) == 4  # in three folders and behind the link


def test_a_folder_of_parts_in_which_others_may_write_is_refused(tmp_path):
    (tmp_path / PARTS).mkdir()
    (tmp_path / PARTS).chmod(0o777)
    (tmp_path / PARTS / "mine").write_text("")
    with pytest.raises(FileError, match="belongs to another user, or others may write in it; remove it"):
        write_text(tmp_path / "a.txt", "")
    assert names(tmp_path) == [PARTS, "mine"]


def test_a_lock_is_neither_made_behind_a_link_nor_waited_for_at_a_pipe(tmp_path):
    (tmp_path / ".lock").symlink_to(tmp_path / "elsewhere")
    with pytest.raises(FileError, match="cannot be written"):
        FolderLock(tmp_path, "busy")
    assert not (tmp_path / "elsewhere").exists()
    (tmp_path / ".lock").unlink()
    os.mkfifo(tmp_path / ".lock")
    with pytest.raises(FileError, match="is no regular file"):
        FolderLock(tmp_path, "busy")
    assert not is_locked(tmp_path)


def test_where_there_are_no_locks_nothing_is_removed(tmp_path, monkeypatch):
    leave_part(tmp_path, "yarns.h5")
    monkeypatch.setattr("stitchmesh.io.folder_lock.fcntl", None)
    write_text(tmp_path / "a.txt", "new")
    assert (tmp_path / "a.txt").read_text() == "new"
    assert [path.name for path in (tmp_path / PARTS).rglob("*.h5")] == ["yarns.h5"]


def test_a_folder_that_another_process_removes_before_it_is_locked_is_made_again(tmp_path, monkeypatch):
    make, made = tempfile.mkdtemp, []

    def taken_away(**options: object) -> str:
        made.append(make(**options))
        if len(made) < 3:
            shutil.rmtree(made[-1])
        return made[-1]

    monkeypatch.setattr("tempfile.mkdtemp", taken_away)
    write_text(tmp_path / "a.txt", "new")
    assert names(tmp_path) == ["a.txt"] and len(made) == 3


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
