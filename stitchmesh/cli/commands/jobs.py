# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The commands for what runs long: ``run``, ``job``, ``status``, ``batch`` and ``book``."""

from __future__ import annotations

import json
import sys
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal

from tyro.conf import Positional, UseAppendAction

from stitchmesh.cli.budget_options import exit_status, load_of_machine, start_of_command
from stitchmesh.cli.options import Device, Overwrite, QualityName, Threads
from stitchmesh.cli.say import say
from stitchmesh.cli.stop_signal import TERMINATED, stopped_by_signal
from stitchmesh.cli.summary import AsJson, files_to_open, knit_summary, swatch_summary
from stitchmesh.cli.words import Flag, help_entry
from stitchmesh.errors import FileError, ParameterError
from stitchmesh.periodic.swatch_options import KnitState

if TYPE_CHECKING:
    from stitchmesh.jobs.job_status import JobStatus
    from stitchmesh.jobs.run_job import FinishedJob
    from stitchmesh.jobs.sweep.run_sweep import FinishedSweep


@dataclass(frozen=True)
class RunCommand:
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
        from stitchmesh.cli.progress import show_reports
        from stitchmesh.jobs.job_file import read_job
        from stitchmesh.jobs.job_status import JobStopped
        from stitchmesh.jobs.run_job import run_job

        job = read_job(self.job, allow_paths=self.allow_paths)
        folder = Path(self.job).with_suffix("") if self.output is None else Path(self.output)
        try:
            with stopped_by_signal() as stop, show_reports() as listener:
                made = run_job(
                    job, folder, resume=self.resume, stop=stop, listener=listener, began=start_of_command(),
                    load=load, overwrite=self.overwrite,
                )  # fmt: skip
        except JobStopped:
            _print_beside_reports(f"stopped; `stitchmesh run {self.job} -o {folder} --resume` continues the job")
            return TERMINATED
        for line in (*_job_lines(made), files_to_open(folder, made.drawn)):
            _print_beside_reports(line)
        return exit_status(made.report.get("yarnrelax", made.report))


def _print_beside_reports(line: str) -> None:
    """Print a line for a person: beside the lines of JSON, where standard output holds these."""
    say(line, file=sys.stdout if sys.stdout.isatty() else sys.stderr)


def _job_lines(made: FinishedJob) -> list[str]:
    """Return the lines about the result, and about stages of earlier runs."""
    from stitchmesh.periodic.swatch import Swatch

    kept = [stage["name"] for stage in made.report["job"]["stages"] if stage["kept"]]
    lines = [f"Kept from earlier runs: {', '.join(kept)}."] if kept else []
    if "yarnrelax" in made.report and made.fabric is not None:
        return lines + knit_summary(made.fabric, made.yarns, made.report, None)
    return lines + swatch_summary(Swatch(made.yarns, made.report, made.fabric, []), made.report["name"], None)


@dataclass(frozen=True)
class JobCommand:
    """Write a new job file with all keys, or clean the folder of a job."""

    action: Annotated[Positional[Literal["init", "clean"]], help_entry("init|clean")]
    """what to do: init writes a new file, clean removes the kept stages that the last run has not used"""
    source: Annotated[Positional[str], help_entry("SOURCE|DIR")]
    """init: a mesh, a recipe (.toml), a chart or a pattern of the library; clean: the folder of a job"""
    output: Annotated[str | None, help_entry("FILE", "job.toml", short="-o")] = None
    """the new file"""

    def run(self) -> None:
        """Write the file, or clean the folder.

        Raises:
            FileError: there is a file of that name, it cannot be written, or the job would begin with a folder; or the
                folder has no finished job, or a run is going on in it.
            ParameterError: there is a file to write beside a folder to clean.
        """
        if self.action == "clean":
            self._clean()
        else:
            self._write("job.toml" if self.output is None else self.output)

    def _clean(self) -> None:
        from stitchmesh.jobs.run_job import clean_job

        if self.output is not None:
            raise ParameterError(f"--output: got {self.output} with clean, which writes no file; leave it out")
        made = clean_job(self.source)
        say(f"Removed {len(made.removed)} stages ({made.freed / 1e6:.1f} MB), kept the {made.kept} of the last run.")

    def _write(self, output: str) -> None:
        import os

        from stitchmesh.io.atomic import write_text
        from stitchmesh.io.contents import suffix_of
        from stitchmesh.io.path_kind import is_folder, is_there, whole_path
        from stitchmesh.io.toml_file import SUFFIX
        from stitchmesh.jobs.job_file import example_job

        suffix_of(output, [SUFFIX])
        if is_there(output):
            raise FileError(f"{output}: is there already; choose another name, or remove it")
        named = Path(self.source)
        if is_folder(named):
            raise FileError(f"{self.source}: is a folder; expected a mesh, a recipe, or a pattern of the library")
        folder = whole_path(output).parent
        source = Path(os.path.relpath(named, folder)).as_posix() if named.suffix else self.source
        write_text(output, example_job(source))
        say(f"Wrote {output}; `stitchmesh run {output}` runs it.")


SWEEP = "sweep"
"""Stage of a sweep, which continues by itself."""


@dataclass(frozen=True)
class StatusCommand:
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


REPORT = "report"
"""Word for the page of a sweep, in the place of a file."""


@dataclass(frozen=True)
class BatchCommand:
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
        from stitchmesh.cli.progress import show_reports
        from stitchmesh.jobs.job_status import JobStopped
        from stitchmesh.jobs.sweep.run_sweep import run_sweep
        from stitchmesh.jobs.sweep.sweep import read_sweep

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
        _print_beside_reports(_sweep_lines(ended, folder))
        return 1 if ended.all_failed else None  # no job has a result

    def _report(self) -> None:
        """Write the page of a sweep."""
        from stitchmesh.jobs.sweep.report_page import write_report_page

        folder = self.folder or self.output
        if folder is None:
            raise ParameterError("batch report: got no folder; expected that of a sweep: `stitchmesh batch report DIR`")
        say(f"Wrote {write_report_page(Path(folder))}.")


def _sweep_lines(ended: FinishedSweep, folder: Path) -> str:
    """Return the lines about a sweep that has ended."""
    parts = [f"{ended.jobs} jobs: {ended.jobs - ended.failed} done"]
    parts += [f"{ended.failed} failed (column error_text)"] if ended.failed else []
    parts += [f"{ended.kept} kept from earlier runs"] if ended.kept else []
    lines = [f"{', '.join(parts)}.",
             f"Table: {folder / 'rows.parquet'}; `stitchmesh batch report {folder}` makes a page of it."]  # fmt: skip
    lines += [f"No job has a result; the first error: {ended.first_error}"] if ended.all_failed else []
    return "\n".join(lines)


@dataclass(frozen=True)
class BookCommand:
    """Make a swatch book: a page of the library, with fabrics that turn."""

    output: Annotated[str, help_entry("DIR", short="-o")]
    """folder of the book; the same command continues a book that was stopped"""
    patterns: Annotated[Positional[tuple[str, ...]], help_entry("PATTERN", "the whole library")] = ()
    """knits and weaves of the library"""
    yarn: Annotated[str, help_entry("NAME")] = "dk"
    """yarn of all swatches (`stitchmesh yarn list`)"""
    relaxation: Annotated[KnitState, help_entry("STATE")] = "dry"
    """state in which knits come to rest (docs/swatches.md)"""
    quality: QualityName = "draft"
    device: Device = None
    no_stretch: Flag = False
    """do not draw the patterns by 20 % along courses and wales, which takes most of the time"""
    workers: Annotated[int | None, help_entry("N", "one for each GPU, or for each core without a GPU")] = None
    """processes on this machine; 0 makes the swatches in this process"""
    overwrite: Overwrite = False

    def run(self) -> int | None:
        """Make the book.

        Returns:
            The exit status if a signal stopped the work, otherwise None.
        """
        from stitchmesh.cli.progress import show_reports
        from stitchmesh.jobs.book.swatch_book import SwatchBook, write_book
        from stitchmesh.jobs.job_status import JobStopped

        book = SwatchBook(
            patterns=self.patterns, yarn=self.yarn, relaxation=self.relaxation, quality=self.quality,
            device=self.device, stretched=not self.no_stretch,
        )  # fmt: skip
        try:
            with stopped_by_signal() as stop, show_reports() as listener:
                page = write_book(
                    book, self.output, workers=self.workers, stop=stop, listener=listener, overwrite=self.overwrite
                )
        except JobStopped:
            say(f"stopped; the same command with -o {self.output} continues the book", file=sys.stderr)
            return TERMINATED
        _print_beside_reports(f"Wrote {page}; open it in a browser.")
        return None
