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

    from tests.app.browser import Rig


@pytest.fixture(scope="package")
def browser() -> Iterator[Browser]:
    """A browser, which is started once for all tests of a process."""
    from tests.app.browser import started_browser

    with started_browser() as started:
        yield started


@pytest.fixture
def app_in_browser(
    browser: Browser, tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> Iterator[Callable[..., AbstractContextManager[Rig]]]:
    """A function that runs the application in the browser: ``app_in_browser(page=None, size=(1000, 700))``.

    The project is in the folder ``tmp_path / "project"``. A traceback that the server prints fails the test.
    """
    from tests.app.browser import rig_on

    yield functools.partial(rig_on, browser, tmp_path / "project")
    printed = capfd.readouterr().err
    assert "Traceback" not in printed, printed
