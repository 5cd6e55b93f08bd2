# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The tables of docs/settings.md agree with the declarations."""

from __future__ import annotations

import sys

from tests.docs.pages import DOCS

sys.path.insert(0, str(DOCS / "site_build"))

from settings_page import PAGE, page_with_tables


def test_the_page_is_up_to_date():
    # `python docs/site_build/settings_page.py` updates the page.
    page = PAGE.read_text()
    assert page_with_tables(page) == page and "`finish.cast_on`" in page
