# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""What somebody reads who makes something stays short, and figures of measurements stand on pages of their own."""

from __future__ import annotations

import re

import pytest

from tests.docs.pages import DOCS, PARTS, USERS_PART, name_of, prose, words_of
from tests.gallery import ROOT

MOST_PAGES = 30
MOST_WORDS = 33_500
"""The bounds of the user's part. The aim is 30 pages and 30,000 words: lower them when the part has become shorter."""
MAKERS = {"walking-skirt walk", "walking-skirt skirt", "budget-tables", "book-page"}
"""Measures that make something of which a user goes on: a body that walks, tables of a machine, a picture of a book."""
PAGES_OF_USERS = [page for part in USERS_PART for page in PARTS[part]]


def test_the_navigation_has_each_page_once():
    listed = [page for pages in PARTS.values() for page in pages]
    assert len(listed) == len(set(listed))
    assert {page for page in listed if page.exists()} == set(DOCS.rglob("*.md"))


def test_no_list_of_the_navigation_is_long():
    """A list of more than ten pages without headings between them is read by nobody."""
    lists = re.split(r"^ *- [^:\n]+:\n", (ROOT / "mkdocs.yml").read_text().partition("\nnav:\n")[2], flags=re.MULTILINE)
    assert max(len(each.splitlines()) for each in lists) <= 13  # the public names of Python have thirteen pages


def test_the_users_part_is_short():
    words = sum(words_of(page) for page in PAGES_OF_USERS)
    assert len(PAGES_OF_USERS) <= MOST_PAGES
    assert words <= MOST_WORDS


def test_contributing_says_how_long_the_parts_are():
    """The text says whole thousands; a page may grow a little before the text has to be corrected."""
    text = " ".join((ROOT / "CONTRIBUTING.md").read_text().split())
    said = re.search(r"It has (\d+) pages and ([\d,]+) words, of ([\d,]+) words of all pages", text)
    assert said is not None
    pages, words, of_all = (int(number.replace(",", "")) for number in said.groups())
    assert pages == len(PAGES_OF_USERS)
    assert abs(words - sum(map(words_of, PAGES_OF_USERS))) <= 1_000
    assert abs(of_all - sum(words_of(page) for pages in PARTS.values() for page in pages if page.exists())) <= 5_000


@pytest.mark.parametrize("page", PARTS["How-to"], ids=name_of)
def test_a_how_to_names_no_measure(page):
    """What a measure printed belongs to How we know; the how-to page says the result in a sentence, with a link."""
    named = re.findall(r"benchmarks/run\.py\s+([\w-]+(?: (?:walk|skirt))?)", page.read_text())
    assert set(named) <= MAKERS


@pytest.mark.parametrize("page", PARTS["How-to"], ids=name_of)
def test_a_page_that_says_how_we_know_says_it_at_its_end(page):
    headings = re.findall(r"^## (.*)$", prose(page), re.MULTILINE)
    assert "How we know" not in headings[:-1]
