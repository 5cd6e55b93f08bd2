# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""What a command may replace: its own unchanged files, others with --overwrite, and no input."""

from __future__ import annotations

import os
import resource
import stat
from pathlib import Path

import pytest

from stitchmesh.cli.main import main
from stitchmesh.errors import FileError
from stitchmesh.io import own_files
from stitchmesh.io.atomic import write_text
from stitchmesh.io.contents import read_bytes
from stitchmesh.io.outputs import claim_folder, guarded_outputs, plan_outputs
from stitchmesh.io.own_files import HEAD, RECORD, is_marked, is_own, mark_folder


def write_guarded(path: Path, text: str, *, overwrite: bool = False) -> None:
    with guarded_outputs(overwrite=overwrite):
        write_text(path, text)


def test_a_command_replaces_what_a_command_wrote_and_nobody_changed(tmp_path):
    write_guarded(tmp_path / "a.txt", "first")
    assert is_own(tmp_path / "a.txt")
    write_guarded(tmp_path / "a.txt", "second")
    (tmp_path / "a.txt").write_text("mine")
    with pytest.raises(FileError, match=r"was not written by StitchMesh, or was changed since; .* --overwrite"):
        write_guarded(tmp_path / "a.txt", "third")
    assert (tmp_path / "a.txt").read_text() == "mine"
    write_guarded(tmp_path / "a.txt", "third", overwrite=True)
    assert (tmp_path / "a.txt").read_text() == "third"


def test_a_copied_folder_is_still_the_programs_own_and_a_foreign_file_is_not(tmp_path):
    write_guarded(tmp_path / "out" / "a\nb.txt", "first")
    (tmp_path / "out").rename(tmp_path / "moved")
    os.utime(tmp_path / "moved" / "a\nb.txt", (0, 0))
    write_guarded(tmp_path / "moved" / "a\nb.txt", "second")
    (tmp_path / "b.txt").write_text("mine")
    (tmp_path / "c.txt").symlink_to(tmp_path / "moved" / "a\nb.txt")
    for name in ("b.txt", "c.txt"):
        with pytest.raises(FileError, match="was not written by StitchMesh"):
            write_guarded(tmp_path / name, "new")
    assert (tmp_path / "b.txt").read_text() == "mine" and (tmp_path / "c.txt").is_symlink()


@pytest.mark.parametrize("overwrite", [False, True])
def test_an_input_is_never_replaced_under_any_of_its_names(tmp_path, overwrite):
    write_guarded(tmp_path / "a.txt", "mine")
    os.link(tmp_path / "a.txt", tmp_path / "hard.txt")
    (tmp_path / "linked").symlink_to(tmp_path)
    with guarded_outputs(overwrite=overwrite):
        read_bytes(tmp_path / "linked" / "a.txt")
        for name in ("a.txt", "hard.txt", "linked/a.txt"):
            with pytest.raises(FileError, match="this command reads the file and would replace it"):
                write_text(tmp_path / name, "new")
            with pytest.raises(FileError, match="this command reads the file and would replace it"):
                plan_outputs([tmp_path / name])
    assert (tmp_path / "a.txt").read_text() == "mine"


def test_an_input_that_is_a_planned_output_is_refused_when_it_is_read(tmp_path):
    write_guarded(tmp_path / "a.txt", "own")
    with guarded_outputs():
        plan_outputs([tmp_path / "a.txt"], folder=tmp_path)
        with pytest.raises(FileError, match="would replace it"):
            read_bytes(tmp_path / "a.txt")


def test_what_a_run_keeps_in_its_folder_is_read_and_replaced_by_the_next_run(tmp_path):
    write_guarded(tmp_path / "kept" / "state.txt", "one")
    (tmp_path / "mine.txt").write_text("mine")
    with guarded_outputs():
        plan_outputs([], folder=tmp_path)
        for name in ("kept/state.txt", "mine.txt"):
            read_bytes(tmp_path / name)
        write_text(tmp_path / "kept" / "state.txt", "two")
        read_bytes(tmp_path / "kept" / "state.txt")
        write_text(tmp_path / "kept" / "state.txt", "three")
        with pytest.raises(FileError, match="would replace it"):
            write_text(tmp_path / "mine.txt", "new")


def test_functions_called_from_python_replace_what_they_are_told_to_and_leave_no_record(tmp_path):
    for text in ("one", "two"):
        write_text(tmp_path / "a.txt", text)
    assert [path.name for path in tmp_path.iterdir()] == ["a.txt"]


def test_a_private_file_stays_private(tmp_path):
    write_text(tmp_path / "a.txt", "one")
    (tmp_path / "a.txt").chmod(0o600)
    write_text(tmp_path / "a.txt", "two")
    assert stat.S_IMODE((tmp_path / "a.txt").stat().st_mode) == 0o600


def test_a_long_record_is_shortened_and_still_knows_every_file(tmp_path, monkeypatch):
    monkeypatch.setattr(own_files, "LONGEST_RECORD", 500)
    for number in range(20):
        write_guarded(tmp_path / f"{number % 2}.txt", str(number))
    assert (tmp_path / RECORD).stat().st_size < 1000
    assert is_own(tmp_path / "0.txt") and is_own(tmp_path / "1.txt")
    assert sorted(path.name for path in tmp_path.iterdir()) == [RECORD, "0.txt", "1.txt"]


@pytest.mark.parametrize("kind", ["file", "link", "pipe", "folder"])
def test_what_has_the_name_of_the_record_and_is_none_is_left_alone(tmp_path, kind):
    out, elsewhere = tmp_path / "out", tmp_path / "elsewhere"
    out.mkdir()
    elsewhere.write_bytes(HEAD)
    record = out / RECORD
    {"file": lambda: record.write_text("mine"), "link": lambda: record.symlink_to(elsewhere),
     "pipe": lambda: os.mkfifo(record), "folder": record.mkdir}[kind]()  # fmt: skip
    with pytest.raises(FileError, match=rf"{RECORD}: .*(is no record of StitchMesh|cannot be written)"):
        write_guarded(out / "a.txt", "")
    assert not (out / "a.txt").exists() and elsewhere.read_bytes() == HEAD and not is_marked(out)


def test_a_folder_is_claimed_if_it_is_new_empty_or_own(tmp_path):
    claim_folder(tmp_path / "new")
    claim_folder(tmp_path / "new")
    (tmp_path / "mine").mkdir()
    (tmp_path / "mine" / "0001.smc").write_text("mine")
    with pytest.raises(FileError, match=r"0001\.smc: is there already and was not made by StitchMesh"):
        claim_folder(tmp_path / "mine")
    (tmp_path / "linked").symlink_to(tmp_path / "new")
    with pytest.raises(FileError, match="is a symbolic link"):
        claim_folder(tmp_path / "linked")
    mark_folder(tmp_path / "mine")
    claim_folder(tmp_path / "mine")


def test_no_command_takes_an_output_in_the_place_of_its_input(tmp_path, capsys):
    cube = tmp_path / "cube.obj"
    cube.write_text("v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3 4\n")
    before = cube.read_bytes()
    for flags in ([], ["--overwrite"]):
        assert main(["convert", str(cube), str(cube), *flags]) == 2
        assert "this command reads the file and would replace it" in capsys.readouterr().err
    assert cube.read_bytes() == before
    assert main(["convert", str(cube), str(tmp_path / "cube.ply")]) == 0
    (tmp_path / "cube.ply").write_text("mine")
    assert main(["convert", str(cube), str(tmp_path / "cube.ply")]) == 2
    assert main(["convert", str(cube), str(tmp_path / "cube.ply"), "--overwrite"]) == 0


def test_a_full_disk_leaves_no_half_line_in_the_record(tmp_path):
    write_guarded(tmp_path / "a.txt", "one")
    before = (tmp_path / RECORD).read_bytes()
    limits = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (len(before) + 10, limits[1]))
    try:
        with pytest.raises(FileError, match=rf"{RECORD}: the record of this folder cannot be written"):
            write_guarded(tmp_path / "a.txt", "two")
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, limits)
    assert (tmp_path / RECORD).read_bytes() == before and is_own(tmp_path / "a.txt")
