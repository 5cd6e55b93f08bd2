# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The command ``batch``."""

from __future__ import annotations

import sys
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from tyro.conf import Positional, UseAppendAction

from stitchmesh.cli.options import Overwrite
from stitchmesh.cli.say import say
from stitchmesh.cli.words import help_entry
from stitchmesh.errors import ParameterError

if TYPE_CHECKING:
    from stitchmesh.jobs.sweep.run_sweep import FinishedSweep

ALL_FAILED = 1
"""Exit status after a sweep of which no job has a result."""
REPORT = "report"
"""Word for the page of a sweep, in the place of a file."""


@dataclass(frozen=True)
class Batch:
    """Run the jobs of a sweep on all cores, GPUs or a cluster, or make its page."""

    sweep: Annotated[Positional[str], help_entry("SWEEP|report")]
    """sweep: TOML (docs/how-to/sweeps.md); or the word report"""
    folder: Annotated[Positional[str | None], help_entry("DIR", "that of -o")] = None
    """folder of a sweep, after the word report"""
    output: Annotated[str | None, help_entry("DIR", "the path of the sweep without its suffix", short="-o")] = None
    """folder of the sweep, for its table and all that it keeps; its workers share it"""
    workers: Annotated[int | None, help_entry("N", "one for each GPU, or for each core without a GPU")] = None
    """processes on this machine; 0 runs the jobs in this process"""
    scheduler: Annotated[str | None, help_entry("ADDRESS", "processes on this machine")] = None
    """a standing scheduler of Dask, such as tls://10.0.0.5:8786, whose workers run the jobs"""

    allow_paths: Annotated[UseAppendAction[tuple[str, ...]], help_entry("DIR", "none")] = ()
    """a further folder with files that the jobs name, besides that of the sweep and the present one"""
    overwrite: Overwrite = False

    def run(self) -> int | None:
        """Run the sweep, or write the page.

        Returns:
            The exit status if a signal stopped the sweep, or if all its jobs failed; otherwise None.
        """
        if self.sweep == REPORT:
            self._report()
            return None
        if self.folder is not None:
            raise ParameterError(f"batch: got the folder {self.folder!r} beside a sweep; give it as -o {self.folder}")
        from stitchmesh.cli.job_progress import show_reports
        from stitchmesh.cli.stop_signal import TERMINATED, stopped_by_signal
        from stitchmesh.jobs.stop import JobStopped
        from stitchmesh.jobs.sweep.run_sweep import run_sweep
        from stitchmesh.jobs.sweep.sweep_file import read_sweep

        sweep = read_sweep(self.sweep, allow_paths=self.allow_paths)
        folder = Path(self.sweep).with_suffix("") if self.output is None else Path(self.output)
        try:
            with stopped_by_signal() as stop, show_reports() as listener:
                ended = run_sweep(
                    sweep, folder, workers=self.workers, scheduler=self.scheduler, stop=stop, listener=listener,
                    overwrite=self.overwrite,
                )  # fmt: skip
        except JobStopped:
            say(f"stopped; `stitchmesh batch {self.sweep} -o {folder}` continues the sweep", file=sys.stderr)
            return TERMINATED
        say(_summary(ended, folder), file=sys.stdout if sys.stdout.isatty() else sys.stderr)
        return ALL_FAILED if ended.all_failed else None

    def _report(self) -> None:
        """Write the page of a sweep."""
        from stitchmesh.jobs.sweep.report_page import write_report_page

        folder = self.folder or self.output
        if folder is None:
            raise ParameterError("batch report: got no folder; expected that of a sweep: `stitchmesh batch report DIR`")
        say(f"Wrote {write_report_page(Path(folder))}.")


def _summary(ended: FinishedSweep, folder: Path) -> str:
    """Return the lines about a sweep that has ended."""
    parts = [f"{ended.jobs} jobs: {ended.jobs - ended.failed} done"]
    parts += [f"{ended.failed} failed (column error_text)"] if ended.failed else []
    parts += [f"{ended.kept} kept from earlier runs"] if ended.kept else []
    lines = [f"{', '.join(parts)}.",
             f"Table: {folder / 'rows.parquet'}; `stitchmesh batch report {folder}` makes a page of it."]  # fmt: skip
    lines += [f"No job has a result; the first error: {ended.first_error}"] if ended.all_failed else []
    return "\n".join(lines)
