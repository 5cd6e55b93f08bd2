# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Examples by name: the program finds its own garments from any folder, and an installed package holds all examples."""

from __future__ import annotations

import tomllib
from pathlib import Path, PurePosixPath

import pytest

import stitchmesh as sm
from stitchmesh.cli.main import main
from stitchmesh.errors import FileError
from stitchmesh.io.any_file import read_any
from stitchmesh.io.examples import example_files, example_names, mesh_file
from tests.gallery import ROOT


@pytest.mark.parametrize("name", ["hat", "tea cozy", "tea_cozy", "Tea-Cozy"])
def test_a_word_is_the_name_of_an_example(tmp_path, monkeypatch, name):
    monkeypatch.chdir(tmp_path)
    mesh = sm.read_mesh(name)
    assert mesh.face_count == read_any(name).face_count == (108 if name == "hat" else 160)


def test_what_stands_in_the_folder_and_what_is_no_word_is_a_path(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    Path("hat").write_text("mine")
    assert mesh_file("hat") == "hat"
    for path in ("hat.obj", "./sock", "folder/sock", ""):
        assert mesh_file(path) == path
    with pytest.raises(FileError, match="hta: there is no such file, and no example of this name; the examples"):
        sm.read_mesh("hta")


def test_the_command_lists_the_examples_and_writes_them_where_the_documentation_names_them(tmp_path, capsys):
    assert main(["examples"]) == 0
    listed = capsys.readouterr().out
    assert all(f"\n{name} " in f"\n{listed}" for name in example_names()) and "stitchmesh knit hat" in listed
    assert main(["examples", "-o", str(tmp_path / "new")]) == 0
    for place, path in example_files().items():
        assert (tmp_path / "new" / place).read_bytes() == path.read_bytes()
    recipe = sm.read_recipe(tmp_path / "new" / "examples" / "hat.toml")
    assert recipe.read_mesh().mesh.face_count == 108
    assert main(["examples", "-o", str(tmp_path / "new")]) == 0  # They are unchanged files of the program.


def test_an_installed_package_holds_all_examples():
    with open(ROOT / "pyproject.toml", "rb") as file:
        included = tomllib.load(file)["tool"]["hatch"]["build"]["targets"]["wheel"]["force-include"]
    included = {source: target for source, target in included.items() if not source.startswith("docs/")}
    assert all(target == f"stitchmesh/{source}" for source, target in included.items())
    sources = {PurePosixPath(source) for source in included}
    for place in example_files():
        held = PurePosixPath(place.as_posix())
        assert held in sources or sources & set(held.parents), f"{held} is not in the wheel"
