# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Fixtures of the tests in the browser."""

from __future__ import annotations

import functools
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager
from typing import TYPE_CHECKING

import pytest

if TYPE_CHECKING:
    from pathlib import Path

    from playwright.sync_api import Browser

    from tests.app.browser import Rig, SharedRig


@pytest.fixture(scope="package")
def browser() -> Iterator[Browser]:
    """A browser, which is started once for all tests of a process."""
    from tests.app.browser import started_browser

    with started_browser() as started:
        yield started


@pytest.fixture(scope="module")
def page_of_file(browser: Browser, tmp_path_factory: pytest.TempPathFactory) -> Iterator[SharedRig]:
    """A page for all tests of a file; it is closed at the end of the file, because it draws while it is open."""
    from tests.app.browser import SharedRig

    shared = SharedRig(browser, tmp_path_factory.mktemp("empty") / "project")
    yield shared
    shared.close()


@pytest.fixture
def app_in_browser(
    page_of_file: SharedRig, tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> Iterator[Callable[..., AbstractContextManager[Rig]]]:
    """A function that shows a project in the browser: ``app_in_browser(page=None, size=(1000, 700))``.

    The project is in the folder ``tmp_path / "project"``. A traceback that the server prints fails the test.
    """
    yield functools.partial(page_of_file.on, tmp_path / "project")
    printed = capfd.readouterr().err
    assert "Traceback" not in printed, printed
