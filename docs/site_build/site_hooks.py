# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""What the site needs beyond the pages of ``docs/``: the pages of the root, pictures of the graphs, and no other host.

A picture that the renderer would draw in another way now ends the build (``pictures.py``).

``CONTRIBUTING.md``, ``CHANGELOG.md`` and ``SECURITY.md`` stand in the root of the repository, where hosts of
repositories look for them; the site shows them with links that start in ``docs/``. A Mermaid graph is drawn as SVG when
the site is built, because the script that draws Mermaid in a browser would come from another host.
"""

from __future__ import annotations

import re
import sys
from pathlib import Path
from typing import Any

sys.path.insert(0, str(Path(__file__).resolve().parent))

from mermaid_svg import mermaid_to_svg
from pictures import check

ROOT_PAGES = {"CONTRIBUTING.md": "contributing.md", "CHANGELOG.md": "changelog.md", "SECURITY.md": "security.md"}
"""File of the root, and its name on the site."""
LINK = re.compile(r"\]\((?:docs/)?(?!https?:)([^)#]+)")
"""A link of such a page: its target without the folder and the anchor."""
REMOTE = re.compile(r"<(?:script|link|img|iframe|source)\b[^>]*(?:src|href)=\"?(?:https?:)?//[^>]*>")
"""What a browser loads by itself, from another host."""
FENCE = re.compile(r"^```mermaid\n(.*?)^```$", re.DOTALL | re.MULTILINE)


def on_pre_build(**_: Any) -> None:
    """Refuse pictures that were drawn by other code than there is now.

    Raises:
        PluginError: there are some.
    """
    from mkdocs.exceptions import PluginError

    try:
        check()
    except ValueError as error:
        raise PluginError(str(error)) from None


def on_files(files: Any, *, config: Any) -> Any:
    """Add the pages of the root to the pages of ``docs/``."""
    from mkdocs.structure.files import File

    root = Path(config.config_file_path).parent
    for name, page in ROOT_PAGES.items():
        files.append(File.generated(config, page, content=links_from_docs((root / name).read_text())))
    return files


def on_page_markdown(markdown: str, **_: Any) -> str:
    """Replace the source of each graph by its picture."""
    return FENCE.sub(lambda found: f'<div class="graph">{mermaid_to_svg(found.group(1))}</div>', markdown)


def on_post_page(output: str, **_: Any) -> str:
    """Refuse a page that would load something from another host.

    Raises:
        ValueError: it would.
    """
    if found := REMOTE.search(output):
        raise ValueError(f"a page loads something from another host: {found.group(0)}")
    return output


def links_from_docs(text: str) -> str:
    """The text of a page of the root with its links as they are written in ``docs/``."""
    return LINK.sub(lambda found: f"]({ROOT_PAGES.get(found[1], found[1])}", text)
