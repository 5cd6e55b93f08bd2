# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The commands and the Python blocks of the documentation are valid."""

from __future__ import annotations

import ast
import re
import shlex
from importlib import import_module

import pytest

import stitchmesh
from benchmarks.run import name_of as name_of_measure
from benchmarks.run import named, paths
from stitchmesh.cli.arguments import parse
from stitchmesh.cli.main import COMMANDS, DESCRIPTION
from stitchmesh.periodic.weave.library import read_weave
from stitchmesh.periodic.weave.text import parse_weave
from tests.docs.pages import PAGES, blocks, name_of, prose
from tests.gallery import ROOT

RUNNER = "benchmarks/run.py"
"""The runner of the measures."""


def command_words(block):
    """Return the words of each command of a block; continued lines are joined, and comments are left out."""
    lines = block.replace("\\\n", " ").splitlines()
    return [words for words in (shlex.split(line, comments=True) for line in lines) if words]


COMMAND_LINES = [
    (name_of(page), words) for page in PAGES for block in blocks(page, "sh") for words in command_words(block)
]
PYTHON = [(name_of(page), block) for page in PAGES for block in blocks(page, "python")]


def test_the_pages_have_commands_and_python():
    assert sum(words[0] == "stitchmesh" for _, words in COMMAND_LINES) > 50
    assert sum("stitchmesh" in block for _, block in PYTHON) > 5


@pytest.mark.parametrize(
    "page, words", [(page, words) for page, words in COMMAND_LINES if words[0] == "stitchmesh"], ids=str
)
def test_commands_parse(page, words):
    assert parse(COMMANDS, words[1:], program="stitchmesh", description=DESCRIPTION) is not None


@pytest.mark.parametrize(
    "page, words", [(page, words) for page, words in COMMAND_LINES if words[0].endswith("python")], ids=str
)
def test_scripts_exist_and_know_their_options(page, words):
    if words[1] == "-m":
        return
    text = (ROOT / words[1]).read_text()
    if words[1] == RUNNER:
        named(words[2:]).close()
        return
    for word in words[2:]:
        assert not word.startswith("--") or f'"{word}"' in text, word


INLINE = sorted(
    (name_of(page), words)
    for page in PAGES
    for words in set(re.findall(rf"`python {RUNNER} ([^`]+)`", page.read_text()))
)


@pytest.mark.parametrize("page, words", INLINE, ids=str)
def test_measures_that_the_text_names_know_their_options(page, words):
    if words != "--list":
        named(shlex.split(words)).close()


def test_each_measure_is_named_on_a_page():
    """A measure that no page names makes no figure, and goes."""
    text = "\n".join(page.read_text() for page in PAGES)
    unnamed = [name for name in map(name_of_measure, paths()) if f"{RUNNER} {name}" not in text]
    assert not unnamed


MEASURED = sorted({page for page, words in COMMAND_LINES if len(words) > 1 and words[1] == RUNNER})


@pytest.mark.parametrize("page", [page for page in MEASURED if page != "CONTRIBUTING.md"])
def test_a_page_of_measurements_says_its_version_before_its_first_section(page):
    """What a solver gives changes with it: a table without a version cannot be compared with one's own."""
    text = (ROOT / page).read_text()
    if re.search(r"^\|[-:| ]+\|$", text, re.MULTILINE):
        assert re.search(r"[Vv]ersion \d+\.\d+\.\d+", text.partition("\n## ")[0]), page


@pytest.mark.parametrize("page, block", PYTHON, ids=range(len(PYTHON)))
def test_python_blocks_compile_and_use_existing_names(page, block):
    for node in ast.walk(ast.parse(block, page)):
        if isinstance(node, ast.Attribute) and isinstance(node.value, ast.Name) and node.value.id == "sm":
            assert node.attr in stitchmesh.__all__, f"{page}: sm.{node.attr}"
        if isinstance(node, ast.ImportFrom) and (node.module or "").startswith("stitchmesh"):
            for alias in node.names:
                assert hasattr(import_module(node.module), alias.name), f"{page}: {node.module}.{alias.name}"


@pytest.mark.parametrize("page", PAGES, ids=name_of)
def test_prose_names_public_names(page):
    for name in re.findall(r"`sm\.(\w+)", prose(page)):
        assert name in stitchmesh.__all__, name


def test_the_weave_of_the_documentation_is_that_of_the_library():
    (text,) = (block for page in PAGES for block in blocks(page, "weave"))
    assert parse_weave(text).matrix == read_weave("double-plain-stitched").matrix
