# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The navigation above the controls of the open page: the pages as buttons, help, and the colours of the program.

The help on a page is its section of the documentation, as paragraphs without pictures and tables.
"""

from __future__ import annotations

import re
from collections.abc import Callable
from pathlib import Path

from stitchmesh.app.controls.controls import Controls
from stitchmesh.app.controls.html_pieces import action_button
from stitchmesh.io.contents import read_bytes
from stitchmesh.markup import Markup, joined, markup

_PACKAGE = Path(__file__).resolve().parents[2]
_FOLDERS = (_PACKAGE / "assets" / "help", _PACKAGE.parent / "docs")
"""Folders that may hold the documentation: inside an installed package, or beside the package in the repository."""
WALK = ("application.md", "From mesh to sweater in ten minutes")
HELP_SECTIONS = {
    "Project": ("application.md", "Projects"), "Label": WALK, "Divide": WALK, "Edit": WALK, "Even out": WALK,
    "Yarns": WALK, "Take home": WALK, "Rows": ("application.md", "A mesh without rows"),
    "Swatch": ("application.md", "A swatch in two minutes"),
    "Outline": ("application.md", "A swatch in two minutes"), "Drape": ("drape-page.md", ""), "View": ("view.md", ""),
}  # fmt: skip
"""File and heading of the help on each page; without a heading, the first part of the file."""
HELP_STYLE = markup("""<style>
.sm-help{margin:.4em .1em;padding:.1em .7em;font-size:.86em;line-height:1.4;max-height:24em;overflow-y:auto;
 border:1px solid var(--mantine-color-default-border);border-radius:6px}
.sm-help p{margin:.5em 0}
</style>""")
LEFT_OUT = ("![", "|", "#", "The pictures")
"""First words of paragraphs that are left out: pictures, tables, headings, and remarks on pictures."""


def help_html(page: str) -> Markup:
    """Return the help on a page of the application."""
    texts = joined(markup("<p>{}</p>", text) for text in help_paragraphs(page))
    box = markup('<div class="sm-help" role="region" tabindex="0" aria-label="Help on {}">{}</div>', page, texts)
    return HELP_STYLE + box


def help_paragraphs(page: str) -> list[str]:
    """Return the paragraphs of the help on a page, as plain text."""
    file, heading = HELP_SECTIONS[page]
    folder = next((folder for folder in _FOLDERS if (folder / file).is_file()), _FOLDERS[-1])
    text = read_bytes(folder / file).decode("utf-8").replace("\n- ", "\n\n- ")
    start = f"\n## {heading}\n" if heading else "\n"
    section = text.split(start, 1)[1].split("\n## ", 1)[0]
    blocks = [block.strip() for block in re.sub(r"(?s)```.*?```", "", section).split("\n\n")]
    return [_plain(block) for block in blocks if block and not block.startswith(LEFT_OUT)]


def _plain(block: str) -> str:
    words = re.sub(r"\[([^\]]*)\]\([^)]*\)", r"\1", " ".join(block.split()))
    bullet = words.startswith("- ")
    plain = re.sub(r"\*\*|`|(?<!\w)\*|\*(?!\w)", "", words.removeprefix("- "))
    return f"\N{BULLET} {plain}" if bullet else plain


SECTIONS: dict[str, tuple[str, ...]] = {
    "Project": ("Project",),
    "Garment": ("Label", "Divide", "Rows", "Edit", "Even out", "Yarns", "Take home"),
    "Swatch": ("Swatch", "Outline"),
    "Drape": ("Drape",),
    "View": ("View",),
}
"""The pages of each section, in order."""
STYLE = markup("""<style>
.sm-nav{display:flex;gap:4px;margin:0 0 .35em}
.sm-nav button{flex:1 1 auto;font:inherit;font-size:.86em;padding:.35em .3em;border-radius:6px;cursor:pointer;
 border:1px solid var(--mantine-color-default-border);background:var(--mantine-color-default);
 color:var(--mantine-color-text)}
.sm-nav button[aria-current=page],.sm-nav button[aria-current=true]{background:#1f5673;border-color:#1f5673;color:#fff;
 font-weight:600}
.sm-nav button:focus-visible,.sm-more button:focus-visible{outline:3px solid #e08a1e;outline-offset:1px}
.sm-more{display:flex;justify-content:space-between;margin:.25em .1em 0}
.sm-more button{font:inherit;font-size:.8em;padding:0;border:0;background:none;cursor:pointer;text-decoration:underline;
 color:var(--mantine-color-text)}
.sm-hint{margin:.1em .1em 0;font-size:.86em;line-height:1.35}
</style>""")


class Navigation:
    """The row of sections, the row of pages of the open section, the hint of the open page, and its help."""

    def __init__(self, controls: Controls, open_page: Callable[[str], None], set_dark: Callable[[bool], None]) -> None:
        """Make the rows.

        Args:
            controls: the place of the navigation.
            open_page: called with the name of a page.
            set_dark: called with True for dark colours of the program, and False for light ones.
        """
        self._last_of = {section: pages[0] for section, pages in SECTIONS.items()}
        self._open, self._set_dark = open_page, set_dark
        self._page, self._hint, self._helps = "", "", False
        self.dark = False
        """Whether the program is dark."""
        self._rows = controls.html(Markup(), self._clicked)

    def show(self, page: str, hint: str) -> None:
        """Show which page is open, and what the user can do on it."""
        self._helps = self._helps and page == self._page
        self._page, self._hint = page, hint
        self._last_of[section_of(page)] = page
        self._show()

    def _show(self) -> None:
        page, section = self._page, section_of(self._page)
        sections = _row("Sections", "section", SECTIONS, section, "true")
        pages = SECTIONS[section]
        steps = _row("Steps", "page", pages, page, "page") if len(pages) > 1 else Markup()
        more = joined([
            _button("help", "", f"Help on {page}", expanded=self._helps),
            _button("dark", "" if self.dark else "dark", "Light colours" if self.dark else "Dark colours"),
        ])  # fmt: skip
        self._rows.content = markup(
            '{}{}{}<p class="sm-hint" role="status">{}</p><p class="sm-more">{}</p>{}',
            STYLE, sections, steps, self._hint, more, help_html(page) if self._helps else "",
        )

    def _clicked(self, action: str, value: str) -> None:
        if action == "section":
            self._open(self._last_of[value])
        elif action == "page":
            self._open(value)
        elif action == "help":
            self._helps = not self._helps
            self._show()
        elif action == "dark":
            self.dark = value == "dark"
            self._set_dark(self.dark)
            self._show()


def section_of(page: str) -> str:
    """Return the section of a page."""
    return next(section for section, pages in SECTIONS.items() if page in pages)


def _button(action: str, value: str, label: str, *, expanded: bool | None = None) -> Markup:
    """Return a button that looks like a link; ``expanded`` says whether the part that it unfolds is visible."""
    state = Markup() if expanded is None else markup(' aria-expanded="{}"', str(expanded).lower())
    return markup('<button type="button" data-action="{}" data-value="{}"{}>{}</button>', action, value, state, label)


def _row(title: str, action: str, names: object, current: str, mark: str) -> Markup:
    assert isinstance(names, dict | tuple)
    buttons = joined(
        action_button(action, name, name, current=mark if name == current else "") for name in names
    )
    return markup('<nav class="sm-nav" aria-label="{}">{}</nav>', title, buttons)
