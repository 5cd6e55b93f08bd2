# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Files are whole whenever a process is killed, and whatever a disk refuses; another seed each night."""

from __future__ import annotations

import subprocess
import sys

import pytest

from tests.fuzz import SEED
from tests.gallery import ROOT


@pytest.mark.nightly
@pytest.mark.parametrize("action", ["kills", "refusals"])
def test_all_commands_leave_whole_files(action):
    if action == "refusals" and subprocess.run(["unshare", "--mount", "true"], capture_output=True).returncode != 0:
        pytest.skip("a disk can be mounted by root only")
    options = ["--kills", "40", "--seed", SEED] if action == "kills" else []
    command = [sys.executable, "-m", "tests.crashes", action, *options]
    ended = subprocess.run(command, cwd=ROOT, capture_output=True, text=True)
    assert ended.returncode == 0, ended.stdout + ended.stderr[-2000:]
