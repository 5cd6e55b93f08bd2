# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""What is on disk is always a whole project, whatever ends the process, and the disk's refusals are said."""

from __future__ import annotations

import json
import shutil
import threading
from dataclasses import replace

import pytest

from stitchmesh.app.project.autosave import Autosave
from stitchmesh.app.project.project import Project
from stitchmesh.app.project.project_folder import ProjectFolder
from stitchmesh.app.project.state import ProjectState
from stitchmesh.errors import FileError
from stitchmesh.io.part_folder import PARTS
from tests.app.project.projects import HISTORY, PURL, REPORT, YARNS, relaxed_project, same_project
from tests.killing import killed, leave_part


def test_files_that_nothing_names_are_removed_and_kept_values_are_written_once(tmp_path):
    project = relaxed_project(tmp_path)
    project.save()
    before = {path.name: path.stat().st_mtime_ns for path in (tmp_path / "files").iterdir()}
    assert sorted(name.split("-")[0] for name in before) == [
        "evened", "history", "relaxed", "report", "source", "yarns"
    ]  # fmt: skip
    mine = tmp_path / "files" / "notes-3.txt"
    mine.write_text("mine")
    project.set_relaxed(YARNS, {**REPORT, "iterations": 8}, HISTORY)
    project.save()
    mine.unlink()  # It was left alone.
    after = {path.name: path.stat().st_mtime_ns for path in (tmp_path / "files").iterdir()}
    assert {name for name in before if name in after} == {name for name in before if name[:3] not in ("rep", "his")}
    assert all(after[name] == before[name] for name in before if name in after)
    project.close()


@pytest.mark.parametrize("calls", [12, 24])
def test_a_write_that_is_killed_leaves_the_state_before_or_after_it(tmp_path, calls):
    project = relaxed_project(tmp_path)
    project.close()  # The thread of autosave ends, so that the process may be divided.
    store = ProjectFolder(tmp_path)
    state, _ = store.read()
    edited = replace(state, edits=(PURL, PURL), results=replace(state.results, relaxed=YARNS, report={"n": 1}))
    killed("write", calls, lambda: store.write(edited), of_files=True)
    again = Project.open(tmp_path)
    assert again.notes == ()
    assert (again.edits, again.report) in [((PURL,), REPORT), ((PURL, PURL), {"n": 1})]
    again.close()


def test_a_folder_that_was_removed_is_written_again(tmp_path):
    project = relaxed_project(tmp_path / "here")
    project.save()
    shutil.rmtree(tmp_path / "here")
    project.set_relaxed(YARNS, {**REPORT, "iterations": 8}, HISTORY)
    project.close()
    again = Project.open(tmp_path / "here")
    assert again.notes == () and again.report["iterations"] == 8 and again.mesh is not None
    again.close()


def test_parts_of_killed_processes_go_when_a_project_is_opened(tmp_path):
    relaxed_project(tmp_path).close()
    leave_part(tmp_path / "files", "yarns-9.h5")
    Project.open(tmp_path).close()
    assert not list(tmp_path.rglob(PARTS))


def test_a_damaged_result_is_left_out_and_said(tmp_path):
    project = relaxed_project(tmp_path)
    project.close()
    (damaged,) = (tmp_path / "files").glob("relaxed-*.h5")
    damaged.write_bytes(damaged.read_bytes()[:50])
    again = Project.open(tmp_path)
    assert again.relaxed is None and again.yarns is not None
    assert len(again.notes) == 1 and again.notes[0].startswith("relaxed left out: ")
    again.close()


@pytest.mark.parametrize(
    ("keys", "message"),
    [
        ({"format": "letter"}, "is 'letter', version 1"),
        ({"version": 9}, "version 9"),
        ({"name": None}, "needs 'name'"),
        ({"source": {"name": "a.obj", "unit": "cm", "file": "../../secret"}}, "is no file of a project"),
        ({"work": {"files": {"colour": "yarns-1.h5"}}}, "has no key 'colour'"),
    ],
)
def test_a_damaged_table_is_refused_and_the_folder_stays_free(tmp_path, keys, message):
    table = {"format": "stitchmesh project", "version": 1, "name": "a", **keys}
    text = json.dumps({key: value for key, value in table.items() if value is not None})
    for damaged, expected in ((text, message), ("{", "is no JSON")):
        (tmp_path / "project.json").write_text(damaged)
        with pytest.raises(FileError, match=expected):
            Project.open(tmp_path)


def test_a_full_disk_is_said_and_the_next_write_succeeds(tmp_path, monkeypatch):
    project = relaxed_project(tmp_path)
    said: list[str | None] = []
    project.on_trouble = said.append
    full = FileError("project.json: cannot be written (No space left on device)")
    with monkeypatch.context() as disk:
        disk.setattr("stitchmesh.app.project.project_folder.write_text", _raising(full))
        with pytest.raises(FileError, match="No space left"):
            project.save()
        assert project.autosave.trouble == f"not saved: {full}"
    project.save()
    assert said[0] == f"not saved: {full}" and said[-1] is None
    project.close()
    again = Project.open(tmp_path)
    assert same_project(project, again)
    again.close()


def test_a_project_that_cannot_be_written_at_first_is_refused_and_its_folder_stays_free(tmp_path, monkeypatch):
    with monkeypatch.context() as disk:
        refusal = FileError("project.json: cannot be written (No space left on device)")
        disk.setattr("stitchmesh.app.project.project_folder.write_text", _raising(refusal))
        with pytest.raises(FileError, match="No space left"):
            Project.create(tmp_path / "one")
        assert not (tmp_path / "one").exists()
        (tmp_path / "one").mkdir()
        with pytest.raises(FileError, match="No space left"):
            Project.create(tmp_path / "one")
        assert list((tmp_path / "one").iterdir()) == []
    project = Project.create(tmp_path / "one")
    assert (tmp_path / "one" / "project.json").exists()
    project.close()


def test_autosave_goes_on_after_an_error_that_nobody_expected_and_writes_the_newest_state(monkeypatch):
    monkeypatch.setattr("stitchmesh.app.project.autosave.RETRY", 0.1)
    written: list[str] = []
    failed, done = threading.Event(), threading.Event()

    def write(state: ProjectState) -> None:
        if state.name == "bad":
            failed.set()
            raise RuntimeError("no such thing")
        written.append(state.name)
        done.set()

    autosave = Autosave(write, lambda message: None)
    autosave.changed(ProjectState(name="bad"))
    assert failed.wait(30)
    autosave.changed(ProjectState(name="older"))
    autosave.changed(ProjectState(name="good"))
    assert done.wait(30)
    autosave.close()
    assert written[-1] == "good" and autosave.trouble is None


def _raising(error: Exception):
    def refuse(*arguments: object) -> None:
        raise error

    return refuse
