# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The tables of docs/validation.md are what the kept results say."""

from __future__ import annotations

import re

import pytest

from benchmarks.published.published import SECTIONS, TABLES
from benchmarks.published.validation_page import PAGE, PICTURES, found, page_with_tables


def test_the_page_is_up_to_date():
    # `python benchmarks/run.py published page` updates the page.
    page = PAGE.read_text(encoding="utf-8")
    assert page_with_tables(page, TABLES) == page


@pytest.mark.parametrize("name", SECTIONS)
def test_each_section_is_kept_and_stands_on_the_page_with_its_picture(name):
    page, section = PAGE.read_text(encoding="utf-8"), SECTIONS[name]
    assert found(name) and re.search(rf"<!-- table {name}[: ]", page)
    assert not section.picture or ((PICTURES / section.picture).exists() and f"({section.picture})" in page)
