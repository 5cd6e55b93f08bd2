# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The stage of a job in which a budget chooses the quality; it is kept, because a calibration is not repeatable."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from stitchmesh.budget.budget import Budget
from stitchmesh.budget.plan import Plan
from stitchmesh.jobs.kept_stages import stage_key
from stitchmesh.jobs.stage_files import quality_stage
from stitchmesh.jobs.stage_run import JobRun
from stitchmesh.quality import Quality


def chosen_quality(run: JobRun, given: Quality, plan: Callable[[Budget], Plan], *inputs: Any) -> Quality:
    """Return the quality that the budget of a job chooses; without a budget it is the given one.

    Args:
        run: the job, whose report has an entry for the given quality.
        given: the quality of the job.
        plan: makes the plan for a budget.
        inputs: what the plan depends on besides the quality and the budget.

    Raises:
        ParameterError: a quality beside an error.
    """
    budget = run.budget
    if budget is None:
        return given

    def choose(report: dict[str, Any]) -> Quality:
        made = plan(budget)
        report["budget"] = made.report()
        report["quality"] = made.report()["quality"] or run.report["quality"]
        return made.quality

    key = stage_key("budget", *inputs, given, run.job.within, run.job.error)
    return run.run(quality_stage("budget", key), choose)
