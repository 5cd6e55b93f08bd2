# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The command ``job``."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Literal

from tyro.conf import Positional

from stitchmesh.cli.arguments import help_entry
from stitchmesh.errors import FileError


@dataclass(frozen=True)
class Job:
    """Write a new job file with all keys, their defaults and comments."""

    action: Annotated[Positional[Literal["init"]], help_entry("init")]
    """what to do: init writes a new file"""
    source: Annotated[Positional[str], help_entry("MESH|RECIPE|PATTERN")]
    """what the job begins with: a mesh, a recipe (.toml), a chart, or a pattern of the library"""
    output: Annotated[str, help_entry("FILE", short="-o")] = "job.toml"
    """the new file"""

    def run(self) -> None:
        """Write the file.

        Raises:
            FileError: there is a file of that name, it cannot be written, or the job would begin with a folder.
        """
        import os

        from stitchmesh.io.atomic import write_text
        from stitchmesh.io.contents import suffix_of
        from stitchmesh.io.toml_file import SUFFIX
        from stitchmesh.jobs.job_file import example_job

        suffix_of(self.output, [SUFFIX])
        if Path(self.output).exists():
            raise FileError(f"{self.output}: is there already; choose another name, or remove it")
        named = Path(self.source)
        if named.is_dir():
            raise FileError(f"{self.source}: is a folder; expected a mesh, a recipe, or a pattern of the library")
        folder = Path(self.output).resolve().parent
        source = Path(os.path.relpath(named, folder)).as_posix() if named.suffix else self.source
        write_text(self.output, example_job(source))
        print(f"Wrote {self.output}; `stitchmesh run {self.output}` runs it.")
