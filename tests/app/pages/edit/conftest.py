# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Fixtures of the page Edit."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import pytest

from tests.app.pages.edit.opened import WIDE, OpenedEdit, edit_page


@pytest.fixture
def page(tmp_path: Path) -> Iterator[OpenedEdit]:
    """The page Edit on a flat piece of 10 x 12 knit stitches, without a browser."""
    with edit_page(tmp_path, WIDE) as opened:
        yield opened
