# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""A swatch job that was killed or stopped continues to the same bits; it consists of several relaxations."""

from __future__ import annotations

import functools
import itertools
import json
import os
import signal
import subprocess
import sys
import tempfile
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from stitchmesh.cli.main import main
from stitchmesh.errors import ParameterError
from stitchmesh.io.checkpoint_file import read_checkpoint
from stitchmesh.io.history import read_history
from stitchmesh.io.yarns import read_yarns
from stitchmesh.jobs import job_status, swatch_stages
from stitchmesh.jobs.job import Job
from stitchmesh.jobs.run_job import run_job
from stitchmesh.jobs.sections import SwatchTable
from stitchmesh.jobs.stop import JobStopped, StopRequest
from stitchmesh.periodic.relaxation import lowest_rest
from stitchmesh.yarnrelax import observer
from tests.gallery import ROOT
from tests.killing import killed

TEXT = """
quality = "draft"
device = "cpu"
render = []
[swatch]
pattern = "stockinette"
relax_cell = true
relaxation = "frictionless"
checkpoint_every = 40
"""
STARTS = 1
"""Displaced starts of the search for the lowest state."""
KILL_CALLS, STOP_WRITES = 700, 6
"""Calls that may change a file before the kill, and checkpoints from there to SIGTERM. A run that is never stopped
makes about 300 such calls for each of the 4 checkpoints of its first relaxation, and 8 checkpoints in those after."""


def results(folder: Path) -> tuple[bytes, list[Any], dict[str, Any]]:
    """The bits of the yarns, the history and the report of a job, without times."""
    report = json.loads((folder / "report.json").read_text())
    report = {
        name: value for name, value in report.items() if name not in ("seconds", "solver_seconds", "job", "memory")
    }
    history = [{**entry, "seconds": 0.0} for entry in read_history(folder / "convergence.csv")]
    return (folder / "yarns.h5").read_bytes(), history, report


def stop_twice() -> dict[str, Any]:
    """Kill a swatch job while it writes files, stop it by SIGTERM, and let it end.

    Returns:
        Whether it was killed, the exit status after SIGTERM, the numbers of relaxations that had begun after each stop,
        the exit status at the end and that of a job that was never stopped, the number of checkpoints that are left,
        and whether both have the same results.
    """
    observer.PROGRESS_SECONDS, job_status.WRITE_SECONDS, lowest_rest.STARTS = 0.0, float("inf"), STARTS
    write_state, writes = observer.write_state, itertools.count(1)

    def write_and_terminate(*given: Any) -> None:
        write_state(*given)
        if next(writes) == STOP_WRITES:
            os.kill(os.getpid(), signal.SIGTERM)

    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        (folder / "job.toml").write_text(TEXT)
        run = functools.partial(main, ["run", str(folder / "job.toml"), "--resume", "-o", str(folder / "stopped")])
        was_killed = killed("relax_yarns", KILL_CALLS, run, of_files=True)
        # Checkpoints that were being written when the process was killed lie in folders of parts.
        begun = [len(list(folder.rglob("relaxations/*/checkpoint.smc")))]
        observer.write_state = write_and_terminate
        status = run()
        begun.append(len(list(folder.rglob("relaxations/*/checkpoint.smc"))))
        observer.write_state = write_state
        ended = [run(), main(["run", str(folder / "job.toml"), "-o", str(folder / "whole")])]
        left = len(list(folder.rglob("*.smc")))
        same = results(folder / "stopped") == results(folder / "whole")
        return {"killed": was_killed, "status": status, "begun": begun, "ended": ended, "left": left, "same": same}


@pytest.mark.nightly
def test_a_kill_and_sigterm_in_a_swatch_change_no_bit():
    code = "import json, tests.jobs.test_stopped_swatches as t; print('\\n' + json.dumps(t.stop_twice()))"
    # The subprocess must not use a GPU, because a process with a GPU context cannot be forked.
    own = {"PYTHONPATH": str(ROOT), "CUDA_VISIBLE_DEVICES": "", "STITCHMESH_THREADS": "1"}
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, cwd=ROOT, env=os.environ | own)
    assert done.returncode == 0, done.stderr
    outcome = json.loads(done.stdout.splitlines()[-1])
    assert (outcome["killed"], outcome["status"], outcome["ended"]) == (True, 143, [0, 0])
    # The kill was in the first relaxation, and SIGTERM in a later one; how many iterations the displaced start needs
    # before it, and whether it leaves an unstable balance, follows from rounding.
    assert outcome["begun"][0] == 1 < outcome["begun"][1]
    assert outcome["left"] == 0
    assert outcome["same"]


@pytest.mark.nightly
def test_a_release_off_the_needles_that_is_stopped_twice_changes_no_bit(tmp_path, monkeypatch):
    monkeypatch.setattr(observer, "PROGRESS_SECONDS", 0.0)
    table = SwatchTable(pattern="stockinette", relaxation="dry")
    job = Job(swatch=table, checkpoint_every=200, quality="draft", device="cpu", render=())
    ended = list[int]()
    for reports in (20, 30):
        stop, count = StopRequest(), itertools.count(1)

        def stop_after_some(status, stop=stop, count=count, reports=reports):
            if "iteration" in status.note and next(count) == reports:
                stop.ask()

        with pytest.raises(JobStopped):
            run_job(job, tmp_path / "stopped", resume=True, stop=stop, listener=stop_after_some)
        found = [read_checkpoint(path).header["ended"] for path in tmp_path.rglob("relaxations/*/checkpoint.smc")]
        ended.append(max(map(len, found)))
    assert 0 < ended[0] < ended[1]  # both stops were in load steps after the first one
    for folder in ("stopped", "whole"):
        run_job(job, tmp_path / folder, resume=True)
    assert results(tmp_path / "stopped") == results(tmp_path / "whole")
    assert not list(tmp_path.rglob("*.smc"))


def test_a_stopped_swatch_is_not_begun_again_without_a_word(tmp_path, monkeypatch):
    monkeypatch.setattr(observer, "PROGRESS_SECONDS", 0.0)
    job, stop = Job(swatch=SwatchTable(pattern="stockinette"), quality="draft", device="cpu", render=()), StopRequest()
    with pytest.raises(JobStopped):
        run_job(job, tmp_path, stop=stop, listener=lambda status: stop.ask() if "iteration" in status.note else None)
    assert read_yarns(tmp_path / "yarns.h5").lattice is not None  # the state, for those who look at it meanwhile
    with pytest.raises(ParameterError, match="a run was stopped in swatch; give --resume to continue"):
        run_job(job, tmp_path)
    longer = replace(job, swatch=SwatchTable(pattern="stockinette", gamma=1.1, max_iterations=20))
    run_job(longer, tmp_path)  # another swatch begins, and leaves the checkpoint
    assert list(tmp_path.glob("stages/swatch-*/relaxations/*/checkpoint.smc"))
    run_job(job, tmp_path, resume=True)
    assert not list(tmp_path.rglob("*.smc"))
    run_job(job, tmp_path / "whole")
    assert results(tmp_path) == results(tmp_path / "whole")


def test_a_search_that_the_time_ended_goes_on_with_more_time(tmp_path, monkeypatch):
    """All yarns are at rest, but displaced starts were left out: the swatch is finished for that time only."""
    monkeypatch.setattr(lowest_rest, "STARTS", STARTS)
    table = SwatchTable(pattern="stockinette", relax_cell=True, relaxation="frictionless")
    job = Job(swatch=table, quality="draft", device="cpu", render=(), within="1h")
    with monkeypatch.context() as patch:
        for module in (lowest_rest, swatch_stages):
            patch.setattr(module, "seconds_left", lambda: -1.0)
        first = run_job(job, tmp_path).report
    assert first["converged"] and first["starts"] == 1 and first["search_out_of_time"]
    second = run_job(replace(job, within="2h"), tmp_path, resume=True).report
    assert second["starts"] == 1 + STARTS and not second["search_out_of_time"]
