# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Text reaches HTML in one place of the code: by ``stitchmesh.markup.markup``, and a template that is written there."""

from __future__ import annotations

import ast
import re

import pytest

from tests.gallery import ROOT

PACKAGE = ROOT / "stitchmesh"
MADE_BY = {PACKAGE / "markup.py", PACKAGE / "app" / "guard.py"}
"""The one place, and the page that asks for a token, which is no page of the application yet."""
TAG = re.compile(r"</?[a-z]+[ >/]")
WAYS = re.compile(r"(inner|outer|insertAdjacent)HTML|document\.write|createContextualFragment|\beval\(|new Function")
"""How a script makes elements or code of a text."""


def trees(needed):
    """Return the trees of the files whose text has what a search needs; to read all of them takes seconds."""
    texts = {path: path.read_text() for path in PACKAGE.rglob("*.py") if path not in MADE_BY}
    return {path: ast.parse(text) for path, text in texts.items() if re.search(needed, text)}


def texts_of(tree, name):
    """Return what a name is set to in a file."""
    return [node.value for node in ast.walk(tree) if isinstance(node, ast.Assign)
            for target in node.targets if isinstance(target, ast.Name) and target.id == name]  # fmt: skip


def is_written(tree, node):
    """Whether an expression is a text that stands in the file."""
    if isinstance(node, ast.Name):
        found = texts_of(tree, node.id)
        return bool(found) and all(isinstance(value, ast.Constant) for value in found)
    return isinstance(node, ast.Constant) and isinstance(node.value, str)


def test_every_template_is_written_in_the_program():
    calls = [(path, tree, node) for path, tree in trees("arkup").items() for node in ast.walk(tree)
             if isinstance(node, ast.Call) and isinstance(node.func, ast.Name)]  # fmt: skip
    templates = [(path, tree, node) for path, tree, node in calls if node.func.id == "markup"]
    assert len(templates) > 80
    assert [f"{path}:{node.lineno}" for path, tree, node in templates if not is_written(tree, node.args[0])] == []
    assert [f"{path}:{node.lineno}" for path, _, node in calls if node.func.id == "Markup" and node.args] == []


def test_no_text_of_the_program_puts_values_between_tags_by_itself():
    found = []
    for path, tree in trees("<[/a-z]").items():
        for node in ast.walk(tree):
            if isinstance(node, ast.JoinedStr):
                text = "".join(str(part.value) for part in node.values if isinstance(part, ast.Constant))
                found += [f"{path}:{node.lineno}"] if TAG.search(text) else []
    assert found == []


def test_controls_are_the_only_way_to_a_browser_and_show_no_markdown():
    for path in PACKAGE.rglob("*.py"):
        text = path.read_text()
        assert "add_markdown" not in text, path
        assert "add_html" not in text or path == PACKAGE / "app" / "controls" / "viser_controls.py", path


@pytest.mark.parametrize("path", [*PACKAGE.rglob("*.js"), *PACKAGE.rglob("*.html")], ids=lambda path: path.name)
def test_scripts_of_pages_make_no_elements_of_texts(path):
    assert WAYS.findall(path.read_text()) == []
