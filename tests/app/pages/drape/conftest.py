# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The page Drape without a browser, empty or with a small scene."""

from __future__ import annotations

from collections.abc import Iterator

import pytest

from stitchmesh.mixed.scene.scene import write_scene
from tests.app.pages.drape.on_page import open_file
from tests.app.pages.headless import Headless, headless
from tests.mixed.small_scene import SWINGING


@pytest.fixture
def shown(tmp_path) -> Iterator[Headless]:
    with headless(tmp_path, None, "Drape") as page:
        yield page


@pytest.fixture
def swinging(shown, tmp_path) -> Headless:
    """The page with the small scene."""
    write_scene(tmp_path / "swinging.toml", SWINGING)
    open_file(shown, tmp_path / "swinging.toml")
    return shown
