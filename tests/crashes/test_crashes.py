# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Files are whole whenever a process is killed, and whatever a disk refuses.

The moments of the kills of `convert` are counted in calls that may change a file, so that each run has the same ones;
those of all commands are random, with another seed each night.
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
import tempfile
from functools import partial
from importlib import import_module
from pathlib import Path

import pytest

from tests.fuzz import SEED
from tests.gallery import ROOT
from tests.killing import killed

CALLS = (4, 30, 55, 97)
"""Numbers of calls before the kills; the run makes more than these."""


def kill_convert() -> tuple[int, list[str]]:
    """Kill a process that replaces yarns of seven formats; return the number of kills and the faults."""
    from tests.crashes import kills, works

    for name in ("h5py", "pxr.Usd", "pyvista", "trimesh"):
        import_module(name)  # once, in the place of once for each process
    with tempfile.TemporaryDirectory() as scratch:
        (Path(scratch) / "inputs").mkdir()
        (work,) = (one for one in works.works(Path(scratch) / "inputs") if one.name == "convert")

        def kill(folder: Path, calls: int) -> bool:
            return killed("_begin_part", calls, partial(work.new, folder), of_files=True)

        tally = kills.kill_often(
            work, Path(scratch) / "work", lambda _: (partial(kill, calls=calls) for calls in CALLS), len(CALLS)
        )
    return tally.kills, tally.faults


@pytest.mark.nightly
def test_files_of_every_format_are_whole_after_kills_and_the_next_run_succeeds():
    code = "import json; from tests.crashes.test_crashes import kill_convert as k; print(json.dumps(k()))"
    environment = {**os.environ, "PYTHONPATH": str(ROOT)}
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, cwd=ROOT, env=environment)
    assert done.returncode == 0, done.stderr
    assert json.loads(done.stdout.splitlines()[-1]) == [len(CALLS), []]


@pytest.mark.nightly
@pytest.mark.parametrize("action", ["kills", "refusals"])
def test_all_commands_leave_whole_files(action):
    if action == "refusals" and subprocess.run(["unshare", "--mount", "true"], capture_output=True).returncode != 0:
        pytest.skip("a disk can be mounted by root only")
    options = ["--kills", "40", "--seed", SEED] if action == "kills" else []
    command = [sys.executable, "-m", "tests.crashes", action, *options]
    ended = subprocess.run(command, cwd=ROOT, capture_output=True, text=True)
    assert ended.returncode == 0, ended.stdout + ended.stderr[-2000:]
