# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The navigation: the pages as buttons, above the controls of the open page."""

from __future__ import annotations

from collections.abc import Callable

from stitchmesh.app.controls.controls import Controls
from stitchmesh.markup import Markup, joined, markup

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
.sm-nav button:focus-visible{outline:3px solid #e08a1e;outline-offset:1px}
.sm-hint{margin:.1em .1em 0;font-size:.86em;line-height:1.35}
</style>""")


class Navigation:
    """The row of sections, the row of pages of the open section, and the hint of the open page."""

    def __init__(self, controls: Controls, open_page: Callable[[str], None]) -> None:
        """Make the rows; ``open_page`` is called with the name of a page."""
        self._last_of = {section: pages[0] for section, pages in SECTIONS.items()}
        self._open = open_page
        self._rows = controls.html(Markup(), self._clicked)

    def show(self, page: str, hint: str) -> None:
        """Show which page is open, and what to do on it."""
        section = section_of(page)
        self._last_of[section] = page
        sections = _row("Sections", "section", SECTIONS, section, "true")
        pages = SECTIONS[section]
        steps = _row("Steps", "page", pages, page, "page") if len(pages) > 1 else Markup()
        self._rows.content = markup('{}{}{}<p class="sm-hint" role="status">{}</p>', STYLE, sections, steps, hint)

    def _clicked(self, action: str, value: str) -> None:
        if action == "section":
            self._open(self._last_of[value])
        elif action == "page":
            self._open(value)


def section_of(page: str) -> str:
    """Return the section of a page."""
    return next(section for section, pages in SECTIONS.items() if page in pages)


def _row(title: str, action: str, names: object, current: str, mark: str) -> Markup:
    """Return a row of buttons."""
    assert isinstance(names, dict | tuple)
    present = markup(' aria-current="{}"', mark)
    buttons = joined(
        markup(
            '<button type="button" data-action="{}" data-value="{}"{}>{}</button>',
            action, name, present if name == current else "", name,
        )
        for name in names
    )
    return markup('<nav class="sm-nav" aria-label="{}">{}</nav>', title, buttons)
