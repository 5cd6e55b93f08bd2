# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Each command of a guide begins at files that are in the repository, or that the page has made before."""

from __future__ import annotations

import re
from itertools import pairwise
from pathlib import PurePath

import pytest

from tests.docs.pages import BLOCK, DOCS, PAGES, name_of
from tests.docs.test_commands import command_words
from tests.gallery import ROOT

GUIDES = [page for page in PAGES if page.parent == DOCS / "how-to" or page == DOCS / "tour.md"]
FILE = re.compile(r"[\w./~-]+\.(obj|h5|bcc|toml|usdc|usda|ply|glb|knit|weave|smobj|jsonl|smc)")
"""A word that is the name of a file."""
OUTPUTS = ("-o", "--output", "--output-folder", ">")
"""What the name of an output follows."""
MAKERS = {("stitchmesh", "convert"): 3, ("stitchmesh", "drape"): 2}
"""Commands that write a file without ``-o``, ``drape`` only with ``--init``, and its place among their words."""


def written_by(words: list[str]) -> set[str]:
    """The files and folders that a command makes."""
    made = {after for word, after in pairwise(words) if word in OUTPUTS}
    place = MAKERS.get((words[0], words[1] if len(words) > 1 else ""))
    if place is not None and (words[1] != "drape" or "--init" in words):
        made.add(words[place])
    return made


def is_there(file: str, made: set[str]) -> bool:
    """Whether a file is in the repository, was made before, or lies in or beside what was made before."""
    folders = {str(parent) for parent in PurePath(file).parents}
    beside = {str(PurePath(one).with_suffix(".checkpoints")) for one in made}
    return (ROOT / file).exists() or file in made or bool(folders & (made | beside))


@pytest.mark.parametrize("page", GUIDES, ids=name_of)
def test_the_files_of_the_commands_are_there(page):
    made, text = set[str](), page.read_text()
    for block in BLOCK.finditer(text):
        kind, content = block.groups()
        if kind == "python":
            made |= set(re.findall(r'sm\.write_\w+\(\s*"([^"]+)"', content))
        elif kind != "sh":  # What a reader writes by hand: the words before the block name its file.
            made |= set(re.findall(r"`([\w./-]+)`", text[: block.start()].rstrip().rsplit("\n\n", 1)[-1]))
        for words in command_words(content) if kind == "sh" else ():
            made |= written_by(words)
            for word in words[1:]:
                assert not FILE.fullmatch(word) or is_there(word, made), f"{' '.join(words)}: nothing has made {word}"
