# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The command ``info``."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Annotated

from tyro.conf import Positional, arg

from stitchmesh.cli.arguments import shown
from stitchmesh.cli.options import FileReading


@dataclass(frozen=True)
class Info:
    """Describe what a file holds."""

    file: Annotated[Positional[str], shown("FILE")]
    """polygon mesh, stitch mesh or yarns"""
    reading: Annotated[FileReading, arg(name="")] = field(default_factory=FileReading)

    def run(self) -> None:
        """The lines that describe the file."""
        from stitchmesh.cli.describe import description

        for line in description(self.reading.read(self.file)):
            print(line)
