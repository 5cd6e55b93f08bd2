# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""What `stitchmesh status` says of a job and of a sweep that were stopped."""

from __future__ import annotations

import pytest

from stitchmesh.cli.commands.jobs import status_lines
from stitchmesh.jobs.job_status import JobStatus
from stitchmesh.jobs.sweep.run_sweep import STAGE


@pytest.mark.parametrize("state", ["stopped", "killed"])
@pytest.mark.parametrize(("stage", "remedy"), [(STAGE, "run it again"), ("relax_yarns", "run it with --resume")])
def test_a_stopped_run_says_how_it_continues(state, stage, remedy):
    status = JobStatus(time="now", state=state, stage=stage, done=0.5, seconds=70.2)
    assert status_lines(status) == [f"{state} after 70 s; {remedy} to continue"]


def test_a_failed_run_says_why():
    status = JobStatus(time="now", state="failed", stage="label", done=0.5, seconds=1.0, note="LabelError: face 17")
    assert status_lines(status) == ["failed after 1 s: LabelError: face 17"]
