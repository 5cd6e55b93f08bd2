# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Links lead to pages, headings and files that exist, both on the site and in the repository itself."""

from __future__ import annotations

import pkgutil
import re
import sys
import unicodedata

import pytest

import stitchmesh
from tests.docs.pages import BLOCK, DOCS, PAGES, name_of, prose
from tests.gallery import ROOT

sys.path.insert(0, str(DOCS / "site_build"))

import site_hooks

LINK = re.compile(r"!?\[(?:[^\[\]]|!\[[^\]]*\]\([^)]*\))*\]\(([^)\s]+)\)")
REFERENCE = re.compile(r"^::: stitchmesh\.([\w.]+)$", re.MULTILINE)
OF_THE_SITE = {DOCS / page: ROOT / name for name, page in site_hooks.ROOT_PAGES.items()}
"""Pages that exist only on the site, and the files from which they are made."""


def words(heading: str) -> str:
    text = re.sub(r"\[([^\]]*)\]\([^)]*\)", r"\1", heading).replace("`", "")
    return unicodedata.normalize("NFKD", text).encode("ascii", "ignore").decode().strip().lower()


def anchors(page) -> set[str]:
    """Return the anchors that the headings of a page have both on the site and on hosts of repositories."""
    text = [words(each) for each in re.findall(r"^#+ (.*)$", BLOCK.sub("", page.read_text()), re.MULTILINE)]
    on_site = {re.sub(r"[-\s]+", "-", re.sub(r"[^\w\s-]", "", each)) for each in text}
    in_place = {re.sub(r"\s", "-", re.sub(r"[^\w\s-]", "", each)) for each in text}
    return on_site & in_place


@pytest.mark.parametrize("page", PAGES, ids=name_of)
def test_links_resolve(page):
    for link in LINK.findall(re.sub(r"`[^`\n]*`", "", prose(page))):
        if re.match(r"https?:", link):
            continue
        path, _, anchor = link.partition("#")
        target = (page.parent / path).resolve() if path else page
        target = OF_THE_SITE.get(target, target)
        assert target.exists(), link
        assert not anchor or anchor in anchors(target), link


@pytest.mark.parametrize("page", PAGES, ids=name_of)
def test_files_named_in_prose_exist(page):
    for path in re.findall(r"`((?:stitchmesh|tests|benchmarks|assets|docs)/[\w./-]*)`", prose(page)):
        assert (ROOT / path).exists(), path


def test_the_reference_has_every_public_name_once():
    named = [name.split(".")[-1] for page in PAGES for name in REFERENCE.findall(page.read_text())]
    assert len(named) == len(set(named))
    assert set(named) >= set(stitchmesh.__all__)


def test_the_names_of_the_reference_stand_where_it_says():
    for name in [name for page in PAGES for name in REFERENCE.findall(page.read_text())]:
        assert pkgutil.resolve_name(f"stitchmesh.{name}") is not None, name


def test_references_from_pages_are_in_the_reference():
    known = {f"stitchmesh.{name}" for page in PAGES for name in REFERENCE.findall(page.read_text())}
    used = {name for page in PAGES for name in re.findall(r"\]\[(stitchmesh[\w.]*)\]", page.read_text())}
    assert used <= known
    assert used


@pytest.mark.parametrize("tag", ['<script src="https://host/a.js">', '<link rel="stylesheet" href="//host/a.css">'])
def test_a_page_that_loads_from_another_host_is_an_error(tag):
    with pytest.raises(ValueError, match="another host"):
        site_hooks.on_post_page(f"<html>{tag}</html>")


def test_a_page_may_link_to_another_host():
    page = '<html><a href="https://host/">host</a><script src="assets/a.js"></script></html>'
    assert site_hooks.on_post_page(page) == page


def test_pages_of_the_root_are_linked_from_docs():
    text = "[a](docs/tour.md#swatches) [b](CHANGELOG.md) [c](CONTRIBUTING.md) [d](https://example.org/docs/x.md)"
    expected = "[a](tour.md#swatches) [b](changelog.md) [c](contributing.md) [d](https://example.org/docs/x.md)"
    assert site_hooks.links_from_docs(text) == expected
