# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The command ``job``."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Literal

from tyro.conf import Positional

from stitchmesh.cli.say import say
from stitchmesh.cli.words import help_entry
from stitchmesh.errors import FileError, ParameterError


@dataclass(frozen=True)
class Job:
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
        from stitchmesh.jobs.clean_job import clean_job

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
