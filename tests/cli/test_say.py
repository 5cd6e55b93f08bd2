# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""What the command line prints commands no terminal, whatever the names of files hold."""

from __future__ import annotations

import ast
import shutil

import pytest

from stitchmesh.cli.main import main
from stitchmesh.cli.say import printable
from stitchmesh.errors import REPLACEMENT
from tests.gallery import ROOT

HARM = "a\x1b[2J\u202eb\udcff\r\x07"
CLI = ROOT / "stitchmesh" / "cli"


def test_characters_that_command_a_terminal_are_replaced():
    assert printable(HARM).replace(REPLACEMENT, "?") == "a?[2J?b???"
    assert printable("stitches 0.8\u2009cm, ✓\n\tnext") == "stitches 0.8\u2009cm, ✓\n\tnext"


@pytest.mark.parametrize("words", ["check {}", "convert {} {}.ply", "info {}", "label {} --auto -o {}.h5"])
def test_names_in_lines_of_success_are_printed_without_commands(tmp_path, monkeypatch, capsys, words):
    monkeypatch.chdir(tmp_path)
    name = "\x1b[31mtube\x07.obj"
    shutil.copy(ROOT / "assets" / "meshes" / "swatch.obj", name)
    assert main([word.replace("{}", name) for word in words.split()]) == 0
    printed = capsys.readouterr()
    assert "\x1b" not in printed.out + printed.err and "\x07" not in printed.out + printed.err


def test_a_name_that_is_not_utf8_is_refused_in_one_line(capsys):
    assert main(["knit", "a\udcff.obj", "-o", "out"]) == 2
    error = capsys.readouterr().err
    assert error == "ParameterError: argument 2: 'a\\udcff.obj' is not UTF-8; rename the file\n"


def test_commands_print_in_one_place():
    for path in CLI.rglob("*.py"):
        calls = [node.func for node in ast.walk(ast.parse(path.read_text())) if isinstance(node, ast.Call)]
        prints = [call for call in calls if isinstance(call, ast.Name) and call.id == "print"]
        assert not prints or path.name == "say.py", path
