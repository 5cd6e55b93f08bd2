# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The command ``status``."""

from __future__ import annotations

import json
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from tyro.conf import Positional

from stitchmesh.cli.say import say
from stitchmesh.cli.summary import AsJson
from stitchmesh.cli.words import help_entry

if TYPE_CHECKING:
    from stitchmesh.jobs.job_status import JobStatus

SWEEP = "sweep"
"""Stage of a sweep, which continues by itself."""


@dataclass(frozen=True)
class Status:
    """Print how far a job or a sweep is that runs in another process."""

    folder: Annotated[Positional[str], help_entry("DIR")]
    """folder of the job or of the sweep"""
    json: AsJson = False

    def run(self) -> None:
        """Print the status.

        Raises:
            FileError: the folder has neither.
        """
        from stitchmesh.jobs.job_status import read_status

        status = read_status(Path(self.folder))
        say(json.dumps(asdict(status)) if self.json else "\n".join(status_lines(status)))


def status_lines(status: JobStatus) -> list[str]:
    """Return the lines about a job: the stages that have ended, and the state."""
    kept = ", kept from an earlier run"
    ended = [f"{one.name}: {one.seconds:.1f} s{kept if one.kept else ''}" for one in status.stages]
    spent = f"after {status.seconds:.0f} s"
    if status.state == "running":
        return [*ended, status.line, f"running {spent} (process {status.process} on {status.host}), seen {status.time}"]
    if status.state in ("stopped", "killed"):
        remedy = "run it again to continue" if status.stage == SWEEP else "run it with --resume to continue"
        return [*ended, f"{status.state} {spent}; {remedy}"]
    note = f": {status.note}" if status.note and status.state == "failed" else ""
    return [*ended, f"{status.state} {spent}{note}"]
