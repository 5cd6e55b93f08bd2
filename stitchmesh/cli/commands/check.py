# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The command ``check``."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Annotated

from tyro.conf import Positional, arg

from stitchmesh.cli.options import FileReading
from stitchmesh.cli.say import say
from stitchmesh.cli.words import help_entry


@dataclass(frozen=True)
class Check:
    """Check a file; the exit status is 0 for a valid file, else 2."""

    file: Annotated[Positional[str], help_entry("FILE")]
    """polygon mesh, stitch mesh or yarns"""
    reading: Annotated[FileReading, arg(name="")] = field(default_factory=FileReading)

    def run(self) -> None:
        """Read the file, which validates it, and print its kind."""
        from stitchmesh.cli.describe import kind_of

        say(f"{self.file}: valid {kind_of(self.reading.read(self.file))}")
