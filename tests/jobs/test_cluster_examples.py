# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The examples for a cluster: a batch script of SLURM with programs in the place of SLURM's, and a sweep on workers."""

from __future__ import annotations

import importlib.util
import os
import shutil
import subprocess

import pytest

from stitchmesh.cli.arguments import parse
from stitchmesh.cli.main import COMMANDS, DESCRIPTION
from stitchmesh.cli.stop_signal import TERMINATED
from stitchmesh.jobs.sweep.result_table import read_table
from tests.gallery import ROOT

SCRIPT = ROOT / "examples" / "jobs" / "sweater.sbatch"
SWEEP = """picture = false
[job]
quality = "draft"
device = "cpu"
[job.swatch]
pattern = "stockinette"
[grid]
swatch.gamma = [1.0, 1.1]
"""


@pytest.fixture
def submitted(tmp_path):
    """Return a function that runs the batch script with a program that ends with a status; it returns what was called.

    The result holds the exit status of the script and the words of all calls of SLURM and of StitchMesh.
    """
    calls = tmp_path / "calls"

    def submit(status: int, *words: str) -> tuple[int, list[list[str]]]:
        for name, end in (("srun", '"$@"'), ("scontrol", "true"), ("stitchmesh", f"exit {status}")):
            (tmp_path / name).write_text(f'#!/bin/bash\necho "{name} $*" >> {calls}\n{end}\n')
            (tmp_path / name).chmod(0o755)
        environment = {"PATH": f"{tmp_path}:{os.environ['PATH']}", "SLURM_JOB_ID": "17"}
        done = subprocess.run(["bash", SCRIPT, *words], env=environment, check=False)
        return done.returncode, [line.split() for line in calls.read_text().splitlines()]

    return submit


@pytest.mark.skipif(shutil.which("bash") is None, reason="this system has no bash")
@pytest.mark.parametrize(("status", "ends", "queued"), [(0, 0, False), (2, 2, False), (TERMINATED, 0, True)])
def test_the_batch_job_waits_again_if_a_signal_stopped_it(submitted, status, ends, queued):
    returned, calls = submitted(status)
    assert returned == ends
    assert calls[2:] == ([["scontrol", "requeue", "17"]] if queued else [])


def test_the_batch_job_runs_a_command_that_continues(submitted):
    _, (srun, stitchmesh) = submitted(0, "a.toml", "out/a")
    assert srun[1:] == stitchmesh == ["stitchmesh", "run", "a.toml", "-o", "out/a", "--resume"]
    command = parse(COMMANDS, stitchmesh[1:], program="stitchmesh", description=DESCRIPTION)
    assert (command.job, command.output, command.resume) == ("a.toml", "out/a", True)
    assert "#SBATCH --signal=TERM@120\n#SBATCH --requeue\n" in SCRIPT.read_text()


def test_a_sweep_runs_on_the_workers_of_a_cluster(tmp_path):
    distributed = pytest.importorskip("distributed")
    spec = importlib.util.spec_from_file_location("sweep_on_slurm", SCRIPT.with_name("sweep_on_slurm.py"))
    example = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(example)
    (tmp_path / "sweep.toml").write_text(SWEEP)
    local = distributed.LocalCluster(
        n_workers=0, threads_per_worker=1, processes=False, protocol="tls://", security=True, host="127.0.0.1",
        dashboard_address=None,
    )  # fmt: skip
    ended = example.run_on(local, 1, tmp_path / "sweep.toml", tmp_path / "out")
    assert (ended.jobs, ended.failed) == (2, 0)
    assert read_table(tmp_path / "out")["swatch.gamma"] == [1.0, 1.1]
    assert local.status == distributed.Status.closed
