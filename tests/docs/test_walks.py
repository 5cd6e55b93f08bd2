# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The walks of the pages list the files whose functions run."""

from __future__ import annotations

import re
import sys

import pytest

from tests.docs.pages import DOCS
from tests.nightly import at_night

sys.path.insert(0, str(DOCS / "site_build"))

from walks import WALKS, Walked, page_with_walks, walked


def listed_files(name: str) -> set[str]:
    """The files that the page lists for a walk, by their paths in the package."""
    page = WALKS[name].page.read_text()
    walk = page[page.index(f"<!-- walk: {name} -->") :]
    rows = re.findall(r"^\| `?([a-z_]*)`? ?\| (`.*?) \|$", walk[: walk.index("<!-- end of walk -->")], re.MULTILINE)
    return {f"{folder}/{file}".removeprefix("/") for folder, files in rows for file in re.findall("`(.*?)`", files)}


@pytest.mark.parametrize("name", at_night(*WALKS))
def test_the_page_lists_the_files_whose_functions_run(name: str) -> None:
    # `python docs/site_build/walks.py` updates the page. How a processor shares its work among threads, in
    # stitchmesh/compute, depends on the number of its cores.
    run = {file for file in walked(name).functions if not file.startswith("compute/")}
    assert run == {file for file in listed_files(name) if not file.startswith("compute/")}


def test_a_page_without_a_walk_is_an_error() -> None:
    with pytest.raises(ValueError, match="got 0 walks named 'one iteration'"):
        page_with_walks("# Architecture", {"one iteration": Walked({}, {})})
