# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""A start opens the project of a folder, of a file, or the last one."""

from __future__ import annotations

import os

import pytest

from stitchmesh.app.project.opening import project_for, recent_projects, remember
from stitchmesh.app.project.project import Project
from stitchmesh.errors import FileError
from tests.app.project.projects import divided_project, mesh_bytes


@pytest.fixture(autouse=True)
def own_folders(tmp_path, monkeypatch):
    monkeypatch.setenv("STITCHMESH_PROJECTS", str(tmp_path / "projects"))
    monkeypatch.setenv("XDG_STATE_HOME", str(tmp_path / "state"))


@pytest.fixture
def tube_file(tmp_path):
    path = tmp_path / "a_tube.obj"
    path.write_bytes(mesh_bytes(tmp_path))
    return path


def test_the_first_start_makes_an_empty_project_and_the_next_one_opens_it(tmp_path):
    project = project_for()
    assert project.folder == tmp_path / "projects" / "Garment" and project.source is None
    remember(project)
    project.close()
    again = project_for()
    assert again.folder == project.folder
    again.close()


def test_a_file_starts_a_project_once(tmp_path, tube_file):
    project = project_for(tube_file, unit="mm")
    assert project.name == "a tube" and project.source.reading.unit == "mm"
    project.close()
    again = project_for(tube_file)
    assert again.folder == project.folder and again.source.reading.unit == "mm"
    again.close()
    in_metres = project_for(tube_file, unit="m")
    assert in_metres.folder != project.folder and in_metres.source.reading.unit == "m"
    in_metres.close()
    with pytest.raises(FileError, match="obj in mm; leave --unit out"):
        project_for(tube_file, project.folder, unit="cm")
    tube_file.write_bytes(mesh_bytes(tmp_path, around=8))
    other = project_for(tube_file)
    assert other.folder != project.folder and other.mesh.face_count == 32
    other.close()


def test_a_folder_is_opened_or_made(tmp_path, tube_file):
    divided_project(tmp_path / "one").close()
    project = project_for(tmp_path / "one")
    assert project.fabric is not None
    project.close()
    project = project_for(tube_file, tmp_path / "new")
    assert project.folder == tmp_path / "new" and project.mesh is not None
    project.close()
    again = project_for(tube_file, tmp_path / "new")
    again.close()
    (tmp_path / "other.obj").write_bytes(mesh_bytes(tmp_path, around=8))
    with pytest.raises(FileError, match="give another --project"):
        project_for(tmp_path / "other.obj", tmp_path / "new")
    project_for(folder=tmp_path / "new").close()


@pytest.mark.parametrize(("name", "content"), [("a.obj", b"f 1 2 3\n"), ("a.txt", b"no mesh")])
def test_a_file_that_cannot_be_read_leaves_no_project(tmp_path, name, content):
    (tmp_path / name).write_bytes(content)
    (tmp_path / "mine").mkdir()
    (tmp_path / "mine" / "letter.txt").write_text("mine")
    for folder in (None, tmp_path / "own", tmp_path / "mine"):
        with pytest.raises(FileError, match=name):
            project_for(tmp_path / name, folder)
    assert sorted(os.listdir(tmp_path)) == [name, "mine"] and recent_projects() == []
    assert os.listdir(tmp_path / "mine") == ["letter.txt"]


def test_a_folder_that_cannot_be_made_is_said(tmp_path):
    (tmp_path / "file").write_text("no folder")
    with pytest.raises(FileError, match="cannot be written"):
        project_for(folder=tmp_path / "file" / "project")
    assert os.listdir(tmp_path) == ["file"]


@pytest.mark.parametrize("damage", ["{", None])
def test_a_damaged_project_is_left_as_it_was(tmp_path, tube_file, damage):
    folder = tmp_path / "projects" / "one"
    project_for(tube_file, folder).close()
    (folder / ".lock").unlink()
    if damage is None:
        (folder / "files" / "source-1.obj").write_text("f 1 2 3")
    else:
        (folder / "project.json").write_text(damage)
    before = sorted(os.listdir(folder))
    with pytest.raises(FileError):
        project_for(folder)
    assert sorted(os.listdir(folder)) == before


def test_a_damaged_project_is_not_taken_for_that_of_a_file(tmp_path, tube_file):
    project = Project.create(tmp_path / "projects" / "tube")
    project.close()
    (tmp_path / "projects" / "tube" / "project.json").write_text("{")
    other = project_for(tube_file)
    assert other.folder == tmp_path / "projects" / "a-tube"
    other.close()


def test_the_name_of_an_example_starts_a_project_of_it(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    project = project_for("tea cozy")
    assert project.source is not None and project.source.name == "tea_cozy.obj" and project.mesh.face_count == 160
    project.close()
