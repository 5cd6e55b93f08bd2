# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The finished job of a file of tests, whose fixture ``job`` says which one."""

from __future__ import annotations

import shutil
from pathlib import Path

import pytest

from stitchmesh.jobs.run_job import run_job


@pytest.fixture(scope="module")
def done(job, tmp_path_factory) -> Path:
    """Return the folder of the finished job."""
    folder = tmp_path_factory.mktemp("done")
    run_job(job, folder)
    return folder


@pytest.fixture
def copy(done, tmp_path) -> Path:
    """Return a copy of the folder of the finished job."""
    return shutil.copytree(done, tmp_path / "job")
