# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The pages of the documentation and their code blocks, for the tests of the documentation."""

from __future__ import annotations

import re
from pathlib import Path

from tests.gallery import ROOT

DOCS = ROOT / "docs"
ROOT_PAGES = [ROOT / name for name in ("README.md", "CONTRIBUTING.md", "CHANGELOG.md", "SECURITY.md")]
PAGES = ROOT_PAGES + sorted(DOCS.rglob("*.md"))
BLOCK = re.compile(r"^```(\w+)\n(.*?)^```$", re.DOTALL | re.MULTILINE)


def name_of(page: Path) -> str:
    return str(page.relative_to(ROOT))


def blocks(page: Path, language: str) -> list[str]:
    """Return the code blocks of a page that are marked as one language."""
    return [text for kind, text in BLOCK.findall(page.read_text()) if kind == language]


def prose(page: Path) -> str:
    """Return the text of a page without its code blocks, marked or indented."""
    return re.sub(r"(?<=\n\n)(?: {4}.*\n)+", "", BLOCK.sub("", page.read_text()))
