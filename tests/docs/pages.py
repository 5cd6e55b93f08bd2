# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The pages of the documentation, their parts and their code blocks, for the tests of the documentation.

``python -m tests.docs.pages`` prints the pages and words of each part.
"""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import yaml

from tests.gallery import ROOT

DOCS = ROOT / "docs"
ROOT_PAGES = [ROOT / name for name in ("README.md", "CONTRIBUTING.md", "CHANGELOG.md", "SECURITY.md")]
PAGES = ROOT_PAGES + sorted(DOCS.rglob("*.md"))
BLOCK = re.compile(r"^```(\w+)\n(.*?)^```$", re.DOTALL | re.MULTILINE)

USERS_PART = ("Start", "How-to", "Gallery and book", "Commands")
"""The parts of the navigation that somebody reads who makes something."""


def pages_of(entry: Any) -> list[Path]:
    """Return the pages of an entry of the navigation: of a page, of a page with a title, or of a list of entries."""
    if isinstance(entry, dict):
        entry = list(entry.values())
    return [page for each in entry for page in pages_of(each)] if isinstance(entry, list) else [DOCS / entry]


PARTS = {
    part: pages_of(entries)
    for each in yaml.safe_load((ROOT / "mkdocs.yml").read_text())["nav"]
    for part, entries in each.items()
}
"""The parts of the navigation with their pages; pages of the root have the name that they have on the site."""


def words_of(page: Path) -> int:
    """Return the number of words of a page, with its tables and its code."""
    return len(page.read_text().split())


def name_of(page: Path) -> str:
    return str(page.relative_to(ROOT))


def blocks(page: Path, language: str) -> list[str]:
    """Return the code blocks of a page that are marked as one language."""
    return [text for kind, text in BLOCK.findall(page.read_text()) if kind == language]


def prose(page: Path) -> str:
    """Return the text of a page without its code blocks, marked or indented."""
    return re.sub(r"(?<=\n\n)(?: {4}.*\n)+", "", BLOCK.sub("", page.read_text()))


if __name__ == "__main__":
    for part, pages in PARTS.items():
        there = [page for page in pages if page.exists()]
        print(f"{part}: {len(there)} pages, {sum(map(words_of, there)):,} words")
    users = [page for part in USERS_PART for page in PARTS[part]]
    print(f"the user's part: {len(users)} pages, {sum(map(words_of, users)):,} words")
