# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Writes the tables of ``docs/settings.md`` from the declarations of the settings.

python docs/site_build/settings_page.py
"""

from __future__ import annotations

import json
import re
from pathlib import Path
from typing import Any

from stitchmesh.jobs.sections import SwatchTable
from stitchmesh.mixed.scene.motion_section import AttachmentSection, BodySection
from stitchmesh.mixed.scene.scene import ClothSection, Scene, YarnsSection
from stitchmesh.recipe.sections import GarmentSettings
from stitchmesh.settings import declared_setting, settings_of

PAGE = Path(__file__).resolve().parents[1] / "settings.md"
WITH_OPTIONS = {"garment": GarmentSettings(), "swatch": SwatchTable(pattern="rib2x2")}
"""Declarations from which options follow too, by the names of their tables on the page."""
WITHOUT_OPTIONS = {
    "scene": Scene(cloth=ClothSection(rectangle=(1.0, 1.0)), yarns=YarnsSection(weave="plain")),
    "held part": AttachmentSection(vertices=(0,)),
    "body": BodySection(shape="ball", size=(1.0,)),
}
"""Declarations that only files hold."""


def settings_table(value: Any, *, options: bool) -> str:
    """Return the table of all settings of a dataclass: key, option if there are any, default, and what it does."""
    titles = ("key", "option", "default", "") if options else ("key", "default", "")
    lines = ["| " + " | ".join(titles[:-1]) + " | |", "|" + "---|" * len(titles)]
    for path, part, _found in settings_of(value):
        declared = declared_setting(part)
        assert declared is not None
        sign = "no-" if part.default is True else ""
        flag = "" if declared.flag is None else f"`--{sign}{declared.flag or part.name.replace('_', '-')}`"
        text = f"{declared.help} [{declared.unit}]" if declared.unit else declared.help
        cells = (f"`{path}`", *([flag] if options else []), _default(part.default, declared.unset), text)
        lines.append("| " + " | ".join(cell.replace("|", "\\|") for cell in cells) + " |")
    return "\n".join(lines)


def _default(default: Any, unset: str | None) -> str:
    """Return the default as a reader sees it in a file, or in words."""
    if default is None or default == ():
        return unset or ("none" if default == () else "")
    return f"`{json.dumps(default)}`" if isinstance(default, bool | tuple) else f"`{default}`"


def page_with_tables(page: str) -> str:
    """Return a page with its tables up to date."""
    for name, value in (WITH_OPTIONS | WITHOUT_OPTIONS).items():
        start, end = f"<!-- settings of a {name} -->", "<!-- end of settings -->"
        table = f"{start}\n\n{settings_table(value, options=name in WITH_OPTIONS)}\n\n{end}"
        page = re.sub(f"{start}.*?{end}", lambda _found, table=table: table, page, flags=re.DOTALL)
    return page


if __name__ == "__main__":
    PAGE.write_text(page_with_tables(PAGE.read_text()))
