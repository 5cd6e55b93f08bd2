# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The page Project imports, says what a project holds, sends files, and changes to other projects."""

from __future__ import annotations

import json
import re
import threading
from dataclasses import replace

import numpy as np
import pytest

from stitchmesh.app.application import App
from stitchmesh.app.pages.all_pages import PAGES
from stitchmesh.app.pages.downloads import PATTERN_FILE, Export, exports
from stitchmesh.app.pages.page import Page
from stitchmesh.app.pages.project_page import next_page
from stitchmesh.app.project.opening import new_project_folder, recent_projects
from stitchmesh.app.project.project import Project
from stitchmesh.errors import FileError, ParameterError
from stitchmesh.io.any_file import read_any
from stitchmesh.io.meshes import write_mesh
from stitchmesh.mesh import extent
from stitchmesh.mesh.upright import Y, Z, upright_turn
from tests.app.null_front import NullFront
from tests.app.project.projects import COARSE, LABEL_ALL, divided_project, mesh_bytes, relaxed_project, same
from tests.app.project.test_source import with_a_button
from tests.gallery import torus, tube
from tests.io.test_garments import scene
from tests.mesh.test_layers import with_thickness


class Other(Page):
    """A page in the place of another one, with nothing on it."""


@pytest.fixture(autouse=True)
def own_surroundings(tmp_path, monkeypatch):
    for name in ("Label", "Divide", "Edit", "Even out", "Yarns", "Swatch", "View"):
        monkeypatch.setitem(PAGES, name, type(name, (Other,), {"name": name, "hint": "Nothing."}))
    monkeypatch.setenv("STITCHMESH_PROJECTS", str(tmp_path / "projects"))
    monkeypatch.setenv("XDG_STATE_HOME", str(tmp_path / "state"))


@pytest.fixture
def opened(tmp_path):
    """A function that opens the page on a project, and returns the application."""
    apps = []

    def open_app(project: Project) -> App:
        app = App(project, NullFront())
        apps.append(app)
        app.open_page("Project")
        return app

    yield open_app
    for app in apps:
        app.close()


def end_downloads(app: App) -> None:
    """Wait until the threads that write files have ended, and what they sent has arrived."""
    for thread in threading.enumerate():
        if thread.name.startswith("download of"):
            thread.join()
    app.queue.settle()


def test_a_mesh_is_imported_into_an_empty_project_and_else_starts_a_new_one(opened, tmp_path):
    app = opened(Project.create(tmp_path / "one"))
    app.controls.send("Import a mesh", "A Tube.obj", mesh_bytes(tmp_path))
    assert app.project.mesh.face_count == 48 and app.project.name == "A Tube"
    assert app.project.folder == tmp_path / "one"
    app.project.apply_label_step(LABEL_ALL)
    app.project.divide(COARSE)
    app.open_page("Project")
    app.controls.send("Import a mesh", "other.obj", mesh_bytes(tmp_path, around=8))
    assert app.project.folder == tmp_path / "projects" / "other" and app.project.mesh.face_count == 32
    before = Project.open(tmp_path / "one")
    assert before.fabric is not None
    before.close()


def test_a_broken_file_changes_nothing(opened, tmp_path):
    app = opened(divided_project(tmp_path / "one"))
    with pytest.raises(FileError, match=r"^broken\.obj"):
        app.controls.send("Import a mesh", "broken.obj", b"f 1 2 3\n")
    assert app.project.folder == tmp_path / "one" and not (tmp_path / "projects" / "broken").exists()


def test_the_page_says_what_was_repaired(opened, tmp_path):
    app = opened(Project.create(tmp_path / "one"))
    app.controls.send("Import a mesh", "shirt.obj", with_a_button(tube(8, 4)))
    assert "1 edge with more than two faces was split" in app.front.notices[-1][1]
    app.open_page("Project")
    assert "1 edge with more than two faces was split: edge" in app.controls.text_shown()


def test_an_example_is_taken(opened, tmp_path):
    app = opened(Project.create(tmp_path / "one"))
    app.controls.set("Unit", "mm")
    app.controls.set("Example", "sock")
    app.controls.press("Take the example")
    assert app.project.source.name == "sock.obj" and app.project.source.reading.unit == "cm"


def test_another_unit_takes_effect_on_the_present_mesh(opened, tmp_path):
    app = opened(Project.create(tmp_path / "one"))
    app.controls.send("Import a mesh", "tube.obj", mesh_bytes(tmp_path))
    app.open_page("Project")
    before = app.project.mesh.vertices
    app.controls.set("Unit", "dm")
    assert app.project.folder == tmp_path / "one" and app.project.source.reading.unit == "dm"
    np.testing.assert_allclose(app.project.mesh.vertices, 10.0 * before, rtol=1e-15)  # one rounding of the product


def test_work_in_another_unit_stays_in_its_project(opened, tmp_path):
    app = opened(divided_project(tmp_path / "one"))
    app.controls.set("Unit", "dm")
    assert app.project.folder == tmp_path / "projects" / "tube" and app.project.source.reading.unit == "dm"
    before = Project.open(tmp_path / "one")
    assert before.fabric is not None and before.source.reading.unit == "cm"
    before.close()


def test_a_mesh_of_an_odd_size_is_read_in_another_unit_with_one_click(opened, tmp_path):
    write_mesh(tmp_path / "skirt.obj", tube(12, 4, radius=20.0, height=10.0))
    app = opened(Project.create(tmp_path / "one"))
    app.controls.set("Unit", "m")
    app.controls.send("Import a mesh", "skirt.obj", (tmp_path / "skirt.obj").read_bytes())
    size = extent(app.project.mesh.vertices / 100.0)
    shown = app.controls.text_shown()
    assert app.page.name == "Project"
    assert "too large for a garment" in shown and f"Read it in cm: {size}" in shown and "--unit" not in shown
    app.controls.act("unit", "cm")
    assert extent(app.project.mesh.vertices) == size and "for a garment" not in app.controls.text_shown()


def test_a_mesh_that_lies_in_its_file_stands_and_can_be_turned(opened, tmp_path):
    """A tube of 36 x 20 x 36 cm whose axis is z in the file."""
    upright = tube(12, 4, radius=18.0, height=5.0)
    write_mesh(tmp_path / "skirt.obj", replace(upright, vertices=upright.vertices @ upright_turn(Z)))
    app = opened(Project.create(tmp_path / "one"))
    app.controls.send("Import a mesh", "skirt.obj", (tmp_path / "skirt.obj").read_bytes())
    np.testing.assert_array_equal(app.project.mesh.vertices, upright.vertices)
    app.open_page("Project")
    assert app.controls.find("Up in the file").value == "+z" and "turned upright" in app.controls.text_shown()
    app.controls.set("Unit", "dm")
    assert app.project.up == Z  # what was found or chosen stays
    app.controls.set("Unit", "cm")
    app.controls.set("Up in the file", "+y")
    assert extent(app.project.mesh.vertices) == "36.0 x 36.0 x 20.0 cm"
    app.project.close()
    again = Project.open(tmp_path / "one")
    assert again.up == Y and extent(again.mesh.vertices) == "36.0 x 36.0 x 20.0 cm"
    again.close()


def test_an_object_and_a_layer_of_a_file_are_chosen_by_name(opened, tmp_path):
    """A closed body, and a tube of 36 cm with a thickness of 0.5 cm."""
    skirt = with_thickness(tube(32, 4, radius=18.0, height=5.0), 0.5)
    path = scene(tmp_path / "scene.obj", ("body", torus(12, 8)), ("<skirt>", skirt))
    app = opened(Project.create(tmp_path / "one"))
    app.controls.send("Import a mesh", "scene.obj", path.read_bytes())
    app.open_page("Project")
    shown = app.controls.text_shown()
    assert "The file holds body, &lt;skirt&gt;; body was left out" in shown and "of which the outer one" in shown
    assert "--object" not in shown and "--layer" not in shown
    outer = np.ptp(app.project.mesh.vertices, axis=0)
    app.controls.set("Layer", "inner")
    np.testing.assert_allclose(np.ptp(app.project.mesh.vertices, axis=0), outer - [1.0, 0.0, 1.0], atol=1e-9)
    app.controls.set("Object", "body")
    assert app.project.mesh.face_count == torus(12, 8).face_count
    app.project.close()
    again = Project.open(tmp_path / "one")
    assert again.source.reading.objects == ("body",) and again.mesh.face_count == torus(12, 8).face_count
    again.close()


def test_a_file_that_fixes_its_unit_is_read_in_it(opened, tmp_path):
    write_mesh(tmp_path / "tube.glb", tube(12, 4))
    app = opened(Project.create(tmp_path / "one"))
    app.controls.set("Unit", "mm")
    app.controls.send("Import a mesh", "tube.glb", (tmp_path / "tube.glb").read_bytes())
    app.open_page("Project")
    app.controls.set("Unit", "dm")
    # glTF holds float32
    np.testing.assert_allclose(np.ptp(app.project.mesh.vertices, axis=0), np.ptp(tube(12, 4).vertices, axis=0), 1e-6)


def test_the_next_page_follows_the_stages(tmp_path):
    project = Project.create(tmp_path)
    assert next_page(project) == "Project"
    project.import_mesh("tube.obj", mesh_bytes(tmp_path))
    assert next_page(project) == "Label"
    project.apply_label_step(LABEL_ALL)
    assert next_page(project) == "Divide"
    project.close()
    project = relaxed_project(tmp_path / "relaxed")
    assert next_page(project) == "View"
    project.undo()
    assert next_page(project) == "Edit"
    project.close()


def test_the_page_says_what_the_project_holds(opened, tmp_path):
    app = opened(relaxed_project(tmp_path / "one"))
    shown = app.controls.text_shown()
    for text in ("tube.obj, 48 faces", "<td>4</td>", "<td>96</td>", "<td>1</td>", "at rest", "Every change is saved"):
        assert text in shown
    app.project.autosave.trouble = "not saved: the disk is <full>"
    app.refresh()
    assert "not saved: the disk is &lt;full&gt;" in app.controls.text_shown()


def test_every_export_is_written_and_read_again(tmp_path):
    project = relaxed_project(tmp_path / "one")
    files = exports(project)
    assert len({file.name for file in files}) == len(files)
    for file in files:
        if file.name == PATTERN_FILE:
            continue  # which the page Take home sends in its test
        path = tmp_path / file.name
        path.write_bytes(file.content())
        if file.suffix in (".h5", ".smobj") and file.name.startswith(("stitches", "evened")):
            assert same(read_any(path).face_vertex, project.fabric.face_vertex)
    assert {file.what for file in files} >= {
        "Mesh", "Steps of the labeling", "Labeled mesh", "Stitches", "Knitting instructions", "Edits",
        "Evened stitches", "Yarns", "Relaxed yarns", "Report of the relaxation", "Convergence",
    }  # fmt: skip
    project.close()


def test_a_format_that_cannot_hold_a_value_is_refused_in_words(opened, tmp_path, monkeypatch):
    def refuse(path: object) -> None:
        raise FileError("stitches.k: a knitting machine cannot make bobbles; remove them first")

    monkeypatch.setattr("stitchmesh.app.pages.project_page.exports", lambda project: [Export("A", "a.k", refuse)])
    app = opened(relaxed_project(tmp_path / "one"))
    app.controls.act("download", "a.k")
    end_downloads(app)
    assert app.front.downloads == []
    _, text, kind = app.front.notices[-1]
    assert (text, kind) == ("stitches.k: a knitting machine cannot make bobbles; remove them first", "error")


def test_only_files_of_the_project_can_be_asked_for(opened, tmp_path):
    app = opened(relaxed_project(tmp_path / "one"))
    with pytest.raises(ParameterError, match="does not hold it"):
        app.page._clicked("download", "../../project.json")
    with pytest.raises(ParameterError, match="the list has changed"):
        app.page._clicked("open", "-1")


def test_projects_are_made_opened_and_remembered(opened, tmp_path):
    app = opened(divided_project(tmp_path / "one"))
    app.controls.set("New name", "My hat / 2")
    app.controls.press("New project")
    assert app.project.folder == tmp_path / "projects" / "My-hat-2" and app.project.name == "My hat / 2"
    assert [one.folder.name for one in recent_projects()] == ["My-hat-2", "one"]
    app.controls.act("open", "1")
    assert app.project.folder == tmp_path / "one" and app.project.fabric is not None
    app.controls.set("Name", "Sleeve")
    assert recent_projects()[0].name == "Sleeve"


def test_a_project_is_deleted_after_a_question_and_files_of_others_stay(opened, tmp_path):
    for name in ("one", "two", "three"):
        app = opened(divided_project(tmp_path / name))
        if name != "three":
            app.close()
    (tmp_path / "two" / "notes.txt").write_text("mine")
    for name, left in (("one", []), ("two", ["notes.txt"])):
        place = next(str(number) for number, one in enumerate(recent_projects()) if one.name == name)
        app.controls.act("delete", place)
        assert f"Delete <b>{name}</b> for ever?" in app.controls.text_shown()
        app.controls.act("keep", place)
        assert (tmp_path / name / "project.json").exists()
        app.controls.act("delete", place)
        app.controls.act("delete-now", place)
        folder = tmp_path / name
        assert (sorted(path.name for path in folder.iterdir()) if folder.exists() else []) == left
    assert [one.name for one in recent_projects()] == ["three"]
    with pytest.raises(FileError, match="open in another"):
        Project.delete(tmp_path / "three")


def test_a_recent_project_has_its_outline_and_its_date(opened, tmp_path):
    opened(divided_project(tmp_path / "one"))
    (one,) = recent_projects()
    # The tube is 6 cm wide and 4 cm high: in the square of 100 it reaches from 100 to 100 - 400 / 6 downwards.
    heights = {int(number) for number in re.findall(r"[ML]-?\d+ (-?\d+)", one.outline)}
    assert (min(heights), max(heights)) == (33, 100)
    assert abs(one.changed.timestamp() - (tmp_path / "one" / "project.json").stat().st_mtime) < 1e-3  # float of a time
    app = opened(Project.create(tmp_path / "two"))
    shown = app.controls.text_shown()
    assert f'<path d="{one.outline}"' in shown and f"{one.changed:%d %b %Y}" in shown


def test_a_new_project_needs_a_name_and_a_name_that_is_taken_gets_a_number():
    for name in ("", "...", "/", "x" * 70):
        with pytest.raises(ParameterError, match="name"):
            new_project_folder(name)
    Project.create(new_project_folder("Hat")).close()
    assert new_project_folder("Hat").name == "Hat-2"


def test_an_outline_that_is_none_is_not_shown(tmp_path):
    (tmp_path / "state" / "stitchmesh").mkdir(parents=True)
    Project.create(tmp_path / "one").close()
    entry = {"folder": str(tmp_path / "one"), "name": "one", "outline": 'M0 0L9 9"/><script>'}
    (tmp_path / "state" / "stitchmesh" / "projects.json").write_text(json.dumps([entry]))
    assert [one.outline for one in recent_projects()] == [""]


def test_what_a_change_dropped_is_brought_back(opened, tmp_path):
    app = opened(relaxed_project(tmp_path / "one"))
    app.project.divide(app.project.division)
    app.refresh()
    app.controls.press("Bring back: stitches, edits, evened stitches, yarns, relaxed yarns")
    assert app.project.relaxed is not None


def test_a_damaged_list_of_recent_projects_is_made_anew(opened, tmp_path):
    (tmp_path / "state" / "stitchmesh").mkdir(parents=True)
    for damaged in ('[{"folder": 3}]', "[" * 10_000, '[{"folder": "' + "a" * 5000 + '", "name": "a"}]'):
        (tmp_path / "state" / "stitchmesh" / "projects.json").write_text(damaged)
        assert recent_projects() == []
    opened(Project.create(tmp_path / "one"))
    assert [one.folder.name for one in recent_projects()] == ["one"]


def test_a_full_disk_is_said_once_it_happens(opened, tmp_path, monkeypatch):
    app = opened(Project.create(tmp_path / "one"))

    def refuse(*arguments: object) -> None:
        raise FileError("project.json: cannot be written (No space left on device)")

    with monkeypatch.context() as disk:
        disk.setattr("stitchmesh.app.project.project_folder.write_text", refuse)
        with pytest.raises(FileError):
            app.project.save()
        app.queue.settle()
    title, text, kind = app.front.notices[-1]
    assert (title, kind) == ("Not saved", "error") and "No space left on device" in text
    app.project.save()
    app.queue.settle()
    assert app.front.notices[-1][1] == "The project is saved again."
