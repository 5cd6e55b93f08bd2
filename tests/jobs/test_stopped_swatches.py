# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""A swatch job that was stopped continues to the same bits; it consists of several relaxations."""

from __future__ import annotations

import itertools
import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from stitchmesh.errors import ParameterError
from stitchmesh.io.checkpoint_file import read_checkpoint
from stitchmesh.io.history import read_history
from stitchmesh.io.yarns import read_yarns
from stitchmesh.jobs import swatch_stages
from stitchmesh.jobs.job import Job
from stitchmesh.jobs.job_status import JobStopped, StopRequest
from stitchmesh.jobs.run_job import run_job
from stitchmesh.jobs.sections import SwatchTable
from stitchmesh.periodic.relaxation import lowest_rest
from stitchmesh.yarnrelax import observer

STARTS = 1
"""Displaced starts of the search for the lowest state."""


def results(folder: Path) -> tuple[bytes, list[Any], dict[str, Any]]:
    """The bits of the yarns, the history and the report of a job, without times."""
    report = json.loads((folder / "report.json").read_text())
    report = {
        name: value for name, value in report.items() if name not in ("seconds", "solver_seconds", "job", "memory")
    }
    history = [{**entry, "seconds": 0.0} for entry in read_history(folder / "convergence.csv")]
    return (folder / "yarns.h5").read_bytes(), history, report


@pytest.mark.nightly
@pytest.mark.parametrize(
    ("table", "every", "reports"),
    [
        (SwatchTable(pattern="stockinette", relaxation="dry"), 200, (20, 30)),
        (SwatchTable(pattern="stockinette", relax_cell=True, relaxation="frictionless"), 40, (5, 15)),
    ],
    ids=["release off the needles", "search for the lowest state"],
)
def test_a_swatch_that_is_stopped_twice_changes_no_bit(tmp_path, monkeypatch, table, every, reports):
    """Both stops are after the first of several relaxations, or of the load steps of one."""
    monkeypatch.setattr(observer, "PROGRESS_SECONDS", 0.0)
    monkeypatch.setattr(lowest_rest, "STARTS", STARTS)
    job = Job(swatch=table, checkpoint_every=every, quality="draft", device="cpu", render=())
    begun = list[int]()
    for number in reports:
        stop, count = StopRequest(), itertools.count(1)

        def stop_after_some(status, stop=stop, count=count, number=number):
            if "iteration" in status.note and next(count) == number:
                stop.ask()

        with pytest.raises(JobStopped):
            run_job(job, tmp_path / "stopped", resume=True, stop=stop, listener=stop_after_some)
        checkpoints = [read_checkpoint(path) for path in tmp_path.rglob("relaxations/*/checkpoint.smc")]
        begun.append(sum(1 + len(one.header.get("ended", ())) for one in checkpoints))
    assert 0 < begun[0] < begun[1]
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
