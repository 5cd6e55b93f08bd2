# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Fixtures of the tests of pictures."""

from __future__ import annotations

import pytest

from stitchmesh.errors import DisplayError
from stitchmesh.render import check_display


@pytest.fixture
def display() -> None:
    """Skip the test, with the reason, if this machine cannot draw pictures."""
    try:
        check_display()
    except DisplayError as error:
        pytest.skip(str(error))
