# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The page Project in a real browser: files in and out, two browsers, and what the user is told."""

from __future__ import annotations

import base64
from contextlib import closing

import pytest

from stitchmesh.app.uploads import LARGEST_UPLOAD
from stitchmesh.io.meshes import write_mesh
from stitchmesh.io.stitches import read_stitches
from tests.app.project.projects import LABEL_ALL, divided_project, mesh_bytes, same
from tests.gallery import tube

DROP = """([name, text]) => {
  const bytes = Uint8Array.from(atob(text), c => c.charCodeAt(0));
  const data = new DataTransfer();
  data.items.add(new File([bytes], name));
  const target = window.__viserMutable.canvas;
  target.dispatchEvent(new DragEvent("dragover", { bubbles: true, cancelable: true, dataTransfer: data }));
  target.dispatchEvent(new DragEvent("drop", { bubbles: true, cancelable: true, dataTransfer: data }));
}"""


@pytest.fixture(autouse=True)
def own_folders(tmp_path, monkeypatch):
    monkeypatch.setenv("STITCHMESH_PROJECTS", str(tmp_path / "projects"))
    monkeypatch.setenv("XDG_STATE_HOME", str(tmp_path / "state"))


def drop(rig, name: str, content: bytes) -> None:
    """Drop a file on the scene."""
    rig.browser_page.evaluate(DROP, [name, base64.b64encode(content).decode()])


def test_a_mesh_is_uploaded_and_the_next_page_opens(app_in_browser, tmp_path):
    write_mesh(tmp_path / "tube.obj", tube(12, 4, radius=18.0, height=5.0))
    with app_in_browser(page="Project") as rig:
        rig.upload(tmp_path / "tube.obj")
        rig.wait_for(lambda: rig.app.project.mesh is not None, "the mesh is imported")
        rig.wait_for_text("Label all")
        rig.wait_for_text("File uploaded successfully.")
        assert rig.app.project.mesh.face_count == 48 and rig.app.page.name == "Label"


@pytest.mark.nightly
def test_a_file_is_dropped_on_the_scene(app_in_browser, tmp_path):
    with app_in_browser(page="Project") as rig:
        drop(rig, "tube.obj", mesh_bytes(tmp_path))
        rig.wait_for(lambda: rig.app.project.mesh is not None, "the mesh is imported")
        assert rig.app.project.source.name == "tube.obj"


@pytest.mark.nightly
def test_a_file_that_no_upload_takes_is_refused_in_words(app_in_browser):
    with app_in_browser(page="Project") as rig:
        drop(rig, "letter.doc", b"Dear")
        rig.wait_for_text("letter.doc: no upload of this page takes such a file")
        assert rig.app.project.source is None


BROKEN_FILES = [
    ("broken.obj", b"v 0 0 0\nf 1 2 3\n", "broken.obj"),
    ("empty.obj", b"", "empty.obj: the file is empty"),
    ("text.h5", b"no HDF5", "text.h5"),
    ("../../escape.obj", b"v a b c\n", "escape.obj"),
]
"""Names and contents of files, and what is said of them."""


def test_broken_files_are_refused_in_words_and_the_server_lives_on(app_in_browser, tmp_path):
    with app_in_browser(page="Project") as rig:
        for name, content, said in BROKEN_FILES:
            drop(rig, name, content)
            rig.wait_for(lambda: any(said in notice and "Not possible" in notice for notice in rig.notices()), said)  # noqa: B023
            assert rig.app.project.mesh is None
        drop(rig, "tube.obj", mesh_bytes(tmp_path))
        rig.wait_for(lambda: rig.app.project.mesh is not None, "a good file is taken afterwards")
        assert rig.app.project.source.name == "tube.obj"


def test_a_file_that_is_too_large_is_not_sent(app_in_browser):
    with app_in_browser(page="Project") as rig:
        rig.browser_page.evaluate("() => { window.stitchmeshDrop.largest = 3; }")
        drop(rig, "tube.obj", b"v 0 0 0\n")
        rig.wait_for_text(f"tube.obj: is larger than {LARGEST_UPLOAD // 2**20} MiB")
        assert rig.app.project.mesh is None
        rig.browser_page.evaluate(f"() => {{ window.stitchmeshDrop.largest = {LARGEST_UPLOAD}; }}")


@pytest.mark.nightly
def test_the_stitches_are_downloaded_as_the_library_writes_them(app_in_browser, tmp_path):
    divided_project(tmp_path / "project").close()
    with app_in_browser(page="Project") as rig:
        rig.open_group("Download")
        rig.settle()
        name, content = rig.downloaded(lambda: rig.act("download", "stitches.h5"))
        (tmp_path / name).write_bytes(content)
        assert name == "stitches.h5" and same(read_stitches(tmp_path / name), rig.app.project.fabric)


@pytest.mark.nightly
def test_a_download_goes_to_the_browser_that_asked_for_it(app_in_browser, tmp_path):
    divided_project(tmp_path / "project").close()
    with app_in_browser(page="Project") as rig, closing(rig.another_window()) as other:
        received = []
        rig.browser_page.on("download", lambda download: received.append("first"))
        other.browser_page.on("download", lambda download: received.append("second"))
        for window in (rig, other):
            window.open_group("Download")
            rig.settle()
            window.downloaded(lambda window=window: window.act("download", "labeled.h5"))
            rig.settle()
            other.browser_page.wait_for_timeout(300)
        assert received == ["first", "second"]


@pytest.mark.nightly
def test_a_second_browser_sees_the_same_state(app_in_browser, tmp_path):
    divided_project(tmp_path / "project").close()
    with app_in_browser(page="Project") as rig, closing(rig.another_window()) as other:
        other.wait_for_text("tube.obj, 48 faces")
        rig.page_button("Garment")
        other.wait_for_text("Label all")
        other.press("Undo")
        rig.wait_for(lambda: rig.app.project.labeled is None, "the step is undone by the other browser")
        rig.press("Label all")
        other.wait_for_text("Go on: divide into stitches")
        rig.settle()
        other.page_button("Project")
        rig.wait_for_text("tube.obj, 48 faces")
        assert other.faults == []


@pytest.mark.nightly
def test_a_page_that_is_loaded_again_shows_the_same(app_in_browser, tmp_path):
    project = divided_project(tmp_path / "project")
    project.close()
    with app_in_browser(page="Project") as rig:
        rig.page_button("Garment")
        rig.wait_for_text("Label all")
        rig.settle()
        rig.browser_page.reload()
        rig.wait_until_ready()
        rig.settle()
        rig.wait_for_text("Label all")
        rig.press("Undo")
        rig.wait_for(lambda: rig.app.project.label_steps == (), "the step is undone")
        assert rig.call(rig.app.project.apply_label_step, LABEL_ALL) == ()


@pytest.mark.nightly
def test_a_browser_that_leaves_in_the_middle_of_a_frame_ends_nothing(app_in_browser, tmp_path):
    divided_project(tmp_path / "project").close()
    with app_in_browser(page="Project") as rig:
        for _ in range(2):
            other = rig.another_window()
            rig.app.post(rig.app.open_page, "Label")
            other.browser_page.goto("about:blank")
            rig.app.post(rig.app.open_page, "Project")
            other.close()
            rig.settle()
        rig.wait_for_text("tube.obj, 48 faces")
        assert len(rig.opened.server.get_clients()) == 1
