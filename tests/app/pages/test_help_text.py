# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Each page has help, which is its part of the documentation as plain text."""

from __future__ import annotations

import pytest

from stitchmesh.app.pages.all_pages import PAGES
from stitchmesh.app.pages.navigation import help_html, help_paragraphs


@pytest.mark.parametrize("page", PAGES)
def test_each_page_has_help_without_marks_of_markdown(page):
    paragraphs = help_paragraphs(page)
    assert paragraphs and all(len(text) > 20 for text in paragraphs)
    assert not any(mark in text for text in paragraphs for mark in ("](", "**", "`", "![", "##"))
    assert f'aria-label="Help on {page}"' in str(help_html(page))
