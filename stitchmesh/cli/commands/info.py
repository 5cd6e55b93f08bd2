# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The command ``info``."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Annotated

from tyro.conf import Positional, arg

from stitchmesh.cli.arguments import help_entry
from stitchmesh.cli.options import FileReading
from stitchmesh.cli.say import say


@dataclass(frozen=True)
class Info:
    """Describe the content of a file."""

    file: Annotated[Positional[str], help_entry("FILE")]
    """polygon mesh, stitch mesh or yarns"""
    reading: Annotated[FileReading, arg(name="")] = field(default_factory=FileReading)

    def run(self) -> None:
        """Print the lines that describe the file."""
        from stitchmesh.cli.describe import description

        for line in description(self.reading.read(self.file)):
            say(line)
