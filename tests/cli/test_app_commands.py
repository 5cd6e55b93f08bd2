# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The commands that open the application: which project, which page, where it listens, and what they refuse."""

from __future__ import annotations

from dataclasses import replace

import pytest

from stitchmesh.app.pages.swatch.state import read_state
from stitchmesh.cli.main import main
from stitchmesh.io.stitches import write_stitches
from stitchmesh.mixed.scene.scene import read_scene, write_scene
from stitchmesh.yarn.yarn_presets import Yarn
from tests.app.project.projects import mesh_bytes
from tests.cli.calls import refused, refused_without_files
from tests.editing.fabrics import flat
from tests.mixed.small_scene import SWINGING


@pytest.fixture
def started(tmp_path, monkeypatch):
    """A function that runs a command, and returns the project's values, the options and the page it would open."""
    monkeypatch.setenv("STITCHMESH_PROJECTS", str(tmp_path / "projects"))
    monkeypatch.setenv("XDG_STATE_HOME", str(tmp_path / "state"))
    found = []

    def run_app(open_project, options, *, page=None):
        project = open_project()
        found.append((project, options, page))
        project.close()

    monkeypatch.setattr("stitchmesh.app.run.run_app", run_app)

    def start(*words: object):
        assert main([str(word) for word in words]) == 0
        return found[-1]

    return start


@pytest.fixture
def tube_file(tmp_path):
    path = tmp_path / "tube.obj"
    path.write_bytes(mesh_bytes(tmp_path))
    return path


def test_app_opens_the_project_of_a_file(started, tube_file, tmp_path):
    project, options, page = started("app", tube_file, "--port", 0, "--no-browser")
    assert project.mesh.face_count == 48 and project.folder == tmp_path / "projects" / "tube"
    assert (options.host, options.port, options.browser, page) == ("127.0.0.1", 0, False, None)


def test_app_opens_a_folder(started, tube_file, tmp_path):
    project, options, _ = started("app", tube_file, "--project", tmp_path / "here", "--token", "correct-horse")
    assert project.folder == tmp_path / "here" and options.token == "correct-horse" and options.browser
    again, _, _ = started("app", tmp_path / "here")
    assert again.mesh.face_count == 48


def test_the_token_is_that_of_the_user_or_a_new_one(started, tmp_path, monkeypatch):
    monkeypatch.delenv("STITCHMESH_TOKEN", raising=False)
    for words, variable, token, needs_token in [
        ([], None, None, True), ([], "", None, True), ([], "of-the-variable", "of-the-variable", True),
        (["--token", "of-the-words"], "of-the-variable", "of-the-words", True),
        (["--no-token"], "of-the-variable", None, False),
    ]:  # fmt: skip
        if variable is not None:
            monkeypatch.setenv("STITCHMESH_TOKEN", variable)
        _, options, _ = started("app", "--project", tmp_path / "here", *words)
        assert (options.token, options.needs_token) == (token, needs_token)


def test_a_token_and_none_are_refused(capsys, tmp_path):
    words = ["app", "--project", tmp_path / "here", "--no-token"]
    assert "token: there is one" in refused(capsys, *words, "--token", "correct-horse")
    assert "other machines reach it" in refused(capsys, *words, "--host", "0.0.0.0")


def test_edit_without_edits_opens_the_page_edit(started, tmp_path):
    write_stitches(tmp_path / "flat.h5", flat())
    project, options, page = started("edit", tmp_path / "flat.h5", "--port", 9000)
    assert project.fabric.face_count == 42 and page == "Edit" and options.port == 9000


def test_swatch_view_opens_the_designer_with_the_pattern(started):
    project, _, page = started("swatch", "rib2x2", "--view", "--gamma", 1.25)
    design = read_state(project.settings("Swatch")).design
    assert page == "Swatch" and design.pattern.name == "2 x 2 rib" and design.dials.gamma == 1.25
    again, _, _ = started("swatch", "rib2x2", "--view", "--gamma", 1.25)
    other, _, _ = started("swatch", "rib2x2", "--view")
    assert again.folder == project.folder != other.folder
    assert read_state(other.settings("Swatch")).design.dials.gamma == 1.0


def test_swatch_view_takes_the_yarn_and_the_gauge(started):
    project, _, _ = started("swatch", "rib2x2", "--view", "--yarn", "lace", "--columns", 2)
    dials, yarn = read_state(project.settings("Swatch")).design.dials, Yarn.named("lace")
    # a dial has four digits
    assert (dials.yarn_radius, dials.loop_length) == pytest.approx((yarn.core_radius, yarn.loop_length), rel=5e-4)
    assert dials.columns == 2
    wide, _, _ = started("swatch", "rib2x2", "--view", "--yarn", "lace", "--gauge", 20)
    assert read_state(wide.settings("Swatch")).design.dials.loop_length > yarn.loop_length


def test_drape_view_opens_the_page_with_the_scene(started, tmp_path):
    path = tmp_path / "swinging.toml"
    write_scene(path, SWINGING)
    project, _, page = started("drape", path, "--view")
    assert page == "Drape" and read_scene(project.folder / "drape" / "scene.toml") == SWINGING
    again, _, _ = started("drape", path, "--view")
    write_scene(path, replace(SWINGING, duration=0.5))
    other, _, _ = started("drape", path, "--view")
    assert again.folder == project.folder != other.folder


def test_view_opens_a_file_or_a_folder(started, tube_file, tmp_path):
    project, _, page = started("view", tube_file)
    assert page == "View" and project.settings("View")["path"] == str(tube_file)
    project, _, _ = started("view", tmp_path)
    assert project.settings("View")["path"] == str(tmp_path)


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["app", "missing.obj"], "there is no such file"),
        (["view", "missing.h5"], "there is no such file"),
        (["edit", "a.h5", "-o", "b.h5"], "needs one edit or one log"),
        (["drape", "missing.toml", "--view"], "missing.toml"),
        (["drape", "scene.toml"], "needs -o DIR for its files, --view for the browser"),
        (["swatch", "plain"], "needs -o DIR for its files, or --view"),
        (["swatch", "plain", "--view", "--spacing", "0.5"], "spacing has no effect beside --view"),
    ],
)
def test_wrong_words_give_one_line(started, capsys, tmp_path, monkeypatch, words, message):
    monkeypatch.chdir(tmp_path)
    assert message in refused(capsys, *words)


NOISE = bytes(range(256)) * 20


@pytest.mark.parametrize(
    ("name", "content"),
    [(f"noise.{suffix}", NOISE) for suffix in ("h5", "bcc", "vtp", "obj", "smc", "png", "txt", "unknown")]
    + [("nan.obj", b"v 0 0 0\nv 1 0 0\nv 1 nan 0\nv 0 1 0\nf 1 2 3 4\n"), ("empty.h5", b"")],
)
def test_view_refuses_a_file_that_it_cannot_show(started, capsys, tmp_path, name, content):
    (tmp_path / name).write_bytes(content)
    assert name in refused_without_files(capsys, tmp_path, "view", tmp_path / name)


def test_a_port_that_cannot_be_is_refused_and_the_project_is_free_again(capsys, tmp_path, monkeypatch, tube_file):
    monkeypatch.setenv("STITCHMESH_PROJECTS", str(tmp_path / "projects"))
    monkeypatch.setenv("XDG_STATE_HOME", str(tmp_path / "state"))
    for _ in range(2):
        assert "port: got 70000" in refused(capsys, "app", tube_file, "--port", "70000", "--no-browser")
