# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The command ``run``."""

from __future__ import annotations

import sys
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from tyro.conf import Positional, UseAppendAction

from stitchmesh.cli.budget_options import exit_status, load_of_machine, start_of_command
from stitchmesh.cli.options import Overwrite, Threads
from stitchmesh.cli.say import say
from stitchmesh.cli.stop_signal import TERMINATED, stopped_by_signal
from stitchmesh.cli.summary import files_to_open, knit_summary, swatch_summary
from stitchmesh.cli.words import Flag, help_entry

if TYPE_CHECKING:
    from stitchmesh.jobs.run_job import FinishedJob


@dataclass(frozen=True)
class Run:
    """Run a job file; finished stages are kept, and stopped ones continue."""

    job: Annotated[Positional[str], help_entry("JOB")]
    """job: TOML (docs/how-to/jobs.md); `stitchmesh job init` writes one"""
    output: Annotated[str | None, help_entry("DIR", "the path of the job without its suffix", short="-o")] = None
    """folder of the job, for its results, its kept stages and its status"""
    resume: Flag = False
    """continue a relaxation from its checkpoint"""
    allow_paths: Annotated[UseAppendAction[tuple[str, ...]], help_entry("DIR", "none")] = ()
    """a further folder in which files may be that the job names, besides that of the job and the present one"""
    threads: Threads = None
    overwrite: Overwrite = False

    def run(self) -> int | None:
        """Run the job, and print a summary.

        Returns:
            The exit status if a signal stopped the job or the time ended a relaxation, otherwise None.
        """
        load = load_of_machine()  # before the heavy imports
        from stitchmesh.cli.job_progress import show_reports
        from stitchmesh.jobs.job_file import read_job
        from stitchmesh.jobs.run_job import run_job
        from stitchmesh.jobs.stop import JobStopped

        job = read_job(self.job, allow_paths=self.allow_paths)
        folder = Path(self.job).with_suffix("") if self.output is None else Path(self.output)
        try:
            with stopped_by_signal() as stop, show_reports() as listener:
                made = run_job(
                    job, folder, resume=self.resume, stop=stop, listener=listener, began=start_of_command(),
                    load=load, overwrite=self.overwrite,
                )  # fmt: skip
        except JobStopped:
            _print(f"stopped; `stitchmesh run {self.job} -o {folder} --resume` continues the job")
            return TERMINATED
        for line in (*_summary(made), files_to_open(folder, made.drawn)):
            _print(line)
        return exit_status(made.report.get("yarnrelax", made.report))


def _print(line: str) -> None:
    """Print a line for a person: beside the lines of JSON, where standard output holds these."""
    say(line, file=sys.stdout if sys.stdout.isatty() else sys.stderr)


def _summary(made: FinishedJob) -> list[str]:
    """Return the lines about the result, and about stages of earlier runs."""
    from stitchmesh.periodic.swatch import Swatch

    kept = [stage["name"] for stage in made.report["job"]["stages"] if stage["kept"]]
    lines = [f"Kept from earlier runs: {', '.join(kept)}."] if kept else []
    if "yarnrelax" in made.report and made.fabric is not None:
        return lines + knit_summary(made.fabric, made.yarns, made.report, None)
    return lines + swatch_summary(Swatch(made.yarns, made.report, made.fabric, []), made.report["name"], None)
