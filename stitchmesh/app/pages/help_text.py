# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Help on each page of the application: its section of the documentation, as paragraphs without pictures and tables."""

from __future__ import annotations

import re
from pathlib import Path

from stitchmesh.io.contents import read_bytes
from stitchmesh.markup import Markup, joined, markup

_PACKAGE = Path(__file__).resolve().parents[2]
_FOLDERS = (_PACKAGE / "assets" / "help", _PACKAGE.parent / "docs")
"""Folders that may hold the documentation: inside an installed package, or beside the package in the repository."""
WALK = ("application.md", "From mesh to sweater in ten minutes")
SECTIONS = {
    "Project": ("application.md", "Projects"), "Label": WALK, "Divide": WALK, "Edit": WALK, "Even out": WALK,
    "Yarns": WALK, "Take home": WALK, "Rows": ("application.md", "A mesh without rows"),
    "Swatch": ("application.md", "A swatch in two minutes"),
    "Outline": ("application.md", "A swatch in two minutes"), "Drape": ("drape-page.md", ""), "View": ("view.md", ""),
}  # fmt: skip
"""File and heading of the help on each page; without a heading, what the file begins with."""
STYLE = markup("""<style>
.sm-help{margin:.4em .1em;padding:.1em .7em;font-size:.86em;line-height:1.4;max-height:24em;overflow-y:auto;
 border:1px solid var(--mantine-color-default-border);border-radius:6px}
.sm-help p{margin:.5em 0}
</style>""")
LEFT_OUT = ("![", "|", "#", "The pictures")
"""How paragraphs begin that are left out: pictures, tables, headings, and what is said of pictures."""


def help_html(page: str) -> Markup:
    """Return the help on a page of the application."""
    texts = joined(markup("<p>{}</p>", text) for text in help_paragraphs(page))
    box = markup('<div class="sm-help" role="region" tabindex="0" aria-label="Help on {}">{}</div>', page, texts)
    return STYLE + box


def help_paragraphs(page: str) -> list[str]:
    """Return the paragraphs of the help on a page, as plain text."""
    file, heading = SECTIONS[page]
    folder = next((folder for folder in _FOLDERS if (folder / file).is_file()), _FOLDERS[-1])
    text = read_bytes(folder / file).decode("utf-8").replace("\n- ", "\n\n- ")
    start = f"\n## {heading}\n" if heading else "\n"
    section = text.split(start, 1)[1].split("\n## ", 1)[0]
    blocks = [block.strip() for block in re.sub(r"(?s)```.*?```", "", section).split("\n\n")]
    return [_plain(block) for block in blocks if block and not block.startswith(LEFT_OUT)]


def _plain(block: str) -> str:
    """Return a paragraph without the marks of Markdown."""
    words = re.sub(r"\[([^\]]*)\]\([^)]*\)", r"\1", " ".join(block.split()))
    bullet = words.startswith("- ")
    plain = re.sub(r"\*\*|`|(?<!\w)\*|\*(?!\w)", "", words.removeprefix("- "))
    return f"\N{BULLET} {plain}" if bullet else plain
