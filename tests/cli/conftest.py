# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Inputs that several test files copy."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.cli.every_command import write_inputs


@pytest.fixture(scope="session")
def inputs(tmp_path_factory) -> Path:
    """Return a folder with an input of each kind; a test that changes a file of it makes a copy first."""
    return write_inputs(tmp_path_factory.mktemp("inputs"))
