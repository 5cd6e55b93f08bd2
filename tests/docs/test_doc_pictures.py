# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The list of the pictures of the documentation: it is complete, its commands are valid, and it knows what is stale."""

from __future__ import annotations

import shlex
import sys
from dataclasses import replace
from fnmatch import fnmatch
from pathlib import Path

import pytest

from benchmarks.run import named
from stitchmesh.cli.arguments import parse
from stitchmesh.cli.main import COMMANDS, DESCRIPTION
from tests.docs.pages import DOCS
from tests.gallery import ROOT

sys.path.insert(0, str(DOCS / "site_build"))

import pictures

DRAWER = "import sys; from PIL import Image; Image.new('RGB', (8, 4), 'red').save('made.png')"


@pytest.fixture
def small(tmp_path: Path) -> Path:
    """A repository of one module that draws, and one picture."""
    (tmp_path / "stitchmesh" / "render").mkdir(parents=True)
    (tmp_path / "docs" / "site_build").mkdir(parents=True)
    (tmp_path / "stitchmesh" / "render" / "light.py").write_text("KEY = 1\n")
    entry = pictures.Entry(files="a.jpg", commands=(f"python -c {shlex.quote(DRAWER)}",), source="made.png", width=4)
    (tmp_path / pictures.LIST).write_text(pictures.written_list([entry], []))
    return tmp_path


def test_each_picture_of_the_documentation_is_listed_once():
    entries, others = pictures.read_list()
    patterns = [entry.files for entry in entries] + others
    for path in sorted([*DOCS.rglob("*.jpg"), *DOCS.rglob("*.png")]):
        name = str(path.relative_to(DOCS))
        assert sum(fnmatch(name, pattern) for pattern in patterns) == 1, name
    assert all(list(DOCS.glob(pattern)) for pattern in patterns)  # none is listed that is not there


def test_the_commands_of_the_list_are_valid():
    for entry in pictures.read_list()[0]:
        for command in entry.commands:
            program, *words = shlex.split(command)
            if program == "stitchmesh":
                assert parse(COMMANDS, words, program=program, description=DESCRIPTION) is not None
            else:
                assert (program, words[0]) == ("python", "benchmarks/run.py"), command
                named(words[1:]).close()


def test_the_code_of_the_renderer_is_there():
    assert all(list(ROOT.glob(pattern)) for pattern in pictures.RENDERER)


def test_a_picture_is_drawn_and_stale_after_the_renderer_changed(small, capsys):
    pictures.check(small)  # a picture that is older than the list does not end the build
    assert pictures.main(["draw"], small) == 0
    assert (small / "docs" / "a.jpg").read_bytes()[:2] == b"\xff\xd8"  # a JPEG
    pictures.check(small)
    code = small / "stitchmesh" / "render" / "light.py"
    code.write_text('"""Light."""\n\n# Bright.\nKEY = 1\n')
    pictures.check(small)  # comments draw nothing
    code.write_text("KEY = 2\n")
    with pytest.raises(ValueError, match=r"^docs/a.jpg: .* draw it again by `python docs/site_build/pictures.py draw"):
        pictures.check(small)
    assert pictures.main([], small) == 0
    assert "changed since" in capsys.readouterr().out
    assert pictures.main(["draw", "a.*"], small) == 0
    pictures.check(small)


def test_a_command_that_two_pictures_share_runs_once(small):
    count = "python -c \"open('runs', 'a').write('x')\""
    (first,), others = pictures.read_list(small)
    shared = [replace(first, files=name, commands=(count, *first.commands)) for name in ("a.jpg", "b.jpg")]
    (small / pictures.LIST).write_text(pictures.written_list(shared, others))
    assert pictures.main(["draw"], small) == 0
    assert (small / "runs").read_text() == "x"
    assert (small / "docs" / "b.jpg").exists()


def test_a_picture_is_stale_after_its_command_changed(small):
    assert pictures.main(["draw"], small) == 0
    (small / pictures.LIST).write_text((small / pictures.LIST).read_text().replace("red", "blue"))
    with pytest.raises(ValueError, match="the renderer or the command of this picture changed"):
        pictures.check(small)


def test_what_cannot_be_drawn_is_said_in_one_line(small, capsys):
    entry = pictures.Entry(files="a.jpg")
    (small / pictures.LIST).write_text(pictures.written_list([entry], []))
    assert pictures.main(["draw", "a.jpg"], small) == 1
    assert capsys.readouterr().out.startswith("docs/a.jpg: no command is known that draws it")
    failing = pictures.Entry(files="a.jpg", commands=("python -c 'raise SystemExit(3)'",))
    with pytest.raises(ValueError, match="ended with status 3"):
        pictures.draw(failing, small)
    assert pictures.main(["drew"], small) == 2


def test_the_build_of_the_site_checks_the_pictures(monkeypatch):
    import site_hooks
    from mkdocs.exceptions import PluginError

    site_hooks.on_pre_build()
    monkeypatch.setattr(site_hooks, "check", lambda: (_ for _ in ()).throw(ValueError("docs/a.jpg: changed")))
    with pytest.raises(PluginError, match=r"^docs/a.jpg: changed$"):
        site_hooks.on_pre_build()
